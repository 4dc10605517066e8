//! The grid of a scan whose points have the indices of their row and column.
//!
//! The input is these indices, record by record. The output is a [`GridShape`].

use crate::points::{GridShape, Order, ScanGrid};

/// A grid may have so many cells for each record. Scanners that leave out the sky fill a third
/// of the cells or more. A grid with fewer points has hardly any neighbours, and indices that
/// are far apart would fill the memory.
const MOST_CELLS: usize = 16;

/// The rows and columns of the records of a scan.
#[derive(Default)]
pub(super) struct GridIndices {
    /// `None` for a record that is left out.
    cells: Vec<Option<[i32; 2]>>,
    /// Whether an index is not a whole number in the range of `i32`.
    is_broken: bool,
}

/// The indices make no grid, although they should.
pub(super) struct NoGrid;

impl GridIndices {
    /// Adds the row and the column of the next record. `None` if it is left out.
    pub(super) fn push(&mut self, cell: Option<[f64; 2]>) {
        let whole = |index: f64| f64::from(index as i32) == index;
        self.is_broken |= cell.is_some_and(|cell| !cell.into_iter().all(whole));
        self.cells.push(cell.map(|cell| cell.map(|index| index as i32)));
    }

    /// The shape, or `None` if all points are in one row or column, or have no indices.
    pub(super) fn finish(self) -> Result<Option<GridShape>, NoGrid> {
        if self.is_broken {
            return Err(NoGrid);
        }
        let Some([first_row, rows]) = self.range(0) else { return Ok(None) };
        let Some([first_column, columns]) = self.range(1) else { return Ok(None) };
        if rows < 2 || columns < 2 {
            return Ok(None);
        }
        let most = (self.cells.len() as i64).saturating_mul(MOST_CELLS as i64);
        let count = rows.checked_mul(columns).filter(|&count| count <= most).ok_or(NoGrid)?;
        let mut cells = vec![ScanGrid::EMPTY; count as usize];
        for (record, cell) in self.cells.iter().enumerate() {
            let Some([row, column]) = cell.map(|cell| cell.map(i64::from)) else { continue };
            let at = (row - first_row) * columns + (column - first_column);
            let taken = &mut cells[at as usize];
            if *taken != ScanGrid::EMPTY || record >= ScanGrid::EMPTY as usize {
                return Err(NoGrid);
            }
            *taken = record as u32;
        }
        let (rows, columns) = (rows as usize, columns as usize);
        Ok(Some(GridShape { rows, columns, order: Order::Indexed(cells) }))
    }

    /// The least index of an axis and the length of the range.
    fn range(&self, axis: usize) -> Option<[i64; 2]> {
        let indices = self.cells.iter().flatten().map(|cell| i64::from(cell[axis]));
        let least = indices.clone().min()?;
        Some([least, indices.max()? - least + 1])
    }
}
