//! How far from a cell a point whose foot is in it is sure to have no other one nearer.

use rayon::prelude::*;

use super::cell::{Cell, Growth};
use super::grid::Grid;
use super::tree::Tree;
use crate::geometry::Vector;

/// What is known of the feet in a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Safety {
    /// How the surface moves in the cell and those around it.
    square: f64,
    bend: f64,
    /// How far cells are that are not around it, in mm.
    gap: f64,
}

impl Safety {
    /// Whether a foot in the cell, `away` from a point and with a remaining `slope`, is the
    /// only one that is nearer to it than `best`, but for `exact` mm.
    ///
    /// Around it the Taylor series says so, as [`Growth::reach`] has it. What is elsewhere
    /// is farther than the gap from the foot.
    pub fn settles(&self, away: f64, slope: f64, best: f64, exact: f64) -> bool {
        let room = self.square - best * self.bend;
        room > 0.0
            && best + away <= self.gap
            && (away <= exact || slope * slope <= room * away * exact)
    }
}

/// For every cell.
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

/// A cell and those that touch it: columns and rows of the grid, the last ones excluded.
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

    /// Whether there is a sharp bend between the cells.
    fn is_sharp(&self, grid: &Grid) -> bool {
        let inner = |[a, b]: [usize; 2], sharp: &[bool]| (a + 1..b).any(|i| sharp[i]);
        inner(self.columns, &grid.sharp[0]) || inner(self.rows, &grid.sharp[1])
    }

    /// How the surface moves in all of them, measured by the one in the middle.
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

/// How far the cells that do not touch `cell` are from it, but at most about three times its
/// size: more is not needed.
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

/// A cell and the directions along which it is parted from others: its normal and, in its
/// plane, the normals of its sides.
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

    /// How far another cell is at least.
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

/// How far a cell goes from its centre along a unit vector.
fn extent(cell: &Cell, axis: Vector) -> f64 {
    cell.sides.iter().map(|side| side.dot(&axis).abs()).sum::<f64>() + cell.spread()
}
