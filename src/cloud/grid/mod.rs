//! Triangles along the grid of a scan. A cloud with one of its scans goes in; triangles over the
//! cloud's points come out, with the spacing and the noise, or the reason why the grid is not
//! believed.
//!
//! The grid says which points are neighbours, so noise cannot mislead the triangles. They are cut
//! at jumps of depth ([`jumps`]), as Turk and Levoy ("Zippered polygon meshes from range images",
//! 1994) do, with another rule for what a jump is. The first and the last column of a scan all
//! around are not joined.

mod cells;
mod facing;
mod jumps;
mod noise;
mod raster;
#[cfg(test)]
mod tests;

use formats::Points;
use formats::points::PointScan;

pub use facing::Outside;

use crate::geometry::{Point, VertexId};
use crate::mesh::Neighbours;
use jumps::GridEdges;
use raster::{GridStep, Raster, median};

/// The triangles along a grid.
#[derive(Debug)]
pub(super) struct GridMesh {
    /// Indices of the cloud's points, counter-clockwise seen from the side that the scanner saw.
    pub(super) triangles: Vec<[VertexId; 3]>,
    /// The median spacing of the points: the square root of the area for each of them.
    pub(super) spacing: f64,
    /// The standard deviation of the points along the normal.
    pub(super) noise: f64,
    /// The number of edges that were cut because of a jump of depth.
    pub(super) cut: usize,
    /// What decided which side is outside.
    pub(super) outside: Outside,
}

/// Why a grid is not believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum GridDoubt {
    /// Two cells have the same point, or a cell has a point that does not exist.
    #[error("two of its cells have the same point")]
    Repeated,
    /// Neighbours in the grid are not neighbours in space.
    #[error("neighbours in it are not neighbours in space")]
    MadeUp,
    /// Hardly any patch of 5 × 5 cells is complete.
    #[error("too many of its cells are empty")]
    Sparse,
}

/// Edges of a true grid are at most this multiple of the distance of nearest neighbours, in the
/// median. A tilted surface takes it to 2, a made-up grid to 10 and more.
const LONGEST_EDGE: f64 = 3.0;

/// Makes triangles along the grid of scan `number`.
///
/// # Errors
/// The reason why the grid is not believed. A scan without a grid or without points has one that
/// is too sparse.
pub(super) fn triangulate_grid(cloud: &Points, number: usize) -> Result<GridMesh, GridDoubt> {
    let scan = cloud.scans.get(number).ok_or(GridDoubt::Sparse)?;
    let grid = scan.grid.as_ref().ok_or(GridDoubt::Sparse)?;
    let raster = Raster::new(cloud, grid).ok_or(GridDoubt::Repeated)?;
    if !has_near_neighbours(cloud, scan, &raster) {
        return Err(GridDoubt::MadeUp);
    }
    let edges = GridEdges::new(&raster);
    let mut triangles = cells::triangles(&raster, &edges);
    let spacing = spacing(cloud, &triangles);
    let noise = noise::measure(&raster, &edges, scan.points.len(), spacing);
    let noise = noise.ok_or(GridDoubt::Sparse)?;
    let outside = facing::face_scanner(cloud, scan, &mut triangles);
    Ok(GridMesh { triangles, spacing, noise, cut: edges.cut(), outside })
}

/// The number of points whose nearest neighbours are looked at. The share of such points is known
/// to 3 %, and true and made-up grids differ by far more.
const LOOKED_AT: usize = 1000;

/// Whether neighbours in the grid are neighbours in space: at least half of the points have no
/// other point within the median edge divided by [`LONGEST_EDGE`].
fn has_near_neighbours(cloud: &Points, scan: &PointScan, raster: &Raster) -> bool {
    let mut lengths = raster.lengths(GridStep::Column);
    lengths.extend(raster.lengths(GridStep::Row));
    lengths.retain(|length| !length.is_nan());
    let Some(edge) = median(&mut lengths) else { return false };
    let Some(positions) = cloud.positions.get(scan.points.clone()) else { return false };
    let points: Vec<Point> = positions.iter().map(|&p| Point::from(p)).collect();
    if points.is_empty() {
        return false;
    }
    let near = Neighbours::new(&points);
    let mut found = Vec::new();
    let mut looked_at = points.iter().step_by(points.len().div_ceil(LOOKED_AT));
    let count = looked_at.len();
    let is_alone = |p: &&Point| {
        near.within(**p, edge / LONGEST_EDGE, &mut found);
        found.len() <= 1
    };
    2 * looked_at.by_ref().filter(is_alone).count() >= count
}

/// The median over the triangles of the root of twice their area: a point has two triangles.
fn spacing(cloud: &Points, triangles: &[[VertexId; 3]]) -> f64 {
    let point = |v: VertexId| Point::from(cloud.positions[v.index()]);
    let side = |t: &[VertexId; 3]| {
        let [a, b, c] = t.map(point);
        (b - a).cross(&(c - a)).norm().sqrt()
    };
    let mut sides: Vec<f64> = triangles.iter().map(side).collect();
    median(&mut sides).unwrap_or(0.0)
}
