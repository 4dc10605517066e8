//! Neighbour search in space, with the k-d tree of the crate kiddo.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Rotation3;

use crate::geometry::{Point, Vector};

/// The axis about which points are rotated, and its length is the angle. Results do not depend on it.
const TURN: [f64; 3] = [0.61, -0.37, 0.83];

/// Finds the points of a fixed cloud within a radius of a place.
pub(crate) struct Neighbours {
    tree: ImmutableKdTree<f64, 3>,
    turn: Rotation3<f64>,
}

impl std::fmt::Debug for Neighbours {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Neighbours({} points)", self.tree.size())
    }
}

impl Neighbours {
    /// Builds the tree. There must be at least one point, and all points must be finite.
    ///
    /// Scans repeat coordinates: a gridded range map, for example, has columns of equal x. Equal
    /// coordinates make the splits of the tree degenerate and its construction slow. The points are
    /// therefore rotated about an arbitrary axis first.
    pub(crate) fn new(points: &[Point]) -> Self {
        let turn = Rotation3::new(Vector::from(TURN));
        let turned: Vec<[f64; 3]> = points.iter().map(|p| (turn * p).coords.into()).collect();
        #[expect(clippy::expect_used, reason = "kiddo refuses only what is not finite")]
        let tree = ImmutableKdTree::new_from_slice(&turned)
            .expect("a tree of finite points builds, however many coincide");
        Neighbours { tree, turn }
    }

    /// Replaces `found` by the indices of the points within `radius` of `at`. They ascend, so sums
    /// over them do not depend on the shape of the tree.
    pub(crate) fn within(&self, at: Point, radius: f64, found: &mut Vec<u32>) {
        let centre: [f64; 3] = (self.turn * at).coords.into();
        found.clear();
        let hits = self
            .tree
            .query(&centre)
            .within::<SquaredEuclidean<f64>>(radius * radius)
            .unsorted()
            .execute();
        found.extend(hits.into_iter().map(|hit| hit.item));
        found.sort_unstable();
    }

    /// Replaces `found` by the indices of the `count` points nearest to `at`, each with its squared
    /// distance, nearest first. There are fewer if the cloud has fewer.
    pub(crate) fn nearest_n(&self, at: Point, count: usize, found: &mut Vec<(u32, f64)>) {
        let centre: [f64; 3] = (self.turn * at).coords.into();
        found.clear();
        let Some(count) = NonZero::new(count) else { return };
        let hits = self.tree.query(&centre).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        found.extend(hits.into_iter().map(|hit| (hit.item, hit.distance)));
    }

    /// The index of the point nearest to `at`.
    pub(crate) fn nearest(&self, at: Point) -> usize {
        let centre: [f64; 3] = (self.turn * at).coords.into();
        self.tree.query(&centre).nearest_one::<SquaredEuclidean<f64>>().execute().item as usize
    }
}
