//! The surface of a face: a primitive, or a B-spline where the kind is not known.

use std::sync::Arc;

use crate::geometry::{Point, Vector};
use crate::primitives::{Primitive, PrimitiveKind};
use crate::spline::SplineSheet;

/// The surface of a face, in mm.
#[derive(Debug, Clone)]
pub enum FaceSurface {
    /// A surface that is known exactly.
    Exact(Primitive),
    /// A B-spline surface near the vertices of the face.
    Spline(Arc<SplineSheet>),
}

impl From<Primitive> for FaceSurface {
    fn from(exact: Primitive) -> Self {
        FaceSurface::Exact(exact)
    }
}

impl FaceSurface {
    /// The surface if it is known exactly.
    pub fn exact(&self) -> Option<Primitive> {
        match self {
            FaceSurface::Exact(exact) => Some(*exact),
            FaceSurface::Spline(_) => None,
        }
    }

    /// The kind of an exact surface.
    pub fn kind(&self) -> Option<PrimitiveKind> {
        self.exact().map(|exact| exact.kind())
    }

    /// The name of the kind: that of the primitive, or "spline".
    pub fn name(&self) -> &'static str {
        self.kind().map_or("spline", PrimitiveKind::name)
    }

    /// The control points of a B-spline in u and in v.
    pub fn net(&self) -> Option<[usize; 2]> {
        match self {
            FaceSurface::Exact(_) => None,
            FaceSurface::Spline(sheet) => Some(sheet.surface().shape()),
        }
    }

    /// The distance in mm within which the vertices of the face and its edges lie on the surface. It is 0 if the surface
    /// is exact.
    pub(crate) fn within(&self) -> f64 {
        match self {
            FaceSurface::Exact(_) => 0.0,
            FaceSurface::Spline(sheet) => sheet.within(),
        }
    }

    pub(super) fn is_plane(&self) -> bool {
        self.kind() == Some(PrimitiveKind::Plane)
    }

    /// The signed distance of a point, and the unit normal at the closest point.
    pub(crate) fn distance(&self, p: Point) -> (f64, Vector) {
        match self {
            FaceSurface::Exact(exact) => exact.distance(p),
            FaceSurface::Spline(sheet) => sheet.distance(p),
        }
    }

    /// The unit normal at the closest point.
    pub(crate) fn normal(&self, p: Point) -> Vector {
        self.distance(p).1
    }

    pub(crate) fn closest(&self, p: Point) -> Point {
        match self {
            FaceSurface::Exact(exact) => exact.closest(p),
            FaceSurface::Spline(sheet) => sheet.closest(p),
        }
    }

    pub(crate) fn curvature(&self, p: Point) -> f64 {
        match self {
            FaceSurface::Exact(exact) => exact.curvature(p),
            FaceSurface::Spline(sheet) => sheet.curvature(p),
        }
    }
}
