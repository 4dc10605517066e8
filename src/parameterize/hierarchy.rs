//! A mesh made coarser by taking vertices out, in passes that can be undone
//! (after Praun, Hoppe, "Spherical parametrization and remeshing", 2003, who
//! map a surface from coarse to fine).

use rayon::prelude::*;

use super::stars::{Removal, Stars};
use crate::geometry::{Point, Vector};

/// A mesh and what was taken out of it.
pub struct Hierarchy {
    /// What is left.
    pub stars: Stars,
    /// The vertices that are left, in ascending order.
    pub left: Vec<u32>,
    /// Removals of each pass. Those of one pass do not touch each other.
    passes: Vec<Vec<Removal>>,
}

/// A pass that takes out less than this share of the vertices is the last.
const IDLE: f64 = 0.01;

/// Neighbours of a fan's apex at the most.
const MOST_NEIGHBOURS: usize = 14;

impl Hierarchy {
    /// Nothing is taken out yet.
    pub fn new(stars: Stars) -> Self {
        let left = (0..stars.len() as u32).collect();
        Hierarchy { stars, left, passes: Vec::new() }
    }

    /// Takes vertices out until no more than `target` are left, or no more can
    /// be: first those where the surface is flattest for its density. Those
    /// that are `kept` stay. Each is shown.
    pub fn coarsen(
        &mut self,
        points: &[Point],
        kept: &[bool],
        target: usize,
        mut show: impl FnMut(&Removal),
    ) {
        while self.left.len() > target {
            let pass = self.pass(points, kept, target);
            let idle = (pass.len() as f64) < IDLE * self.left.len() as f64;
            let gone = |v: &u32| self.stars.ring(*v).is_empty();
            self.left.retain(|v| !gone(v));
            pass.iter().for_each(&mut show);
            self.passes.push(pass);
            if idle {
                break;
            }
        }
    }

    fn pass(&mut self, points: &[Point], kept: &[bool], target: usize) -> Vec<Removal> {
        let stars = &self.stars;
        let loose = |v: &&u32| !kept[**v as usize];
        let mut order: Vec<(f64, u32)> =
            self.left.par_iter().filter(loose).map(|&v| (loss(points, stars, v), v)).collect();
        order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Late in the order a vertex stands where much is lost; its time comes
        // in a later pass, when more has gone around it.
        order.truncate((order.len() * 3 / 4).max(8));
        let mut locked = vec![false; points.len()];
        let most = self.left.len() - target;
        let mut pass = Vec::new();
        for (_, v) in order {
            if pass.len() >= most {
                break;
            }
            if locked[v as usize] {
                continue;
            }
            if let Some(removal) = best_removal(points, &self.stars, v) {
                self.stars.remove(&removal);
                removal.ring.iter().for_each(|&w| locked[w as usize] = true);
                pass.push(removal);
            }
        }
        pass
    }

    /// Puts back what the last pass took out; each vertex is shown, with its
    /// ring, before it is. False if nothing is out.
    pub fn refine(&mut self, mut show: impl FnMut(&Removal)) -> bool {
        let Some(mut pass) = self.passes.pop() else { return false };
        while let Some(removal) = pass.pop() {
            show(&removal);
            self.stars.restore(&removal);
            self.left.push(removal.vertex);
        }
        self.left.par_sort_unstable();
        true
    }
}

/// What goes with a vertex, in mm: how far it stands out of its ring's mean
/// plane, and a share of the edges' length, so that flat regions become even.
fn loss(points: &[Point], stars: &Stars, v: u32) -> f64 {
    let p = points[v as usize];
    let ring = stars.ring(v);
    let away = |&w: &u32| points[w as usize] - p;
    let n = ring.len().max(1) as f64;
    let edge = ring.iter().map(|w| away(w).norm()).sum::<f64>() / n;
    if stars.on_boundary(v) {
        let ends = ring.first().zip(ring.last());
        let bend = ends.map_or(0.0, |(a, b)| (away(a) + away(b)).norm());
        return 0.5 * bend + 0.05 * edge;
    }
    let mean = ring.iter().map(away).sum::<Vector>() / n;
    let normal = normal(points, stars, v);
    mean.dot(&normal).abs() + 0.05 * edge
}

/// The unit normal at a vertex.
pub fn normal(points: &[Point], stars: &Stars, v: u32) -> Vector {
    let p = points[v as usize];
    let areas =
        stars.sides(v).map(|(a, b)| (points[a as usize] - p).cross(&(points[b as usize] - p)));
    areas.sum::<Vector>().try_normalize(0.0).unwrap_or_else(Vector::zeros)
}

/// The removal that leaves the best of worst triangles, and none upside down if
/// that can be had.
fn best_removal(points: &[Point], stars: &Stars, v: u32) -> Option<Removal> {
    let up = normal(points, stars, v);
    let n = stars.ring(v).len();
    let rate = |k: usize| (worst_of_fan(points, stars, v, k, up), k);
    let mut rated: Vec<(f64, usize)> = (0..n).map(rate).collect();
    rated.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    rated.into_iter().find_map(|(_, k)| stars.removal(v, k))
}

/// The least quality, area over squares of sides, of the triangles by which the
/// fan from the `k`-th neighbour would replace v's star.
fn worst_of_fan(points: &[Point], stars: &Stars, v: u32, k: usize, up: Vector) -> f64 {
    let ring = stars.ring(v);
    let n = ring.len();
    let apex = points[ring[k] as usize];
    let away = |j: usize| points[ring[(k + j) % n] as usize] - apex;
    let shape = |j: usize| {
        let (d, e) = (away(j), away(j + 1));
        let area = d.cross(&e);
        let sides = d.norm_squared() + e.norm_squared() + (e - d).norm_squared();
        let upright = if area.dot(&up) > 0.0 { area.norm() } else { area.dot(&up) };
        upright / sides.max(f64::MIN_POSITIVE)
    };
    let worst = (2..n).map(|j| shape(j - 1)).fold(f64::INFINITY, f64::min);
    let crowded = stars.ring(ring[k]).len() + n > MOST_NEIGHBOURS + 4;
    if crowded { worst - 1.0 } else { worst }
}
