//! The points of one scan as a raster. A cloud and one of its grids go in; the point of every
//! cell, the steps between neighbouring cells, and the checks of the grid itself come out.

use formats::points::ScanGrid;

use crate::geometry::{Point, Vector};

/// The direction of an edge between two neighbouring cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GridStep {
    /// To the next column of the same row.
    Column,
    /// To the next row of the same column.
    Row,
}

/// A row and a column.
pub(super) type GridCell = (usize, usize);

/// The points of a cloud seen through one of its grids.
#[derive(Debug, Clone, Copy)]
pub(super) struct Raster<'a> {
    points: &'a [Point],
    grid: &'a ScanGrid,
}

impl<'a> Raster<'a> {
    /// The raster, or `None` if two cells have the same point, if a cell has a point that the cloud
    /// does not have, or if the number of cells is not that of rows times columns.
    pub(super) fn new(points: &'a [Point], grid: &'a ScanGrid) -> Option<Self> {
        if grid.rows.checked_mul(grid.columns) != Some(grid.cells.len()) {
            return None;
        }
        let mut used = vec![false; points.len()];
        for &point in grid.cells.iter().filter(|&&point| point != ScanGrid::EMPTY) {
            let used = used.get_mut(point as usize)?;
            if *used {
                return None;
            }
            *used = true;
        }
        Some(Raster { points, grid })
    }

    /// The number of rows.
    pub(super) fn rows(&self) -> usize {
        self.grid.rows
    }

    /// The number of columns.
    pub(super) fn columns(&self) -> usize {
        self.grid.columns
    }

    /// All cells, row by row.
    pub(super) fn cells(&self) -> impl Iterator<Item = GridCell> {
        let columns = self.columns();
        (0..self.rows()).flat_map(move |row| (0..columns).map(move |column| (row, column)))
    }

    /// The cell with a number in the order of [`Raster::cells`].
    pub(super) fn cell(&self, number: usize) -> GridCell {
        (number / self.columns(), number % self.columns())
    }

    /// The index of the point in a cell.
    pub(super) fn index(&self, (row, column): GridCell) -> Option<u32> {
        self.grid.point(row, column)
    }

    /// The point in a cell.
    pub(super) fn point(&self, cell: GridCell) -> Option<Point> {
        self.points.get(self.index(cell)? as usize).copied()
    }

    /// The cell that is `count` steps away, if the grid has it.
    pub(super) fn moved(
        &self,
        (row, column): GridCell,
        step: GridStep,
        count: isize,
    ) -> Option<GridCell> {
        let cell = match step {
            GridStep::Column => (row, column.checked_add_signed(count)?),
            GridStep::Row => (row.checked_add_signed(count)?, column),
        };
        (cell.0 < self.rows() && cell.1 < self.columns()).then_some(cell)
    }

    /// The displacement from the point of a cell to the point that is `count` steps away.
    pub(super) fn displacement(
        &self,
        cell: GridCell,
        step: GridStep,
        count: isize,
    ) -> Option<Vector> {
        Some(self.point(self.moved(cell, step, count)?)? - self.point(cell)?)
    }

    /// The lengths of all edges in one direction, by the number of their first cell. It is NaN
    /// where the edge lacks a point.
    pub(super) fn lengths(&self, step: GridStep) -> Vec<f64> {
        let length = |cell| self.displacement(cell, step, 1).map_or(f64::NAN, |d| d.norm());
        self.cells().map(length).collect()
    }
}
