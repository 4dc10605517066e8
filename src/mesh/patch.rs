//! A disk whose holes are filled, with the memory of what was measured.

use std::ops::Range;

use super::boundary::Loop;
use super::disk::Island;
use super::{EdgeMap, Mesh, Topology};
use crate::geometry::{Bound, VertexId};

/// Where a triangle comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceOrigin {
    /// The scanner saw it.
    Measured,
    /// It fills the hole of that number.
    Hole(u32),
    /// It closes a bay of the outer boundary.
    Bay,
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
    /// The measured outer boundary, if bays of it were closed.
    pub measured_outer: Option<Loop>,
    /// The rims of the measured holes, the measured surface to their left.
    pub rims: Vec<Loop>,
    /// The measured islands in them; the fill joins each to the rest.
    pub islands: Vec<Island>,
}

impl Patch {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Patch { mesh: self.mesh.scaled(factor), ..self }
    }

    /// Whether a vertex was measured.
    pub fn is_measured(&self, v: VertexId) -> bool {
        v.index() < self.measured
    }

    /// The numbers of the triangles that were measured.
    pub fn measured_triangles(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.origin.len()).filter(|&t| self.origin[t] == FaceOrigin::Measured)
    }

    /// The patch as it was before its bays were closed. `None`: none were.
    pub fn without_bays(&self) -> Option<Patch> {
        let outer = self.measured_outer.clone()?;
        let is_land = |t: &usize| self.origin[*t] != FaceOrigin::Bay;
        let land: Vec<usize> = (0..self.origin.len()).filter(is_land).collect();
        let triangles: Vec<[VertexId; 3]> = land.iter().map(|&t| self.mesh.triangles[t]).collect();
        // What closes bays comes last.
        let count = triangles.iter().flatten().map(|v| v.index() + 1).max().unwrap_or(0);
        let points = self.mesh.points[..count].to_vec();
        Some(Patch {
            mesh: Mesh { points, triangles },
            origin: land.iter().map(|&t| self.origin[t]).collect(),
            outer,
            measured_outer: None,
            measured: self.measured,
            rims: self.rims.clone(),
            islands: self.islands.clone(),
        })
    }

    /// A loop, the measured surface to its left.
    pub fn loop_of(&self, bound: Bound) -> &Loop {
        match bound {
            Bound::Outer => self.measured_outer.as_ref().unwrap_or(&self.outer),
            Bound::Hole(hole) => &self.rims[hole],
            Bound::Island { number, .. } => &self.islands[number].rim,
        }
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
