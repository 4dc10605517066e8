//! The nearest point of a surface: certified, not only a local one.
//!
//! The surface is cut into cells on which its derivatives are bounded ([`cell`]), and a
//! tree of boxes finds those that may hold a nearer point than the one known ([`tree`]). In
//! such a cell the Taylor series at a foot tells whether it is the only one; where it does
//! not, the cell is cut up. For most points none of this is needed: each cell knows how far
//! a point may be from a foot in it, so that no other place can be nearer ([`safety`]).

mod cell;
mod grid;
mod safety;
mod tree;

#[cfg(test)]
mod tests;

use super::Patch;
pub(crate) use super::foot::Foot;
use super::foot::descend;
use crate::geometry::{Point, Uv};
use cell::Cell;
use grid::Grid;
use safety::Safety;
use tree::Tree;

/// Distances are exact to this share of the diagonal, or of the distance where that is
/// longer: files round to more, and distances of points that see one place as far as
/// another (the centre of a sphere) would take for ever.
pub(crate) const EXACT: f64 = 1e-7;

/// Cells are halved so often at the most: what is left is below the resolution of doubles.
const MOST_HALVINGS: usize = 24;

/// Newton's last step in a cell, as a share of its side. What is left of the gradient is
/// part of the bound.
const LAST_STEP: f64 = 1e-5;

/// The nearest place that is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Best {
    /// Its parameter point.
    pub at: Uv,
    /// How far it is, in mm.
    pub distance: f64,
}

/// Finds nearest points of a part of a surface.
#[derive(Debug)]
pub(crate) struct Search {
    grid: Grid,
    safety: Vec<Safety>,
    tree: Tree,
    exact: f64,
}

impl Search {
    /// A search of the cells, given by corners, that `is_used` names.
    pub fn new<S: Patch + ?Sized>(surface: &S, is_used: impl Fn(Uv, Uv) -> bool + Sync) -> Self {
        let grid = Grid::new(surface);
        let tree = Tree::new(&grid, is_used);
        let safety = safety::all(&grid, &tree);
        let exact = EXACT * tree.diagonal();
        Search { grid, safety, tree, exact }
    }

    /// How far `p` at least is from the part.
    pub fn outside(&self, p: Point) -> f64 {
        self.tree.outside(p)
    }

    /// A place to begin at where none is known: in a cell whose box is near.
    pub fn start(&self, p: Point) -> Uv {
        self.tree.near(p).map_or_else(Uv::origin, |i| self.grid.cells[i].nearest(p).0)
    }

    /// Whether no foot but `foot`, which was found on the whole surface, is nearer than
    /// `best` mm.
    pub fn settles(&self, p: Point, foot: &Foot, best: f64) -> bool {
        let slope = self.grid.slope(p, foot);
        self.safety[self.grid.find(foot.at)].settles(foot.distance, slope, best, self.exact)
    }

    /// The nearest of `best` and of all feet that `accepts`; where the surface has an end
    /// that belongs to the part, also of the places there.
    pub fn improve<S: Patch + ?Sized>(
        &self,
        surface: &S,
        p: Point,
        best: Best,
        accepts: &dyn Fn(Uv) -> bool,
    ) -> Best {
        let mut visit = Visit { surface, p, best, accepts, exact: self.exact };
        let mut next = 0;
        while let Some(node) = self.tree.nodes.get(next) {
            if node.outside(p) >= visit.bound() {
                next = node.skip;
                continue;
            }
            if let Some(i) = node.cell {
                visit.cell(&self.grid.cells[i], self.grid.ends(i), MOST_HALVINGS);
            }
            next += 1;
        }
        visit.best
    }
}

/// What is known while cells are visited.
struct Visit<'a, S: ?Sized> {
    surface: &'a S,
    p: Point,
    best: Best,
    accepts: &'a dyn Fn(Uv) -> bool,
    exact: f64,
}

impl<S: Patch + ?Sized> Visit<'_, S> {
    /// What is not nearer than this need not be looked at.
    fn bound(&self) -> f64 {
        self.best.distance - self.exact.max(EXACT * self.best.distance)
    }

    /// Looks at a cell. `ends` tells at which of its sides, low and high in u and in v, the
    /// nearest place need not be a foot.
    fn cell(&mut self, cell: &Cell, ends: [[bool; 2]; 2], halvings: usize) {
        let (near, away) = cell.nearest(self.p);
        if away - cell.spread() >= self.bound() {
            return;
        }
        let growth = cell.growth();
        if ends == [[false; 2]; 2] && cell.has_no_foot(self.p, &growth) {
            return;
        }
        let part = Part { surface: self.surface, low: cell.low, high: cell.high };
        let last = LAST_STEP * (cell.high - cell.low).min();
        let foot = descend(&part, self.p, near, [true; 2], last);
        if foot.distance < self.best.distance && (self.accepts)(foot.at) {
            self.best = Best { at: foot.at, distance: foot.distance };
        }
        let is_only = foot.distance.max(self.best.distance) <= growth.reach();
        let least = cell.least_distance(self.p, &foot, &growth);
        let is_flat = cell.spread() <= 0.5 * self.exact;
        if is_only || least >= self.bound() || is_flat || halvings == 0 {
            return;
        }
        for part in cell.split(self.surface) {
            let is_end = |k: usize| {
                [
                    ends[k][0] && part.low[k] == cell.low[k],
                    ends[k][1] && part.high[k] == cell.high[k],
                ]
            };
            self.cell(&part, [is_end(0), is_end(1)], halvings - 1);
        }
    }
}

/// A surface within a cell.
struct Part<'a, S: ?Sized> {
    surface: &'a S,
    low: Uv,
    high: Uv,
}

/// A cell ends before the knot line at its end, beyond which the surface may turn off.
const BEFORE_END: f64 = 1e-12;

impl<S: Patch + ?Sized> Patch for Part<'_, S> {
    fn jet(&self, at: Uv) -> super::Jet {
        self.surface.jet(at)
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        [0, 1].map(|k| {
            let (low, high) = (self.low[k], self.high[k]);
            (low, high - BEFORE_END * (high - low))
        })
    }
}
