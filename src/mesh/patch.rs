//! A disk whose holes are filled. It remembers which triangles and vertices were measured.

use std::borrow::Cow;
use std::ops::Range;

use super::boundary::Loop;
use super::disk::Island;
use super::{EdgeMap, Mesh, StandIns, Topology};
use crate::geometry::{Bound, VertexId};

/// The origin of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceOrigin {
    /// The triangle was measured by the scanner.
    Measured,
    /// The triangle fills the hole with this number.
    Hole(u32),
    /// The triangle closes a bay, which is a concavity of the outer boundary.
    Bay,
}

/// A disk without holes. Its first `measured` vertices are those of the scan, in the order of the
/// scan, or those that stand for them. Vertices added by later stages follow them.
#[derive(Debug, Clone)]
pub struct Patch {
    /// The triangles and points.
    pub mesh: Mesh,
    /// The number of measured vertices.
    pub measured: usize,
    /// The origin of each triangle.
    pub origin: Vec<FaceOrigin>,
    /// The boundary of the mesh; the surface lies to its left. It is empty for a body.
    pub outer: Loop,
    /// The outer boundary of the measured surface, if bays of it were closed.
    pub measured_outer: Option<Loop>,
    /// The rims of the measured holes; the measured surface lies to their left.
    pub rims: Vec<Loop>,
    /// The measured islands in the holes. The fill joins each island to the surrounding surface.
    pub islands: Vec<Island>,
    /// The vertices of the scan for which the measured vertices stand, if the patch has fewer of them
    /// than the scan.
    pub stand_ins: Option<StandIns>,
    /// For each measured vertex the number of points of the cloud for which it stands, if the mesh was made of one.
    pub point_counts: Option<Vec<f64>>,
}

impl Patch {
    /// The patch with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Patch { mesh: self.mesh.scaled(factor), ..self }
    }

    /// For each measured vertex how much was measured there: the number of points of the cloud or of vertices of the scan
    /// for which it stands.
    pub(crate) fn counts(&self) -> Vec<f64> {
        match (&self.point_counts, &self.stand_ins) {
            (Some(counts), _) => counts.clone(),
            (None, Some(stand_ins)) => stand_ins.counts().to_vec(),
            (None, None) => vec![1.0; self.measured],
        }
    }

    /// A value of each measured vertex, for each vertex of the scan for which it stands.
    pub(crate) fn of_scan<'a, T: Copy>(&self, values: &'a [T]) -> Cow<'a, [T]> {
        match &self.stand_ins {
            Some(stand_ins) => stand_ins.of_scan(values).into(),
            None => values.into(),
        }
    }

    /// Whether a vertex was measured.
    pub fn is_measured(&self, v: VertexId) -> bool {
        v.index() < self.measured
    }

    /// The numbers of the measured triangles.
    pub(crate) fn measured_triangles(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.origin.len()).filter(|&t| self.origin[t] == FaceOrigin::Measured)
    }

    /// The patch as it was before its bays were closed, or `None` if none were closed.
    pub(crate) fn without_bays(&self) -> Option<Patch> {
        let outer = self.measured_outer.clone()?;
        let is_kept = |t: &usize| self.origin[*t] != FaceOrigin::Bay;
        let kept: Vec<usize> = (0..self.origin.len()).filter(is_kept).collect();
        let triangles: Vec<[VertexId; 3]> = kept.iter().map(|&t| self.mesh.triangles[t]).collect();
        // The vertices that were added to close bays come last.
        let count = triangles.iter().flatten().map(|v| v.index() + 1).max().unwrap_or(0);
        let points = self.mesh.points[..count].to_vec();
        Some(Patch {
            mesh: Mesh { points, triangles },
            origin: kept.iter().map(|&t| self.origin[t]).collect(),
            outer,
            measured_outer: None,
            measured: self.measured,
            rims: self.rims.clone(),
            islands: self.islands.clone(),
            stand_ins: self.stand_ins.clone(),
            point_counts: self.point_counts.clone(),
        })
    }

    /// A boundary loop of the measured surface, which lies to its left.
    pub fn loop_of(&self, bound: Bound) -> &Loop {
        match bound {
            Bound::Outer => self.measured_outer.as_ref().unwrap_or(&self.outer),
            Bound::Hole(hole) => &self.rims[hole],
            Bound::Island { number, .. } => &self.islands[number].rim,
        }
    }

    /// The holes that do not lie in an island, as positions in `rims`.
    pub(crate) fn own_holes(&self) -> Range<usize> {
        0..self.islands.first().map_or(self.rims.len(), |island| island.holes.start)
    }

    /// Whether the mesh is edge-manifold and oriented, has Euler characteristic 1, and has `outer`
    /// as its only boundary loop. Debug builds check this.
    pub fn is_disk(&self) -> bool {
        let edges = EdgeMap::new(&self.mesh);
        let topology = Topology::new(&self.mesh, &edges, true);
        topology.euler == 1
            && topology.loops == 1
            && edges.open_sides().count() == self.outer.len()
            && edges.is_oriented(&self.mesh)
    }
}
