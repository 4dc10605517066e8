//! Vertices for a map whose triangles are larger than the knot cells.
//!
//! Where the map draws triangles out over several knot cells, no sample holds the surface
//! within them: it may go anywhere, and no vertex is far from it.

use super::attempt::Attempt;
use super::moves::correct::{LEAST_AREA, correct};
use super::problem::Problem;
use crate::fit;
use crate::geometry::Uv;
use crate::mesh::Parameterized;
use crate::spline::{KnotVector, Surface};

/// How often the sides of such triangles are halved. Each time holds the surface in more places.
/// Along rims, whose sides stay, it also makes slivers, which leave less room for taking folds
/// out.
const HALVINGS: usize = 2;

/// The share of inverted Jacobian samples from which on the scan, or its map, is crumpled, and
/// the mesh between the vertices is no guide.
const CRUMPLED: f64 = 0.3;

/// Whether an attempt, with the vertices at `uv`, shows that vertices are missing: it leaves the
/// mesh between them, or has folds and may leave the mesh when these are taken out. A crumpled
/// surface gets none.
pub fn needs_vertices(problem: &Problem, of: &Attempt, uv: &[Uv]) -> bool {
    let surface = &of.surface;
    if problem.options.method == fit::Method::Blend || !are_sparse(problem.map, uv, surface) {
        return false;
    }
    let state = correct(problem, of, LEAST_AREA);
    let folded = fit::folded(surface, &state.samples(problem), &state.holds(problem));
    let misses = || {
        let left = problem.left(surface, uv, 1.0).len();
        left as f64 / problem.measured_triangles.len().max(1) as f64
    };
    folded < CRUMPLED && (folded > 0.0 || misses() > problem.goal.outliers)
}

/// Halves the sides that span more than a knot cell.
pub fn halve(map: &mut Parameterized, surface: &Surface) {
    let cells = Widths::new(surface);
    map.halve(HALVINGS, |a, b| cells.are_exceeded(a, b));
}

/// Whether a side of the map, with the vertices at `uv`, spans more than a knot cell of a
/// surface.
fn are_sparse(map: &Parameterized, uv: &[Uv], surface: &Surface) -> bool {
    let cells = Widths::new(surface);
    !map.long_sides(uv, |a, b| cells.are_exceeded(a, b)).is_empty()
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
