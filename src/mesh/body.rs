//! A component of any genus, closed or with gaps, as a [`Disk`] without an outer boundary.

use foldhash::{HashSet, HashSetExt};

use super::boundary::{self, Loop};
use super::build::count;
use super::components::{Component, trim_bow_ties};
use super::{Disk, Mesh, Repairs};
use crate::error::{Error, Result};
use crate::geometry::VertexId;

impl Component {
    /// Makes a body of the component in the unit of the mesh: a mesh of any genus whose boundary
    /// loops are all holes. Where several fans meet at one place, only the largest is kept. This is
    /// added to `repairs`.
    ///
    /// # Errors
    /// [`Error::NotOrientable`] for a one-sided component.
    pub fn into_own_body(self, repairs: &mut Repairs) -> Result<Disk> {
        if !self.topology.orientable {
            return Err(Error::NotOrientable);
        }
        let mut build = self.build;
        let before = build.mesh.triangles.len();
        while trim_bow_ties(&mut build, &HashSet::new()) {}
        count(repairs, "faces_dropped_at_bow_ties", before - build.mesh.triangles.len());
        let holes = boundary::boundary_loops(&build.mesh, &build.edges);
        Ok(Disk { mesh: build.mesh, outer: Vec::new(), holes, islands: Vec::new() })
    }

    /// The share that flat caps over all boundary loops would add to the area of the component.
    pub fn gap_share(&self) -> f64 {
        self.cap_shares().iter().sum()
    }

    /// The areas of flat caps over the boundary loops, as shares of the area of the component, in
    /// descending order.
    pub fn cap_shares(&self) -> Vec<f64> {
        let mesh = self.own_mesh();
        let area = |t: &[VertexId; 3]| mesh.area_vector(*t).norm();
        let whole: f64 = mesh.triangles.iter().map(area).sum();
        let cap = |ring: &Loop| 2.0 * boundary::area(mesh, ring).norm();
        let share = |ring: &Loop| cap(ring) / whole.max(f64::MIN_POSITIVE);
        let mut shares: Vec<f64> = self.loops().iter().map(share).collect();
        shares.sort_by(|a, b| b.total_cmp(a));
        shares
    }
}

impl Disk {
    /// Turns a body that is inside out, and adds this to `repairs`.
    pub fn turn_outwards(&mut self, repairs: &mut Repairs) {
        if volume(&self.mesh) < 0.0 {
            self.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            self.holes.iter_mut().for_each(|ring| ring.reverse());
            count(repairs, "faces_turned_outwards", self.mesh.triangles.len());
        }
    }
}

/// The volume that triangles enclose. Cones from the middle of the mesh close its gaps.
fn volume(mesh: &Mesh) -> f64 {
    let [low, high] = mesh.bounds();
    let middle = nalgebra::center(&low, &high);
    let cone = |t: &[VertexId; 3]| {
        let [a, b, c] = mesh.corners(*t).map(|p| p - middle);
        a.dot(&b.cross(&c)) / 6.0
    };
    mesh.triangles.iter().map(cone).sum()
}
