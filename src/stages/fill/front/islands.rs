//! Bridges from islands to the rim by the shortest path. The front passes a bridge on both
//! sides.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rstar::primitives::GeomWithData;
use rstar::{PointDistance, RTree};

use super::Front;
use crate::geometry::{NEGLIGIBLE, OrderedFloat, VertexId};

/// A vertex of a rim: its position, and the number of its node in the front.
type RimNode = GeomWithData<[f64; 3], usize>;

impl Front<'_> {
    /// Joins every island to the rim, or to an island that is joined already. The nearest pair
    /// of vertices comes first.
    pub(super) fn bridge_islands(&mut self, rims: &[&[VertexId]]) {
        let mut starts = vec![0];
        rims.iter().for_each(|rim| starts.push(starts[starts.len() - 1] + rim.len()));
        let nodes = |ring: usize| starts[ring]..starts[ring + 1];
        let ring_of = |node: usize| starts.partition_point(|&start| start <= node) - 1;
        let places: Vec<RimNode> = (0..starts[rims.len()])
            .map(|node| GeomWithData::new(self.loops.at(node).into(), node))
            .collect();
        let mut left = RTree::bulk_load(places[starts[1]..].to_vec());
        let mut is_joined = vec![false; rims.len()];
        // For each joined vertex the distance to the vertex that was nearest when it was looked
        // up. This is a lower bound, because islands are only removed from the tree.
        let mut nearest = BinaryHeap::new();
        let ask = |left: &RTree<RimNode>, from: usize| {
            let to = left.nearest_neighbor(*places[from].geom())?;
            let squared = to.distance_2(places[from].geom());
            Some(Reverse((OrderedFloat(squared), from, to.data)))
        };
        let mut ring = 0;
        loop {
            is_joined[ring] = true;
            if ring > 0 {
                nodes(ring).for_each(|node| _ = left.remove(&places[node]));
            }
            nearest.extend(nodes(ring).filter_map(|from| ask(&left, from)));
            let (from, to) = loop {
                let Some(Reverse((_, from, to))) = nearest.pop() else { return };
                if !is_joined[ring_of(to)] {
                    break (from, to);
                }
                nearest.extend(ask(&left, from));
            };
            self.bridge(from, to);
            nearest.extend(ask(&left, from));
            ring = ring_of(to);
        }
    }

    /// Bridges two loops by a straight path with vertices at the target edge length.
    fn bridge(&mut self, from: usize, to: usize) {
        let ends =
            [from, to].map(|node| (self.loops.at(node), self.normal(self.loops.vertex(node))));
        let [(p, n), (q, m)] = ends;
        let size = self.sizes.at(nalgebra::center(&p, &q)).max(0.1 * self.sizes.mean);
        let steps = (((q - p).norm() / size).round() as usize).clamp(1, self.most_points.max(2));
        let mut path = Vec::new();
        for k in 1..steps {
            let share = k as f64 / steps as f64;
            let normal = n.lerp(&m, share).try_normalize(NEGLIGIBLE).unwrap_or(n);
            let at = p + share * (q - p);
            path.push((self.add_point(at, normal), at));
        }
        let ends = [self.loops.vertex(from), self.loops.vertex(to)];
        let chain: Vec<VertexId> =
            [ends[0]].into_iter().chain(path.iter().map(|p| p.0)).chain([ends[1]]).collect();
        self.edges.extend(chain.windows(2).map(|e| (e[0].min(e[1]), e[0].max(e[1]))));
        self.loops.bridge(from, to, &path);
    }
}
