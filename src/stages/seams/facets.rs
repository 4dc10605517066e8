//! Facets: which triangles lie in one plane, and the planes through moved vertices.

use super::fallback::SeamFault;
use super::network::ChainNetwork;
use super::{EXACT, FacePatch, Work};
use crate::geometry::{Point, Vector};
use crate::primitives::Primitive;

/// The largest distance of a corner from the plane of three others, in errors: κ = 2 for the corner and, weighted, as
/// much for the three.
const FLAT_ERRORS: f64 = 4.0;

impl Work<'_> {
    fn corner_points(&self, side: usize) -> [Point; 3] {
        let corner = |k: usize| self.mesh.point(self.mesh.side(3 * (side / 3) + (side + k) % 3).0);
        [corner(0), corner(1), corner(2)]
    }

    /// Whether a triangle has no plane of its own, and the side is its longest one.
    pub(super) fn is_thin(&self, side: usize) -> bool {
        let [a, b, c] = self.corner_points(side);
        let long = (b - a).norm();
        let is_longest = long >= (c - b).norm().max((a - c).norm());
        let [u, v, w] = self.mesh.triangles[side / 3].map(|v| self.errors[v.index()]);
        is_longest && (b - a).cross(&(c - a)).norm() < FLAT_ERRORS * u.max(v).max(w) * long
    }

    /// Whether the corners of the triangles on both sides of an edge lie in a plane.
    pub(super) fn is_flat(&self, side: usize, twin: usize) -> bool {
        let [a, b, c] = self.corner_points(side);
        let across = self.mesh.side(3 * (twin / 3) + (twin + 2) % 3).0;
        let corners = self.mesh.triangles[side / 3].map(|v| self.errors[v.index()]);
        let error = corners.iter().copied().fold(self.errors[across.index()], f64::max);
        let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE);
        normal.is_some_and(|n| (self.mesh.point(across) - a).dot(&n).abs() < FLAT_ERRORS * error)
    }

    /// The plane of a facet through the places of its vertices.
    fn plane(&self, patch: &FacePatch, places: &[Point]) -> Option<Primitive> {
        let mut normal = Vector::zeros();
        let mut sum = Vector::zeros();
        let mut first = None;
        for &t in &patch.triangles {
            let [a, b, c] = self.mesh.triangles[t as usize].map(|v| places[v.index()]);
            normal += (b - a).cross(&(c - a));
            sum += a.coords + b.coords + c.coords;
            first = first.or(Some(a));
        }
        let normal = normal.try_normalize(f64::MIN_POSITIVE)?;
        let origin = match patch.triangles.len() {
            1 => first?,
            n => Point::from(sum / (3 * n) as f64),
        };
        Some(Primitive::Plane { origin, normal })
    }

    /// Lays planes through the facets. Those of several triangles then hold their vertices.
    pub(super) fn lay_facets(&mut self) {
        for i in 0..self.patches.len() {
            if self.patches[i].is_facet
                && let Some(plane) = self.plane(&self.patches[i], &self.mesh.points)
            {
                self.patches[i].surface = plane;
                self.patches[i].side = 1.0;
            }
        }
    }

    /// Lays the planes of single triangles through their vertices.
    pub(super) fn fit_facets(&mut self, network: &ChainNetwork) -> Result<(), Vec<SeamFault>> {
        let mut places = self.mesh.points.clone();
        for (n, &v) in network.junctions.iter().enumerate() {
            places[v as usize] = network.vertices[n];
        }
        let mut bent = Vec::new();
        for i in 0..self.patches.len() {
            let patch = &self.patches[i];
            if !patch.is_facet {
                continue;
            }
            if self.is_bent(i) {
                if let Some(plane) = self.plane(patch, &places) {
                    self.patches[i].surface = plane;
                }
                continue;
            }
            let corners = patch.triangles.iter().flat_map(|&t| self.mesh.triangles[t as usize]);
            let off = |v: crate::geometry::VertexId| patch.surface.distance(places[v.index()]).0;
            if corners.map(off).any(|d| d.abs() > EXACT) {
                bent.push(SeamFault::new(&[i], "a facet that is not flat"));
            }
        }
        if bent.is_empty() { Ok(()) } else { Err(bent) }
    }
}
