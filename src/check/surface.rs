//! Points and derivatives of the surfaces of a CAD file.
//!
//! The input is a surface and a parameter point. The output is the point with its first and second
//! derivatives. Rational splines follow The NURBS Book (Piegl and Tiller 1997).

use std::f64::consts::{FRAC_PI_2, TAU};

use formats::cad::{CadCurve, CadSurface, CurveShape};
use formats::spline::{SplineBasis, SplineCurve, SplineKnots, SplineSurface};
use nalgebra::Vector4;

use crate::geometry::{Point, Uv, Vector};
use crate::spline::{Jet, KnotVector, ParametricSurface, Surface};

/// A surface over a rectangle of its parameter plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Domain<'a> {
    surface: &'a CadSurface,
    ranges: [(f64, f64); 2],
}

/// The step of finite differences of first derivatives, as a share of the range. At this step the
/// rounding error and the truncation error are both small.
const DIFFERENCE: f64 = 1e-4;

impl<'a> Domain<'a> {
    /// The surface over its whole range.
    pub(super) fn whole(surface: &'a CadSurface) -> Self {
        Domain { surface, ranges: ranges(surface) }
    }

    /// The part of the surface within the rectangle from `low` to `high`.
    pub(super) fn within(&self, [low, high]: [Uv; 2]) -> Self {
        let part = |(from, to): (f64, f64), a: f64, b: f64| (a.clamp(from, to), b.clamp(from, to));
        let [u, v] = self.ranges;
        Domain { surface: self.surface, ranges: [part(u, low.x, high.x), part(v, low.y, high.y)] }
    }

    /// Whether the range is finite in both parameters.
    pub(super) fn is_bounded(&self) -> bool {
        self.ranges.iter().all(|(from, to)| from.is_finite() && to.is_finite())
    }

    /// The surface once around where it is periodic. It is the whole surface if nothing else bounds
    /// it.
    pub(super) fn once(&self) -> Self {
        let periods = self.periods();
        let ranges = [0, 1].map(|axis| match periods[axis] {
            Some(period) if self.ranges[axis] == ENDLESS => (0.0, period),
            _ => self.ranges[axis],
        });
        Domain { ranges, ..*self }
    }

    /// The periods in u and in v, where the surface is periodic.
    pub(super) fn periods(&self) -> [Option<f64>; 2] {
        angles(self.surface).map(|is_angle| is_angle.then_some(TAU))
    }

    /// Adds second derivatives to a jet by finite differences of first derivatives. Their relative
    /// error is about a millionth.
    fn bent(&self, mut jet: Jet, at: Uv) -> Jet {
        let [u, v] = [0, 1].map(|axis| {
            let (from, to) = self.ranges[axis];
            let step = DIFFERENCE * if (to - from).is_finite() { to - from } else { 1.0 };
            let [mut a, mut b] = [at; 2];
            (a[axis], b[axis]) = ((at[axis] - step).max(from), (at[axis] + step).min(to));
            let length = b[axis] - a[axis];
            let [a, b] = [a, b].map(|at| self::jet(self.surface, at));
            (length > 0.0).then(|| [(b.su - a.su) / length, (b.sv - a.sv) / length])
        });
        if let (Some(u), Some(v)) = (u, v) {
            (jet.suu, jet.suv, jet.svv) = (u[0], 0.5 * (u[1] + v[0]), v[1]);
        }
        jet
    }
}

impl ParametricSurface for Domain<'_> {
    fn jet(&self, at: Uv) -> Jet {
        let here = jet(self.surface, at);
        if matches!(self.surface, CadSurface::Offset { .. }) { self.bent(here, at) } else { here }
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        self.ranges
    }

    fn fast_form(&self) -> Option<Box<dyn ParametricSurface>> {
        let CadSurface::Spline(spline) = self.surface else { return None };
        if spline.weights().is_some() {
            return None;
        }
        let knots = |k: &SplineKnots| KnotVector::try_new(k.degree(), k.knots().to_vec()).ok();
        let net = spline.poles().iter().map(vector).collect();
        Surface::try_new(knots(spline.u())?, knots(spline.v())?, net).ok()?.fast_form()
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        let inner = breaks(self.surface);
        [0, 1].map(|axis| {
            let (from, to) = self.ranges[axis];
            let inside = inner[axis].iter().copied().filter(|t| from < *t && *t < to);
            std::iter::once(from).chain(inside).chain(std::iter::once(to)).collect()
        })
    }
}

const ENDLESS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn ranges(surface: &CadSurface) -> [(f64, f64); 2] {
    match surface {
        CadSurface::Spline(s) => [s.u().range(), s.v().range()],
        CadSurface::Plane { .. } | CadSurface::Cylinder { .. } => [ENDLESS; 2],
        CadSurface::Torus { .. } => [ENDLESS; 2],
        // The faces of a cone are on one side of its apex.
        CadSurface::Cone { radius, slope, .. } if *slope > 0.0 => {
            [ENDLESS, (-radius / slope, f64::INFINITY)]
        }
        CadSurface::Cone { radius, slope, .. } if *slope < 0.0 => {
            [ENDLESS, (f64::NEG_INFINITY, -radius / slope)]
        }
        CadSurface::Cone { .. } => [ENDLESS; 2],
        CadSurface::Sphere { .. } => [ENDLESS, (-FRAC_PI_2, FRAC_PI_2)],
        CadSurface::Revolution { curve, angles, .. } => match &curve.shape {
            CurveShape::Spline(s) => [*angles, s.knots().range()],
            _ => [*angles, curve.range.unwrap_or(ENDLESS)],
        },
        CadSurface::Extrusion { curve, .. } => match &curve.shape {
            CurveShape::Spline(s) => [s.knots().range(), ENDLESS],
            _ => [ENDLESS; 2],
        },
        CadSurface::Offset { base, .. } => ranges(base),
    }
}

fn breaks(surface: &CadSurface) -> [Vec<f64>; 2] {
    match surface {
        CadSurface::Spline(s) => [s.u().breaks(), s.v().breaks()],
        CadSurface::Extrusion { curve: CadCurve { shape: CurveShape::Spline(s), .. }, .. } => {
            [s.knots().breaks(), Vec::new()]
        }
        CadSurface::Revolution { curve: CadCurve { shape: CurveShape::Spline(s), .. }, .. } => {
            [Vec::new(), s.knots().breaks()]
        }
        CadSurface::Offset { base, .. } => breaks(base),
        _ => [Vec::new(), Vec::new()],
    }
}

/// Whether u and v are angles over a whole turn.
fn angles(surface: &CadSurface) -> [bool; 2] {
    match surface {
        CadSurface::Cylinder { .. } | CadSurface::Cone { .. } => [true, false],
        CadSurface::Sphere { .. } | CadSurface::Revolution { .. } => [true, false],
        CadSurface::Torus { .. } => [true; 2],
        CadSurface::Offset { base, .. } => angles(base),
        CadSurface::Spline(_) | CadSurface::Plane { .. } | CadSurface::Extrusion { .. } => {
            [false; 2]
        }
    }
}

fn vector(a: &[f64; 3]) -> Vector {
    Vector::from(*a)
}

fn jet(surface: &CadSurface, at: Uv) -> Jet {
    let zero = Vector::zeros();
    match surface {
        CadSurface::Spline(spline) => on_spline(spline, at),
        CadSurface::Plane { origin, x, y } => {
            let (su, sv) = (vector(x), vector(y));
            let s = Point::from(vector(origin) + at.x * su + at.y * sv);
            Jet { s, su, sv, suu: zero, suv: zero, svv: zero }
        }
        CadSurface::Cylinder { origin, x, y, z } => {
            let (sin, cos) = at.x.sin_cos();
            let round = vector(x) * cos + vector(y) * sin;
            let sv = vector(z);
            let s = Point::from(vector(origin) + round + at.y * sv);
            let su = vector(y) * cos - vector(x) * sin;
            Jet { s, su, sv, suu: -round, suv: zero, svv: zero }
        }
        CadSurface::Cone { origin, x, y, z, radius, slope } => {
            let meridian = [[radius + at.y * slope, at.y], [*slope, 1.0], [0.0; 2]];
            turned(vector(origin), [x, y, z].map(vector), at.x, meridian)
        }
        CadSurface::Sphere { origin, x, y, z } => {
            let (sin, cos) = at.y.sin_cos();
            let meridian = [[cos, sin], [-sin, cos], [-cos, -sin]];
            turned(vector(origin), [x, y, z].map(vector), at.x, meridian)
        }
        CadSurface::Torus { origin, x, y, z, major, minor } => {
            let (sin, cos) = at.y.sin_cos();
            let [a, b] = [cos, sin].map(|e| minor * e);
            let meridian = [[major + a, b], [-b, a], [-a, -b]];
            turned(vector(origin), [x, y, z].map(vector), at.x, meridian)
        }
        CadSurface::Revolution { curve, origin, axis, .. } => {
            let (origin, axis) = (vector(origin), vector(axis));
            let [c, first, second] = curve_jet(curve, at.y);
            let [s, su, suu] = revolved(c - origin, axis, at.x);
            let [sv, suv, _] = revolved(first, axis, at.x);
            let [svv, ..] = revolved(second, axis, at.x);
            Jet { s: Point::from(origin + s), su, sv, suu, suv, svv }
        }
        CadSurface::Extrusion { curve, vector: along } => {
            let [c, su, suu] = curve_jet(curve, at.x);
            let sv = vector(along);
            Jet { s: Point::from(c + at.y * sv), su, sv, suu, suv: zero, svv: zero }
        }
        CadSurface::Offset { base, distance } => offset(&jet(base, at), *distance),
    }
}

/// The jet of a surface whose meridian turns from x to y. `meridian` is its radius and its height with
/// their first and second derivatives.
fn turned(origin: Vector, [x, y, z]: [Vector; 3], u: f64, meridian: [[f64; 2]; 3]) -> Jet {
    let (sin, cos) = u.sin_cos();
    let (out, around) = (x * cos + y * sin, y * cos - x * sin);
    let [[r, h], [dr, dh], [ddr, ddh]] = meridian;
    Jet {
        s: Point::from(origin + out * r + z * h),
        su: around * r,
        sv: out * dr + z * dh,
        suu: -out * r,
        suv: around * dr,
        svv: out * ddr + z * ddh,
    }
}

/// A vector turned by an angle about a unit vector, and its first and second derivatives in the angle.
fn revolved(vector: Vector, axis: Vector, angle: f64) -> [Vector; 3] {
    let (sin, cos) = angle.sin_cos();
    let along = axis * axis.dot(&vector);
    let out = vector - along;
    let across = axis.cross(&out);
    let round = out * cos + across * sin;
    [along + round, across * cos - out * sin, -round]
}

/// The jet of an offset surface. Its second derivatives would need third derivatives of the base
/// surface, so [`Domain::bent`] computes them.
fn offset(base: &Jet, distance: f64) -> Jet {
    let n = base.su.cross(&base.sv);
    let length = n.norm();
    if length == 0.0 {
        return *base;
    }
    let unit = n / length;
    let turn = |change: Vector| (change - unit * unit.dot(&change)) * (distance / length);
    let nu = base.suu.cross(&base.sv) + base.su.cross(&base.suv);
    let nv = base.suv.cross(&base.sv) + base.su.cross(&base.svv);
    Jet { s: base.s + unit * distance, su: base.su + turn(nu), sv: base.sv + turn(nv), ..*base }
}

/// The point and the first and second derivatives of a curve.
fn curve_jet(curve: &CadCurve<3>, t: f64) -> [Vector; 3] {
    match &curve.shape {
        CurveShape::Line { origin, direction } => {
            [vector(origin) + vector(direction) * t, vector(direction), Vector::zeros()]
        }
        CurveShape::Ellipse { centre, x, y } => {
            let (sin, cos) = t.sin_cos();
            let round = vector(x) * cos + vector(y) * sin;
            [vector(centre) + round, vector(y) * cos - vector(x) * sin, -round]
        }
        CurveShape::Spline(spline) => spline_curve_jet(spline, t),
    }
}

fn spline_curve_jet(spline: &SplineCurve<3>, t: f64) -> [Vector; 3] {
    let basis = SplineBasis::new(spline.knots(), t);
    let mut h = [Vector4::zeros(); 3];
    for j in 0..=spline.knots().degree() {
        let i = basis.first + j;
        let pole = lifted(spline.poles()[i], spline.weights().map_or(1.0, |w| w[i]));
        (0..3).for_each(|k| h[k] += pole * basis.derivative[k][j]);
    }
    let (w, s) = (h[0].w, h[0].xyz() / h[0].w);
    let first = (h[1].xyz() - s * h[1].w) / w;
    let second = (h[2].xyz() - first * (2.0 * h[1].w) - s * h[2].w) / w;
    [s, first, second]
}

/// A pole in homogeneous coordinates.
fn lifted([x, y, z]: [f64; 3], weight: f64) -> Vector4<f64> {
    Vector4::new(x * weight, y * weight, z * weight, weight)
}

fn on_spline(spline: &SplineSurface, at: Uv) -> Jet {
    let (bu, bv) = (SplineBasis::new(spline.u(), at.x), SplineBasis::new(spline.v(), at.y));
    let row = spline.v().poles();
    // h[k][l] is the k-th derivative in u and the l-th in v of the homogeneous surface.
    let mut h = [[Vector4::zeros(); 3]; 3];
    for i in 0..=spline.u().degree() {
        let mut inner = [Vector4::zeros(); 3];
        for j in 0..=spline.v().degree() {
            let n = (bu.first + i) * row + bv.first + j;
            let pole = lifted(spline.poles()[n], spline.weights().map_or(1.0, |w| w[n]));
            (0..3).for_each(|l| inner[l] += pole * bv.derivative[l][j]);
        }
        for (k, l) in [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)] {
            h[k][l] += inner[l] * bu.derivative[k][i];
        }
    }
    quotient(&h)
}

/// The jet of a rational surface from its homogeneous derivatives (The NURBS Book, eq. 4.20).
fn quotient(h: &[[Vector4<f64>; 3]; 3]) -> Jet {
    let w = h[0][0].w;
    let s = h[0][0].xyz() / w;
    let su = (h[1][0].xyz() - s * h[1][0].w) / w;
    let sv = (h[0][1].xyz() - s * h[0][1].w) / w;
    let suu = (h[2][0].xyz() - su * (2.0 * h[1][0].w) - s * h[2][0].w) / w;
    let svv = (h[0][2].xyz() - sv * (2.0 * h[0][1].w) - s * h[0][2].w) / w;
    let suv = (h[1][1].xyz() - su * h[0][1].w - sv * h[1][0].w - s * h[1][1].w) / w;
    Jet { s: Point::from(s), su, sv, suu, suv, svv }
}
