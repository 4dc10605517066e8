//! Parameters (u, v) on a surface, in the convention of STEP (ISO 10303-42), and their ranges on a patch.

use std::f64::consts::TAU;

use super::Primitive;
use super::primitive::cylindrical;
use crate::geometry::{Point, Uv, Vector, plane_axes, range};

/// The parameters that a patch covers: low and high of u and of v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchRange {
    /// Range of u. For a periodic u the low end is in [0, 2π) and the high end may be above 2π.
    pub u: [f64; 2],
    /// Range of v, likewise.
    pub v: [f64; 2],
}

impl Primitive {
    /// The direction in which u is 0 (for a plane that of increasing u).
    pub fn reference(&self) -> Vector {
        match *self {
            Primitive::Plane { normal, .. } => plane_axes(normal).0,
            _ => plane_axes(self.axis().unwrap_or_else(Vector::z)).0,
        }
    }

    /// The parameters of the point of the surface that is closest to `p`.
    ///
    /// u is the angle about the axis in [0, 2π). v is the height of a cylinder and of a cone over the origin,
    /// the latitude of a sphere in [-π/2, π/2], the angle around the tube of a torus in [0, 2π). The height of
    /// a cone is measured along its axis. A plane has lengths.
    pub(crate) fn parameters_of(&self, p: Point) -> Uv {
        let axis = match *self {
            Primitive::Plane { normal, .. } => normal,
            _ => self.axis().unwrap_or_else(Vector::z),
        };
        let (x, y) = plane_axes(axis);
        let q = p - self.origin();
        let turn = |angle: f64| if angle < 0.0 { (angle + TAU) % TAU } else { angle };
        let u = turn(q.dot(&y).atan2(q.dot(&x)));
        let (h, rho, _) = cylindrical(self.origin(), axis, p);
        match *self {
            Primitive::Plane { .. } => Uv::new(q.dot(&x), q.dot(&y)),
            Primitive::Cylinder { .. } => Uv::new(u, h),
            Primitive::Cone { radius, angle, .. } => {
                let (sin, cos) = angle.sin_cos();
                Uv::new(u, ((rho - radius) * sin + h * cos) * cos)
            }
            Primitive::Sphere { .. } => Uv::new(u, h.atan2(rho)),
            Primitive::Torus { major, .. } => Uv::new(u, turn(h.atan2(rho - major))),
        }
    }

    /// The point with the given parameters.
    pub fn point_at(&self, uv: Uv) -> Point {
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

    /// The apex of a cone.
    pub(crate) fn apex(&self) -> Option<Point> {
        match *self {
            Primitive::Cone { origin, axis, radius, angle } => {
                Some(origin - radius / angle.tan() * axis)
            }
            _ => None,
        }
    }

    /// The ranges of the parameters of some points. A periodic range leaves out the largest gap between them.
    pub fn range(&self, points: impl Iterator<Item = Point>) -> PatchRange {
        let (us, vs): (Vec<f64>, Vec<f64>) = points
            .map(|p| {
                let uv = self.parameters_of(p);
                (uv.x, uv.y)
            })
            .unzip();
        let is_plane = matches!(self, Primitive::Plane { .. });
        let is_torus = matches!(self, Primitive::Torus { .. });
        PatchRange {
            u: if is_plane { range(us.into_iter()) } else { periodic(us) },
            v: if is_torus { periodic(vs) } else { range(vs.into_iter()) },
        }
    }
}

fn periodic(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_unstable_by(f64::total_cmp);
    let Some((&first, &last)) = values.first().zip(values.last()) else { return [0.0, TAU] };
    let mut widest = (first + TAU - last, [first, last]);
    for pair in values.windows(2) {
        let gap = pair[1] - pair[0];
        if gap > widest.0 {
            widest = (gap, [pair[1], pair[0] + TAU]);
        }
    }
    widest.1
}
