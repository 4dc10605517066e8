//! Triangles joined to quads: a perfect matching of neighbours with a small cost.
//!
//! The dual of a closed triangulation is a cubic graph without a bridge, so a perfect matching exists
//! (Petersen 1891). A greedy one is extended to a perfect one, and improved along alternating cycles
//! (Remacle et al., "Blossom-Quad", 2012, for the idea).

use std::collections::BTreeMap;

use super::base::Base;
use super::matching;
use crate::geometry::{NONE, ROUNDING};

/// The weight of the squares of valences minus four, beside the shape of the quads. It leaves almost
/// only vertices of three to five quads.
const VALENCE: f64 = 3.0;

/// The costs of a vertex with two quads or fewer, which no surface is smooth at, and of each quad
/// beyond five.
const TOO_FEW: f64 = 100.0;
const TOO_MANY: f64 = 10.0;

/// The most pairs of a cycle along which the matching is changed. Longer cycles seldom lower the
/// cost, and their number doubles with each pair.
const CYCLE: usize = 5;

/// Triangles of a base, numbered, with their neighbours.
pub(super) struct Pairs {
    /// The triangles of the base.
    pub triangles: Vec<u32>,
    /// For each triangle its three neighbours, across sides 0, 1 and 2.
    neighbours: Vec<Vec<u32>>,
    /// The cost of joining a triangle with each neighbour.
    shapes: Vec<[f64; 3]>,
    corners: Vec<[u32; 3]>,
    /// The partner of each triangle.
    pub mate: Vec<u32>,
    /// The number of quads at each vertex of the scan.
    pub valence: Vec<i64>,
}

impl Pairs {
    /// Joins the triangles, and keeps the pairs of an `earlier` state of the base that still exist.
    /// `None` if they are not closed or have no perfect matching.
    pub(super) fn new(base: &Base, earlier: Option<&Pairs>) -> Option<Self> {
        let triangles: Vec<u32> =
            (0..base.triangles.len() as u32).filter(|&t| base.alive[t as usize]).collect();
        let number: BTreeMap<u32, u32> =
            triangles.iter().enumerate().map(|(i, &t)| (t, i as u32)).collect();
        let mut neighbours = Vec::with_capacity(triangles.len());
        let mut shapes = Vec::with_capacity(triangles.len());
        for &t in &triangles {
            let beside: Vec<(u32, u32)> =
                (0..3).map(|k| base.across(t as usize, k)).collect::<Option<_>>()?;
            neighbours
                .push(beside.iter().map(|b| number.get(&b.0).copied()).collect::<Option<_>>()?);
            let shape = |k: usize| shape(base, base.triangles[t as usize], k, beside[k].1);
            shapes.push([0, 1, 2].map(shape));
        }
        let corners: Vec<[u32; 3]> =
            triangles.iter().map(|&t| base.triangles[t as usize]).collect();
        let valence = base.around.iter().map(|around| around.len() as i64).collect();
        let mate = vec![NONE; triangles.len()];
        let mut pairs = Pairs { triangles, neighbours, shapes, corners, mate, valence };
        earlier.into_iter().flat_map(Pairs::each).for_each(|(t, other)| {
            if let (Some(&t), Some(&other)) = (number.get(&t), number.get(&other)) {
                pairs.mate[t as usize] = other;
                pairs.mate[other as usize] = t;
            }
        });
        pairs.match_greedily();
        matching::extend(&pairs.neighbours, &mut pairs.mate);
        if pairs.mate.contains(&NONE) {
            return None;
        }
        for t in 0..pairs.mate.len() {
            if t < pairs.mate[t] as usize {
                pairs.count(t as u32, pairs.mate[t], -1);
            }
        }
        while pairs.improve() {}
        Some(pairs)
    }

    /// The triangles of the base in each pair.
    fn each(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let name = |t: u32| self.triangles[t as usize];
        let all = self.mate.iter().enumerate().filter(|&(t, &mate)| t < mate as usize);
        all.map(move |(t, &mate)| (name(t as u32), name(mate)))
    }

    fn match_greedily(&mut self) {
        let all = (0..self.mate.len()).flat_map(|t| (0..3).map(move |k| (t, k)));
        let mut order: Vec<(f64, usize, usize)> =
            all.map(|(t, k)| (self.shapes[t][k], t, k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, t, k) in order {
            let other = self.neighbours[t][k] as usize;
            if self.mate[t] == NONE && self.mate[other] == NONE && t != other {
                self.mate[t] = other as u32;
                self.mate[other] = t as u32;
            }
        }
    }

    /// The side of a triangle on which another one is.
    pub(crate) fn side(&self, t: u32, other: u32) -> usize {
        self.neighbours[t as usize].iter().position(|&n| n == other).unwrap_or(0)
    }

    /// Changes the numbers of quads at the ends of the side between two triangles.
    fn count(&mut self, t: u32, other: u32, by: i64) {
        let k = self.side(t, other);
        let corners = self.corners[t as usize];
        self.valence[corners[k] as usize] += by;
        self.valence[corners[(k + 1) % 3] as usize] += by;
    }

    /// Changes the matching along cycles that lower the cost. Returns whether there was one.
    fn improve(&mut self) -> bool {
        let mut improved = false;
        for start in 0..self.mate.len() as u32 {
            let mut path = vec![start];
            improved |= self.extend_path(&mut path);
        }
        improved
    }

    /// Extends an alternating path by an edge that is not matched and one that is, and changes the
    /// matching along the first closed path that lowers the cost.
    fn extend_path(&mut self, path: &mut Vec<u32>) -> bool {
        let Some(&last) = path.last() else { return false };
        for k in 0..3 {
            let next = self.neighbours[last as usize][k];
            let partner = self.mate[next as usize];
            if next == self.mate[last as usize] || path.contains(&next) || path.contains(&partner) {
                continue;
            }
            path.extend([next, partner]);
            let found = self.close(path) || (path.len() < 2 * CYCLE - 1 && self.extend_path(path));
            path.truncate(path.len() - 2);
            if found {
                return true;
            }
        }
        false
    }

    /// Tries to close the path: its first triangle's partner must be beside its end.
    fn close(&mut self, path: &[u32]) -> bool {
        let (first, last) = (path[0], path[path.len() - 1]);
        let home = self.mate[first as usize];
        if path.contains(&home) || !self.neighbours[last as usize].contains(&home) {
            return false;
        }
        // Matched now: (home, first), (path[1], path[2]), … Then: (first, path[1]), …, (last, home).
        let mut cycle = vec![home];
        cycle.extend(path);
        let pairs = |from: usize| -> Vec<(u32, u32)> {
            let n = cycle.len();
            (0..n / 2).map(|i| (cycle[(2 * i + from) % n], cycle[(2 * i + 1 + from) % n])).collect()
        };
        let (old, new) = (pairs(0), pairs(1));
        let mut touched: Vec<u32> = cycle.iter().flat_map(|&t| self.corners[t as usize]).collect();
        touched.sort_unstable();
        touched.dedup();
        let before = self.cost(&old, &touched);
        old.iter().for_each(|&(a, b)| self.count(a, b, 1));
        new.iter().for_each(|&(a, b)| self.count(a, b, -1));
        if self.cost(&new, &touched) < before - ROUNDING {
            for &(a, b) in &new {
                self.mate[a as usize] = b;
                self.mate[b as usize] = a;
            }
            return true;
        }
        new.iter().for_each(|&(a, b)| self.count(a, b, 1));
        old.iter().for_each(|&(a, b)| self.count(a, b, -1));
        false
    }

    fn cost(&self, pairs: &[(u32, u32)], touched: &[u32]) -> f64 {
        let shape = |&(a, b): &(u32, u32)| self.shapes[a as usize][self.side(a, b)];
        let vertex = |&v: &u32| {
            let q = self.valence[v as usize];
            let few = if q <= 2 { TOO_FEW * (3 - q) as f64 } else { 0.0 };
            VALENCE * ((q - 4) * (q - 4)) as f64 + few + TOO_MANY * (q - 5).max(0) as f64
        };
        pairs.iter().map(shape).sum::<f64>() + touched.iter().map(vertex).sum::<f64>()
    }
}

/// The cost of the quad that a triangle makes with the one across side `k`: the sum of squares of how
/// far its angles are from right ones.
fn shape(base: &Base, corners: [u32; 3], k: usize, apex: u32) -> f64 {
    let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
    let quad = [a, apex, b, c].map(|v| base.point(v));
    let off = |i: usize| {
        let [before, at, after] = [quad[(i + 3) % 4], quad[i], quad[(i + 1) % 4]];
        let angle = (before - at).angle(&(after - at));
        // Angles at the ends of the common side are sums of two and may exceed a half turn.
        let angle = match i % 2 {
            0 => {
                let across = quad[(i + 2) % 4] - at;
                (before - at).angle(&across) + across.angle(&(after - at))
            }
            _ => angle,
        };
        (angle - std::f64::consts::FRAC_PI_2).powi(2)
    };
    (0..4).map(off).sum()
}
