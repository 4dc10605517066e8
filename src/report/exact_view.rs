//! What pictures show of exact faces: the mesh in colours by kind, and bores and shafts.

use super::exact::ExactFigures;
use crate::convert::{ExactFace, ExactFit};
use crate::geometry::{Point, Vector};
use crate::mesh::Mesh;
use crate::primitives::PrimitiveKind;
use crate::report::picture::colour::{Rgb, TINTS, linear, srgb};
use crate::words::mm;

/// The kind of faces that lie on no surface.
pub(super) const OTHER: &str = "free-form or facet";

/// The kinds of faces, in the order of their colours.
pub(super) const KINDS: [&str; 6] = ["plane", "cylinder", "cone", "sphere", "torus", OTHER];

/// The position of a face's kind among [`KINDS`].
pub(super) fn kind_of(face: &ExactFace) -> usize {
    match face.surface.kind() {
        _ if face.is_facet => 5,
        PrimitiveKind::Plane => 0,
        PrimitiveKind::Cylinder => 1,
        PrimitiveKind::Cone => 2,
        PrimitiveKind::Sphere => 3,
        PrimitiveKind::Torus => 4,
    }
}

impl ExactFace {
    /// The normals at the corners of a triangle of the face. Where its surface is not elementary they are those of the triangle.
    pub(super) fn normals(&self, corners: [Point; 3]) -> [Vector; 3] {
        let [a, b, c] = corners;
        match self.is_free {
            true => [(b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default(); 3],
            false => corners.map(|p| self.side * self.surface.normal(p)),
        }
    }
}

/// The exact faces of one body.
#[derive(Debug)]
pub(super) struct ExactView {
    /// The mesh, in mm.
    pub mesh: Mesh,
    /// For each triangle its kind and the outer normals of its surface at the corners.
    painted: Vec<(usize, [Vector; 3])>,
    /// For each triangle its face.
    pub face_of: Vec<u32>,
    /// The number of faces of each kind.
    pub counts: [usize; KINDS.len()],
    /// Bores and shafts, what was snapped, and what became facets.
    pub figures: ExactFigures,
}

impl ExactView {
    pub(super) fn of(fit: &ExactFit) -> Self {
        let mut counts = [0; KINDS.len()];
        fit.faces.iter().for_each(|face| counts[kind_of(face)] += 1);
        let paint = |(&face, &triangle): (&u32, &[_; 3])| {
            let face = &fit.faces[face as usize];
            (kind_of(face), face.normals(fit.mesh.corners(triangle)))
        };
        ExactView {
            painted: fit.of_triangle.iter().zip(&fit.mesh.triangles).map(paint).collect(),
            mesh: fit.mesh.clone(),
            face_of: fit.of_triangle.clone(),
            counts,
            figures: ExactFigures::of(fit),
        }
    }

    /// Bores and shafts, a line each.
    pub(super) fn cylinders(&self) -> impl Iterator<Item = String> {
        self.figures.cylinders.iter().map(|row| {
            let [x, y, z] = row.at.map(|x| format!("{x:.3}"));
            let [radius, length] = [row.radius_mm, row.length_mm].map(mm);
            format!("{} of radius {radius}, {length} long, at ({x}, {y}, {z})", row.name())
        })
    }

    /// The places that the page points at, with what is there: cylinders, and then faces that became facets.
    #[cfg(feature = "html")]
    pub(super) fn spots(&self) -> impl Iterator<Item = ([f64; 3], String)> {
        let cylinders = self.figures.cylinders.iter();
        let cylinders =
            cylinders.map(|row| (row.at, format!("{}, radius {}", row.name(), mm(row.radius_mm))));
        let facets = self.figures.facets.iter();
        cylinders.chain(facets.map(|row| (row.at, format!("facets of a {}", row.surface))))
    }

    /// The outer normals of its surface at the corners of a triangle.
    pub(super) fn normals(&self, triangle: usize) -> [Vector; 3] {
        self.painted[triangle].1
    }

    /// The colour of a triangle, and the normals at its corners.
    pub(super) fn paint(&self, triangle: usize) -> (Rgb, [Vector; 3]) {
        let (kind, normals) = self.painted[triangle];
        (linear(srgb(TINTS[kind])), normals)
    }
}
