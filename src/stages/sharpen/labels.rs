//! Which surface each triangle lies on.

use super::Work;
use crate::geometry::sets::Sets;
use crate::geometry::{NONE, Point};
use crate::mesh::Mesh;
use crate::primitives::Primitive;
use crate::primitives::contact::{contact, crossing};
use crate::statistics::outlying;

/// Distances beyond so many standard deviations of the noise count linearly, as in Huber's estimator.
const HUBER: f64 = 3.0;

/// The standard deviation (rad) of the normals of triangles that noise tilts.
const TILT: f64 = 0.15;

/// The cost of a normal that has nothing to do with its surface.
const MOST_TILT: f64 = 6.0;

/// The cost of a border as long as an edge, and of each edge length that it lies off the curve of its surfaces.
const BORDER: f64 = 0.8;
const OFF_CURVE: f64 = 2.0;

/// A border so many edge lengths off the curve of its surfaces costs no more if it is farther.
const FARTHEST: f64 = 3.0;

/// The sweeps over the borders. Nearly all settle in a few.
const SWEEPS: usize = 12;

/// Pieces of fewer triangles are no faces. The narrowest face that can be told is two edges wide and long.
const FEWEST: usize = 10;

/// What no region holds goes to the nearest one if it is nowhere deeper than so many rings.
const DEEPEST: u32 = 2;

/// It is then also nowhere farther from the surfaces beside it than so many edges, as the fillet of a right angle that is as wide is within
/// 0.75, and its normals have such a cosine with one of theirs, as the normal in a corner of three right angles leans by 55°.
const NEAREST: f64 = 1.0;
const LEAST_COSINE: f64 = 0.5;

/// The end of a bore has one region beside it and so many triangles. Pieces between two regions are rims of sheets, and smaller ones are
/// noise.
const FEWEST_OF_END: usize = 3;

/// Normals of two surfaces that differ by a smaller sine may touch.
const NEARLY_PARALLEL: f64 = 0.35;

impl Work<'_> {
    /// Smooths the borders, and gives small pieces to their neighbours.
    pub(super) fn tidy(&mut self) {
        let before = self.of.clone();
        self.strip();
        self.fill();
        self.find_small_faces();
        self.give_back(&before);
        self.fill();
        self.smooth();
        for _ in 0..3 {
            if !self.dissolve() {
                break;
            }
            self.smooth();
        }
        for _ in 0..SWEEPS {
            if !self.part_pinches() {
                break;
            }
        }
    }

    /// Takes triangles away from their regions that are far from all surfaces around them.
    fn strip(&mut self) {
        let mut is_foreign = Vec::with_capacity(self.of.len());
        for t in 0..self.of.len() {
            let around = self.mesh.triangles[t].map(|v| self.around(v.0)).concat();
            is_foreign.push(self.of[t] != NONE && self.is_foreign(t, &around));
        }
        (0..self.of.len()).filter(|&t| is_foreign[t]).for_each(|t| self.of[t] = NONE);
    }

    /// Gives triangles back to their regions that have no surface of their own, but for the ends of bores.
    fn give_back(&mut self, before: &[u32]) {
        for piece in self.pieces() {
            let is_end = self.regions_beside(&piece).len() == 1 && piece.len() >= FEWEST_OF_END;
            if self.of[piece[0] as usize] == NONE && !is_end {
                piece.iter().for_each(|&t| self.of[t as usize] = before[t as usize]);
            }
        }
    }

    /// Gives triangles at vertices where a region touches itself to the region beside them, so that no border touches itself. Returns
    /// whether there were some.
    fn part_pinches(&mut self) -> bool {
        let mut is_any = false;
        for v in 0..self.mesh.points.len() as u32 {
            let sectors = self.sectors(&self.fan(v));
            let regions: Vec<u32> = sectors.iter().map(|of| of.0).collect();
            let n = regions.len();
            if n < 4 || repeats(&regions) == 0 {
                continue;
            }
            let mut best: Option<(f64, usize, u32)> = None;
            for (k, (own, sides)) in sectors.iter().enumerate().filter(|(_, of)| of.0 != NONE) {
                for to in [regions[(k + n - 1) % n], regions[(k + 1) % n]] {
                    let mut after = regions.clone();
                    after[k] = to;
                    if to == NONE || repeats(&after) >= repeats(&regions) {
                        continue;
                    }
                    let triangles = sides.iter().map(|side| side / 3);
                    let cost = triangles.map(|t| self.misfit(t, to) - self.misfit(t, *own)).sum();
                    if best.is_none_or(|best| cost < best.0) {
                        best = Some((cost, k, to));
                    }
                }
            }
            if let Some((_, k, to)) = best {
                sectors[k].1.iter().for_each(|side| self.of[side / 3] = to);
                is_any = true;
            }
        }
        is_any
    }

    fn beside(&self, t: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        (3 * t..3 * t + 3).filter_map(|side| Some((side, self.edges.across(side)? / 3)))
    }

    /// How badly a triangle fits a surface, as a negative logarithm of a likelihood.
    pub(super) fn misfit(&self, t: usize, region: u32) -> f64 {
        let of = &self.surfaces[region as usize];
        let corners = self.mesh.corners(self.mesh.triangles[t]);
        let mut cost = 0.0;
        for p in corners {
            let x = of.surface.distance(p).0.abs() / self.noise;
            cost += if x < HUBER { 0.5 * x * x } else { HUBER * (x - 0.5 * HUBER) } / 3.0;
        }
        let normal = of.side * of.surface.normal(middle(corners));
        let own = self.mesh.area_vector(self.mesh.triangles[t]);
        let angle = own.cross(&normal).norm().atan2(own.dot(&normal));
        cost + (0.5 * (angle / TILT).powi(2)).min(MOST_TILT)
    }

    /// The cost of a side between two regions.
    fn border(&self, side: usize, a: u32, b: u32) -> f64 {
        if a == b {
            return 0.0;
        }
        let (p, q) = self.mesh.side(side);
        let (p, q) = (self.mesh.point(p), self.mesh.point(q));
        let long = (q - p).norm() / self.edge;
        if a == NONE || b == NONE {
            return long * (BORDER + OFF_CURVE);
        }
        let middle = nalgebra::center(&p, &q);
        let off = off_curve(self.surface(a), self.surface(b), middle, self.edge);
        long * (BORDER + OFF_CURVE * (off / self.edge).min(FARTHEST))
    }

    fn cost(&self, t: usize, region: u32) -> f64 {
        let own = if region == NONE { 0.0 } else { self.misfit(t, region) };
        own + self.beside(t).map(|(side, o)| self.border(side, region, self.of[o])).sum::<f64>()
    }

    /// Gives triangles at borders to the most likely region beside them, until none changes.
    fn smooth(&mut self) {
        let mut open: Vec<bool> = vec![true; self.of.len()];
        for _ in 0..SWEEPS {
            let mut is_done = true;
            for t in 0..self.of.len() {
                let own = self.of[t];
                if !std::mem::take(&mut open[t]) || own == NONE {
                    continue;
                }
                let mut others: Vec<u32> = self.beside(t).map(|(_, o)| self.of[o]).collect();
                others.retain(|&r| r != own && r != NONE);
                others.sort_unstable();
                others.dedup();
                if others.is_empty() {
                    continue;
                }
                let mut best = (self.cost(t, own), own);
                for r in others {
                    let cost = self.cost(t, r);
                    if cost < best.0 {
                        best = (cost, r);
                    }
                }
                if best.1 != own {
                    self.of[t] = best.1;
                    is_done = false;
                    let around: Vec<usize> = self.beside(t).map(|(_, o)| o).collect();
                    around.into_iter().for_each(|o| open[o] = true);
                }
            }
            if is_done {
                break;
            }
        }
    }

    /// The connected pieces of all regions, and of what has none.
    pub(super) fn pieces(&self) -> Vec<Vec<u32>> {
        let mut sets = Sets::new(self.of.len());
        for t in 0..self.of.len() {
            for (_, o) in self.beside(t).filter(|&(_, o)| self.of[o] == self.of[t]) {
                sets.join(t, o);
            }
        }
        sets.members()
    }

    /// The regions that a piece has edges in common with, ascending.
    pub(super) fn regions_beside(&self, piece: &[u32]) -> Vec<u32> {
        let own = self.of[piece[0] as usize];
        let all = piece.iter().flat_map(|&t| self.beside(t as usize)).map(|(_, o)| self.of[o]);
        let mut around: Vec<u32> = all.filter(|&r| r != own && r != NONE).collect();
        around.sort_unstable();
        around.dedup();
        around
    }

    /// How far the corners and the middle of a triangle are from the nearest one of some surfaces.
    fn off(&self, t: usize, regions: &[u32]) -> f64 {
        let off = |p: Point| {
            let offs = regions.iter().map(|&r| self.surface(r).distance(p).0.abs());
            offs.fold(f64::INFINITY, f64::min)
        };
        let corners = self.mesh.corners(self.mesh.triangles[t]);
        corners.into_iter().map(off).fold(off(middle(corners)), f64::max)
    }

    /// Whether a triangle has nothing to do with some surfaces: noise does not explain how far it is off them, and it is farther than a fillet
    /// between them or faces elsewhere.
    fn is_foreign(&self, t: usize, regions: &[u32]) -> bool {
        let corners = self.mesh.triangles[t];
        let (own, at) = (self.mesh.area_vector(corners), middle(self.mesh.corners(corners)));
        let faces = |&r: &u32| {
            let of = &self.surfaces[r as usize];
            of.side * of.surface.normal(at).dot(&own) >= LEAST_COSINE * own.norm()
        };
        let off = self.off(t, regions);
        let explained = || outlying(self.mesh.points.len()) * self.noise;
        off > NEAREST * self.edge || !regions.iter().any(faces) && off > explained()
    }

    /// Gives pieces that are too small for a face to the regions around them. Returns whether there were some.
    fn dissolve(&mut self) -> bool {
        let mut is_any = false;
        let mut pieces = self.pieces();
        pieces.retain(|piece| piece.len() < FEWEST);
        pieces.sort_by_key(Vec::len);
        for piece in pieces {
            let around = self.regions_beside(&piece);
            if piece.iter().any(|&t| self.is_foreign(t as usize, &around)) {
                continue;
            }
            let cost = |&r: &u32| piece.iter().map(|&t| self.misfit(t as usize, r)).sum::<f64>();
            let best = around.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
            if let Some(best) = best {
                piece.iter().for_each(|&t| self.of[t as usize] = best);
                is_any = true;
            }
        }
        is_any
    }

    /// Gives what no region holds to the nearest one beside it, where it is thin.
    fn fill(&mut self) {
        let mut queue: Vec<usize> = (0..self.of.len()).filter(|&t| self.of[t] != NONE).collect();
        let mut depth = vec![u32::MAX; self.of.len()];
        queue.iter().for_each(|&t| depth[t] = 0);
        let mut at = 0;
        while let Some(&t) = queue.get(at) {
            at += 1;
            let corners = self.mesh.triangles[t];
            let around = corners.iter().flat_map(|&v| self.rings.triangles(v));
            for &o in around {
                if depth[o as usize] == u32::MAX {
                    depth[o as usize] = depth[t] + 1;
                    queue.push(o as usize);
                }
            }
        }
        let pieces = self.pieces();
        let is_thin = |piece: &&Vec<u32>| {
            self.of[piece[0] as usize] == NONE
                && piece.iter().all(|&t| depth[t as usize] <= DEEPEST)
        };
        let thin: Vec<Vec<u32>> = pieces.iter().filter(is_thin).cloned().collect();
        for piece in thin {
            let around = self.regions_beside(&piece);
            let mut left = piece;
            while !left.is_empty() {
                let mut found: Vec<(u32, u32)> = Vec::new();
                for &t in &left {
                    let mut beside: Vec<u32> = self
                        .beside(t as usize)
                        .map(|(_, o)| self.of[o])
                        .filter(|&r| r != NONE)
                        .collect();
                    beside.sort_unstable();
                    beside.dedup();
                    if self.is_foreign(t as usize, &around) {
                        continue;
                    }
                    let cost = |&r: &u32| self.misfit(t as usize, r);
                    let best = beside.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
                    found.extend(best.map(|r| (t, r)));
                }
                if found.is_empty() {
                    break;
                }
                found.iter().for_each(|&(t, r)| self.of[t as usize] = r);
                left.retain(|&t| self.of[t as usize] == NONE);
            }
        }
    }
}

pub(super) fn middle([a, b, c]: [Point; 3]) -> Point {
    Point::from((a.coords + b.coords + c.coords) / 3.0)
}

/// How often regions occur again around a vertex, apart from what follows itself.
fn repeats(around: &[u32]) -> usize {
    let n = around.len();
    let starts = (0..n).filter(|&k| around[k] != around[(k + n - 1) % n]);
    let mut found: Vec<u32> = starts.map(|k| around[k]).collect();
    let all = found.len();
    found.sort_unstable();
    found.dedup();
    all - found.len()
}

/// How far a point is from where two surfaces cross or touch, at most [`FARTHEST`] edges.
pub(super) fn off_curve(a: &Primitive, b: &Primitive, p: Point, edge: f64) -> f64 {
    let most = FARTHEST * edge;
    let off = |q: Point| {
        let left = a.distance(q).0.abs().max(b.distance(q).0.abs());
        let off = (q - p).norm();
        if left < 0.1 * edge && off.is_finite() { off + left } else { most }
    };
    let crossed = off(crossing(a, b, p));
    if a.normal(p).cross(&b.normal(p)).norm() < NEARLY_PARALLEL {
        crossed.min(off(contact(a, b, p))).min(most)
    } else {
        crossed.min(most)
    }
}

/// The ends of a side, ascending.
pub(super) fn ends(mesh: &Mesh, side: usize) -> [u32; 2] {
    let (a, b) = mesh.side(side);
    [a.0.min(b.0), a.0.max(b.0)]
}
