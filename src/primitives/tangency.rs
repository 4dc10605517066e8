//! Conditions under which two surfaces touch along a curve.

use super::{Primitive, PrimitiveKind};
use crate::geometry::{Point, Vector};

/// Radii that differ by a smaller share are those of one pipe.
const ONE_PIPE: f64 = 1e-3;

/// The spine of one pipe lies inside the other one by a radius; by how much it may be off while that is not exact yet.
const ON_SPINE: f64 = 0.2;

/// The centre of the ball that rolls along a surface, next to a point. Planes and cones have none.
fn ball_centre(surface: &Primitive, p: Point) -> Option<Point> {
    match *surface {
        Primitive::Plane { .. } | Primitive::Cone { .. } => None,
        Primitive::Sphere { centre, .. } => Some(centre),
        Primitive::Cylinder { origin, axis, .. } => Some(origin + (p - origin).dot(&axis) * axis),
        Primitive::Torus { centre, axis, major, .. } => {
            let q = p - centre;
            let out = (q - q.dot(&axis) * axis).try_normalize(0.0)?;
            Some(centre + major * out)
        }
    }
}

/// Which of two surfaces is the ball that touches the other one: the one with the smaller radius. `None` if neither is
/// one.
pub(crate) fn ball_is_second(a: &Primitive, b: &Primitive) -> Option<bool> {
    match (a.radius(), b.radius()) {
        (None, None) => None,
        (Some(_), None) => Some(false),
        (None, Some(_)) => Some(true),
        (Some(x), Some(y)) => Some(x >= y),
    }
}

/// What two touching surfaces are off at a point of their border, as lengths. `ball` is the one of
/// [`ball_is_second`].
pub(crate) fn misses(other: &Primitive, ball: &Primitive, p: Point, into: &mut Vec<f64>) {
    let (Some(centre), Some(radius)) = (ball_centre(ball, p), ball.radius()) else { return };
    let d = other.distance(centre).0;
    if let Some(wide) = other.radius() {
        let is_pipe = (wide - radius).abs() < ONE_PIPE * radius;
        let from_spine = match *other {
            Primitive::Sphere { centre: middle, .. } => (centre - middle).norm(),
            _ => d + wide,
        };
        if is_pipe && from_spine.abs() < ON_SPINE * radius {
            match other {
                Primitive::Sphere { centre: middle, .. } => {
                    into.extend((centre - middle).iter());
                }
                _ => into.push(from_spine),
            }
            into.push(wide - radius);
            return;
        }
    }
    into.push(d.abs() - radius);
}

/// The unknowns of a surface: place, radius, major radius. Planes stay: they are known best.
pub(crate) const UNKNOWNS: usize = 5;

/// A surface with its place and its radii changed.
pub(crate) fn changed(surface: &Primitive, by: &[f64]) -> Primitive {
    let shift = Vector::new(by[0], by[1], by[2]);
    match *surface {
        Primitive::Plane { .. } => *surface,
        Primitive::Cylinder { origin, axis, radius } => {
            Primitive::Cylinder { origin: origin + shift, axis, radius: radius + by[3] }
        }
        Primitive::Cone { origin, axis, radius, angle } => {
            Primitive::Cone { origin: origin + shift, axis, radius: radius + by[3], angle }
        }
        Primitive::Sphere { centre, radius } => {
            Primitive::Sphere { centre: centre + shift, radius: radius + by[3] }
        }
        Primitive::Torus { centre, axis, major, minor } => Primitive::Torus {
            centre: centre + shift,
            axis,
            major: major + by[4],
            minor: minor + by[3],
        },
    }
}

/// Whether a surface has unknowns.
pub(crate) fn is_movable(surface: &Primitive) -> bool {
    surface.kind() != PrimitiveKind::Plane
}
