//! Jumps of depth in a grid. A raster goes in; the edges between neighbouring cells come out, each
//! joined, cut or absent.
//!
//! An edge is a jump if it is long in comparison with the edges around it, and if the surface on
//! neither side leads up to it: a step of the surface comes without warning, a steep flank does
//! not. Turk and Levoy ("Zippered polygon meshes from range images", 1994) compare lengths only,
//! which also cuts steep flanks. All comparisons are between displacements in space, so that they
//! need no viewpoint and hold for parallel, central and spherical rays.

use rayon::prelude::*;

use super::raster::{GridCell, GridStep, Raster};
use crate::geometry::Vector;
use crate::statistics::median;

/// An edge may be a jump from this multiple of the median around it. A lower value tests noise of a
/// third of the spacing, a higher one misses steps of two spacings.
const LONG: f64 = 2.0;

/// A side does not lead up to an edge if the edge and the mean step on this side differ by more
/// than this share of the edge. It is 0.5 for a flank of two edges, which must stay, and 1 for a
/// step. Noise makes both vary by about 0.2.
const SURPRISE: f64 = 0.7;

/// An edge of this multiple of the median around it is a jump in any case. A flank within it is
/// less steep than 84° where rays are perpendicular. A higher value joins objects through the
/// pixels that lie between them.
const TOO_LONG: f64 = 10.0;

/// The edges of a window reach this far from its middle: five by five edges of the same direction.
const REACH: isize = 2;

/// What is between two neighbouring cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GridEdge {
    /// One of the cells has no point, or does not exist.
    Absent,
    /// Both points are on the same piece of the surface.
    Joined,
    /// The surface has a jump between them.
    Cut,
}

/// The edges of a raster.
#[derive(Debug)]
pub(super) struct GridEdges {
    columns: usize,
    /// To the next column, and to the next row, by the number of the first cell.
    edges: [Vec<GridEdge>; 2],
}

impl GridEdges {
    /// Finds the jumps of a raster.
    pub(super) fn new(raster: &Raster) -> Self {
        let edges = [GridStep::Column, GridStep::Row].map(|step| classify(raster, step));
        GridEdges { columns: raster.columns(), edges }
    }

    /// Whether the edge from a cell of the raster is there and not cut.
    pub(super) fn is_joined(&self, (row, column): GridCell, step: GridStep) -> bool {
        self.edges[step as usize][row * self.columns + column] == GridEdge::Joined
    }

    /// The number of cut edges.
    pub(super) fn cut(&self) -> usize {
        self.edges.iter().flatten().filter(|&&edge| edge == GridEdge::Cut).count()
    }
}

fn classify(raster: &Raster, step: GridStep) -> Vec<GridEdge> {
    let lengths = raster.lengths(step);
    let classified = |window: &mut Vec<f64>, number: usize| {
        let (length, cell) = (lengths[number], raster.cell(number));
        if length.is_nan() {
            return GridEdge::Absent;
        }
        window.clear();
        window.extend(around(raster, &lengths, cell));
        let usual = median(window).unwrap_or(length);
        match length > TOO_LONG * usual || length > LONG * usual && is_surprise(raster, cell, step)
        {
            true => GridEdge::Cut,
            false => GridEdge::Joined,
        }
    };
    (0..lengths.len()).into_par_iter().map_init(Vec::new, classified).collect()
}

/// The lengths around an edge, its own included.
fn around<'a>(
    raster: &'a Raster,
    lengths: &'a [f64],
    cell: GridCell,
) -> impl Iterator<Item = f64> + 'a {
    let moved = move |cell, step| (-REACH..=REACH).filter_map(move |n| raster.moved(cell, step, n));
    let cells = moved(cell, GridStep::Row).flat_map(move |row| moved(row, GridStep::Column));
    let lengths = cells.map(|(row, column)| lengths[row * raster.columns() + column]);
    lengths.filter(|length| !length.is_nan())
}

/// Whether the surface on neither side of an edge leads up to it. A side without points does not.
fn is_surprise(raster: &Raster, cell: GridCell, step: GridStep) -> bool {
    let Some(edge) = raster.displacement(cell, step, 1) else { return false };
    let before = mean_step(raster, Some(cell), step, -1);
    let after = mean_step(raster, raster.moved(cell, step, 1), step, 1);
    [before, after].iter().flatten().all(|mean| (edge - mean).norm() > SURPRISE * edge.norm())
}

/// The mean of the two edges, or of the one edge, on the side of a cell that `sign` tells.
fn mean_step(
    raster: &Raster,
    cell: Option<GridCell>,
    step: GridStep,
    sign: isize,
) -> Option<Vector> {
    let edges = |count: isize| {
        let displacement = raster.displacement(cell?, step, sign * count)?;
        Some(displacement / (sign * count) as f64)
    };
    // The second point alone says nothing: the missing one may lie behind another jump.
    let one = edges(1)?;
    Some(edges(2).unwrap_or(one))
}
