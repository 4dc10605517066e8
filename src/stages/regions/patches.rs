//! Small connected patches of facets around a seed, in several orders: one of them lies on a single surface.

use super::exact::{ExactFacets, MOST_TURN};
use super::facets::Border;
use crate::geometry::random::scattered;

/// The orders in which a patch takes neighbours, each with the number of vertices at which it stops.
///
/// Six vertices are two facets of a strip, eight are three: narrow bends have no more. Seven are a corner of
/// triangles, nine are two more than a torus has parameters, fourteen are twice its parameters, and thirty
/// reach across the rows of a finely divided face.
const ORDERS: [(PatchOrder, usize); 14] = [
    (PatchOrder::Nearest, 14),
    (PatchOrder::LongestEdge, 10),
    (PatchOrder::LeastTurn, 9),
    (PatchOrder::LikeArea, 10),
    (PatchOrder::LongestEdge, 6),
    (PatchOrder::LongestEdge, 8),
    (PatchOrder::LeastTurn, 6),
    (PatchOrder::Nearest, 7),
    (PatchOrder::Nearest, 30),
    (PatchOrder::Mixed(1), 6),
    (PatchOrder::Mixed(2), 6),
    (PatchOrder::Mixed(3), 9),
    (PatchOrder::Mixed(4), 9),
    (PatchOrder::Mixed(5), 9),
];

/// The number of patches of a seed.
pub(super) const PATCHES: usize = ORDERS.len();

#[derive(Debug, Clone, Copy)]
enum PatchOrder {
    Nearest,
    LongestEdge,
    LeastTurn,
    LikeArea,
    /// A fixed pseudo-random order.
    Mixed(u64),
}

/// The different patches around a seed among the facets that `may_join`, in a fixed order. The second value says whether
/// neighbours came by their distance.
pub(super) fn around(
    evidence: &ExactFacets,
    seed: u32,
    may_join: &dyn Fn(u32) -> bool,
) -> Vec<(Vec<u32>, bool)> {
    let mut patches: Vec<(Vec<u32>, bool)> = Vec::new();
    let mut sorted: Vec<Vec<u32>> = Vec::new();
    for (order, vertices) in ORDERS {
        let patch = grown(evidence, seed, may_join, order, vertices);
        let mut key = patch.clone();
        key.sort_unstable();
        if patch.len() >= 2 && !sorted.contains(&key) {
            sorted.push(key);
            patches.push((patch, matches!(order, PatchOrder::Nearest)));
        }
    }
    patches
}

fn grown(
    evidence: &ExactFacets,
    seed: u32,
    may_join: &dyn Fn(u32) -> bool,
    order: PatchOrder,
    vertices: usize,
) -> Vec<u32> {
    let mut patch = Vec::new();
    let mut corners: Vec<u32> = Vec::new();
    let mut front: Vec<(f64, u32)> = vec![(0.0, seed)];
    while corners.len() < vertices {
        let best = (0..front.len())
            .min_by(|&i, &j| front[i].0.total_cmp(&front[j].0).then(front[i].1.cmp(&front[j].1)));
        let Some(best) = best else { break };
        let facet = front.swap_remove(best).1;
        if patch.contains(&facet) {
            continue;
        }
        patch.push(facet);
        for &v in &evidence.facets.get(facet).corners {
            if !corners.contains(&v) {
                corners.push(v);
            }
        }
        for border in &evidence.facets.get(facet).borders {
            if border.dihedral <= MOST_TURN
                && !patch.contains(&border.facet)
                && may_join(border.facet)
            {
                front.push((key(evidence, seed, facet, border, order), border.facet));
            }
        }
    }
    patch
}

fn key(evidence: &ExactFacets, seed: u32, from: u32, border: &Border, order: PatchOrder) -> f64 {
    let [first, near, to] = [seed, from, border.facet].map(|f| evidence.facets.get(f));
    match order {
        PatchOrder::Nearest => (to.centre - first.centre).norm(),
        PatchOrder::LongestEdge => -border.length / near.area.sqrt(),
        PatchOrder::LeastTurn => border.dihedral,
        PatchOrder::LikeArea => (to.area / first.area).ln().abs(),
        PatchOrder::Mixed(number) => scattered(u64::from(border.facet) << 8 | number) as f64,
    }
}

/// FacetMesh around a seed by distance, until eight of them leave a surface. Empty if fewer than four do.
pub(super) fn beyond(
    evidence: &ExactFacets,
    seed: u32,
    may_join: &dyn Fn(u32) -> bool,
    leaves: &dyn Fn(u32) -> bool,
) -> Vec<u32> {
    /// Twice and once the vertices that a torus has beyond a sphere, in facets.
    const ENOUGH: usize = 8;
    const FEWEST: usize = 4;
    /// So many facets are a large face without a torus beside it.
    const MOST: usize = 400;
    let mut patch = Vec::new();
    let mut seen = vec![seed];
    let mut front: Vec<(f64, u32)> = vec![(0.0, seed)];
    let mut outside = 0;
    while outside < ENOUGH && patch.len() < MOST {
        let best = (0..front.len())
            .min_by(|&i, &j| front[i].0.total_cmp(&front[j].0).then(front[i].1.cmp(&front[j].1)));
        let Some(best) = best else { break };
        let facet: u32 = front.swap_remove(best).1;
        patch.push(facet);
        outside += usize::from(leaves(facet));
        for border in &evidence.facets.get(facet).borders {
            if border.dihedral <= MOST_TURN
                && may_join(border.facet)
                && !seen.contains(&border.facet)
            {
                seen.push(border.facet);
                let away =
                    evidence.facets.get(border.facet).centre - evidence.facets.get(seed).centre;
                front.push((away.norm(), border.facet));
            }
        }
    }
    if outside < FEWEST { Vec::new() } else { patch }
}
