//! A grid of quads in each pair of triangles.

use std::collections::HashMap;

use super::base::{Base, TrianglePlace};
use super::pair::Pairs;
use crate::geometry::{NONE, VertexId};
use crate::mesh::QuadMesh;

/// What names a vertex of a grid: corners of the base, and steps. A corner is named by itself, a vertex
/// on a side by the ends of the side in order and the steps from the first one, and an inner vertex by
/// the four corners of its block and the steps along both sides.
pub(super) type GridName = ([u32; 4], usize, usize);

/// A quad mesh without points, and for each vertex its name and its place on the scan.
#[derive(Default)]
pub(super) struct BlockGrid {
    pub mesh: QuadMesh,
    pub names: Vec<GridName>,
    pub places: Vec<TrianglePlace>,
    /// The two triangles of the base of each block.
    pub triangles: Vec<[u32; 2]>,
}

impl BlockGrid {
    /// Takes the places of vertices from an earlier grid. Returns the vertices near those that it did
    /// not have.
    pub(crate) fn keep(&mut self, known: &HashMap<GridName, TrianglePlace>) -> Vec<bool> {
        let mut is_new = vec![false; self.names.len()];
        for (v, name) in self.names.iter().enumerate() {
            match known.get(name) {
                Some(place) => self.places[v] = *place,
                None => is_new[v] = true,
            }
        }
        self.mesh.with_neighbours(&is_new)
    }
}

/// Divides every pair into `n` × `n` quads.
pub(super) fn grid(base: &Base, pairs: &Pairs, n: usize) -> BlockGrid {
    let mut mesh = QuadMesh { side: n, ..QuadMesh::default() };
    let mut triangles = Vec::new();
    let mut names = Vec::new();
    let mut places = Vec::new();
    let mut shared: HashMap<GridName, VertexId> = HashMap::new();
    for t in 0..pairs.mate.len() as u32 {
        let other = pairs.mate[t as usize];
        if other < t {
            continue;
        }
        let k = pairs.side(t, other);
        let [t, other] = [t, other].map(|t| pairs.triangles[t as usize]);
        triangles.push([t, other]);
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
            let name = name([a, d, b, c], n, i, j);
            let vertex = *shared.entry(name).or_insert_with(|| {
                names.push(name);
                put()
            });
            vertices.push(vertex);
        }
        let at = |i: usize, j: usize| vertices[(n + 1) * j + i];
        let quads = (0..n * n).map(|k| (k % n, k / n));
        mesh.quads
            .extend(quads.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]));
    }
    BlockGrid { mesh, names, places, triangles }
}

fn name([a, d, b, c]: [u32; 4], n: usize, i: usize, j: usize) -> GridName {
    let corner = |v: u32| ([v, v, NONE, NONE], 0, 0);
    let (from, to, steps) = match (i, j) {
        (0, 0) => return corner(a),
        (i, 0) if i == n => return corner(d),
        (i, j) if i == n && j == n => return corner(b),
        (0, j) if j == n => return corner(c),
        (i, 0) => (a, d, i),
        (i, j) if i == n => (d, b, j),
        (i, j) if j == n => (c, b, i),
        (0, j) => (a, c, j),
        (i, j) => return ([a, d, b, c], i, j),
    };
    let (ends, steps) = if from < to { ([from, to], steps) } else { ([to, from], n - steps) };
    ([ends[0], ends[1], NONE, NONE], steps, 0)
}
