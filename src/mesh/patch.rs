//! A disk whose holes are filled, with the memory of what was measured.

use std::ops::Range;

use super::boundary::Loop;
use super::disk::Island;
use super::{EdgeMap, Mesh, Topology};
use crate::geometry::VertexId;

/// Where a triangle comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceOrigin {
    /// The scanner saw it.
    Measured,
    /// It fills the hole of that number.
    Hole(u32),
}

/// A disk without holes. Its first `measured` vertices are the scan's, in the
/// scan's order; those after them were added.
#[derive(Debug, Clone)]
pub struct Patch {
    /// The triangles and points.
    pub mesh: Mesh,
    /// How many of the vertices were measured.
    pub measured: usize,
    /// Where each triangle comes from.
    pub origin: Vec<FaceOrigin>,
    /// The boundary, the surface to its left.
    pub outer: Loop,
    /// The rims of the measured holes, the measured surface to their left.
    pub rims: Vec<Loop>,
    /// The measured islands in them; the fill joins each to the rest.
    pub islands: Vec<Island>,
}

impl Patch {
    /// Whether a vertex was measured.
    pub fn is_measured(&self, v: VertexId) -> bool {
        v.index() < self.measured
    }

    /// The holes that are not in an island: positions among `rims`.
    pub fn own_holes(&self) -> Range<usize> {
        0..self.islands.first().map_or(self.rims.len(), |island| island.holes.start)
    }

    /// Whether the mesh is edge-manifold and oriented, with Euler characteristic 1 and the
    /// one boundary loop that it should have. For checks in debug builds.
    pub fn is_disk(&self) -> bool {
        let edges = EdgeMap::new(&self.mesh);
        let topology = Topology::new(&self.mesh, &edges, true);
        topology.euler == 1
            && topology.loops == 1
            && edges.open_sides().count() == self.outer.len()
            && edges.is_oriented(&self.mesh)
    }
}
