//! A grid of quads in each pair of triangles.

use std::collections::HashMap;

use super::base::{Base, TrianglePlace};
use super::pair::Pairs;
use crate::geometry::VertexId;
use crate::mesh::QuadMesh;

/// Divides every pair into `n` × `n` quads. The result has no points yet, but the place of every
/// vertex on the scan.
pub(super) fn grid(base: &Base, pairs: &Pairs, n: usize) -> (QuadMesh, Vec<TrianglePlace>) {
    let mut mesh = QuadMesh { side: n, ..QuadMesh::default() };
    let mut places = Vec::new();
    let mut shared: HashMap<(u32, u32, usize), VertexId> = HashMap::new();
    for t in 0..pairs.mate.len() as u32 {
        let other = pairs.mate[t as usize];
        if other < t {
            continue;
        }
        let k = pairs.side(t, other);
        let [t, other] = [t, other].map(|t| pairs.triangles[t as usize]);
        let corners = base.triangles[t as usize];
        let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        let apex = base.triangles[other as usize].into_iter().find(|&w| w != a && w != b);
        let d = apex.unwrap_or(c);
        let weights = |t: u32, of: [(u32, f64); 3]| TrianglePlace {
            triangle: t,
            weights: base.triangles[t as usize]
                .map(|v| of.iter().find(|w| w.0 == v).map_or(0.0, |w| w.1)),
        };
        let size = n as f64;
        let mut vertices = Vec::with_capacity((n + 1) * (n + 1));
        for (i, j) in (0..(n + 1) * (n + 1)).map(|k| (k % (n + 1), k / (n + 1))) {
            let mut put = || {
                let (x, y) = (i as f64 / size, j as f64 / size);
                let place = match i >= j {
                    true => weights(other, [(a, 1.0 - x), (d, x - y), (b, y)]),
                    false => weights(t, [(a, 1.0 - y), (c, y - x), (b, x)]),
                };
                places.push(base.on_scan(place));
                VertexId::from(places.len() - 1)
            };
            let vertex = match side_key([a, d, b, c], n, i, j) {
                Some(key) => *shared.entry(key).or_insert_with(put),
                None => put(),
            };
            vertices.push(vertex);
        }
        let at = |i: usize, j: usize| vertices[(n + 1) * j + i];
        let quads = (0..n * n).map(|k| (k % n, k / n));
        mesh.quads
            .extend(quads.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
    }
    (mesh, places)
}

/// What names a vertex on a side of a block: the ends of the side in order, and the steps from the
/// first one. A corner is named by itself. `None` inside the block.
fn side_key([a, d, b, c]: [u32; 4], n: usize, i: usize, j: usize) -> Option<(u32, u32, usize)> {
    let (from, to, steps) = match (i, j) {
        (0, 0) => return Some((a, a, 0)),
        (i, 0) if i == n => return Some((d, d, 0)),
        (i, j) if i == n && j == n => return Some((b, b, 0)),
        (0, j) if j == n => return Some((c, c, 0)),
        (i, 0) => (a, d, i),
        (i, j) if i == n => (d, b, j),
        (i, j) if j == n => (c, b, i),
        (0, j) => (a, c, j),
        _ => return None,
    };
    Some(if from < to { (from, to, steps) } else { (to, from, n - steps) })
}
