//! Whether a grid is one. A raster goes in; the answer comes out.
//!
//! Some programs write a header with rows and columns before points in any order. Neighbours in such
//! a grid are far from each other.

use super::raster::{GridStep, Raster};
use crate::geometry::{Point, SAMPLE};
use crate::mesh::Neighbours;
use crate::statistics::median;

/// Why a grid is not believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GridDoubt {
    /// Two cells have the same point, a cell has a point that does not exist, or the number of cells
    /// is not that of rows times columns.
    #[error("its cells contradict each other or the points")]
    Inconsistent,
    /// Neighbours in the grid are not neighbours in space.
    #[error("neighbours in it are not neighbours in space")]
    MadeUp,
    /// Hardly any patch of 5 × 5 cells is complete.
    #[error("too many of its cells are empty")]
    Sparse,
}

/// The median edge of a true grid is at most this multiple of the median distance of nearest
/// neighbours. It is about 1 to 2, as the surface is tilted; of made-up grids it is 10 and more.
const LONGEST_EDGE: f64 = 3.0;

/// Whether neighbours in the grid are neighbours in space.
pub(super) fn has_near_neighbours(points: &[Point], raster: &Raster) -> bool {
    let mut lengths = raster.lengths(GridStep::Column);
    lengths.extend(raster.lengths(GridStep::Row));
    lengths.retain(|length| !length.is_nan());
    let Some(edge) = median(&mut lengths) else { return false };
    let near = Neighbours::new(points);
    let mut found = Vec::new();
    let distance = |p: &Point| {
        near.nearest_n(*p, 2, &mut found);
        found.get(1).map(|(_, squared)| squared.sqrt())
    };
    let looked_at = points.iter().step_by(points.len().div_ceil(SAMPLE));
    let mut distances: Vec<f64> = looked_at.filter_map(distance).collect();
    median(&mut distances).is_some_and(|distance| edge <= LONGEST_EDGE * distance)
}
