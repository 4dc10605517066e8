//! Points on two surfaces: where they cross by Newton's method, where they touch from the spine of the thinner one.

use super::Primitive;
use crate::geometry::{Point, Vector};

/// The farthest step count of Newton's method. It converges quadratically from the mesh's own points.
const STEPS: usize = 20;

/// A distance in mm that counts as none: rounding of coordinates of about 100 mm.
const NOTHING: f64 = 1e-13;

/// The squared sine of the angle below which two surfaces do not cross.
const PARALLEL: f64 = 1e-12;

/// The point of two surfaces that cross next to a point, by steps of least length.
pub(crate) fn crossing(a: &Primitive, b: &Primitive, start: Point) -> Point {
    let mut p = start;
    for _ in 0..STEPS {
        let ((da, ga), (db, gb)) = (a.distance(p), b.distance(p));
        if da.abs().max(db.abs()) < NOTHING {
            break;
        }
        let cos = ga.dot(&gb);
        let square = (1.0 - cos * cos).max(PARALLEL);
        p -= ga * ((da - cos * db) / square) + gb * ((db - cos * da) / square);
    }
    p
}

/// The point of the axis, of the circle or the centre of a tube that is closest to a point, and the direction of the
/// spine there, and the radius of the tube.
fn spine(a: &Primitive, p: Point) -> Option<(Point, Option<Vector>, f64)> {
    match *a {
        Primitive::Cylinder { origin, axis, radius } => {
            Some((origin + (p - origin).dot(&axis) * axis, Some(axis), radius))
        }
        Primitive::Sphere { centre, radius } => Some((centre, None, radius)),
        Primitive::Torus { centre, axis, major, minor } => {
            let q = p - centre;
            let out = (q - q.dot(&axis) * axis).try_normalize(f64::MIN_POSITIVE)?;
            Some((centre + major * out, Some(axis.cross(&out)), minor))
        }
        _ => None,
    }
}

/// Two tubes whose radii and spines differ by less than this share of the radius are equal where they touch.
const EQUAL: f64 = 0.05;

/// The point in which two surfaces that touch each other touch next to a point.
pub(crate) fn contact(a: &Primitive, b: &Primitive, p: Point) -> Point {
    let (sa, sb) = (spine(a, p), spine(b, p));
    let thin_first = match (&sa, &sb) {
        (Some(x), Some(y)) => x.2 <= y.2,
        (Some(_), None) => true,
        (None, Some(_)) => false,
        (None, None) => return b.closest(a.closest(p)),
    };
    let (thin, other, from) = if thin_first { (a, b, sa) } else { (b, a, sb) };
    let Some((at, _, radius)) = from else { return p };
    if let Some((there, _, second)) = spine(other, at)
        && (second - radius).abs() < EQUAL * radius
        && (there - at).norm() < EQUAL * radius
    {
        // Equal tubes with one spine are one surface.
        return across(thin, other, p, radius).unwrap_or_else(|| other.closest(thin.closest(p)));
    }
    other.closest(at)
}

/// The point on the circle in which equal tubes touch: it is at right angles to their spines.
fn across(a: &Primitive, b: &Primitive, p: Point, radius: f64) -> Option<Point> {
    let on_line = |a: &Primitive, c: Point| spine(a, c).map(|s| s.0);
    let (at, along) = match (a, b) {
        (Primitive::Sphere { centre, .. }, other) | (other, Primitive::Sphere { centre, .. }) => {
            (*centre, spine(other, *centre)?.1?)
        }
        (line @ Primitive::Cylinder { axis, .. }, Primitive::Torus { centre, .. })
        | (Primitive::Torus { centre, .. }, line @ Primitive::Cylinder { axis, .. }) => {
            (on_line(line, *centre)?, *axis)
        }
        // Crossed cylinders have only the two points on the common normal.
        (Primitive::Cylinder { axis, .. }, Primitive::Cylinder { axis: other, .. }) => {
            let normal = axis.cross(other).try_normalize(PARALLEL.sqrt())?;
            let at = on_line(a, p)?;
            return Some(at + radius * (p - at).dot(&normal).signum() * normal);
        }
        (Primitive::Torus { centre: c, axis, major, .. }, Primitive::Torus { centre: d, .. }) => {
            let towards = (d - c).try_normalize(f64::MIN_POSITIVE)?;
            let sign = if (p - c).dot(&towards) < 0.0 { -1.0 } else { 1.0 };
            (c + sign * *major * towards, axis.cross(&towards))
        }
        _ => return None,
    };
    let q = p - at;
    let out = (q - q.dot(&along) * along).try_normalize(f64::MIN_POSITIVE)?;
    Some(at + radius * out)
}

/// So many times the error of a vertex may leave the normals of touching surfaces apart: an error δ of the place
/// turns the contact by √(2 δ c) where c is the curvature, and four errors of each of two surfaces add up.
const TURN: f64 = 16.0;

/// Whether two surfaces touch along points instead of crossing. `error` bounds the errors of the points.
pub(crate) fn touch(a: &Primitive, b: &Primitive, points: &[Point], error: f64) -> bool {
    let flat = a.radius().is_none() && b.radius().is_none();
    !flat
        && points.iter().all(|&p| {
            let curvature = a.curvature(p).max(b.curvature(p));
            let sine = a.normal(p).cross(&b.normal(p)).norm();
            sine < (TURN * error * curvature).sqrt()
        })
}
