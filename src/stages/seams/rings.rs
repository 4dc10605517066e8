//! Changes of chains that keep the loops: reversal, splitting, and the choice of a start.

use super::network::{Chain, ChainNetwork, ChainUse};
use crate::geometry::Point;

/// Points of a chain that are closer than this in mm are one.
const SAME: f64 = 1e-7;

impl ChainNetwork {
    /// The points of a chain in the direction of a use.
    pub(super) fn points_of(&self, (chain, forward): ChainUse) -> Vec<Point> {
        let mut points = self.chains[chain].points.clone();
        if !forward {
            points.reverse();
        }
        points
    }

    /// The points of a loop. The last one is the first one.
    pub(super) fn ring_points(&self, ring: &[ChainUse]) -> Vec<Point> {
        let mut points: Vec<Point> = Vec::new();
        for &of in ring {
            points.pop();
            points.extend(self.points_of(of));
        }
        if let Some(&first) = points.first() {
            points.push(first);
        }
        points
    }

    /// The loops into which a loop falls at the vertices that it visits more than once.
    pub(super) fn parts_of(&self, ring: &[ChainUse]) -> Vec<Vec<ChainUse>> {
        let ends = |(chain, forward): ChainUse| {
            let [a, b] = self.chains[chain].ends?;
            Some(if forward { [a, b] } else { [b, a] })
        };
        let mut found = Vec::new();
        let mut open: Vec<ChainUse> = Vec::new();
        for &of in ring {
            open.push(of);
            let Some([_, end]) = ends(of) else { continue };
            let begins = |of: &ChainUse| ends(*of).is_some_and(|[start, _]| start == end);
            if let Some(first) = open.iter().position(begins) {
                found.push(open.split_off(first));
            }
        }
        found.extend((!open.is_empty()).then_some(open));
        found
    }

    /// Turns a chain round.
    pub(super) fn reverse(&mut self, chain: usize) {
        let of = &mut self.chains[chain];
        of.points.reverse();
        of.mesh_vertices.reverse();
        let [first, last] = of.tangents;
        of.tangents = [last.map(|t| -t), first.map(|t| -t)];
        std::mem::swap(&mut of.left, &mut of.right);
        if let Some(ends) = &mut of.ends {
            ends.reverse();
        }
        let [left, right] = [of.left, of.right];
        self.change(left, right, |of| match of.0 == chain {
            true => vec![(chain, !of.1)],
            false => vec![of],
        });
    }

    /// Makes a vertex at a point of a chain after the point with the given number.
    pub(super) fn cut(&mut self, chain: usize, after: usize, p: Point) {
        let vertex = self.vertices.len();
        self.vertices.push(p);
        let of = &mut self.chains[chain];
        let apart = |q: &&Point| (*q - p).norm() > SAME;
        let before: Vec<Point> = of.points[..=after].iter().filter(apart).copied().collect();
        let behind: Vec<Point> = of.points[after + 1..].iter().filter(apart).copied().collect();
        let Some(ends) = of.ends else {
            // The first and the last point of a closed chain are one.
            let mut points = vec![p];
            points.extend(behind);
            points.extend(before.iter().skip(1));
            points.push(p);
            of.points = points;
            of.ends = Some([vertex; 2]);
            return;
        };
        let number = self.chains.len();
        let of = &mut self.chains[chain];
        let mut second: Chain = of.clone();
        second.points = std::iter::once(p).chain(behind).collect();
        second.ends = Some([vertex, ends[1]]);
        second.tangents[0] = None;
        of.tangents[1] = None;
        of.points = before.into_iter().chain([p]).collect();
        of.ends = Some([ends[0], vertex]);
        let [left, right] = [of.left, of.right];
        self.chains.push(second);
        self.change(left, right, |of| match of {
            (c, true) if c == chain => vec![(chain, true), (number, true)],
            (c, false) if c == chain => vec![(number, false), (chain, false)],
            of => vec![of],
        });
    }

    fn change(&mut self, left: usize, right: usize, to: impl Fn(ChainUse) -> Vec<ChainUse>) {
        let mut patches = vec![left, right];
        patches.dedup();
        for patch in patches {
            for ring in &mut self.loops[patch] {
                *ring = ring.iter().flat_map(|&of| to(of)).collect();
            }
        }
    }
}
