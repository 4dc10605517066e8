//! Bounding boxes of cells and of halves of the grid.

use super::grid::CellGrid;
use crate::geometry::{Point, Uv};
use rayon::prelude::*;

/// A box of the tree. The node after it in the list is its first child.
#[derive(Debug)]
pub(super) struct BoxNode {
    pub low: Point,
    pub high: Point,
    /// The number of the first node after the descendants of this node.
    pub skip: usize,
    /// The cell, if this node is a leaf.
    pub cell: Option<usize>,
}

impl BoxNode {
    /// The distance from `p` to the box.
    pub(crate) fn outside(&self, p: Point) -> f64 {
        (p.sup(&self.low).inf(&self.high) - p).norm()
    }

    /// The distance from another box to this one.
    pub(crate) fn apart(&self, [low, high]: &[Point; 2]) -> f64 {
        (self.low - high).sup(&(low - self.high)).map(|x| x.max(0.0)).norm()
    }
}

/// The boxes in depth-first order, parents before children.
#[derive(Debug)]
pub(super) struct BoxTree {
    pub nodes: Vec<BoxNode>,
}

impl BoxTree {
    /// The tree of the cells for which `is_used` holds.
    pub(super) fn new(grid: &CellGrid, is_used: impl Fn(Uv, Uv) -> bool + Sync) -> Self {
        let used = grid.cells.par_iter().with_min_len(64).map(|c| is_used(c.low, c.high));
        let used: Vec<bool> = used.collect();
        let mut tree = BoxTree { nodes: Vec::with_capacity(2 * grid.cells.len()) };
        let [columns, rows] = grid.shape();
        tree.add(grid, &used, [0, columns], [0, rows]);
        tree
    }

    /// Adds the cells of a rectangle of the grid. Returns whether there are any.
    fn add(&mut self, grid: &CellGrid, used: &[bool], i: [usize; 2], j: [usize; 2]) -> bool {
        let node = self.nodes.len();
        let (wide, high) = (i[1] - i[0], j[1] - j[0]);
        if wide == 1 && high == 1 {
            let cell = i[0] * grid.rows + j[0];
            if used[cell] {
                let [low, high] = grid.cells[cell].bounds();
                self.nodes.push(BoxNode { low, high, skip: node + 1, cell: Some(cell) });
            }
            return used[cell];
        }
        let [low, high_end] = [f64::INFINITY, f64::NEG_INFINITY].map(|x| Point::new(x, x, x));
        self.nodes.push(BoxNode { low, high: high_end, skip: 0, cell: None });
        let halves = |[a, b]: [usize; 2]| [[a, (a + b) / 2], [(a + b) / 2, b]];
        let mut some = false;
        for k in 0..2 {
            let from = self.nodes.len();
            let added = match wide >= high {
                true => self.add(grid, used, halves(i)[k], j),
                false => self.add(grid, used, i, halves(j)[k]),
            };
            if added {
                let (low, high) = (self.nodes[from].low, self.nodes[from].high);
                let own = &mut self.nodes[node];
                (own.low, own.high) = (own.low.inf(&low), own.high.sup(&high));
                some = true;
            }
        }
        if some {
            self.nodes[node].skip = self.nodes.len();
        } else {
            self.nodes.truncate(node);
        }
        some
    }

    /// The diagonal of the box around all cells.
    pub(super) fn diagonal(&self) -> f64 {
        self.nodes.first().map_or(0.0, |root| (root.high - root.low).norm())
    }

    /// A cell whose box is near `p`. The descent takes the nearer child of each node.
    pub(crate) fn near(&self, p: Point) -> Option<usize> {
        let key = |n: usize| {
            let node = &self.nodes[n];
            (node.outside(p), (nalgebra::center(&node.low, &node.high) - p).norm_squared())
        };
        let mut at = 0;
        loop {
            let node = self.nodes.get(at)?;
            if let Some(cell) = node.cell {
                return Some(cell);
            }
            let (first, second) = (at + 1, self.nodes[at + 1].skip);
            at = if second < node.skip && key(second) < key(first) { second } else { first };
        }
    }
}
