//! Where a fitted surface leaves the mesh between its vertices.
//!
//! Where the map draws triangles out over several knot cells, no sample holds the surface
//! within them: it may go anywhere, and no vertex is far from it.

use rayon::prelude::*;

use crate::geometry::{Point, Uv};
use crate::mesh::Triangles;
use crate::parameterize::Parameterized;
use crate::spline::{KnotVector, Surface};

/// A middle of an edge bends with the surface, and may be off by as much again …
const BEND: f64 = 2.0;

/// … and by this share of the edge: less than that is what smooth surfaces do between
/// points of a noisy scan.
const SLACK: f64 = 0.25;

/// How often such sides are halved. Each time holds the surface in more places; along rims,
/// whose sides stay, it also makes slivers, which leave folds less room to be taken out.
const HALVINGS: usize = 2;

/// Sides of the map that span more than a knot cell of a surface.
pub struct Bare<'a> {
    map: &'a Parameterized,
    uv: &'a [Uv],
    surface: &'a Surface,
    sides: Vec<usize>,
}

impl<'a> Bare<'a> {
    /// Those with the vertices at `uv`.
    pub fn new(map: &'a Parameterized, uv: &'a [Uv], surface: &'a Surface) -> Self {
        let cells = Widths::new(surface);
        let sides = map.long_sides(uv, |a, b| cells.are_exceeded(a, b));
        Bare { map, uv, surface, sides }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty()
    }

    /// The place on such a side where the surface is farthest from the mesh, and its
    /// distance in mm. `None`: nowhere much more than `tolerance`.
    pub fn farthest(&self, tolerance: f64) -> Option<(Point, f64)> {
        if self.is_empty() {
            return None;
        }
        let (mesh, uv) = (&self.map.patch.mesh, self.uv);
        let normals = mesh.vertex_normals();
        let at = |&side: &usize| {
            let (a, b) = mesh.side(side);
            let place = self.surface.point(nalgebra::center(&uv[a.index()], &uv[b.index()]));
            let straight = nalgebra::center(&mesh.point(a), &mesh.point(b));
            let slack = SLACK * (mesh.point(b) - mesh.point(a)).norm();
            let allowed = tolerance.max(slack) + BEND * mesh.bend(&normals, a, b).0.norm();
            ((place - straight).norm() > allowed).then_some((place, allowed))
        };
        let far: Vec<(Point, f64)> = self.sides.par_iter().filter_map(at).collect();
        if far.is_empty() {
            return None;
        }
        // It may have slid along the mesh.
        let triangles = Triangles::new(mesh);
        let off = |&(place, allowed): &(Point, f64)| {
            let distance = triangles.distance(place);
            (distance > allowed).then_some((place, distance))
        };
        let off: Vec<(Point, f64)> = far.par_iter().filter_map(off).collect();
        off.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Halves the sides that span more than a knot cell.
pub fn bridge(map: &mut Parameterized, surface: &Surface) {
    let cells = Widths::new(surface);
    map.halve(HALVINGS, |a, b| cells.are_exceeded(a, b));
}

/// How wide a surface's knot cells are.
struct Widths<'a>([Spans<'a>; 2]);

impl<'a> Widths<'a> {
    fn new(surface: &'a Surface) -> Self {
        Widths([&surface.u, &surface.v].map(Spans::new))
    }

    /// Whether two parameter points are farther apart than the cell between them is wide.
    fn are_exceeded(&self, a: Uv, b: Uv) -> bool {
        let middle: Uv = nalgebra::center(&a, &b);
        (0..2).any(|k| self.0[k].are_shorter((a[k] - b[k]).abs(), middle[k]))
    }
}

/// The knot spans of an axis.
struct Spans<'a> {
    knots: &'a KnotVector,
    narrowest: f64,
}

impl<'a> Spans<'a> {
    fn new(knots: &'a KnotVector) -> Self {
        let widths = knots.breaks();
        let widths = widths.windows(2).map(|ends| ends[1] - ends[0]);
        Spans { knots, narrowest: widths.fold(f64::MAX, f64::min) }
    }

    /// Whether a length is more than the width of the span at `t`.
    fn are_shorter(&self, length: f64, t: f64) -> bool {
        length > self.narrowest && {
            let i = self.knots.span(t);
            length > self.knots.knots()[i + 1] - self.knots.knots()[i]
        }
    }
}
