//! For each cell, a test that proves a foot point in it to be the nearest place.

use rayon::prelude::*;

use super::cell::{DerivativeBounds, SurfaceCell};
use super::grid::CellGrid;
use super::tree::BoxTree;
use crate::geometry::Vector;

/// Bounds that hold for every foot point in a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestProof {
    /// Bounds on the derivatives in the cell and its neighbours: the squared lower bound of
    /// [`DerivativeBounds::least`], and [`DerivativeBounds::bend`].
    square: f64,
    bend: f64,
    /// A lower bound in mm on the distance from the cell to cells that are not its neighbours.
    gap: f64,
}

impl NearestProof {
    /// Whether a foot point in this cell is proved to be the only place nearer than `best` mm, up
    /// to an error of `exact` mm. `away` is its distance from the point, and `remaining_gradient`
    /// the remaining gradient.
    ///
    /// In the cell and its neighbours the Taylor series proves it, as in
    /// [`DerivativeBounds::reach`]. Everything else is farther than `gap` from the foot point.
    pub(crate) fn proves_nearest(
        &self,
        away: f64,
        remaining_gradient: f64,
        best: f64,
        exact: f64,
    ) -> bool {
        let room = self.square - best * self.bend;
        room > 0.0
            && best + away <= self.gap
            && (away <= exact || remaining_gradient * remaining_gradient <= room * away * exact)
    }
}

/// The bounds of every cell.
pub(super) fn all(grid: &CellGrid, tree: &BoxTree) -> Vec<NearestProof> {
    (0..grid.cells.len()).into_par_iter().with_min_len(16).map(|n| of(grid, tree, n)).collect()
}

fn of(grid: &CellGrid, tree: &BoxTree, n: usize) -> NearestProof {
    let cell = &grid.cells[n];
    let around = CellNeighbours::new(grid, n);
    let DerivativeBounds { least, bend, .. } = around.derivative_bounds(grid, cell);
    let square = least * least;
    if square == 0.0 || around.is_crease(grid) {
        return NearestProof { square: 0.0, bend, gap: 0.0 };
    }
    NearestProof { square, bend, gap: gap(grid, tree, cell, &around) }
}

/// A cell and its neighbours, as half-open ranges of columns and rows of the grid.
struct CellNeighbours {
    columns: [usize; 2],
    rows: [usize; 2],
}

impl CellNeighbours {
    fn new(grid: &CellGrid, n: usize) -> Self {
        let around = |i: usize, count: usize| [i.saturating_sub(1), (i + 2).min(count)];
        let [columns, rows] = grid.shape();
        CellNeighbours {
            columns: around(n / grid.rows, columns),
            rows: around(n % grid.rows, rows),
        }
    }

    fn holds(&self, grid: &CellGrid, n: usize) -> bool {
        let (i, j) = (n / grid.rows, n % grid.rows);
        (self.columns[0]..self.columns[1]).contains(&i) && (self.rows[0]..self.rows[1]).contains(&j)
    }

    fn cells<'a>(&self, grid: &'a CellGrid) -> impl Iterator<Item = &'a SurfaceCell> + use<'a> {
        let (rows, down) = (self.rows, grid.rows);
        let columns = self.columns[0]..self.columns[1];
        columns.flat_map(move |i| (rows[0]..rows[1]).map(move |j| &grid.cells[i * down + j]))
    }

    /// Whether there is a crease between the cells.
    fn is_crease(&self, grid: &CellGrid) -> bool {
        let inner = |[a, b]: [usize; 2], creases: &[bool]| (a + 1..b).any(|i| creases[i]);
        inner(self.columns, &grid.creases[0]) || inner(self.rows, &grid.creases[1])
    }

    /// Bounds on the derivatives in all these cells, in the scale of the one in the middle.
    fn derivative_bounds(&self, grid: &CellGrid, cell: &SurfaceCell) -> DerivativeBounds {
        let (mut differ, mut bend) = ([0.0_f64; 2], [0.0_f64; 3]);
        let size = cell.high - cell.low;
        for other in self.cells(grid) {
            let scale = size.component_div(&(other.high - other.low));
            for k in 0..2 {
                let here = (other.sides[k] * scale[k] - cell.sides[k]).norm();
                differ[k] = differ[k].max(here + other.differ()[k] * scale[k]);
            }
            let scales = [scale.x * scale.x, scale.x * scale.y, scale.y * scale.y];
            for k in 0..3 {
                bend[k] = bend[k].max(other.bend[k] * scales[k]);
            }
        }
        DerivativeBounds::new(&cell.sides, differ, bend)
    }
}

/// The distance from `cell` to the cells that do not touch it, but at most about three times the
/// size of `cell`. Larger distances are not needed.
fn gap(grid: &CellGrid, tree: &BoxTree, cell: &SurfaceCell, around: &CellNeighbours) -> f64 {
    let axes = SeparatingAxes::new(cell);
    let bounds = cell.bounds();
    let mut gap = 3.0 * (cell.sides[0].norm() + cell.sides[1].norm());
    let mut next = 0;
    while let Some(node) = tree.nodes.get(next) {
        if node.apart(&bounds) >= gap {
            next = node.skip;
            continue;
        }
        if let Some(other) = node.cell.filter(|&other| !around.holds(grid, other)) {
            gap = gap.min(axes.apart(&grid.cells[other]));
        }
        next += 1;
    }
    gap
}

/// A cell with the directions of possible separating axes: its normal and, in its plane, the
/// normals of its sides.
struct SeparatingAxes<'a> {
    cell: &'a SurfaceCell,
    axes: [Vector; 3],
}

impl<'a> SeparatingAxes<'a> {
    fn new(cell: &'a SurfaceCell) -> Self {
        let [a, b] = cell.sides;
        let normal = a.cross(&b);
        SeparatingAxes { cell, axes: [normal, b.cross(&normal), a.cross(&normal)].map(unit) }
    }

    /// A lower bound on the distance to another cell.
    fn apart(&self, other: &SurfaceCell) -> f64 {
        let between = other.centre - self.cell.centre;
        let along =
            |axis: Vector| between.dot(&axis).abs() - extent(self.cell, axis) - extent(other, axis);
        self.axes.into_iter().chain([unit(between)]).map(along).fold(0.0, f64::max)
    }
}

fn unit(v: Vector) -> Vector {
    v.try_normalize(0.0).unwrap_or_else(Vector::zeros)
}

/// The extent of a cell from its centre along a unit vector.
fn extent(cell: &SurfaceCell, axis: Vector) -> f64 {
    cell.sides.iter().map(|side| side.dot(&axis).abs()).sum::<f64>() + cell.spread()
}
