//! Samples inside triangles that hold the surface, too: where the map draws a triangle out over
//! several knot cells, its three vertices leave the surface free between them.

use std::ops::Range;

use foldhash::HashMap;

use super::moves::reweight::MOST_RAISE;
use crate::deviation::{
    MissedTriangle, SAMPLES_PER_CELL, middles, narrowest, samples_along, spanned,
};
use crate::geometry::{Point, Uv, Vector, VertexId};
use crate::mesh::Mesh;
use crate::spline::{KnotVector, Surface};
use crate::stages::fit::TangentDistance;

/// What all samples of a triangle weigh together, in vertices: a mesh has half as many vertices
/// as triangles.
const WEIGHT: f64 = 0.5;

/// The share of what a triangle may be left by that is aimed at: raised weights bring a surface
/// to its aim from above and ever more slowly, so that an aim of 1 is not reached.
pub(crate) const AIM: f64 = 0.85;

/// A sample in a triangle, on the surface as the normals at the corners bend it and not on the
/// flat facet.
#[derive(Clone)]
pub(crate) struct InnerSample {
    corners: [VertexId; 3],
    /// The corners' shares in it.
    shares: [f64; 3],
    /// Where it is.
    pub point: Point,
    /// How it holds the surface.
    pub hold: TangentDistance,
    /// Its weight in a fit.
    pub weight: f64,
}

impl InnerSample {
    /// Its parameters, with the vertices at `uv`.
    pub(crate) fn uv(&self, uv: &[Uv]) -> Uv {
        let share = |k: usize| self.shares[k] * uv[self.corners[k].index()].coords;
        Uv::from(share(0) + share(1) + share(2))
    }
}

/// The samples of some triangles.
#[derive(Default, Clone)]
pub(crate) struct InnerSamples {
    /// All of them.
    pub all: Vec<InnerSample>,
    /// Where among them those of a triangle are.
    of: HashMap<usize, Range<usize>>,
}

impl InnerSamples {
    /// Those of a triangle.
    pub(super) fn of(&self, triangle: usize) -> Range<usize> {
        self.of.get(&triangle).cloned().unwrap_or_default()
    }

    /// The parameters of vertices at `uv` and, after them, those of the samples.
    pub(crate) fn after(&self, mut uv: Vec<Uv>) -> Vec<Uv> {
        let between: Vec<Uv> = self.all.iter().map(|sample| sample.uv(&uv)).collect();
        uv.extend(between);
        uv
    }

    /// Raises the weights of the samples of triangles that a surface leaves (Lawson's iteration).
    /// A triangle without samples gets them, and so do the triangles beside it that were
    /// `measured` and span a knot cell: the surface would leave those next.
    pub(crate) fn hold(&mut self, left: &[MissedTriangle], maker: &Maker, measured: &[usize]) {
        let mesh = maker.mesh;
        let mut beside = vec![false; mesh.points.len()];
        for &MissedTriangle { triangle, ratio } in left {
            let held = self.of(triangle);
            let samples = self.all[held.clone()].iter_mut();
            samples.for_each(|sample| sample.weight *= (ratio / AIM).powi(2).min(MOST_RAISE));
            if held.is_empty() {
                self.add(maker, triangle);
            }
            mesh.triangles[triangle].iter().for_each(|v| beside[v.index()] = true);
        }
        for &triangle in measured {
            let is_beside = mesh.triangles[triangle].iter().any(|v| beside[v.index()]);
            if is_beside && self.of(triangle).is_empty() && maker.spanned(triangle) > 1.0 {
                self.add(maker, triangle);
            }
        }
    }

    fn add(&mut self, maker: &Maker, triangle: usize) {
        let before = self.all.len();
        maker.samples(triangle, &mut self.all);
        self.of.insert(triangle, before..self.all.len());
    }
}

/// What makes samples.
pub(crate) struct Maker<'a> {
    mesh: &'a Mesh,
    normals: Vec<Vector>,
    uv: &'a [Uv],
    knots: [&'a KnotVector; 2],
    /// The widths of their narrowest spans.
    cells: [f64; 2],
}

impl<'a> Maker<'a> {
    /// One for a surface over a mesh with vertices at `uv`, whose normals are those of `holds`.
    pub(super) fn new(
        mesh: &'a Mesh,
        holds: &[TangentDistance],
        uv: &'a [Uv],
        surface: &'a Surface,
    ) -> Self {
        let normals = holds.iter().map(|hold| hold.normal).collect();
        let (knots, cells) = ([&surface.u, &surface.v], narrowest(surface));
        Maker { mesh, normals, uv, knots, cells }
    }

    /// How many of the narrowest cells a triangle spans.
    pub(crate) fn spanned(&self, triangle: usize) -> f64 {
        spanned(self.mesh.triangles[triangle].map(|v| self.uv[v.index()]), self.cells)
    }

    /// A triangle's samples, one in each part of a knot cell at the most. With a single part a surface still
    /// bends to and fro between samples, and mending does not come to an end.
    fn samples(&self, triangle: usize, to: &mut Vec<InnerSample>) {
        let corners = self.mesh.triangles[triangle];
        let n = samples_along(self.spanned(triangle));
        let shares: Vec<[f64; 3]> = self.one_a_cell(corners, n);
        let next = |k: usize| (k + 1) % 3;
        let bends =
            [0, 1, 2].map(|k| self.mesh.bend(&self.normals, corners[k], corners[next(k)]).0);
        let weight = WEIGHT / shares.len() as f64;
        to.extend(shares.into_iter().map(|shares| {
            let sum = |of: &dyn Fn(usize) -> Vector| of(0) + of(1) + of(2);
            // Quadratic, with the bends in the middles of the sides.
            let flat = sum(&|k| shares[k] * self.mesh.point(corners[k]).coords);
            let bent = sum(&|k| 4.0 * shares[k] * shares[next(k)] * bends[k]);
            let normal = sum(&|k| shares[k] * self.normals[corners[k].index()]);
            let normal = normal.try_normalize(0.0).unwrap_or_default();
            let metric = normal * normal.transpose();
            InnerSample {
                corners,
                shares,
                point: Point::from(flat + bent),
                hold: TangentDistance { normal, metric, moves: [true; 2] },
                weight,
            }
        }));
    }

    /// The span of an axis that holds `t`, and the part of it.
    fn part(&self, axis: usize, t: f64) -> (usize, usize) {
        let knots = self.knots[axis];
        let span = knots.span(t);
        let [from, to] = [span, span + 1].map(|i| knots.knots()[i]);
        (span, (SAMPLES_PER_CELL * (t - from) / (to - from)) as usize)
    }

    /// Of the middles of n² parts of a triangle the first in each part of a knot cell.
    fn one_a_cell(&self, corners: [VertexId; 3], n: usize) -> Vec<[f64; 3]> {
        let [a, b, c] = corners.map(|v| self.uv[v.index()]);
        let mut cells = Vec::new();
        let is_first = |[_, x, y]: &[f64; 3]| {
            let at = a + (b - a) * *x + (c - a) * *y;
            let cell = [0, 1].map(|k| self.part(k, at[k]));
            let is_first = !cells.contains(&cell);
            if is_first {
                cells.push(cell);
            }
            is_first
        };
        middles(n).map(|(x, y)| [1.0 - x - y, x, y]).filter(is_first).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::UvVector;

    /// A triangle on a cylinder around the y axis, of radius 10.
    #[test]
    fn samples_are_on_the_bent_surface_and_go_where_the_corners_go() {
        let at = [(0.0f64, 0.0), (0.4, 0.0), (0.2, 5.0)];
        let normals = at.map(|(a, _)| Vector::new(a.sin(), 0.0, a.cos())).to_vec();
        let on =
            |((_, y), normal): (&(f64, f64), &Vector)| Point::new(0.0, *y, 0.0) + normal * 10.0;
        let points = at.iter().zip(&normals).map(on).collect();
        let mesh = Mesh { points, triangles: vec![[0, 1, 2].map(VertexId)] };
        let uv = [Uv::new(0.0, 0.0), Uv::new(0.5, 0.0), Uv::new(0.25, 0.4)];
        let knots = KnotVector::uniform(3, 13);
        let maker = Maker { mesh: &mesh, normals, uv: &uv, knots: [&knots; 2], cells: [0.1; 2] };
        let mut samples = Vec::new();
        maker.samples(0, &mut samples);
        // It touches some fourteen cells, a quarter of some of them.
        assert!((30..60).contains(&samples.len()), "{}", samples.len());
        let weight: f64 = samples.iter().map(|sample| sample.weight).sum();
        assert!((weight - WEIGHT).abs() < 1e-12, "{weight}");
        for sample in &samples {
            let radius = sample.point.x.hypot(sample.point.z);
            // Its chords are 0.2 from the cylinder.
            assert!((radius - 10.0).abs() < 0.01, "{radius}");
            let normal = sample.hold.normal;
            assert!((normal.x * 10.0 - sample.point.x).abs() < 0.02, "{normal} {}", sample.point);
            let moved = uv.map(|at| at + UvVector::new(0.1, 0.2));
            let step = sample.uv(&moved) - sample.uv(&uv);
            assert!((step - UvVector::new(0.1, 0.2)).norm() < 1e-12, "{step}");
        }
    }
}
