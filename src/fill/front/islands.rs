//! Islands are bridged to the rim, by the shortest path, which then is an edge of
//! the front on both sides.

use super::Front;
use crate::geometry::VertexId;

impl Front<'_> {
    /// Joins every island to the rim or to an island that is joined already.
    pub(super) fn bridge_islands(&mut self, rims: &[&[VertexId]]) {
        let starts: Vec<usize> =
            rims.iter().scan(0, |end, r| Some(std::mem::replace(end, *end + r.len()))).collect();
        let nodes = |ring: usize| starts[ring]..starts[ring] + rims[ring].len();
        let mut joined: Vec<usize> = nodes(0).collect();
        let mut left: Vec<usize> = (1..rims.len()).collect();
        while !left.is_empty() {
            let pairs = left.iter().flat_map(|&ring| {
                let to = nodes(ring);
                joined.iter().flat_map(move |&from| to.clone().map(move |to| (from, to, ring)))
            });
            let distance =
                |from: usize, to: usize| (self.rings.at(to) - self.rings.at(from)).norm();
            let Some((from, to, ring)) =
                pairs.min_by(|x, y| distance(x.0, x.1).total_cmp(&distance(y.0, y.1)))
            else {
                return;
            };
            self.bridge(from, to);
            joined.extend(nodes(ring));
            left.retain(|&r| r != ring);
        }
    }

    /// Bridges two rings by a straight path with vertices at the edge length
    /// wanted.
    fn bridge(&mut self, from: usize, to: usize) {
        let ends =
            [from, to].map(|node| (self.rings.at(node), self.normal(self.rings.vertex(node))));
        let [(p, n), (q, m)] = ends;
        let size = self.sizes.at(nalgebra::center(&p, &q)).max(0.1 * self.sizes.mean);
        let steps = (((q - p).norm() / size).round() as usize).clamp(1, self.most_points.max(2));
        let mut path = Vec::new();
        for k in 1..steps {
            let share = k as f64 / steps as f64;
            let normal = n.lerp(&m, share).try_normalize(1e-6).unwrap_or(n);
            let at = p + share * (q - p);
            path.push((self.add_point(at, normal), at));
        }
        let ends = [self.rings.vertex(from), self.rings.vertex(to)];
        let chain: Vec<VertexId> =
            [ends[0]].into_iter().chain(path.iter().map(|p| p.0)).chain([ends[1]]).collect();
        self.edges.extend(chain.windows(2).map(|e| (e[0].min(e[1]), e[0].max(e[1]))));
        self.rings.bridge(from, to, &path);
    }
}
