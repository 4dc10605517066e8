//! The triangles of a grid. A raster and its edges go in; triangles whose sides cross no jump come
//! out, as indices of the cloud's points.
//!
//! Four neighbouring cells with points make two triangles, three make one. All triangles run
//! around in the same direction of the grid.

use rayon::prelude::*;

use super::jumps::GridEdges;
use super::raster::{GridCell, GridStep, Raster};
use crate::geometry::VertexId;

/// Makes the triangles, in the order of the cells.
pub(super) fn triangles(raster: &Raster, edges: &GridEdges) -> Vec<[VertexId; 3]> {
    let squares = (0..raster.rows().saturating_sub(1)).into_par_iter();
    let of_row = |row| {
        let columns = 0..raster.columns().saturating_sub(1);
        columns.flat_map(move |column| square(raster, edges, (row, column)))
    };
    squares.flat_map_iter(of_row).collect()
}

/// The triangles between a cell and the next ones in its row and column.
///
/// A triangle has two edges of the grid and a diagonal. It stays if neither of the edges is cut.
/// Of the two diagonals that one is taken with which more triangles stay, else the shorter one.
fn square(
    raster: &Raster,
    edges: &GridEdges,
    (row, column): GridCell,
) -> impl Iterator<Item = [VertexId; 3]> {
    // Around the square: each corner, and whether it is joined with the next one.
    let corners = [(row, column), (row + 1, column), (row + 1, column + 1), (row, column + 1)];
    let joined = [
        edges.is_joined(corners[0], GridStep::Row),
        edges.is_joined(corners[1], GridStep::Column),
        edges.is_joined(corners[3], GridStep::Row),
        edges.is_joined(corners[0], GridStep::Column),
    ];
    let stays = move |middle: usize| joined[(middle + 3) % 4] && joined[middle];
    // The diagonal of a choice cuts off the two corners that are named.
    let choices = [[1, 3], [0, 2]];
    let count = |choice: [usize; 2]| choice.into_iter().filter(|&middle| stays(middle)).count();
    let counts = choices.map(count);
    let first = match counts[0] == counts[1] {
        true => {
            diagonal(raster, corners[0], corners[2]) <= diagonal(raster, corners[1], corners[3])
        }
        false => counts[0] > counts[1],
    };
    let middles = choices[usize::from(!first)].into_iter().filter(move |&middle| stays(middle));
    middles.filter_map(move |middle| {
        let corner = |i: usize| raster.index(corners[i % 4]).map(VertexId);
        Some([corner(middle + 3)?, corner(middle)?, corner(middle + 1)?])
    })
}

/// The squared length of a diagonal, or infinity if it lacks a point.
fn diagonal(raster: &Raster, from: GridCell, to: GridCell) -> f64 {
    let ends = raster.point(from).zip(raster.point(to));
    ends.map_or(f64::INFINITY, |(from, to)| (to - from).norm_squared())
}
