//! Points and derivatives of the surfaces and the curves of a CAD file.
//!
//! The input is a surface and a parameter point, or a curve and a parameter. The output is the point with its
//! first and second derivatives. Rational splines follow The NURBS Book (Piegl and Tiller 1997).

use formats::cad::{CadSurface, CurveShape};
use formats::spline::{SplineBasis, SplineCurve, SplineSurface};
use nalgebra::{SVector, Vector4};

use crate::geometry::{Point, Uv, Vector};
use crate::spline::Jet;

fn vector(a: &[f64; 3]) -> Vector {
    Vector::from(*a)
}

/// The jet of a surface. The second derivatives of an offset surface are missing.
pub(super) fn jet(surface: &CadSurface, at: Uv) -> Jet {
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
            let [c, first, second] = curve_jet(&curve.shape, at.y);
            let [s, su, suu] = revolved(c - origin, axis, at.x);
            let [sv, suv, _] = revolved(first, axis, at.x);
            let [svv, ..] = revolved(second, axis, at.x);
            Jet { s: Point::from(origin + s), su, sv, suu, suv, svv }
        }
        CadSurface::Extrusion { curve, vector: along } => {
            let [c, su, suu] = curve_jet(&curve.shape, at.x);
            let sv = vector(along);
            Jet { s: Point::from(c + at.y * sv), su, sv, suu, suv: zero, svv: zero }
        }
        CadSurface::Offset { base, distance } => offset(&jet(base, at), *distance),
        CadSurface::Part { base, .. } => jet(base, at),
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
pub(super) fn curve_jet<const D: usize>(shape: &CurveShape<D>, t: f64) -> [SVector<f64, D>; 3] {
    let vector = |a: &[f64; D]| SVector::from(*a);
    match shape {
        CurveShape::Line { origin, direction } => {
            let direction = vector(direction);
            [vector(origin) + direction * t, direction, SVector::zeros()]
        }
        CurveShape::Ellipse { centre, x, y } => {
            let ((sin, cos), x, y) = (t.sin_cos(), vector(x), vector(y));
            let round = x * cos + y * sin;
            [vector(centre) + round, y * cos - x * sin, -round]
        }
        CurveShape::Hyperbola { centre, x, y } => {
            let (sinh, cosh, x, y) = (t.sinh(), t.cosh(), vector(x), vector(y));
            let branch = x * cosh + y * sinh;
            [vector(centre) + branch, x * sinh + y * cosh, branch]
        }
        CurveShape::Parabola { vertex, x, y } => {
            let (x, y) = (vector(x), vector(y));
            [vector(vertex) + x * (t * t) + y * t, x * (2.0 * t) + y, x * 2.0]
        }
        CurveShape::Spline(spline) => spline_curve_jet(spline, t),
    }
}

fn spline_curve_jet<const D: usize>(spline: &SplineCurve<D>, t: f64) -> [SVector<f64, D>; 3] {
    let basis = SplineBasis::new(spline.knots(), t);
    // The derivatives of the numerator and of the denominator.
    let (mut h, mut w) = ([SVector::<f64, D>::zeros(); 3], [0.0; 3]);
    for j in 0..=spline.knots().degree() {
        let i = basis.first + j;
        let (pole, weight) =
            (SVector::from(spline.poles()[i]), spline.weights().map_or(1.0, |w| w[i]));
        for k in 0..3 {
            let share = weight * basis.derivative[k][j];
            h[k] += pole * share;
            w[k] += share;
        }
    }
    let s = h[0] / w[0];
    let first = (h[1] - s * w[1]) / w[0];
    let second = (h[2] - first * (2.0 * w[1]) - s * w[2]) / w[0];
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
