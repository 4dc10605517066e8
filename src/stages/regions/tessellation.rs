//! A mesh with what all steps need: the errors of its vertices, normals, areas and neighbours.

use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{EdgeMap, Mesh};

/// A triangle whose altitude is below so many errors of its vertices has no normal: two errors at each end.
pub(super) const SLIVER: f64 = 4.0;

/// A distance of a vertex to a true surface is at most so many errors: one is that of the file, the second is that of
/// exporters which compute in the file's own precision.
pub(crate) const MOST_ERRORS: f64 = 2.0;

/// A mesh as the file has it, with the errors of its vertices.
pub struct Tessellation<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) errors: &'a [f64],
    pub(super) edges: EdgeMap,
    pub(super) normals: Vec<Vector>,
    /// Twice the areas.
    pub(super) areas: Vec<f64>,
    pub(super) longest: Vec<f64>,
}

impl<'a> Tessellation<'a> {
    /// Measures the triangles of a mesh. `errors` are bounds of the errors of its vertices.
    pub fn new(mesh: &'a Mesh, errors: &'a [f64]) -> Self {
        let edges = EdgeMap::new(mesh);
        let vectors: Vec<Vector> = mesh.triangles.iter().map(|&t| mesh.area_vector(t)).collect();
        let areas: Vec<f64> = vectors.iter().map(|v| v.norm()).collect();
        let unit = |(v, a): (&Vector, &f64)| if *a > 0.0 { v / *a } else { Vector::zeros() };
        let normals = vectors.iter().zip(&areas).map(unit).collect();
        let longest = |&t: &[VertexId; 3]| {
            let [a, b, c] = mesh.corners(t);
            (b - a).norm().max((c - b).norm()).max((a - c).norm())
        };
        let longest = mesh.triangles.iter().map(longest).collect();
        Tessellation { mesh, errors, edges, normals, areas, longest }
    }

    pub(super) fn point(&self, v: u32) -> Point {
        self.mesh.points[v as usize]
    }

    pub(super) fn error(&self, v: u32) -> f64 {
        self.errors[v as usize]
    }

    pub(super) fn corners(&self, t: u32) -> [u32; 3] {
        self.mesh.triangles[t as usize].map(|v| v.0)
    }

    /// The smallest altitude of a triangle.
    pub(super) fn altitude(&self, t: u32) -> f64 {
        self.areas[t as usize] / self.longest[t as usize].max(f64::MIN_POSITIVE)
    }

    /// The largest error at a triangle's corners.
    pub(super) fn triangle_error(&self, t: u32) -> f64 {
        self.corners(t).iter().map(|&v| self.error(v)).fold(0.0, f64::max)
    }

    /// Whether a triangle is too narrow to have a normal.
    pub(super) fn is_sliver(&self, t: u32) -> bool {
        self.altitude(t) < SLIVER * self.triangle_error(t)
    }

    /// The triangles across the three sides, each with the side.
    pub(super) fn across(&self, t: u32) -> impl Iterator<Item = (u32, usize)> + '_ {
        let first = 3 * t as usize;
        (first..first + 3).filter_map(|side| Some((self.edges.across(side)? as u32 / 3, side)))
    }

    /// The ends of a side.
    pub(super) fn ends(&self, side: usize) -> [u32; 2] {
        let (a, b) = self.mesh.side(side);
        [a.0, b.0]
    }
}
