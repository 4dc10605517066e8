//! The five surfaces.

use crate::geometry::{Point, Vector, plane_axes};

/// The kinds of surfaces, from the simplest to the richest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PrimitiveKind {
    /// A plane.
    Plane,
    /// A circular cylinder.
    Cylinder,
    /// A circular cone.
    Cone,
    /// A sphere.
    Sphere,
    /// A torus that does not touch itself.
    Torus,
}

impl PrimitiveKind {
    /// All kinds.
    pub const ALL: [PrimitiveKind; 5] = [
        PrimitiveKind::Plane,
        PrimitiveKind::Cylinder,
        PrimitiveKind::Cone,
        PrimitiveKind::Sphere,
        PrimitiveKind::Torus,
    ];

    /// The number of parameters of such a surface.
    pub(crate) fn parameters(self) -> usize {
        match self {
            PrimitiveKind::Plane => 3,
            PrimitiveKind::Sphere => 4,
            PrimitiveKind::Cylinder => 5,
            PrimitiveKind::Cone => 6,
            PrimitiveKind::Torus => 7,
        }
    }

    /// The name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            PrimitiveKind::Plane => "plane",
            PrimitiveKind::Cylinder => "cylinder",
            PrimitiveKind::Cone => "cone",
            PrimitiveKind::Sphere => "sphere",
            PrimitiveKind::Torus => "torus",
        }
    }
}

/// A surface. Lengths are in the unit of the points, angles in radians, directions are unit vectors.
///
/// The signed distance of a closed surface is positive outside; that of a plane is positive on the side
/// of its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primitive {
    /// A plane through a point.
    Plane {
        /// Any point of the plane.
        origin: Point,
        /// The unit normal.
        normal: Vector,
    },
    /// A cylinder about the line through `origin` along `axis`.
    Cylinder {
        /// A point of the axis.
        origin: Point,
        /// The direction of the axis.
        axis: Vector,
        /// The radius.
        radius: f64,
    },
    /// The half of a cone that opens along `axis`.
    Cone {
        /// A point of the axis.
        origin: Point,
        /// The direction of the axis, in which the radius grows.
        axis: Vector,
        /// The radius at `origin`.
        radius: f64,
        /// The angle between axis and generators, in (0, π/2).
        angle: f64,
    },
    /// A sphere.
    Sphere {
        /// The centre.
        centre: Point,
        /// The radius.
        radius: f64,
    },
    /// A torus: a tube around a circle.
    Torus {
        /// The centre of the circle.
        centre: Point,
        /// The direction perpendicular to the circle.
        axis: Vector,
        /// The radius of the circle.
        major: f64,
        /// The radius of the tube. If it is larger than `major`, the surface is the part outside of where it crosses itself.
        minor: f64,
    },
}

/// Height over the origin along the axis, distance from the axis, and the unit direction away from it
/// (any perpendicular one on the axis itself).
pub(super) fn cylindrical(origin: Point, axis: Vector, p: Point) -> (f64, f64, Vector) {
    let q = p - origin;
    let h = q.dot(&axis);
    let w = q - h * axis;
    let rho = w.norm();
    let out = if rho > 0.0 { w / rho } else { plane_axes(axis).0 };
    (h, rho, out)
}

impl Primitive {
    /// The kind.
    pub fn kind(&self) -> PrimitiveKind {
        match self {
            Primitive::Plane { .. } => PrimitiveKind::Plane,
            Primitive::Cylinder { .. } => PrimitiveKind::Cylinder,
            Primitive::Cone { .. } => PrimitiveKind::Cone,
            Primitive::Sphere { .. } => PrimitiveKind::Sphere,
            Primitive::Torus { .. } => PrimitiveKind::Torus,
        }
    }

    /// A point of the plane or of the axis, or the centre.
    pub(crate) fn origin(&self) -> Point {
        match *self {
            Primitive::Plane { origin, .. }
            | Primitive::Cylinder { origin, .. }
            | Primitive::Cone { origin, .. } => origin,
            Primitive::Sphere { centre, .. } | Primitive::Torus { centre, .. } => centre,
        }
    }

    /// The direction of the axis. A sphere has none, nor has a plane.
    pub(crate) fn axis(&self) -> Option<Vector> {
        match *self {
            Primitive::Cylinder { axis, .. }
            | Primitive::Cone { axis, .. }
            | Primitive::Torus { axis, .. } => Some(axis),
            Primitive::Plane { .. } | Primitive::Sphere { .. } => None,
        }
    }

    /// The radius of a cylinder or a sphere, or of a torus' tube. A cone and a plane have none.
    pub(crate) fn radius(&self) -> Option<f64> {
        match *self {
            Primitive::Cylinder { radius, .. } | Primitive::Sphere { radius, .. } => Some(radius),
            Primitive::Torus { minor, .. } => Some(minor),
            Primitive::Plane { .. } | Primitive::Cone { .. } => None,
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

    /// The signed distance of a point, and its gradient there, which is the unit normal at the closest
    /// point. The distance to a cone is that to its generators, prolonged beyond the apex.
    pub fn distance(&self, p: Point) -> (f64, Vector) {
        match *self {
            Primitive::Plane { origin, normal } => ((p - origin).dot(&normal), normal),
            Primitive::Sphere { centre, radius } => {
                let q = p - centre;
                let rho = q.norm();
                let g = if rho > 0.0 { q / rho } else { Vector::z() };
                (rho - radius, g)
            }
            Primitive::Cylinder { origin, axis, radius } => {
                let (_, rho, out) = cylindrical(origin, axis, p);
                (rho - radius, out)
            }
            Primitive::Cone { origin, axis, radius, angle } => {
                let (h, rho, out) = cylindrical(origin, axis, p);
                let (sin, cos) = angle.sin_cos();
                ((rho - radius) * cos - h * sin, out * cos - axis * sin)
            }
            Primitive::Torus { centre, axis, major, minor } => {
                let (h, rho, out) = cylindrical(centre, axis, p);
                let x = rho - major;
                let l = x.hypot(h);
                let g = if l > 0.0 { out * (x / l) + axis * (h / l) } else { out };
                (l - minor, g)
            }
        }
    }

    /// The closest point of the surface (of a cone: of its prolonged generator).
    pub fn closest(&self, p: Point) -> Point {
        let (d, g) = self.distance(p);
        p - d * g
    }

    /// The unit normal at the closest point.
    pub(crate) fn normal(&self, p: Point) -> Vector {
        self.distance(p).1
    }

    /// The largest absolute curvature next to a point.
    pub(crate) fn curvature(&self, p: Point) -> f64 {
        match *self {
            Primitive::Plane { .. } => 0.0,
            Primitive::Cylinder { radius, .. } | Primitive::Sphere { radius, .. } => 1.0 / radius,
            Primitive::Cone { origin, axis, angle, .. } => {
                let rho = cylindrical(origin, axis, p).1;
                angle.cos() / rho.max(f64::MIN_POSITIVE)
            }
            Primitive::Torus { centre, axis, major, minor } => {
                let rho = cylindrical(centre, axis, p).1;
                let other = (rho - major).abs() / (minor * rho.max(f64::MIN_POSITIVE));
                other.max(1.0 / minor)
            }
        }
    }

    /// The same surface with its origin slid along the axis, or in the plane, next to a point.
    pub(crate) fn centred_at(self, p: Point) -> Self {
        let slid = |origin: Point, axis: Vector| {
            let h = (p - origin).dot(&axis);
            (origin + h * axis, h)
        };
        match self {
            Primitive::Plane { origin, normal } => {
                Primitive::Plane { origin: p - (p - origin).dot(&normal) * normal, normal }
            }
            Primitive::Cylinder { origin, axis, radius } => {
                Primitive::Cylinder { origin: slid(origin, axis).0, axis, radius }
            }
            Primitive::Cone { origin, axis, radius, angle } => {
                let (origin, h) = slid(origin, axis);
                Primitive::Cone { origin, axis, radius: radius + h * angle.tan(), angle }
            }
            Primitive::Sphere { .. } | Primitive::Torus { .. } => self,
        }
    }

    /// The surface with all lengths multiplied by a positive factor.
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Primitive::Plane { origin, normal } => {
                Primitive::Plane { origin: origin * factor, normal }
            }
            Primitive::Cylinder { origin, axis, radius } => {
                Primitive::Cylinder { origin: origin * factor, axis, radius: radius * factor }
            }
            Primitive::Cone { origin, axis, radius, angle } => {
                Primitive::Cone { origin: origin * factor, axis, radius: radius * factor, angle }
            }
            Primitive::Sphere { centre, radius } => {
                Primitive::Sphere { centre: centre * factor, radius: radius * factor }
            }
            Primitive::Torus { centre, axis, major, minor } => Primitive::Torus {
                centre: centre * factor,
                axis,
                major: major * factor,
                minor: minor * factor,
            },
        }
    }
}
