//! The parameters of points on the surface of a face, in a frame whose x axis is chosen.

use std::f64::consts::TAU;

use formats::brep::{BrepSurface, Frame};

use crate::geometry::{Point, Vector};
use crate::primitives::Primitive;

/// A surface in a frame.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    pub frame: Frame,
    pub surface: BrepSurface,
}

pub(super) fn array(p: Point) -> [f64; 3] {
    [p.x, p.y, p.z]
}

pub(super) fn vector(v: Vector) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// An angle in [-π, π].
pub(super) fn around(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

impl Chart {
    /// The surface with its usual frame. A sphere has the given axis.
    pub(super) fn new(surface: &Primitive, axis: Vector) -> Result<Self, String> {
        let z = match *surface {
            Primitive::Plane { normal, .. } => normal,
            _ => surface.axis().unwrap_or(axis),
        };
        let frame = Frame::along(array(surface.origin()), vector(z))?;
        Ok(Chart::in_frame(surface, frame))
    }

    /// The surface in a frame whose origin is anywhere on its axis.
    fn in_frame(surface: &Primitive, frame: Frame) -> Self {
        let made = match surface.centred_at(Point::from(frame.origin())) {
            Primitive::Plane { .. } => BrepSurface::plane(frame),
            Primitive::Cylinder { radius, .. } => BrepSurface::cylinder(frame, radius),
            // Any place of the axis inside of the cone serves as its origin.
            Primitive::Cone { radius, angle, .. } if radius < 0.0 => {
                let frame = frame.at(frame.point([0.0, 0.0, -2.0 * radius / angle.tan()]));
                return Chart { frame, surface: BrepSurface::cone(frame, -radius, angle) };
            }
            Primitive::Cone { radius, angle, .. } => BrepSurface::cone(frame, radius, angle),
            Primitive::Sphere { radius, .. } => BrepSurface::sphere(frame, radius),
            Primitive::Torus { major, minor, .. } => BrepSurface::torus(frame, major, minor),
        };
        Chart { frame, surface: made }
    }

    /// The same surface with u = 0 where it was `u`.
    pub(super) fn turned(&self, surface: &Primitive, u: f64) -> Self {
        Chart::in_frame(surface, if u == 0.0 { self.frame } else { self.frame.turned(u) })
    }

    /// The parameters of the closest point, and whether u is undefined there. Angles are in [-π, π].
    pub(super) fn parameters(&self, p: Point) -> ([f64; 2], bool) {
        let [x, y, h] = self.frame.coordinates(array(p));
        let rho = x.hypot(y);
        let u = y.atan2(x);
        match self.surface {
            BrepSurface::Cylinder { .. } => ([u, h], false),
            BrepSurface::Cone { radius, half_angle, .. } => {
                let (sin, cos) = half_angle.sin_cos();
                ([u, ((rho - radius) * sin + h * cos) * cos], rho < ON_AXIS)
            }
            BrepSurface::Sphere { .. } => ([u, h.atan2(rho)], rho < ON_AXIS),
            BrepSurface::Torus { major, .. } => ([u, h.atan2(rho - major)], false),
            _ => ([x, y], false),
        }
    }

    /// The distance in mm from the line on which one parameter is `seam` to the point of the surface that is nearest to `p`.
    pub(super) fn off_seam(&self, p: Point, k: usize, seam: f64) -> f64 {
        let foot = self.parameters(p).0;
        let mut uv = foot;
        uv[k] = seam;
        (self.point(uv) - self.point(foot)).norm()
    }

    pub(super) fn point(&self, [u, v]: [f64; 2]) -> Point {
        let [x, y, z] = self.surface.point(u, v);
        Point::new(x, y, z)
    }

    /// The parameters of points that follow each other, without jumps by a period. The first ones are those closest
    /// to `near`, if it is given.
    pub(super) fn unwrapped(&self, points: &[Point], near: Option<[f64; 2]>) -> Vec<[f64; 2]> {
        let found: Vec<([f64; 2], bool)> = points.iter().map(|&p| self.parameters(p)).collect();
        let mut out: Vec<[f64; 2]> = found.iter().map(|(uv, _)| *uv).collect();
        for i in 0..out.len() {
            if found[i].1 {
                let good = (0..out.len()).filter(|&k| !found[k].1).min_by_key(|k| k.abs_diff(i));
                if let Some(k) = good {
                    out[i][0] = found[k].0[0];
                }
            }
        }
        let periods = self.surface.periods();
        let mut last = near;
        for uv in &mut out {
            if let Some(before) = last {
                for k in 0..2 {
                    if let Some(period) = periods[k] {
                        uv[k] += period * ((before[k] - uv[k]) / period).round();
                    }
                }
            }
            last = Some(*uv);
        }
        out
    }
}

/// A point so close to the axis in mm has no angle about it: the modelling kernel's own precision.
const ON_AXIS: f64 = 1e-7;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_from_a_seam_is_one_along_the_surface() {
        let (centre, axis) = (Point::origin(), Vector::z());
        let torus = Primitive::Torus { centre, axis, major: 10.0, minor: 2.0 };
        let chart = Chart::new(&torus, axis).expect("a frame");
        for (off, along) in [(0.0, 0.0), (1e-3, 0.0), (1e-3, 0.02)] {
            let foot = chart.point([along, 0.7]);
            let p = foot + off * torus.normal(foot);
            let most = Primitive::distance(&torus, foot).0.abs() + along * 12.0;
            let found = chart.off_seam(p, 0, 0.0);
            assert!(
                (found == 0.0 || along > 0.0) && found <= most + 1e-12,
                "{off} {along}: {found}"
            );
        }
    }

    #[test]
    fn a_turned_cone_is_the_same_surface_whatever_place_of_its_axis_is_its_origin() {
        let (axis, angle) = (Vector::new(0.6, 0.0, 0.8), 0.4);
        for radius in [-3.0, 0.0, 2.0] {
            let cone = Primitive::Cone { origin: Point::new(1.0, 2.0, 3.0), axis, radius, angle };
            let chart = Chart::new(&cone, axis).expect("a frame");
            for u in [0.0, 1.3] {
                let turned = chart.turned(&cone, u);
                for [v, w] in [[0.2, 1.0], [2.0, 4.0], [5.0, 0.5]] {
                    let p = turned.point([v, w]);
                    assert!(cone.distance(p).0.abs() < 1e-12, "{radius}, {u}: {cone:?}");
                    assert!((turned.point(turned.parameters(p).0) - p).norm() < 1e-12);
                }
            }
        }
    }
}
