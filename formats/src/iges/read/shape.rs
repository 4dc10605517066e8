//! Conversion of the parameters of entities to shapes.

use super::parameters::Parameters;
use crate::Result;
use crate::cad::affine::cross;
use crate::cad::{CadCurve, CadSurface, CurveShape};
use crate::spline::{SplineCurve, SplineKnots};

/// Converts a net in which the index of u changes fastest to one in which the index of v does.
pub(super) fn turned<T: Copy>(net: &[T], m: usize, n: usize) -> Vec<T> {
    (0..m * n).map(|k| net[k / n + m * (k % n)]).collect()
}

/// A circular arc, counter-clockwise (clause 4.3).
pub(super) fn arc(p: &mut Parameters) -> Result<CadCurve<3>> {
    let level = p.real()?;
    let mut point = || Ok([p.real()?, p.real()?]);
    let (centre, start, end): ([f64; 2], [f64; 2], [f64; 2]) = (point()?, point()?, point()?);
    let angle = |q: [f64; 2]| (q[1] - centre[1]).atan2(q[0] - centre[0]);
    let radius = (start[0] - centre[0]).hypot(start[1] - centre[1]);
    let (from, mut to) = (angle(start), angle(end));
    if to <= from {
        to += std::f64::consts::TAU;
    }
    let shape = CurveShape::Ellipse {
        centre: [centre[0], centre[1], level],
        x: [radius, 0.0, 0.0],
        y: [0.0, radius, 0.0],
    };
    Ok(CadCurve { shape, range: Some((from, to)) })
}

/// An elliptic arc, counter-clockwise (clause 4.5). `None` if its axes are not along x and y.
pub(super) fn ellipse(p: &mut Parameters) -> Result<Option<CadCurve<3>>> {
    let mut equation = [0.0; 6];
    for factor in &mut equation {
        *factor = p.real()?;
    }
    let [xx, xy, yy, x, y, constant] = equation;
    let level = p.real()?;
    let centre = [-0.5 * x / xx, -0.5 * y / yy];
    let size = xx * centre[0] * centre[0] + yy * centre[1] * centre[1] - constant;
    let [a, b] = [size / xx, size / yy].map(f64::sqrt);
    if xy != 0.0 || ![a, b, centre[0], centre[1]].iter().all(|x| x.is_finite()) {
        return Ok(None);
    }
    let mut angle = || {
        let [x, y] = [p.real()?, p.real()?];
        Ok(((y - centre[1]) / b).atan2((x - centre[0]) / a))
    };
    let (from, mut to): (f64, f64) = (angle()?, angle()?);
    if to <= from {
        to += std::f64::consts::TAU;
    }
    let shape = CurveShape::Ellipse {
        centre: [centre[0], centre[1], level],
        x: [a, 0.0, 0.0],
        y: [0.0, b, 0.0],
    };
    Ok(Some(CadCurve { shape, range: Some((from, to)) }))
}

/// The projection of a curve to its x and y coordinates.
pub(super) fn flat(curve: CadCurve<3>) -> CadCurve<2> {
    let cut = |p: [f64; 3]| [p[0], p[1]];
    let shape = match curve.shape {
        CurveShape::Line { origin, direction } => {
            CurveShape::Line { origin: cut(origin), direction: cut(direction) }
        }
        CurveShape::Ellipse { centre, x, y } => {
            CurveShape::Ellipse { centre: cut(centre), x: cut(x), y: cut(y) }
        }
        CurveShape::Spline(spline) => CurveShape::Spline(spline.mapped(cut)),
    };
    CadCurve { shape, range: curve.range }
}

/// A pcurve in other parameters, to which `there` is an affine map.
pub(super) fn converted(curve: &CadCurve<2>, there: impl Fn([f64; 2]) -> [f64; 2]) -> CadCurve<2> {
    let origin = there([0.0; 2]);
    let vector = |d: [f64; 2]| {
        let end = there(d);
        [end[0] - origin[0], end[1] - origin[1]]
    };
    let shape = match curve.shape.clone() {
        CurveShape::Line { origin, direction } => {
            CurveShape::Line { origin: there(origin), direction: vector(direction) }
        }
        CurveShape::Ellipse { centre, x, y } => {
            CurveShape::Ellipse { centre: there(centre), x: vector(x), y: vector(y) }
        }
        CurveShape::Spline(spline) => CurveShape::Spline(spline.mapped(there)),
    };
    CadCurve { shape, range: curve.range }
}

/// The same curve with its parameters over [0, 1].
pub(super) fn over_unit(spline: SplineCurve<3>) -> CadCurve<3> {
    CadCurve { shape: CurveShape::Spline(spline.over_unit()), range: None }
}

/// The approximate normal in the middle of the parameter range, which defines the side of an offset
/// surface. It has any length. `None` if there is no middle.
pub(super) fn middle_normal(surface: &CadSurface) -> Option<[f64; 3]> {
    match surface {
        CadSurface::Spline(spline) => {
            let (u, v) = (middle_poles(spline.u()), middle_poles(spline.v()));
            let pole = |i: usize, j: usize| spline.poles()[i * spline.v().poles() + j];
            let between = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| b[i] - a[i]);
            let su = between(pole(u[0], v[0]), pole(u[1], v[0]));
            let sv = between(pole(u[0], v[0]), pole(u[0], v[1]));
            Some(cross(su, sv))
        }
        CadSurface::Plane { x, y, .. } => Some(cross(*x, *y)),
        CadSurface::Offset { base, .. } => middle_normal(base),
        _ => None,
    }
}

/// Two neighbouring poles that influence the middle of the range.
fn middle_poles(knots: &SplineKnots) -> [usize; 2] {
    let (low, high) = knots.range();
    let span = knots.knots().partition_point(|t| *t <= 0.5 * (low + high));
    let first = span.saturating_sub(1 + knots.degree().div_ceil(2)).min(knots.poles() - 2);
    [first, first + 1]
}
