//! For each cell, a test that proves a foot point in it to be the nearest place.

use rayon::prelude::*;

use super::cell::{Cell, Growth};
use super::grid::Grid;
use super::tree::Tree;
use crate::geometry::Vector;

/// Bounds that hold for every foot point in a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Safety {
    /// Bounds on the derivatives in the cell and its neighbours: the squared lower bound of
    /// [`Growth::least`], and [`Growth::bend`].
    square: f64,
    bend: f64,
    /// A lower bound in mm on the distance from the cell to cells that are not its neighbours.
    gap: f64,
}

impl Safety {
    /// Whether a foot point in this cell is proved to be the only place nearer than `best` mm, up
    /// to an error of `exact` mm. `away` is its distance from the point, and `slope` the remaining
    /// gradient.
    ///
    /// In the cell and its neighbours the Taylor series proves it, as in [`Growth::reach`].
    /// Everything else is farther than `gap` from the foot point.
    pub fn settles(&self, away: f64, slope: f64, best: f64, exact: f64) -> bool {
        let room = self.square - best * self.bend;
        room > 0.0
            && best + away <= self.gap
            && (away <= exact || slope * slope <= room * away * exact)
    }
}

/// The bounds of every cell.
pub(super) fn all(grid: &Grid, tree: &Tree) -> Vec<Safety> {
    (0..grid.cells.len()).into_par_iter().with_min_len(16).map(|n| of(grid, tree, n)).collect()
}

fn of(grid: &Grid, tree: &Tree, n: usize) -> Safety {
    let cell = &grid.cells[n];
    let around = Around::new(grid, n);
    let Growth { least, bend, .. } = around.growth(grid, cell);
    let square = least * least;
    if square == 0.0 || around.is_sharp(grid) {
        return Safety { square: 0.0, bend, gap: 0.0 };
    }
    Safety { square, bend, gap: gap(grid, tree, cell, &around) }
}

/// A cell and its neighbours, as half-open ranges of columns and rows of the grid.
struct Around {
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Around {
    fn new(grid: &Grid, n: usize) -> Self {
        let around = |i: usize, count: usize| [i.saturating_sub(1), (i + 2).min(count)];
        let [columns, rows] = grid.shape();
        Around { columns: around(n / grid.rows, columns), rows: around(n % grid.rows, rows) }
    }

    fn holds(&self, grid: &Grid, n: usize) -> bool {
        let (i, j) = (n / grid.rows, n % grid.rows);
        (self.columns[0]..self.columns[1]).contains(&i) && (self.rows[0]..self.rows[1]).contains(&j)
    }

    fn cells<'a>(&self, grid: &'a Grid) -> impl Iterator<Item = &'a Cell> + use<'a> {
        let (rows, down) = (self.rows, grid.rows);
        let columns = self.columns[0]..self.columns[1];
        columns.flat_map(move |i| (rows[0]..rows[1]).map(move |j| &grid.cells[i * down + j]))
    }

    /// Whether there is a crease between the cells.
    fn is_sharp(&self, grid: &Grid) -> bool {
        let inner = |[a, b]: [usize; 2], sharp: &[bool]| (a + 1..b).any(|i| sharp[i]);
        inner(self.columns, &grid.sharp[0]) || inner(self.rows, &grid.sharp[1])
    }

    /// Bounds on the derivatives in all these cells, in the scale of the one in the middle.
    fn growth(&self, grid: &Grid, cell: &Cell) -> Growth {
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
        Growth::new(&cell.sides, differ, bend)
    }
}

/// The distance from `cell` to the cells that do not touch it, but at most about three times the
/// size of `cell`. Larger distances are not needed.
fn gap(grid: &Grid, tree: &Tree, cell: &Cell, around: &Around) -> f64 {
    let axes = Axes::new(cell);
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
struct Axes<'a> {
    cell: &'a Cell,
    axes: [Vector; 3],
}

impl<'a> Axes<'a> {
    fn new(cell: &'a Cell) -> Self {
        let [a, b] = cell.sides;
        let normal = a.cross(&b);
        Axes { cell, axes: [normal, b.cross(&normal), a.cross(&normal)].map(unit) }
    }

    /// A lower bound on the distance to another cell.
    fn apart(&self, other: &Cell) -> f64 {
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
fn extent(cell: &Cell, axis: Vector) -> f64 {
    cell.sides.iter().map(|side| side.dot(&axis).abs()).sum::<f64>() + cell.spread()
}
