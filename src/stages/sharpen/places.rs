//! The places of the vertices on their surfaces.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use super::borders::Border;
use super::{Lost, Work};
use crate::geometry::{NONE, Point, Vector, VertexId};
use crate::mesh::Mesh;
use crate::primitives::Primitive;
use crate::primitives::contact::{contact, crossing};

/// A vertex moves at most so many edges. The borders of regions are known better.
const FARTHEST: f64 = 5.0;

/// What is on its surfaces is off them by less than this share of an edge.
const ON: f64 = 1e-8;

/// The steps of Newton's method, and the step of its derivatives as a share of an edge.
const STEPS: usize = 25;
const STEP: f64 = 1e-5;

/// Directions in which surfaces hold a point less than this do not move it.
const HELD: f64 = 1e-4;

/// How often triangles may lose their region.
const ROUNDS: usize = 6;

impl Work<'_> {
    /// Moves all vertices. Triangles at places where that fails lose their region. Returns the mesh with the numbers that its triangles
    /// had.
    pub(super) fn place(
        &mut self,
        touching: &BTreeSet<[u32; 2]>,
        lost: &mut Vec<Lost>,
    ) -> (Mesh, Vec<u32>) {
        let mut points = self.mesh.points.clone();
        for _ in 0..ROUNDS {
            points = self.mesh.points.clone();
            let failed = self.move_all(touching, &mut points);
            if failed.is_empty() {
                break;
            }
            for (v, why) in failed {
                let mut count = 0;
                for &t in self.rings.triangles(VertexId(v)) {
                    count += usize::from(self.of[t as usize] != NONE);
                    self.of[t as usize] = NONE;
                }
                if count > 0 {
                    lost.push(Lost { place: self.mesh.points[v as usize], triangles: count, why });
                }
            }
        }
        let mesh = Mesh { points, triangles: self.mesh.triangles.clone() };
        joined(mesh, ON * self.edge)
    }

    /// Moves the vertices. Returns those that have no place, with the reason.
    fn move_all(
        &self,
        touching: &BTreeSet<[u32; 2]>,
        points: &mut [Point],
    ) -> Vec<(u32, &'static str)> {
        let mut failed = Vec::new();
        for v in 0..points.len() as u32 {
            let regions = self.around(v);
            let start = self.mesh.points[v as usize];
            let at = match self.placed(&regions, touching, start) {
                Ok(at) => at,
                Err(why) => {
                    failed.push((v, why));
                    continue;
                }
            };
            points[v as usize] = at;
        }
        if failed.is_empty() {
            for border in self.borders().all {
                if border.pair[1] != NONE {
                    self.put_in_order(&border, touching, points);
                }
            }
        }
        failed
    }

    fn is_touching(&self, a: u32, b: u32, touching: &BTreeSet<[u32; 2]>) -> bool {
        touching.contains(&[a.min(b), a.max(b)])
    }

    /// The point of some surfaces next to a point.
    fn placed(
        &self,
        regions: &[u32],
        touching: &BTreeSet<[u32; 2]>,
        start: Point,
    ) -> Result<Point, &'static str> {
        let at = match *regions {
            [] => return Ok(start),
            [a] => self.surface(a).closest(start),
            [a, b] => {
                let is_touching = self.is_touching(a, b, touching);
                on_two(self.surface(a), self.surface(b), is_touching, start)
            }
            _ => {
                let mut pairs = Vec::new();
                for (n, &a) in regions.iter().enumerate() {
                    for &b in &regions[n + 1..] {
                        if self.is_touching(a, b, touching) {
                            pairs.push((self.surface(a), self.surface(b)));
                        }
                    }
                }
                let all: Vec<&Primitive> = regions.iter().map(|&r| self.surface(r)).collect();
                on_all(&all, &pairs, start, self.edge)
            }
        };
        let off = regions.iter().map(|&r| self.surface(r).distance(at).0.abs()).fold(0.0, f64::max);
        if !at.coords.iter().all(|x| x.is_finite()) || off > ON * self.edge {
            return Err(match regions.len() {
                2 => "its two surfaces do not meet there",
                _ => "its surfaces have no common point there",
            });
        }
        if (at - start).norm() > FARTHEST * self.edge {
            return Err("its surfaces meet too far from the scan");
        }
        Ok(at)
    }

    /// Makes the vertices of a border follow each other along its curve.
    fn put_in_order(&self, border: &Border, touching: &BTreeSet<[u32; 2]>, points: &mut [Point]) {
        let vertices = &border.vertices;
        if border.is_closed || vertices.len() < 3 {
            return;
        }
        let [a, b] = border.pair;
        let is_touching = self.is_touching(a, b, touching);
        let (x, y) = (self.surface(a), self.surface(b));
        let place = |p: Point| on_two(x, y, is_touching, p);
        let n = vertices.len() - 1;
        let own: Vec<Point> = vertices.iter().map(|&v| points[v as usize]).collect();
        // The direction of the curve, that of the border as a whole.
        let mut along: Vec<f64> = vec![0.0];
        let mut tangent = own[n] - own[0];
        for pair in own.windows(2) {
            let step = pair[1] - pair[0];
            let middle = nalgebra::center(&pair[0], &pair[1]);
            let mut direction =
                if is_touching { tangent } else { x.normal(middle).cross(&y.normal(middle)) };
            if direction.dot(&tangent) < 0.0 {
                direction = -direction;
            }
            let sign = if step.dot(&direction) < 0.0 { -1.0 } else { 1.0 };
            along.push(along[along.len() - 1] + sign * step.norm());
            if sign > 0.0 && step.norm() > 0.0 {
                tangent = step;
            }
        }
        let total = along[n];
        let is_ordered = along.windows(2).all(|w| w[1] > w[0]);
        if is_ordered || total <= 0.0 {
            return;
        }
        // Those that do not pass a vertex before or behind them stay.
        let mut kept: Vec<usize> = vec![0];
        for k in 1..n {
            let last = kept[kept.len() - 1];
            if along[k] > along[last] && along[k] < total {
                kept.push(k);
            }
        }
        kept.push(n);
        for pair in kept.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            for k in from + 1..to {
                let share = (k - from) as f64 / (to - from) as f64;
                points[vertices[k] as usize] = place(own[from] + share * (own[to] - own[from]));
            }
        }
    }
}

/// The point next to a point on the curve in which two surfaces cross or touch.
fn on_two(a: &Primitive, b: &Primitive, is_touching: bool, start: Point) -> Point {
    if is_touching { contact(a, b, start) } else { crossing(a, b, start) }
}

/// The point of several surfaces next to a point, by steps of least length.
fn on_all(
    surfaces: &[&Primitive],
    touching: &[(&Primitive, &Primitive)],
    start: Point,
    edge: f64,
) -> Point {
    let residual = |p: Point| {
        let mut rows: Vec<f64> = surfaces.iter().map(|s| s.distance(p).0).collect();
        for (a, b) in touching {
            let off = p - contact(a, b, p);
            rows.extend([off.x, off.y, off.z]);
        }
        DVector::from_vec(rows)
    };
    let h = STEP * edge;
    let mut at = start;
    for _ in 0..STEPS {
        let rows = residual(at);
        let columns = [Vector::x(), Vector::y(), Vector::z()]
            .map(|e| (residual(at + h * e) - residual(at - h * e)) / (2.0 * h));
        let svd = DMatrix::from_columns(&columns).svd(true, true);
        let Ok(step) = svd.solve(&-rows, HELD * svd.singular_values.max()) else { break };
        at += Vector::new(step[0], step[1], step[2]);
        if step.norm() < f64::EPSILON * at.coords.norm() {
            break;
        }
    }
    at
}

/// The mesh with one vertex for those that moved to one place, and the numbers that its triangles had. An edge stays if the
/// mesh would not be manifold without it.
fn joined(mesh: Mesh, reach: f64) -> (Mesh, Vec<u32>) {
    let Mesh { points, mut triangles } = mesh;
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for (t, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|v| around[v.index()].push(t as u32));
    }
    let mut is_gone = vec![false; triangles.len()];
    let mut is_done = false;
    while !is_done {
        is_done = true;
        for t in 0..triangles.len() {
            for k in 0..3 {
                let [a, b] = [triangles[t][k], triangles[t][(k + 1) % 3]];
                let apart = (points[a.index()] - points[b.index()]).norm();
                if is_gone[t] || apart > reach || !is_free(&triangles, &around, a, b) {
                    continue;
                }
                is_done = false;
                for o in std::mem::take(&mut around[b.index()]) {
                    let corners = &mut triangles[o as usize];
                    if corners.contains(&a) {
                        is_gone[o as usize] = true;
                        for v in corners.iter().filter(|&&v| v != b) {
                            around[v.index()].retain(|&other| other != o);
                        }
                    } else {
                        corners.iter_mut().filter(|v| **v == b).for_each(|v| *v = a);
                        around[a.index()].push(o);
                    }
                }
            }
        }
    }
    let kept: Vec<u32> = (0..triangles.len() as u32).filter(|&t| !is_gone[t as usize]).collect();
    let whole = Mesh { points, triangles };
    (whole.part(kept.iter().map(|&t| t as usize)).0, kept)
}

/// Whether an edge can become a point: its ends have no neighbours in common but those of its own triangles, and enough is left.
fn is_free(triangles: &[[VertexId; 3]], around: &[Vec<u32>], a: VertexId, b: VertexId) -> bool {
    let beside = |v: VertexId| {
        let corners = around[v.index()].iter().flat_map(|&t| triangles[t as usize]);
        let mut all: Vec<VertexId> = corners.filter(|&w| w != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (of_a, of_b) = (beside(a), beside(b));
    let common = of_a.iter().filter(|v| of_b.binary_search(v).is_ok());
    common.clone().count() == 2 && common.copied().all(|v| around[v.index()].len() > 3)
}
