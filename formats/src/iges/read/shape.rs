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

/// A conic arc A x² + B xy + C y² + D x + E y + F = 0 (clause 4.5). It runs from its start to its end, and that of an
/// ellipse runs counter-clockwise. `None` if the equation is that of no conic.
pub(super) fn conic(p: &mut Parameters) -> Result<Option<CadCurve<3>>> {
    let mut equation = [0.0; 6];
    for factor in &mut equation {
        *factor = p.real()?;
    }
    let level = p.real()?;
    let ends = [[p.real()?, p.real()?], [p.real()?, p.real()?]];
    Ok(Conic::new(equation).and_then(|conic| conic.arc(level, ends)))
}

/// A conic whose axes are turned to those of the coordinates: a x² + b y² + d x + e y + f = 0.
struct Conic {
    /// The direction of its first axis.
    axis: [f64; 2],
    a: f64,
    b: f64,
    d: f64,
    e: f64,
    f: f64,
}

/// A factor of a conic is 0 if it is so much smaller than the others. Files have ten digits.
const NONE: f64 = 1e-9;

impl Conic {
    fn new([xx, xy, yy, x, y, f]: [f64; 6]) -> Option<Self> {
        let turn = if xy == 0.0 { 0.0 } else { 0.5 * xy.atan2(xx - yy) };
        let (s, c) = turn.sin_cos();
        let a = xx * c * c + xy * c * s + yy * s * s;
        let b = xx * s * s - xy * c * s + yy * c * c;
        let least = NONE * a.abs().max(b.abs());
        let [a, b] = [a, b].map(|factor| if factor.abs() <= least { 0.0 } else { factor });
        let conic = Conic { axis: [c, s], a, b, d: x * c + y * s, e: y * c - x * s, f };
        (a != 0.0 || b != 0.0).then_some(conic)
    }

    /// The same conic with its axes exchanged.
    fn exchanged(&self) -> Self {
        let [c, s] = self.axis;
        Conic { axis: [-s, c], a: self.b, b: self.a, d: self.e, e: -self.d, f: self.f }
    }

    fn arc(&self, level: f64, ends: [[f64; 2]; 2]) -> Option<CadCurve<3>> {
        if self.a == 0.0 {
            // Only x may be squared in a parabola.
            return self.exchanged().arc(level, ends);
        }
        let Conic { axis: [c, s], a, b, d, e, f } = *self;
        let back = |[x, y]: [f64; 2], level: f64| [c * x - s * y, s * x + c * y, level];
        let local = ends.map(|[x, y]| [c * x + s * y, c * y - s * x]);
        if b == 0.0 {
            // y = −(a x² + d x + f) / e
            let x = -0.5 * d / a;
            let vertex = [x, (0.25 * d * d / a - f) / e];
            let shape = CurveShape::Parabola {
                vertex: back(vertex, level),
                x: back([0.0, -a / e], 0.0),
                y: back([1.0, 0.0], 0.0),
            };
            return ranged(shape, local.map(|p| p[0] - x), false);
        }
        let centre = [-0.5 * d / a, -0.5 * e / b];
        let size = a * centre[0] * centre[0] + b * centre[1] * centre[1] - f;
        let squares = [size / a, size / b];
        let radii = squares.map(|square| square.abs().sqrt());
        if squares[0] < 0.0 && squares[1] > 0.0 {
            return self.exchanged().arc(level, ends);
        }
        let offset = local.map(|p| [p[0] - centre[0], p[1] - centre[1]]);
        let centre = back(centre, level);
        let y = back([0.0, radii[1]], 0.0);
        if squares[0] > 0.0 && squares[1] > 0.0 {
            let x = back([radii[0], 0.0], 0.0);
            let angle = |p: [f64; 2]| (p[1] / radii[1]).atan2(p[0] / radii[0]);
            return ranged(CurveShape::Ellipse { centre, x, y }, offset.map(angle), true);
        }
        // The arc is on the branch of its start.
        let x = back([radii[0].copysign(offset[0][0]), 0.0], 0.0);
        let at = |p: [f64; 2]| (p[1] / radii[1]).asinh();
        ranged(CurveShape::Hyperbola { centre, x, y }, offset.map(at), false)
    }
}

/// A curve from one parameter to another. If it runs backwards, its second axis is turned.
fn ranged(shape: CurveShape<3>, [from, mut to]: [f64; 2], is_angle: bool) -> Option<CadCurve<3>> {
    if is_angle && to <= from {
        to += std::f64::consts::TAU;
    }
    if ![from, to].iter().all(|t| t.is_finite()) {
        return None;
    }
    if from < to {
        return Some(CadCurve { shape, range: Some((from, to)) });
    }
    let turned = |y: [f64; 3]| y.map(|e| -e);
    let shape = match shape {
        CurveShape::Hyperbola { centre, x, y } => CurveShape::Hyperbola { centre, x, y: turned(y) },
        CurveShape::Parabola { vertex, x, y } => CurveShape::Parabola { vertex, x, y: turned(y) },
        other => other,
    };
    Some(CadCurve { shape, range: Some((-from, -to)) })
}

/// The projection of a curve to its x and y coordinates.
pub(super) fn flat(curve: CadCurve<3>) -> CadCurve<2> {
    let cut = |p: [f64; 3]| [p[0], p[1]];
    let shape = curve.shape.mapped(cut, cut);
    CadCurve { shape, range: curve.range }
}

/// A pcurve in other parameters, to which `there` is an affine map.
pub(super) fn converted(curve: &CadCurve<2>, there: impl Fn([f64; 2]) -> [f64; 2]) -> CadCurve<2> {
    let origin = there([0.0; 2]);
    let vector = |d: [f64; 2]| {
        let end = there(d);
        [end[0] - origin[0], end[1] - origin[1]]
    };
    let shape = curve.shape.clone().mapped(&there, vector);
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
        CadSurface::Offset { base, .. } | CadSurface::Part { base, .. } => middle_normal(base),
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
