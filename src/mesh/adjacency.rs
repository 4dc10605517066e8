//! Tests whether two vertices of a mesh are joined by an edge.

use super::{Mesh, VertexRings};
use crate::geometry::{Vector, VertexId, unit_normal};

/// A mesh with the triangles around its vertices.
#[derive(Clone, Copy)]
pub(crate) struct Adjacency<'a> {
    pub mesh: &'a Mesh,
    pub rings: &'a VertexRings,
}

impl Adjacency<'_> {
    /// Whether an edge of the mesh joins two vertices. Vertices beyond those of the mesh are not
    /// joined.
    pub(crate) fn joined(&self, v: VertexId, w: VertexId) -> bool {
        let measured = v.index().max(w.index()) < self.mesh.points.len();
        measured && self.rings.neighbours(self.mesh, v).any(|x| x == w)
    }

    /// The unit normal of a triangle of the mesh that has both vertices.
    pub(crate) fn normal_at(&self, v: VertexId, w: VertexId) -> Option<Vector> {
        if v.index().max(w.index()) >= self.mesh.points.len() {
            return None;
        }
        let mut of_v = self.rings.triangles(v).iter().map(|&t| self.mesh.triangles[t as usize]);
        unit_normal(self.mesh.corners(of_v.find(|t| t.contains(&w))?))
    }
}
