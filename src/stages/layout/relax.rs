//! Relaxation of a quad mesh on a scan, one vertex at a time.
//!
//! The energy of a corner of a quad is that of its distance from a square (MIPS: Hormann, Greiner
//! 2000) and of its area from that of its neighbours. Determinants that are negative or small are
//! regularized, so that the energy is finite also where quads are turned over (Garanzha et al.,
//! "Foldover-free maps in 50 lines of code", 2021). Vertices walk over the triangles of the scan, so
//! they cannot jump to another sheet.

use nalgebra::{Matrix2, Vector2};

use super::base::TrianglePlace;
use super::ground::Ground;
use crate::geometry::{Point, SAME_SIDE, Vector, plane_axes};
use crate::mesh::QuadMesh;

/// The weight of areas, beside that of shapes. Without it quads at vertices with three quads become
/// large, and with more angles become uneven.
const AREA: f64 = 0.3;

/// The regularization of determinants, as a share of the mean area of the corners around a vertex.
const REGULAR: f64 = 0.05;

/// The cosine of the angle between a corner and the scan at which the barrier is (63°). It lies
/// beyond the angle of a bad quad, so that quads inside the barrier are good.
const BARRIER: f64 = 0.45;

/// Steps that are halved this often without a lower energy are given up.
const HALVINGS: usize = 5;

/// The length of the differences for derivatives, as a share of the length of a side.
const DIFFERENCE: f64 = 1e-3;

/// A quad mesh whose vertices move on a scan.
pub(super) struct Relaxed<'a> {
    pub mesh: &'a QuadMesh,
    pub ground: &'a mut Ground,
    pub places: Vec<TrianglePlace>,
    pub points: Vec<Point>,
    pub normals: Vec<Vector>,
    /// The weight of each quad.
    weights: Vec<f64>,
    /// The quads at each vertex, with the number of the corner.
    around: Vec<Vec<(u32, u8)>>,
    /// Vertices that found no better place, and around which nothing has changed since. They would find
    /// none again.
    settled: Vec<bool>,
    /// Whether the last sweep had the barrier.
    has_barrier: bool,
}

impl<'a> Relaxed<'a> {
    pub(super) fn new(
        mesh: &'a QuadMesh,
        ground: &'a mut Ground,
        places: Vec<TrianglePlace>,
    ) -> Self {
        let mut around = vec![Vec::new(); places.len()];
        for (q, quad) in mesh.quads.iter().enumerate() {
            (0..4).for_each(|k| around[quad[k].index()].push((q as u32, k as u8)));
        }
        let points = places.iter().map(|place| ground.point(place)).collect();
        let normals = places.iter().map(|place| ground.normal(place)).collect();
        let weights = vec![1.0; mesh.quads.len()];
        let settled = vec![false; places.len()];
        let has_barrier = false;
        Relaxed { mesh, ground, places, points, normals, weights, around, settled, has_barrier }
    }

    /// Multiplies the weights of some quads.
    pub(crate) fn weigh(&mut self, quads: &[usize], factor: f64) {
        for &q in quads {
            self.weights[q] *= factor;
            self.mesh.quads[q].iter().for_each(|v| self.settled[v.index()] = false);
        }
    }

    /// Smooths the ground under some quads.
    pub(crate) fn smooth_under(&mut self, quads: &[usize]) {
        let corners = quads.iter().flat_map(|&q| self.mesh.quads[q]);
        let mut under: Vec<u32> = corners.map(|v| self.places[v.index()].triangle).collect();
        under.sort_unstable();
        under.dedup();
        self.ground.smooth_around(&under);
        for (v, place) in self.places.iter().enumerate() {
            self.points[v] = self.ground.point(place);
            self.normals[v] = self.ground.normal(place);
        }
        self.settled.fill(false);
    }

    /// The mean length of the sides of a quad, as a multiple of the ground's edges under it.
    pub(crate) fn ground_edges(&self, quad: usize) -> f64 {
        let quad = self.mesh.quads[quad].map(|v| v.index());
        let side = |k: usize| (self.points[quad[(k + 1) % 4]] - self.points[quad[k]]).norm();
        let edge = |v: usize| self.ground.edge(self.places[v].triangle);
        (0..4).map(side).sum::<f64>() / quad.into_iter().map(edge).sum::<f64>()
    }

    /// Moves all vertices, or those that are `chosen`, once. With the barrier no quad may turn
    /// farther from the scan than the gate allows.
    pub(crate) fn sweep(&mut self, chosen: Option<&[bool]>, barrier: bool) {
        if barrier != self.has_barrier {
            self.settled.fill(false);
            self.has_barrier = barrier;
        }
        for v in 0..self.points.len() {
            if !self.settled[v] && chosen.is_none_or(|chosen| chosen[v]) {
                self.settled[v] = !self.moves(v, barrier);
            }
        }
    }

    /// Moves a vertex to a place with less energy, if one is found. Returns whether it is.
    fn moves(&mut self, v: usize, barrier: bool) -> bool {
        let area = self.mean_area(v).max(f64::MIN_POSITIVE);
        let (x, y) = plane_axes(self.normals[v]);
        let h = DIFFERENCE * area.sqrt();
        let at = |i: f64, j: f64| {
            self.energy(v, self.points[v] + h * (i * x + j * y), self.normals[v], area, barrier)
        };
        let here = at(0.0, 0.0);
        let [east, west, north, south, corner] =
            [at(1.0, 0.0), at(-1.0, 0.0), at(0.0, 1.0), at(0.0, -1.0), at(1.0, 1.0)];
        let gradient = Vector2::new(east - west, north - south) / (2.0 * h);
        let mixed = (corner - east - north + here) / (h * h);
        let hessian = Matrix2::new(
            (east + west - 2.0 * here) / (h * h),
            mixed,
            mixed,
            (north + south - 2.0 * here) / (h * h),
        );
        let newton = hessian.cholesky().map(|factor| factor.solve(&gradient));
        let length = gradient.norm().max(f64::MIN_POSITIVE);
        let mut step = -newton.unwrap_or(gradient * (0.5 * area.sqrt() / length));
        let most = area.sqrt();
        if step.norm() > most {
            step *= most / step.norm();
        }
        for _ in 0..HALVINGS {
            let place = self.ground.walked(self.places[v], step.x * x + step.y * y);
            let (point, normal) = (self.ground.point(&place), self.ground.normal(&place));
            if self.energy(v, point, normal, area, barrier) < here {
                (self.places[v], self.points[v], self.normals[v]) = (place, point, normal);
                let beside = self.around[v].iter().flat_map(|&(q, _)| self.mesh.quads[q as usize]);
                beside.for_each(|w| self.settled[w.index()] = false);
                return true;
            }
            step *= 0.5;
        }
        false
    }

    /// The corners of the quads around a vertex that depend on it: the vertex at the corner, the
    /// next one and the one before.
    fn corners(&self, v: usize) -> impl Iterator<Item = (u32, [usize; 3])> + '_ {
        self.around[v].iter().flat_map(move |&(q, k)| {
            let quad = self.mesh.quads[q as usize];
            let at = move |k: usize| quad[k % 4].index();
            let k = k as usize;
            [k, k + 1, k + 3].map(|k| (q, [at(k), at(k + 1), at(k + 3)]))
        })
    }

    fn mean_area(&self, v: usize) -> f64 {
        let areas = self.corners(v).map(|(_, [a, b, c])| {
            let [a, b, c] = [a, b, c].map(|v| self.points[v]);
            (b - a).cross(&(c - a)).norm()
        });
        let (sum, count) = areas.fold((0.0, 0.0), |(sum, count), area| (sum + area, count + 1.0));
        sum / f64::max(count, 1.0)
    }

    /// The energy of the corners around a vertex if it were at `point`.
    fn energy(&self, v: usize, point: Point, normal: Vector, area: f64, barrier: bool) -> f64 {
        let at = |w: usize| if w == v { point } else { self.points[w] };
        let each = self.corners(v).map(|(q, [a, b, c])| {
            let (e, f) = (at(b) - at(a), at(c) - at(a));
            let n = if a == v { normal } else { self.normals[a] };
            let cross = e.cross(&f);
            let facing = cross.dot(&n);
            let determinant = match barrier {
                true => (facing - BARRIER * cross.norm()) / (1.0 - BARRIER),
                false => facing,
            };
            let regular = REGULAR * area;
            let d = 0.5 * (determinant + determinant.hypot(regular));
            let shape = (e.norm_squared() + f.norm_squared()) / (2.0 * d);
            self.weights[q as usize] * (shape + AREA * (d / area + area / d))
        });
        each.sum()
    }

    /// The quads with a corner that faces another side than the scan does.
    pub(crate) fn bad(&self) -> Vec<usize> {
        let is_bad = |&q: &usize| {
            let quad = self.mesh.quads[q].map(|v| v.index());
            (0..4).any(|k| {
                let [a, b, c] = [quad[k], quad[(k + 1) % 4], quad[(k + 3) % 4]];
                let p = |v: usize| self.points[v];
                let cross = (p(b) - p(a)).cross(&(p(c) - p(a)));
                cross.dot(&self.normals[a]) <= SAME_SIDE * cross.norm()
            })
        };
        (0..self.mesh.quads.len()).filter(is_bad).collect()
    }
}
