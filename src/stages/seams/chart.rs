//! The parameters of points on the surface of a face, in a frame whose x axis is chosen.

use std::f64::consts::TAU;

use std::sync::Arc;

use formats::brep::{BrepSurface, Frame};
use formats::spline::{SplineKnots, SplineSurface};

use crate::geometry::{Point, Vector};
use super::FaceSurface;
use crate::primitives::Primitive;
use crate::spline::{KnotVector, SplineSheet, Surface};

/// A surface in a frame.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    pub frame: Frame,
    pub surface: BrepSurface,
    /// The B-spline, if the surface is one.
    pub sheet: Option<Arc<SplineSheet>>,
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
    pub fn new(surface: &FaceSurface, axis: Vector) -> Result<Self, String> {
        let exact = match surface {
            FaceSurface::Exact(exact) => exact,
            FaceSurface::Spline(sheet) => {
                let frame = Frame::along([0.0; 3], vector(axis))?;
                let surface = BrepSurface::Spline(spline_surface(sheet.surface())?);
                return Ok(Chart { frame, surface, sheet: Some(sheet.clone()) });
            }
        };
        let z = match *exact {
            Primitive::Plane { normal, .. } => normal,
            _ => exact.axis().unwrap_or(axis),
        };
        let frame = Frame::along(array(exact.origin()), vector(z))?;
        Ok(Chart::in_frame(exact, frame))
    }

    /// How far edges may be from the surface in mm, if it is not exact.
    pub fn open(&self) -> f64 {
        self.sheet.as_ref().map_or(0.0, |sheet| sheet.chord_error())
    }

    fn in_frame(surface: &Primitive, frame: Frame) -> Self {
        let made = match *surface {
            Primitive::Plane { .. } => BrepSurface::plane(frame),
            Primitive::Cylinder { radius, .. } => BrepSurface::cylinder(frame, radius),
            // Any place of the axis inside of the cone serves as its origin.
            Primitive::Cone { radius, angle, .. } if radius < 0.0 => {
                let up = frame.point([0.0, 0.0, -2.0 * radius / angle.tan()]);
                return Chart { frame: frame.at(up), surface: BrepSurface::cone(frame.at(up), -radius, angle), sheet: None };
            }
            Primitive::Cone { radius, angle, .. } => BrepSurface::cone(frame, radius, angle),
            Primitive::Sphere { radius, .. } => BrepSurface::sphere(frame, radius),
            Primitive::Torus { major, minor, .. } => BrepSurface::torus(frame, major, minor),
        };
        Chart { frame, surface: made, sheet: None }
    }

    /// The same surface with u = 0 where it was `u`.
    pub fn turned(&self, surface: &Primitive, u: f64) -> Self {
        Chart::in_frame(surface, if u == 0.0 { self.frame } else { self.frame.turned(u) })
    }

    /// The parameters of the closest point, and whether u is undefined there. Angles are in [-π, π].
    pub fn parameters(&self, p: Point) -> ([f64; 2], bool) {
        if let Some(sheet) = &self.sheet {
            let at = sheet.nearest(p);
            return ([at.x, at.y], false);
        }
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

    /// The distance in mm of a point of the surface from the line on which one parameter is `seam`.
    pub fn off_seam(&self, p: Point, k: usize, seam: f64) -> f64 {
        let mut uv = self.parameters(p).0;
        uv[k] = seam;
        (self.point(uv) - p).norm()
    }

    pub fn point(&self, [u, v]: [f64; 2]) -> Point {
        let [x, y, z] = self.surface.point(u, v);
        Point::new(x, y, z)
    }

    /// The parameters of points that follow each other, without jumps by a period. The first ones are those closest
    /// to `near`, if it is given.
    pub fn unwrapped(&self, points: &[Point], near: Option<[f64; 2]>) -> Vec<[f64; 2]> {
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

fn spline_surface(surface: &Surface) -> Result<SplineSurface, String> {
    let net = surface.net.iter().map(|&p| vector(p)).collect();
    let knots = |of: &KnotVector| SplineKnots::new(of.degree(), of.knots().to_vec(), of.functions());
    SplineSurface::new(knots(&surface.u)?, knots(&surface.v)?, net, None)
}

/// A point so close to the axis in mm has no angle about it: the modelling kernel's own precision.
const ON_AXIS: f64 = 1e-7;
