//! What pictures show of exact faces: the mesh in colours by kind, and bores and shafts.

use super::exact::ExactFigures;
use crate::convert::{ExactFace, ExactFit};
use crate::geometry::Vector;
use crate::mesh::Mesh;
use crate::primitives::PrimitiveKind;
use crate::report::picture::colour::{Rgb, TINTS, linear, srgb};
use crate::words::mm;

/// The kinds of faces, in the order of their colours.
pub(super) const KINDS: [&str; 7] =
    ["plane", "cylinder", "cone", "sphere", "torus", "facet", "B-spline"];

/// The position of a face's kind among [`KINDS`].
pub(super) fn kind_of(face: &ExactFace) -> usize {
    match face.surface.kind() {
        _ if face.is_facet => 5,
        Some(PrimitiveKind::Plane) => 0,
        Some(PrimitiveKind::Cylinder) => 1,
        Some(PrimitiveKind::Cone) => 2,
        Some(PrimitiveKind::Sphere) => 3,
        Some(PrimitiveKind::Torus) => 4,
        None => 6,
    }
}

/// The exact faces of one body.
#[derive(Debug)]
pub(super) struct ExactView {
    /// The mesh, in mm.
    pub mesh: Mesh,
    /// For each triangle its kind and the outer normals of its surface at the corners.
    painted: Vec<(usize, [Vector; 3])>,
    /// The number of faces of each kind.
    pub counts: [usize; KINDS.len()],
    /// Bores and shafts, a line each.
    pub cylinders: Vec<String>,
}

impl ExactView {
    pub(super) fn of(fit: &ExactFit) -> Self {
        let mut counts = [0; KINDS.len()];
        fit.faces.iter().for_each(|face| counts[kind_of(face)] += 1);
        let paint = |(&face, &triangle): (&u32, &[_; 3])| {
            let face = &fit.faces[face as usize];
            let normals = fit.mesh.corners(triangle).map(|p| face.side * face.surface.normal(p));
            (kind_of(face), normals)
        };
        let found = ExactFigures::of(fit).cylinders.into_iter();
        let cylinders = found.map(|row| {
            let [x, y, z] = row.at.map(|x| format!("{x:.3}"));
            format!(
                "{} of radius {}, {} long, at ({x}, {y}, {z})",
                row.kind,
                mm(row.radius_mm),
                mm(row.length_mm)
            )
        });
        ExactView {
            painted: fit.of_triangle.iter().zip(&fit.mesh.triangles).map(paint).collect(),
            mesh: fit.mesh.clone(),
            counts,
            cylinders: cylinders.collect(),
        }
    }

    /// The colour of a triangle, and the normals at its corners.
    pub(super) fn paint(&self, triangle: usize) -> (Rgb, [Vector; 3]) {
        let (kind, normals) = self.painted[triangle];
        (linear(srgb(TINTS[kind])), normals)
    }
}
