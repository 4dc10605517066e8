//! The globally nearest point of a surface, with a certificate.
//!
//! A surface and a point go in; the nearest place comes out, exact to [`ACCURACY`]. The surface is
//! divided into cells with bounds on its derivatives ([`cell`]). A tree of bounding boxes
//! ([`tree`]) finds the cells that may contain a point nearer than the best known one. In such a
//! cell the Taylor series at a foot point tells whether this foot point is the only one; if it
//! cannot tell, the cell is divided. Most queries need none of this. Each cell has a distance up to
//! which a foot point in it is proved to be the nearest place ([`proof`]).

mod cell;
mod grid;
mod proof;
mod tree;

#[cfg(test)]
mod tests;

pub(crate) use super::foot::Foot;
use super::foot::descend;
use super::{ACCURACY, MOST_HALVINGS, ParametricSurface};
use crate::geometry::{NEGLIGIBLE, Point, ROUNDING, Uv};
use cell::SurfaceCell;
use grid::CellGrid;
use proof::NearestProof;
use tree::BoxTree;

/// The nearest place known so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearestPlace {
    /// Its parameter point.
    pub at: Uv,
    /// Its distance in mm.
    pub distance: f64,
}

/// A search structure for the nearest points of a part of a surface.
#[derive(Debug)]
pub(crate) struct NearestSearch {
    grid: CellGrid,
    proofs: Vec<NearestProof>,
    tree: BoxTree,
    exact: f64,
}

impl NearestSearch {
    /// Builds the structure. Only cells for which `is_used` holds are searched; its arguments are
    /// the low and the high corner of the cell.
    pub(crate) fn new<S: ParametricSurface + ?Sized>(
        surface: &S,
        is_used: impl Fn(Uv, Uv) -> bool + Sync,
    ) -> Self {
        let grid = CellGrid::new(surface);
        let tree = BoxTree::new(&grid, is_used);
        let proofs = proof::all(&grid, &tree);
        let exact = ACCURACY * tree.diagonal();
        NearestSearch { grid, proofs, tree, exact }
    }

    /// The corners of a box around the part. `None` if the part has no cell.
    pub(crate) fn bounds(&self) -> Option<[Point; 2]> {
        self.tree.nodes.first().map(|whole| [whole.low, whole.high])
    }

    /// A start for a descent if none is known: a place in a cell whose box is near `p`.
    pub(crate) fn start(&self, p: Point) -> Uv {
        self.tree.near(p).map_or_else(Uv::origin, |i| self.grid.cells[i].nearest(p).0)
    }

    /// Whether it is proved that no foot point except `foot` is nearer than `best` mm. `foot` must
    /// come from a descent on the whole surface.
    pub(crate) fn proves_nearest(&self, p: Point, foot: &Foot, best: f64) -> bool {
        let remaining_gradient = self.grid.remaining_gradient(p, foot);
        self.proofs[self.grid.find(foot.at)].proves_nearest(
            foot.distance,
            remaining_gradient,
            best,
            self.exact,
        )
    }

    /// The nearest of `best` and of all foot points for which `accepts` holds. Creases and ends of
    /// the surface are searched as well.
    pub(crate) fn improve<S: ParametricSurface + ?Sized>(
        &self,
        surface: &S,
        p: Point,
        best: NearestPlace,
        accepts: &dyn Fn(Uv) -> bool,
    ) -> NearestPlace {
        let mut search = CellSearch { surface, p, best, accepts, exact: self.exact };
        let mut next = 0;
        while let Some(node) = self.tree.nodes.get(next) {
            if node.outside(p) >= search.bound() {
                next = node.skip;
                continue;
            }
            if let Some(i) = node.cell {
                search.cell(&self.grid.cells[i], self.grid.ends(i), MOST_HALVINGS);
            }
            next += 1;
        }
        search.best
    }
}

/// The state of a search over the cells.
struct CellSearch<'a, S: ?Sized> {
    surface: &'a S,
    p: Point,
    best: NearestPlace,
    accepts: &'a dyn Fn(Uv) -> bool,
    exact: f64,
}

impl<S: ParametricSurface + ?Sized> CellSearch<'_, S> {
    /// Cells that are not nearer than this need not be searched.
    fn bound(&self) -> f64 {
        self.best.distance - self.exact.max(ACCURACY * self.best.distance)
    }

    /// Searches a cell. `ends` tells at which sides, low and high in u and in v, the nearest point
    /// need not be a foot point.
    fn cell(&mut self, cell: &SurfaceCell, ends: [[bool; 2]; 2], halvings: usize) {
        let (near, away) = cell.nearest(self.p);
        if away - cell.spread() >= self.bound() {
            return;
        }
        let derivative_bounds = cell.derivative_bounds();
        if ends == [[false; 2]; 2] && cell.has_no_foot(self.p, &derivative_bounds) {
            return;
        }
        let part = CellRestriction { surface: self.surface, low: cell.low, high: cell.high };
        // The bounds account for the remaining gradient.
        let last = NEGLIGIBLE * (cell.high - cell.low).min();
        let foot = descend(&part, self.p, near, [true; 2], last);
        if foot.distance < self.best.distance && (self.accepts)(foot.at) {
            self.best = NearestPlace { at: foot.at, distance: foot.distance };
        }
        let is_only = foot.distance.max(self.best.distance) <= derivative_bounds.reach();
        let least = cell.least_distance(self.p, &foot, &derivative_bounds);
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

/// A surface restricted to a cell.
struct CellRestriction<'a, S: ?Sized> {
    surface: &'a S,
    low: Uv,
    high: Uv,
}

impl<S: ParametricSurface + ?Sized> ParametricSurface for CellRestriction<'_, S> {
    fn jet(&self, at: Uv) -> super::Jet {
        self.surface.jet(at)
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        [0, 1].map(|k| {
            let (low, high) = (self.low[k], self.high[k]);
            // The surface may have a crease at the knot line at the end of the cell.
            (low, high - ROUNDING * (high - low))
        })
    }
}
