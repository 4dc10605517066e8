//! Control points of B-splines from the polynomial pieces of a regular part of the surface.

use super::PatchSource;
use crate::geometry::Vector;
use crate::spline::KnotVector;
use crate::spline::subdivision::REGULAR;

/// The polynomial pieces of a block: for each quad whose four vertices are regular, the 4 × 4 control
/// points of its uniform bicubic.
pub(super) struct Pieces {
    side: usize,
    /// Point (i, j), counted from −1, is at `4 (j + 1) + i + 1`.
    grids: Vec<Option<[Vector; 16]>>,
}

/// The uniform bicubic of a quad, or `None` if one of its vertices is irregular.
pub(super) fn grid(source: &PatchSource, quad: usize) -> Option<[Vector; 16]> {
    source.surface.is_regular(quad).then(|| {
        let mut grid = [Vector::zeros(); 16];
        for (&place, &v) in REGULAR.iter().zip(source.surface.control(quad)) {
            grid[place] = source.control[v as usize];
        }
        grid
    })
}

/// The blossom of the uniform cubic on [0, 1] with these control points.
pub(super) fn blossom(control: [Vector; 4], arguments: [f64; 3]) -> Vector {
    let mut d = control;
    for (level, t) in (1..=3).zip(arguments) {
        for j in (level..=3).rev() {
            let low = j as f64 - 3.0;
            let high = (j + 1 - level) as f64;
            let a = (t - low) / (high - low);
            d[j] = d[j - 1] * (1.0 - a) + d[j] * a;
        }
    }
    d[3]
}

/// The spans of unit length that the support of B-spline `i` meets, from the middle one outwards.
pub(super) fn spans(knots: &KnotVector, i: usize) -> Vec<usize> {
    let [low, high] = [knots.knots()[i], knots.knots()[i + 4]];
    let (first, last) = (low.floor() as usize, high.ceil() as usize);
    let middle = (first + last) / 2;
    let mut spans: Vec<usize> = (first..last).collect();
    spans.sort_by_key(|&s| (s.abs_diff(middle), s));
    spans
}

/// The arguments of the blossom that is control point `i`, on the span that begins at `first`.
pub(super) fn arguments(knots: &KnotVector, i: usize, first: usize) -> [f64; 3] {
    [1, 2, 3].map(|k| knots.knots()[i + k] - first as f64)
}

impl Pieces {
    pub(super) fn new(source: &PatchSource, block: usize) -> Self {
        let side = source.mesh.side;
        let quads = side * side * block..side * side * (block + 1);
        Pieces { side, grids: quads.map(|quad| grid(source, quad)).collect() }
    }

    /// Control point (i, j) of the block's patch, or `None` if its support is inside a quad with an
    /// irregular vertex.
    pub(super) fn control(&self, knots: &KnotVector, i: usize, j: usize) -> Option<Vector> {
        let columns = spans(knots, i);
        let cells = spans(knots, j).into_iter().flat_map(|b| columns.iter().map(move |&a| (a, b)));
        let (grid, a, b) =
            cells.into_iter().find_map(|(a, b)| Some((self.grids[self.side * b + a]?, a, b)))?;
        let (u, v) = (arguments(knots, i, a), arguments(knots, j, b));
        let row = |j: usize| blossom([0, 1, 2, 3].map(|i| grid[4 * j + i]), u);
        Some(blossom([0, 1, 2, 3].map(row), v))
    }
}
