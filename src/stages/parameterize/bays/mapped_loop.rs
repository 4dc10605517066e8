//! An outer boundary on a map.

use std::f64::consts::PI;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::center;

use super::STRAIGHT;
use crate::geometry::{Uv, VertexId, orient2d};

/// The positions of a closed loop on a map. The surface lies to its left.
pub(crate) struct MappedLoop {
    uv: Vec<Uv>,
    tree: ImmutableKdTree<f64, 2>,
}

impl MappedLoop {
    /// The loop on a map, which must have a finite position for every vertex.
    pub(super) fn new(ring: &[VertexId], map: &[Uv]) -> Self {
        let uv: Vec<Uv> = ring.iter().map(|v| map[v.index()]).collect();
        let places: Vec<[f64; 2]> = uv.iter().map(|p| p.coords.into()).collect();
        #[expect(clippy::expect_used, reason = "kiddo refuses only what is not finite")]
        let tree = ImmutableKdTree::new_from_slice(&places).expect("a map is finite");
        MappedLoop { uv, tree }
    }

    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        orient2d(self.uv[a], self.uv[b], self.uv[c])
    }

    /// The angle at the tip of an ear, or π if the loop turns to the left there.
    pub(crate) fn tip(&self, [p, v, n]: [usize; 3]) -> f64 {
        let (to, from) = (self.uv[p] - self.uv[v], self.uv[n] - self.uv[v]);
        if self.turn(p, v, n) < 0.0 { to.angle(&from) } else { PI }
    }

    /// Whether the loop turns to the right at the tip of an ear.
    pub(crate) fn bends(&self, ear: [usize; 3]) -> bool {
        self.tip(ear) < PI - STRAIGHT
    }

    /// Whether no position for which `counts` holds lies in an ear.
    pub(crate) fn is_free(&self, [p, v, n]: [usize; 3], counts: impl Fn(usize) -> bool) -> bool {
        let middle = center(&center(&self.uv[p], &self.uv[n]), &self.uv[v]);
        let reach = [p, v, n].map(|i| (self.uv[i] - middle).norm_squared());
        let near = self
            .tree
            .query(&middle.coords.into())
            .within::<SquaredEuclidean<f64>>(reach.into_iter().fold(0.0, f64::max))
            .unsorted()
            .execute();
        let inside =
            |i: usize| [[p, n], [n, v], [v, p]].iter().all(|s| self.turn(s[0], s[1], i) > 0.0);
        !near.into_iter().any(|hit| counts(hit.item as usize) && inside(hit.item as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notch_is_an_ear_unless_something_is_in_it() {
        // A square with a notch from its top, and a spike into the notch from the right.
        let corners = [(0, 0), (9, 0), (9, 9), (6, 9), (4, 6), (6, 5), (5, 1), (3, 9), (0, 9)];
        let map = corners.map(|(u, v)| Uv::new(f64::from(u), f64::from(v)));
        let ring: Vec<VertexId> = (0..corners.len()).map(VertexId::from).collect();
        let flat = MappedLoop::new(&ring, &map);
        assert!(!flat.bends([0, 1, 2]) && flat.tip([0, 1, 2]) == PI);
        let notch = [3, 6, 7];
        assert!(flat.bends(notch) && flat.tip(notch) < 0.5);
        assert!(!flat.is_free(notch, |i| !notch.contains(&i)));
        assert!(flat.is_free(notch, |i| i != 4 && !notch.contains(&i)));
    }
}
