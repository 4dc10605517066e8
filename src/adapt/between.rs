//! Where a fitted surface leaves the mesh between its vertices.
//!
//! Where the map draws triangles out over several knot cells, no sample holds the surface
//! within them: it may go anywhere, and no vertex is far from it.

use rayon::prelude::*;

use crate::geometry::{Point, Uv};
use crate::mesh::{FaceOrigin, Triangles};
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

/// The place between measured vertices where a surface is farthest from the mesh, and its
/// distance in mm. `None`: nowhere much more than `tolerance`.
pub fn farthest(
    map: &Parameterized,
    uv: &[Uv],
    surface: &Surface,
    tolerance: f64,
) -> Option<(Point, f64)> {
    let long = long_sides(map, uv, surface);
    if long.is_empty() {
        return None;
    }
    let mesh = &map.patch.mesh;
    let normals = mesh.vertex_normals();
    let at = |side: usize| {
        let (a, b) = mesh.side(side);
        let place = surface.point(nalgebra::center(&uv[a.index()], &uv[b.index()]));
        let straight = nalgebra::center(&mesh.point(a), &mesh.point(b));
        let slack = SLACK * (mesh.point(b) - mesh.point(a)).norm();
        let allowed = tolerance.max(slack) + BEND * mesh.bend(&normals, a, b).0.norm();
        ((place - straight).norm() > allowed).then_some((place, allowed))
    };
    let far: Vec<(Point, f64)> = long.into_par_iter().filter_map(at).collect();
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

/// Whether any side spans more than a knot cell, with the vertices at `uv`.
pub fn is_bare(map: &Parameterized, uv: &[Uv], surface: &Surface) -> bool {
    !long_sides(map, uv, surface).is_empty()
}

/// Halves the sides that span more than a knot cell, where the measured mesh has them.
pub fn bridge(map: &mut Parameterized, surface: &Surface) {
    let cells = Widths::new(surface);
    map.halve(HALVINGS, |a, b| cells.are_exceeded(a, b));
}

/// Sides within the measured surface, one of each edge, that are longer in the map than a
/// knot cell at their middle is wide, ascending.
fn long_sides(map: &Parameterized, uv: &[Uv], surface: &Surface) -> Vec<usize> {
    let (mesh, origin) = (&map.patch.mesh, &map.patch.origin);
    let cells = Widths::new(surface);
    let is_long = |&side: &usize| {
        let (a, b) = mesh.side(side);
        origin[side / 3] == FaceOrigin::Measured && cells.are_exceeded(uv[a.index()], uv[b.index()])
    };
    let sides = 0..3 * mesh.triangles.len();
    let mut long: Vec<usize> = sides.into_par_iter().filter(is_long).collect();
    // Those of an edge are next to each other, the lower one first.
    let edge = |side: usize| {
        let (a, b) = mesh.side(side);
        (a.min(b), a.max(b))
    };
    long.par_sort_unstable_by_key(|&side| (edge(side), side));
    let both = long.chunk_by(|&s, &t| edge(s) == edge(t)).filter(|both| both.len() == 2);
    let mut sides: Vec<usize> = both.map(|both| both[0]).collect();
    sides.sort_unstable();
    sides
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
