//! How far the scan is from exact faces.

use super::conversion::ExactFace;
use crate::deviation::{Deviation, FaceToScan};
use crate::geometry::{Point, VertexId};
use crate::mesh::Mesh;
use crate::stages::seams::FacePatch;

/// How far the vertices and the triangles of a mesh are from the surfaces of their faces.
pub(super) struct Distances {
    /// For each vertex the largest distance from one of its surfaces, positive outside.
    pub of_vertices: Vec<f64>,
    /// What is known of each face.
    pub of_faces: Vec<ExactFace>,
    /// For each triangle its face.
    pub of_triangle: Vec<u32>,
    /// How far the faces are from the triangles.
    pub to_triangles: FaceToScan,
    /// The share of the area that is not facets.
    pub explained: f64,
}

impl Distances {
    /// Measures the first points and triangles of a mesh, so many of each. Those behind them close its gaps.
    pub fn of(mesh: &Mesh, measured: [usize; 2], patches: &[FacePatch]) -> Self {
        let mut of_vertices = vec![0.0f64; measured[0]];
        let mut of_triangle = vec![0; mesh.triangles.len()];
        let mut of_faces = Vec::with_capacity(patches.len());
        let (mut all, mut exact) = (0.0, 0.0);
        let mut middles: Vec<(Point, f64)> = Vec::with_capacity(mesh.triangles.len());
        for (number, patch) in patches.iter().enumerate() {
            let corners = patch.triangles.iter().flat_map(|&t| mesh.triangles[t as usize]);
            let mut vertices: Vec<VertexId> = corners.collect();
            vertices.sort_unstable();
            vertices.dedup();
            vertices.retain(|v| v.index() < measured[0]);
            let mut squares = 0.0;
            let mut max = 0.0f64;
            for &v in &vertices {
                let distance = patch.side * patch.surface.distance(mesh.point(v)).0;
                let known = &mut of_vertices[v.index()];
                if distance.abs() > known.abs() {
                    *known = distance;
                }
                squares += distance * distance;
                max = max.max(distance.abs());
            }
            for &t in &patch.triangles {
                of_triangle[t as usize] = number as u32;
                if t as usize >= measured[1] {
                    continue;
                }
                let area = mesh.area_vector(mesh.triangles[t as usize]).norm();
                all += area;
                exact += if patch.is_facet { 0.0 } else { area };
                let [a, b, c] = mesh.corners(mesh.triangles[t as usize]).map(|p| p.coords);
                let middle = Point::from((a + b + c) / 3.0);
                middles.push((middle, patch.surface.distance(middle).0.abs()));
            }
            let rms = (squares / vertices.len().max(1) as f64).sqrt();
            let FacePatch { surface, side, is_facet, .. } = *patch;
            of_faces.push(ExactFace { surface, side, is_facet, rms, max, points: vertices.len() });
        }
        let (points, distances): (Vec<Point>, Vec<f64>) = middles.into_iter().unzip();
        let found = Deviation::of(&points, distances);
        let to_triangles = FaceToScan {
            rms: found.rms,
            p95: found.p95,
            max: found.max,
            max_at: found.max_at,
            // The corners of the triangles lie on the surface, so that all of this is chord error.
            chord_error: found.max,
            beyond: 0,
            places: points.len(),
        };
        let explained = exact / f64::max(all, f64::MIN_POSITIVE);
        Distances { of_vertices, of_faces, of_triangle, to_triangles, explained }
    }
}
