//! Who borders on whom.

use super::Mesh;
use crate::geometry::VertexId;

/// For each side of each triangle, the side it is glued to.
///
/// Side `3 t + k` of the mesh runs from corner `k` of triangle `t` to corner
/// `k + 1`.
#[derive(Debug)]
pub struct EdgeMap {
    glued: Vec<u32>,
}

const OPEN: u32 = u32::MAX;

impl EdgeMap {
    /// Glues every two sides that join the same two vertices in opposite
    /// directions, where no third side does.
    pub fn new(mesh: &Mesh) -> Self {
        let mut map = Self::unoriented(mesh);
        let from = |side: usize| mesh.triangles[side / 3][side % 3];
        for side in 0..map.glued.len() {
            if let Some(other) = map.across(side).filter(|&other| from(side) == from(other)) {
                map.glued[other] = OPEN;
                map.glued[side] = OPEN;
            }
        }
        map
    }

    /// Glues every two sides that join the same two vertices in any direction,
    /// where no third side does.
    pub(super) fn unoriented(mesh: &Mesh) -> Self {
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * mesh.triangles.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[k].0, corners[(k + 1) % 3].0);
                sides.push((a.min(b), a.max(b), (3 * t + k) as u32));
            }
        }
        sides.sort_unstable();
        let mut glued = vec![OPEN; sides.len()];
        for same in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
            if let [(_, _, x), (_, _, y)] = *same {
                glued[x as usize] = y;
                glued[y as usize] = x;
            }
        }
        EdgeMap { glued }
    }

    /// The side that `side` is glued to, unless it lies on the boundary.
    pub fn across(&self, side: usize) -> Option<usize> {
        let other = self.glued[side];
        (other != OPEN).then_some(other as usize)
    }

    /// Boundary sides in ascending order.
    pub fn open_sides(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.glued.len()).filter(|&s| self.glued[s] == OPEN)
    }
}

/// For each vertex its neighbours along edges, and its triangles.
#[derive(Debug)]
pub struct Rings {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Rings {
    /// Lists the triangles of every vertex, in ascending order.
    pub fn new(mesh: &Mesh) -> Self {
        let mut starts = vec![0u32; mesh.points.len() + 1];
        for v in mesh.triangles.iter().flatten() {
            starts[v.index() + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut triangles = vec![0; 3 * mesh.triangles.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for v in corners {
                triangles[next[v.index()] as usize] = t as u32;
                next[v.index()] += 1;
            }
        }
        Rings { starts, triangles }
    }

    /// The triangles around a vertex.
    pub fn triangles(&self, v: VertexId) -> &[u32] {
        let i = v.index();
        &self.triangles[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// The vertices that share a triangle with `v`, each as often as it does.
    pub fn neighbours<'a>(
        &'a self,
        mesh: &'a Mesh,
        v: VertexId,
    ) -> impl Iterator<Item = VertexId> + 'a {
        let corners = self.triangles(v).iter().flat_map(|&t| mesh.triangles[t as usize]);
        corners.filter(move |&w| w != v)
    }
}
