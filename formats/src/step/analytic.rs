//! Writer of lines, conics, planes and surfaces of revolution and extrusion (ISO 10303-42, clause
//! 4). Points, directions and vectors that occur several times are written once.

use std::io;

use super::geometry;
use super::part21::{Id, Part21, add, share};
use crate::brep::{BrepSurface, EllipseArc, Frame, LineSegment};
use crate::number::StepReal;

/// Writes a `CARTESIAN_POINT`.
pub(super) fn point<const D: usize>(file: &mut Part21<'_>, at: [f64; D]) -> io::Result<Id> {
    share!(file, "CARTESIAN_POINT('',{})", coordinates(at))
}

fn direction<const D: usize>(file: &mut Part21<'_>, along: [f64; D]) -> io::Result<Id> {
    share!(file, "DIRECTION('',{})", coordinates(along))
}

fn coordinates<const D: usize>(of: [f64; D]) -> String {
    let texts = of.map(|x| StepReal(x).to_string());
    format!("({})", texts.join(","))
}

fn vector<const D: usize>(file: &mut Part21<'_>, along: [f64; D]) -> io::Result<Id> {
    let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
    let direction = direction(file, along.map(|x| x / length))?;
    share!(file, "VECTOR('',{direction},{})", StepReal(length))
}

/// Writes a `LINE`. The ends of the edge bound it.
pub(super) fn line<const D: usize>(file: &mut Part21<'_>, line: &LineSegment<D>) -> io::Result<Id> {
    let origin = point(file, line.origin())?;
    let vector = vector(file, line.direction())?;
    share!(file, "LINE('',{origin},{vector})")
}

/// Writes a `CIRCLE` or an `ELLIPSE` in space. The ends of the edge bound it.
pub(super) fn ellipse(file: &mut Part21<'_>, ellipse: &EllipseArc<3>) -> io::Result<Id> {
    let [x, y] = ellipse.axes();
    let z = crate::cad::affine::cross(x, y);
    let [centre, z, x] = [point(file, ellipse.centre())?, direction(file, z)?, direction(file, x)?];
    let placement = share!(file, "AXIS2_PLACEMENT_3D('',{centre},{z},{x})")?;
    conic(file, placement, ellipse)
}

/// Writes a `CIRCLE` or an `ELLIPSE` in a parameter plane.
pub(super) fn flat_ellipse(file: &mut Part21<'_>, ellipse: &EllipseArc<2>) -> io::Result<Id> {
    let [x, _] = ellipse.axes();
    let (centre, x) = (point(file, ellipse.centre())?, direction(file, x)?);
    let placement = share!(file, "AXIS2_PLACEMENT_2D('',{centre},{x})")?;
    conic(file, placement, ellipse)
}

fn conic<const D: usize>(
    file: &mut Part21<'_>,
    placement: Id,
    ellipse: &EllipseArc<D>,
) -> io::Result<Id> {
    match ellipse.radius() {
        Some(radius) => share!(file, "CIRCLE('',{placement},{})", StepReal(radius)),
        None => {
            let [a, b] = ellipse.radii().map(StepReal);
            share!(file, "ELLIPSE('',{placement},{a},{b})")
        }
    }
}

/// Writes an `AXIS2_PLACEMENT_3D`.
fn placement(file: &mut Part21<'_>, frame: &Frame) -> io::Result<Id> {
    let origin = point(file, frame.origin())?;
    let (z, x) = (direction(file, frame.z())?, direction(file, frame.x())?);
    share!(file, "AXIS2_PLACEMENT_3D('',{origin},{z},{x})")
}

/// Writes a surface of any kind. A surface is never shared with another one that is the same: two
/// pcurves of an edge on one surface would look like those of a seam.
pub(super) fn surface(file: &mut Part21<'_>, surface: &BrepSurface) -> io::Result<Id> {
    match surface {
        BrepSurface::Spline(spline) => geometry::spline_surface(file, spline),
        BrepSurface::Plane { frame } => {
            let at = placement(file, frame)?;
            add!(file, "PLANE('',{at})")
        }
        BrepSurface::Cylinder { frame, radius } => {
            let at = placement(file, frame)?;
            add!(file, "CYLINDRICAL_SURFACE('',{at},{})", StepReal(*radius))
        }
        BrepSurface::Cone { frame, radius, half_angle } => {
            let at = placement(file, frame)?;
            let [radius, angle] = [*radius, *half_angle].map(StepReal);
            add!(file, "CONICAL_SURFACE('',{at},{radius},{angle})")
        }
        BrepSurface::Sphere { frame, radius } => {
            let at = placement(file, frame)?;
            add!(file, "SPHERICAL_SURFACE('',{at},{})", StepReal(*radius))
        }
        BrepSurface::Torus { frame, major, minor } => {
            let at = placement(file, frame)?;
            let is_spindle = major < minor;
            let [major, minor] = [*major, *minor].map(StepReal);
            if is_spindle {
                add!(file, "DEGENERATE_TOROIDAL_SURFACE('',{at},{major},{minor},.T.)")
            } else {
                add!(file, "TOROIDAL_SURFACE('',{at},{major},{minor})")
            }
        }
        BrepSurface::Extrusion { profile, direction } => {
            let curve = geometry::spline_curve(file, profile)?;
            let along = vector(file, *direction)?;
            add!(file, "SURFACE_OF_LINEAR_EXTRUSION('',{curve},{along})")
        }
        BrepSurface::Revolution { profile, origin, axis } => {
            let curve = geometry::spline_curve(file, profile)?;
            let (origin, axis) = (point(file, *origin)?, direction(file, *axis)?);
            let at = share!(file, "AXIS1_PLACEMENT('',{origin},{axis})")?;
            add!(file, "SURFACE_OF_REVOLUTION('',{curve},{at})")
        }
    }
}
