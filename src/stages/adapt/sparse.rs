//! Vertices for a map whose triangles are larger than the knot cells.
//!
//! Where the map draws triangles out over several knot cells, no sample holds the surface
//! within them: it may go anywhere, and no vertex is far from it.

use super::attempt::Attempt;
use super::moves::correct::{LEAST_AREA, correct};
use super::problem::Problem;
use crate::deviation::narrowest;
use crate::geometry::Uv;
use crate::mesh::Parameterized;
use crate::spline::{KnotVector, Surface};
use crate::stages::fit;

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
pub(crate) fn needs_vertices(problem: &Problem, of: &Attempt, uv: &[Uv]) -> bool {
    let surface = &of.surface;
    if problem.options.method == fit::Method::Blend || !are_sparse(problem.map, uv, surface) {
        return false;
    }
    let state = correct(problem, of, LEAST_AREA);
    let folded = fit::inverted_share(surface, &state.samples(problem), &state.holds(problem));
    let misses = || {
        let left = problem.left(surface, uv, 1.0).len();
        left as f64 / problem.measured_triangles.len().max(1) as f64
    };
    folded < CRUMPLED && (folded > 0.0 || misses() > problem.goal.outliers)
}

/// Halves the sides that span more than a knot cell.
pub(crate) fn halve(map: &mut Parameterized, surface: &Surface) {
    let cells = CellWidths::new(surface);
    map.halve(HALVINGS, |a, b| cells.are_exceeded(a, b));
}

/// Whether a side of the map, with the vertices at `uv`, spans more than a knot cell of a
/// surface.
fn are_sparse(map: &Parameterized, uv: &[Uv], surface: &Surface) -> bool {
    let cells = CellWidths::new(surface);
    !map.long_sides(uv, |a, b| cells.are_exceeded(a, b)).is_empty()
}

/// How wide a surface's knot cells are.
struct CellWidths<'a> {
    knots: [&'a KnotVector; 2],
    narrowest: [f64; 2],
}

impl<'a> CellWidths<'a> {
    fn new(surface: &'a Surface) -> Self {
        CellWidths { knots: [&surface.u, &surface.v], narrowest: narrowest(surface) }
    }

    /// Whether two parameter points are farther apart than the cell between them is wide.
    fn are_exceeded(&self, a: Uv, b: Uv) -> bool {
        let middle: Uv = nalgebra::center(&a, &b);
        (0..2).any(|k| {
            let length = (a[k] - b[k]).abs();
            length > self.narrowest[k] && length > self.width(k, middle[k])
        })
    }

    /// The width of the span of an axis at `t`.
    fn width(&self, axis: usize, t: f64) -> f64 {
        let knots = self.knots[axis];
        let span = knots.span(t);
        knots.knots()[span + 1] - knots.knots()[span]
    }
}
