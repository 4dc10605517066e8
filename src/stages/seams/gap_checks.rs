//! Checks of the triangles that close gaps: whether they belong to a patch, cross the mesh or lie on it, and which patches they
//! join.

use super::gaps::{ClosedMesh, GapClosure};
use super::rims::{OFF_RIM, Rim};
use super::stretches::MOST_TURN;
use super::{FacePatch, SolidFault};
use crate::geometry::sets::Sets;
use crate::geometry::{Point, VertexId, segment_distance};
use crate::mesh::EdgeMap;
use crate::mesh::crossings::crossings;

/// Faces with a larger angle between them than this cosine says, about 179°, enclose nothing.
const FOLDED: f64 = 0.9998;

impl GapClosure {
    /// The number of vertices of a rim that are off the line of their neighbours.
    pub(super) fn corners(&self, rim: &Rim) -> usize {
        let points = rim.points(&self.closed.mesh);
        let n = points.len();
        let is_corner = |&k: &usize| {
            let [before, at, after] = [k + n - 1, k, k + 1].map(|k| points[k % n]);
            let error = self.closed.errors[rim.vertices[k].index()];
            segment_distance(at, before, after) > OFF_RIM * error
        };
        (0..n).filter(is_corner).count()
    }

    /// Whether a triangle may be one of a patch: its corners lie on the surface, and its normal is near those there.
    pub(super) fn is_on(&self, patch: usize, triangle: [VertexId; 3]) -> bool {
        let ClosedMesh { mesh, errors, patches, .. } = &self.closed;
        let FacePatch { surface, side, .. } = &patches[patch];
        let normal = mesh.area_vector(triangle);
        triangle.iter().all(|&v| {
            let (off, towards) = surface.distance(mesh.point(v));
            off.abs() <= OFF_RIM * errors[v.index()]
                && side * towards.dot(&normal) >= MOST_TURN.cos() * normal.norm()
        })
    }

    /// The distance of the middle of a triangle from the surface of a patch.
    pub(super) fn sagitta(&self, patch: usize, triangle: [VertexId; 3]) -> f64 {
        let [a, b, c] = self.closed.mesh.corners(triangle);
        let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
        self.closed.patches[patch].surface.distance(middle).0.abs()
    }

    /// Checks that triangles from a number on neither cross the mesh nor lie on their neighbours.
    pub(super) fn check(&self, first: usize) -> Result<(), SolidFault> {
        let mesh = &self.closed.mesh;
        let fault = |t: usize, why| {
            let place = mesh.point(mesh.triangles[t][0]);
            Err(SolidFault::Gap { place, why })
        };
        if let Some(pair) = crossings(mesh).into_iter().find(|pair| pair[1] >= first) {
            return fault(pair[1], "its fill would cross the mesh");
        }
        let edges = EdgeMap::new(mesh);
        let normal = |t: usize| mesh.area_vector(mesh.triangles[t]);
        let folds = |&side: &usize| {
            edges.across(side).is_some_and(|twin| {
                let (a, b) = (normal(side / 3), normal(twin / 3));
                a.dot(&b) <= -FOLDED * a.norm() * b.norm() && a.dot(&b) < 0.0
            })
        };
        match (3 * first..3 * mesh.triangles.len()).find(folds) {
            Some(side) => fault(side / 3, "its fill would lie on the faces beside it"),
            None => Ok(()),
        }
    }

    /// Joins patches that a gap has parted: those beside triangles from a number on that have the same surface.
    pub(super) fn join(&mut self, first: usize) {
        let edges = EdgeMap::new(&self.closed.mesh);
        let mut sets = Sets::new(self.closed.patches.len());
        for side in 3 * first..3 * self.closed.mesh.triangles.len() {
            let Some(twin) = edges.across(side) else { continue };
            let (a, b) = (self.of_triangle[side / 3], self.of_triangle[twin / 3]);
            if a != b && sets.find(a) != sets.find(b) && self.are_one(a, b) {
                sets.join(a, b);
            }
        }
        for set in sets.members().into_iter().filter(|set| set.len() > 1) {
            let home = set[0] as usize;
            for &other in &set[1..] {
                let moved = std::mem::take(&mut self.closed.patches[other as usize].triangles);
                self.closed.patches[home].triangles.extend(moved);
            }
            self.closed.patches[home].triangles.sort_unstable();
        }
    }

    /// Whether the surface of a patch has all triangles of another one.
    fn are_one(&self, a: usize, b: usize) -> bool {
        let [of_a, of_b] = [a, b].map(|i| &self.closed.patches[i]);
        let triangle = |t: &u32| self.closed.mesh.triangles[*t as usize];
        !of_a.is_facet
            && !of_b.is_facet
            && of_a.surface.kind() == of_b.surface.kind()
            && of_b.triangles.iter().all(|t| self.is_on(a, triangle(t)))
    }
}
