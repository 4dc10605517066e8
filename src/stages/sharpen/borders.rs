//! The borders between regions: chains of edges between the vertices where more than two meet.

use std::collections::BTreeMap;

use super::Work;
use super::labels::ends;

/// Edges between two regions. Of a closed chain the first vertex is the last one.
#[derive(Debug, Clone)]
pub(super) struct Border {
    /// The regions, the smaller number first.
    pub pair: [u32; 2],
    pub vertices: Vec<u32>,
    pub is_closed: bool,
}

impl Border {
    /// The parts of the border between vertices that are left out.
    pub(super) fn without<T>(&self, left_out: &BTreeMap<u32, T>) -> Vec<Border> {
        let is_out = |v: &u32| left_out.contains_key(v);
        if !self.vertices.iter().any(is_out) {
            return vec![self.clone()];
        }
        let mut vertices = self.vertices.clone();
        if self.is_closed {
            vertices.pop();
            let first = vertices.iter().position(is_out).unwrap_or(0);
            vertices.rotate_left(first);
        }
        let parts = vertices.split(is_out).filter(|part| part.len() > 1);
        let part = |of: &[u32]| Border { vertices: of.to_vec(), is_closed: false, ..*self };
        parts.map(part).collect()
    }
}

impl Work<'_> {
    /// All borders between regions.
    pub(super) fn borders(&self) -> Vec<Border> {
        let mut next: BTreeMap<u32, Vec<(u32, [u32; 2])>> = BTreeMap::new();
        for side in 0..3 * self.of.len() {
            let Some(twin) = self.edges.across(side).filter(|&twin| twin > side) else { continue };
            let [a, b] = [self.of[side / 3], self.of[twin / 3]];
            if a != b {
                let [p, q] = ends(self.mesh, side);
                let pair = [a.min(b), a.max(b)];
                next.entry(p).or_default().push((q, pair));
                next.entry(q).or_default().push((p, pair));
            }
        }
        let mut is_junction = vec![false; self.mesh.points.len()];
        for (&v, out) in &next {
            is_junction[v as usize] = out.len() != 2 || out[0].1 != out[1].1;
        }
        let mut is_used: BTreeMap<[u32; 2], bool> = BTreeMap::new();
        let mut all = Vec::new();
        let junctions = next.keys().copied().filter(|&v| is_junction[v as usize]);
        let starts: Vec<u32> = junctions.chain(next.keys().copied()).collect();
        for start in starts {
            for &(first, pair) in &next[&start] {
                let key = |a: u32, b: u32| [a.min(b), a.max(b)];
                if is_used.insert(key(start, first), true).is_some() {
                    continue;
                }
                let mut vertices = vec![start, first];
                let mut at = first;
                while !is_junction[at as usize] && at != start {
                    let before = vertices[vertices.len() - 2];
                    let Some(&(to, _)) = next[&at].iter().find(|of| of.0 != before) else { break };
                    is_used.insert(key(at, to), true);
                    vertices.push(to);
                    at = to;
                }
                let is_closed = at == start && !is_junction[start as usize];
                all.push(Border { pair, vertices, is_closed });
            }
        }
        all
    }
}
