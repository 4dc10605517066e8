//! A mesh made coarser by taking vertices out, in passes that can be undone
//! (after Praun, Hoppe, "Spherical parametrization and remeshing", 2003, who
//! map a surface from coarse to fine).

use rayon::prelude::*;

use super::stars::{Removal, Stars};
use crate::error::Result;
use crate::geometry::{Point, Vector};
use crate::progress::Progress;

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
        progress: &mut Progress,
    ) -> Result<()> {
        while self.left.len() > target {
            progress(1.0 - self.left.len() as f64 / self.stars.len() as f64)?;
            let pass = self.pass(points, kept, target);
            let idle = (pass.len() as f64) < IDLE * self.left.len() as f64;
            let stays = |v: &u32| !self.stars.ring(*v).is_empty();
            self.left = self.left.par_iter().copied().filter(stays).collect();
            pass.iter().for_each(&mut show);
            self.passes.push(pass);
            if idle {
                break;
            }
        }
        Ok(())
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
        let mut pass = Pass {
            most: self.left.len() - target,
            removals: Vec::new(),
            locked: vec![0; points.len()],
        };
        let mut order = order.into_iter().map(|(_, v)| v);
        let mut late = Vec::new();
        for number in 1.. {
            late.extend(order.by_ref().take(BATCH));
            if late.is_empty() || pass.is_full() {
                break;
            }
            late = pass.remove(points, &mut self.stars, number, &late);
        }
        pass.removals
    }

    /// Puts back what the last pass took out; all of it is shown before, in the order
    /// in which it was taken out. False if nothing is out.
    pub fn refine(&mut self, show: impl FnOnce(&[Removal])) -> bool {
        let Some(pass) = self.passes.pop() else { return false };
        show(&pass);
        self.stars.restore(&pass);
        self.left.extend(pass.iter().map(|removal| removal.vertex));
        self.left.par_sort_unstable();
        true
    }
}

/// Vertices whose removals are found at once, before any of them is made, besides those
/// that came too late before. More would come too late more often; fewer are not worth
/// the threads' meeting.
const BATCH: usize = 1 << 13;

/// A pass while it is made.
struct Pass {
    /// Removals at the most.
    most: usize,
    removals: Vec<Removal>,
    /// For each vertex the number of the batch in which a removal touched it, or 0.
    locked: Vec<u32>,
}

impl Pass {
    fn is_full(&self) -> bool {
        self.removals.len() >= self.most
    }

    fn is_free(&self, v: u32) -> bool {
        self.locked[v as usize] == 0
    }

    /// Takes out, in their order, those of a batch that nothing taken out before touches.
    /// Some come too late: one of the same batch beside them may have changed what is best
    /// for them. They are returned.
    fn remove(
        &mut self,
        points: &[Point],
        stars: &mut Stars,
        number: u32,
        batch: &[u32],
    ) -> Vec<u32> {
        let find = |&v: &u32| if self.is_free(v) { best_removal(points, stars, v) } else { None };
        let found: Vec<Option<Removal>> = batch.par_iter().with_min_len(64).map(find).collect();
        let first = self.removals.len();
        let mut late = Vec::new();
        for removal in found.into_iter().flatten() {
            let v = removal.vertex;
            if self.is_full() {
                break;
            }
            if !self.is_free(v) {
                continue;
            }
            if removal.ring.iter().any(|&w| self.locked[w as usize] == number) {
                late.push(v);
                continue;
            }
            removal.ring.iter().for_each(|&w| self.locked[w as usize] = number);
            self.removals.push(removal);
        }
        stars.remove(&self.removals[first..]);
        late
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
