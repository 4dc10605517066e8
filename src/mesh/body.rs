//! A component of any genus, closed or with gaps, as a [`Disk`] without an outer boundary.

use foldhash::{HashSet, HashSetExt};

use super::boundary::{self, Loop};
use super::build::count;
use super::components::{Component, trim_bow_ties};
use super::least_area::filling_area;
use super::{Disk, Mesh, Repairs};
use crate::error::{Error, Result};
use crate::geometry::{Point, VertexId};

impl Component {
    /// Makes a body of the component in the unit of the mesh: a mesh of any genus whose boundary
    /// loops are all holes. Where several fans meet at one place, only the largest is kept. This is
    /// added to `repairs`.
    ///
    /// # Errors
    /// [`Error::NotOrientable`] for a one-sided component.
    pub(crate) fn into_own_body(self, repairs: &mut Repairs) -> Result<Disk> {
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

    /// The least areas of fillings of the boundary loops, as shares of the area of the component, in
    /// descending order.
    pub(crate) fn filling_shares(&self) -> Vec<f64> {
        let mesh = self.own_mesh();
        let whole = mesh.area();
        let filling =
            |ring: &Loop| filling_area(&ring.iter().map(|&v| mesh.point(v)).collect::<Vec<_>>());
        let share = |ring: &Loop| filling(ring) / whole.max(f64::MIN_POSITIVE);
        let mut shares: Vec<f64> = self.loops().iter().map(share).collect();
        shares.sort_by(|a, b| b.total_cmp(a));
        shares
    }
}

impl Component {
    /// Whether the triangles of a closed component face inwards.
    pub(crate) fn is_inside_out(&self) -> bool {
        self.own_mesh().signed_volume() < 0.0
    }

    /// Whether a closed component encloses another one: it goes around a vertex of it. The components must
    /// not cross each other.
    pub(crate) fn encloses(&self, other: &Component) -> bool {
        other.own_mesh().points.first().is_some_and(|p| self.own_mesh().goes_around(*p))
    }
}

impl Mesh {
    /// Whether a closed mesh goes around a point that is not on it.
    pub(crate) fn goes_around(&self, p: Point) -> bool {
        // The solid angles of all triangles sum to 4π inside, and to 0 outside (Van Oosterom, Strackee,
        // "The solid angle of a plane triangle", 1983).
        let angle = |t: &[VertexId; 3]| {
            let [a, b, c] = self.corners(*t).map(|corner| corner - p);
            let [la, lb, lc] = [a, b, c].map(|v| v.norm());
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            2.0 * a.dot(&b.cross(&c)).atan2(below)
        };
        self.triangles.iter().map(angle).sum::<f64>().abs() > 2.0 * std::f64::consts::PI
    }

    /// The volume that the triangles enclose, negative if they face inwards. Cones from the middle of the mesh
    /// close its gaps.
    pub(crate) fn signed_volume(&self) -> f64 {
        let [low, high] = self.bounds();
        let middle = nalgebra::center(&low, &high);
        let cone = |t: &[VertexId; 3]| {
            let [a, b, c] = self.corners(*t).map(|p| p - middle);
            a.dot(&b.cross(&c)) / 6.0
        };
        self.triangles.iter().map(cone).sum()
    }
}

impl Disk {
    /// Turns the triangles of a body if they do not face outwards, or inwards for a void, and adds this to
    /// `repairs`.
    pub(crate) fn turn(&mut self, outwards: bool, repairs: &mut Repairs) {
        if (self.mesh.signed_volume() < 0.0) == outwards {
            self.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            self.holes.iter_mut().for_each(|ring| ring.reverse());
            let kind = if outwards { "faces_turned_outwards" } else { "faces_turned_inwards" };
            count(repairs, kind, self.mesh.triangles.len());
        }
    }
}
