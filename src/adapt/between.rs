//! Where a fitted surface leaves the mesh between its vertices.
//!
//! Where the map draws triangles out over several knot cells, no sample holds the surface
//! within them: it may go anywhere, and no vertex is far from it.

use crate::geometry::Uv;
use crate::mesh::Parameterized;
use crate::spline::{KnotVector, Surface};

/// How often such sides are halved. Each time holds the surface in more places; along rims,
/// whose sides stay, it also makes slivers, which leave folds less room to be taken out.
const HALVINGS: usize = 2;

/// Whether a side of the map, with the vertices at `uv`, spans more than a knot cell of a
/// surface: nothing need hold that within the cell.
pub fn are_sparse(map: &Parameterized, uv: &[Uv], surface: &Surface) -> bool {
    let cells = Widths::new(surface);
    !map.long_sides(uv, |a, b| cells.are_exceeded(a, b)).is_empty()
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
