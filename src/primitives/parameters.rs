//! Points of a surface by parameters (u, v), in the convention of STEP (ISO 10303-42), for tests.

use super::Primitive;
use crate::geometry::{Point, Uv, Vector, plane_axes};

impl Primitive {
    /// The point with the given parameters: u is the angle about the axis. v is the height of a cylinder and of a
    /// cone over the origin along the axis, the latitude of a sphere, and the angle around the tube of a torus. A
    /// plane has lengths.
    pub(crate) fn point_at(&self, uv: Uv) -> Point {
        let axis = match *self {
            Primitive::Plane { normal, .. } => normal,
            _ => self.axis().unwrap_or_else(Vector::z),
        };
        let (x, y) = plane_axes(axis);
        let (sin, cos) = uv.x.sin_cos();
        let out = cos * x + sin * y;
        match *self {
            Primitive::Plane { origin, .. } => origin + uv.x * x + uv.y * y,
            Primitive::Cylinder { origin, radius, .. } => origin + radius * out + uv.y * axis,
            Primitive::Cone { origin, radius, angle, .. } => {
                origin + (radius + uv.y * angle.tan()) * out + uv.y * axis
            }
            Primitive::Sphere { centre, radius } => {
                centre + radius * (uv.y.cos() * out + uv.y.sin() * axis)
            }
            Primitive::Torus { centre, major, minor, .. } => {
                centre + (major + minor * uv.y.cos()) * out + minor * uv.y.sin() * axis
            }
        }
    }
}
