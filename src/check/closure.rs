//! Where a surface closes: its ranges, its periods, and its poles.
//!
//! The input is a surface. The output says in which parameters it is periodic, and which lines of its parameter
//! plane are single points.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use formats::cad::{CadCurve, CadSurface, CurveShape};
use formats::spline::SplineSurface;

use super::jets::{curve_jet, jet};
use crate::geometry::{NEGLIGIBLE, Point, Uv, Vector};
use crate::spline::ACCURACY;

/// The range of a parameter that nothing bounds.
pub(super) const ENDLESS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// A line of the parameter plane that is a single point of the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pole {
    /// The parameter that is constant on the line: 0 for u, 1 for v.
    pub(super) axis: usize,
    /// Its value.
    pub(super) value: f64,
    /// The point.
    pub(super) point: Point,
}

/// Where a surface closes.
#[derive(Debug, Clone)]
pub(super) struct Closure {
    /// The ranges of the parameters. That of a periodic parameter is infinite.
    pub(super) ranges: [(f64, f64); 2],
    /// The periods of u and of v.
    pub(super) periods: [Option<f64>; 2],
    /// The range to which a parameter is reduced before the surface is evaluated, because its splines do not repeat
    /// themselves.
    pub(super) wraps: [Option<(f64, f64)>; 2],
    /// The points at which the surface comes together.
    pub(super) poles: Vec<Pole>,
}

/// How a parameter is periodic.
#[derive(Debug, Clone, Copy)]
enum Period {
    /// It is an angle.
    Angle,
    /// It is that of a spline over this range, whose ends meet.
    Range(f64, f64),
}

impl Closure {
    /// Finds out where a surface closes.
    pub(super) fn of(surface: &CadSurface) -> Self {
        let (mut ranges, found) = (ranges(surface), periods(surface));
        let mut periods = [None; 2];
        let mut wraps = [None; 2];
        for axis in 0..2 {
            match found[axis] {
                Some(Period::Angle) => periods[axis] = Some(TAU),
                Some(Period::Range(low, high)) => {
                    (periods[axis], wraps[axis]) = (Some(high - low), Some((low, high)));
                }
                None => continue,
            }
            ranges[axis] = ENDLESS;
        }
        let mut closure = Closure { ranges, periods, wraps, poles: Vec::new() };
        closure.poles = poles(surface, &closure);
        closure
    }
}

fn ranges(surface: &CadSurface) -> [(f64, f64); 2] {
    match surface {
        CadSurface::Spline(s) => [s.u().range(), s.v().range()],
        CadSurface::Plane { .. }
        | CadSurface::Cylinder { .. }
        | CadSurface::Cone { .. }
        | CadSurface::Torus { .. } => [ENDLESS; 2],
        CadSurface::Sphere { .. } => [ENDLESS, (-FRAC_PI_2, FRAC_PI_2)],
        CadSurface::Revolution { curve, angles, .. } => [*angles, curve_range(curve)],
        CadSurface::Extrusion { curve, .. } => [curve_range(curve), ENDLESS],
        CadSurface::Offset { base, .. } => ranges(base),
        CadSurface::Part { base, u, v } => {
            let [a, b] = ranges(base);
            [(a.0.max(u.0), a.1.min(u.1)), (b.0.max(v.0), b.1.min(v.1))]
        }
    }
}

fn curve_range(curve: &CadCurve<3>) -> (f64, f64) {
    match &curve.shape {
        CurveShape::Spline(spline) => curve.range.unwrap_or_else(|| spline.knots().range()),
        _ => curve.range.unwrap_or(ENDLESS),
    }
}

/// Whether a range is at least as long as a period.
fn covers((low, high): (f64, f64), period: f64) -> bool {
    high - low >= period * (1.0 - NEGLIGIBLE)
}

fn periods(surface: &CadSurface) -> [Option<Period>; 2] {
    let angle = Some(Period::Angle);
    match surface {
        CadSurface::Spline(spline) => [0, 1].map(|axis| closes(spline, axis)),
        CadSurface::Plane { .. } => [None; 2],
        CadSurface::Cylinder { .. } | CadSurface::Cone { .. } | CadSurface::Sphere { .. } => {
            [angle, None]
        }
        CadSurface::Torus { .. } => [angle; 2],
        CadSurface::Revolution { curve, angles, .. } => {
            [angle.filter(|_| covers(*angles, TAU)), curve_period(curve)]
        }
        CadSurface::Extrusion { curve, .. } => [curve_period(curve), None],
        CadSurface::Offset { base, .. } => periods(base),
        CadSurface::Part { base, u, v } => {
            let [a, b] = periods(base);
            let kept = |period: Option<Period>, range: (f64, f64)| {
                period.filter(|period| match period {
                    Period::Angle => covers(range, TAU),
                    Period::Range(low, high) => covers(range, high - low),
                })
            };
            [kept(a, *u), kept(b, *v)]
        }
    }
}

fn curve_period(curve: &CadCurve<3>) -> Option<Period> {
    match &curve.shape {
        CurveShape::Ellipse { .. } => {
            covers(curve.range.unwrap_or(ENDLESS), TAU).then_some(Period::Angle)
        }
        CurveShape::Spline(spline) => {
            let (low, high) = curve_range(curve);
            let [from, to] = [low, high].map(|t| Point::from(spline.point(t)));
            let first = Point::from(spline.poles()[0]);
            let size = spline.poles().iter().map(|p| (Point::from(*p) - first).norm());
            let size = size.fold(0.0, f64::max);
            ((to - from).norm() <= ACCURACY * size).then_some(Period::Range(low, high))
        }
        _ => None,
    }
}

/// The period of a B-spline surface whose first and last sides in u (axis 0) or in v (axis 1) are the same curve.
fn closes(spline: &SplineSurface, axis: usize) -> Option<Period> {
    let (along, across) =
        if axis == 0 { (spline.u(), spline.v()) } else { (spline.v(), spline.u()) };
    let (low, high) = along.range();
    let breaks = across.breaks();
    let point = |t: f64, s: f64| {
        Point::from(if axis == 0 { spline.point(t, s) } else { spline.point(s, t) })
    };
    let first = Point::from(spline.poles()[0]);
    let size = spline.poles().iter().map(|p| (Point::from(*p) - first).norm()).fold(0.0, f64::max);
    let meets = |s: f64| (point(low, s) - point(high, s)).norm() <= ACCURACY * size;
    // A side of degree p is known from p + 1 places between two knots.
    let places = across.degree() + 1;
    let inner = |w: &[f64], i: usize| w[0] + (w[1] - w[0]) * i as f64 / places as f64;
    let mut all = breaks.windows(2).flat_map(|w| (0..=places).map(move |i| inner(w, i)));
    all.all(meets).then_some(Period::Range(low, high))
}

/// The number of places of a line that are compared to tell whether it is a single point.
const PLACES: usize = 7;

fn poles(surface: &CadSurface, closure: &Closure) -> Vec<Pole> {
    let (mut poles, inner) = (Vec::new(), inner_poles(surface));
    for axis in 0..2 {
        let (low, high) = closure.ranges[axis];
        let mut values: Vec<f64> = [low, high].into_iter().filter(|t| t.is_finite()).collect();
        if axis == 1 {
            values.extend(inner.iter().filter(|v| low < **v && **v < high));
        }
        let around = match (closure.wraps[1 - axis], closure.periods[1 - axis]) {
            (Some(range), _) => range,
            (None, Some(period)) => (0.0, period),
            (None, None) => closure.ranges[1 - axis],
        };
        if !(around.0.is_finite() && around.1.is_finite()) {
            continue;
        }
        for value in values {
            let jets = (0..PLACES).map(|i| {
                let along = around.0 + (around.1 - around.0) * (i as f64 + 0.5) / PLACES as f64;
                jet(surface, if axis == 0 { Uv::new(value, along) } else { Uv::new(along, value) })
            });
            let jets: Vec<_> = jets.collect();
            let point = jets[0].s;
            let spread = jets.iter().map(|jet| (jet.s - point).norm()).fold(0.0, f64::max);
            // How far the surface goes away from the line within its other parameter's unit.
            let away =
                |jet: &crate::spline::Jet| if axis == 0 { jet.su.norm() } else { jet.sv.norm() };
            let size = jets.iter().map(away).fold(point.coords.amax() * NEGLIGIBLE, f64::max);
            if spread <= ACCURACY * size {
                poles.push(Pole { axis, value, point });
            }
        }
    }
    poles
}

/// The values of v at which a surface of revolution may meet its axis between the ends of its range.
fn inner_poles(surface: &CadSurface) -> Vec<f64> {
    match surface {
        CadSurface::Torus { major, minor, .. } if minor >= major => {
            let v = (-major / minor).acos();
            if v == PI { vec![v] } else { vec![-v, v] }
        }
        CadSurface::Cone { radius, slope, .. } if *slope != 0.0 => vec![-radius / slope],
        CadSurface::Revolution { curve, origin, axis, .. } => meetings(curve, *origin, *axis),
        CadSurface::Offset { base, .. } | CadSurface::Part { base, .. } => inner_poles(base),
        _ => Vec::new(),
    }
}

/// The number of places of a meridian between which its meetings with the axis are searched.
const SEARCHED: usize = 64;

/// The parameters at which a line or an ellipse comes nearest to an axis.
fn meetings(curve: &CadCurve<3>, origin: [f64; 3], axis: [f64; 3]) -> Vec<f64> {
    let (origin, axis) = (Vector::from(origin), Vector::from(axis));
    let out = |t: f64| {
        let from = curve_jet(&curve.shape, t)[0] - origin;
        from - axis * axis.dot(&from)
    };
    match &curve.shape {
        CurveShape::Line { direction, .. } => {
            let direction = Vector::from(*direction);
            let out_per_t = direction - axis * axis.dot(&direction);
            let squared = out_per_t.norm_squared();
            if squared > 0.0 { vec![-out(0.0).dot(&out_per_t) / squared] } else { Vec::new() }
        }
        CurveShape::Ellipse { .. } => {
            let at = |i: usize| TAU * i as f64 / SEARCHED as f64 - PI;
            let far = |t: f64| out(t).norm_squared();
            let is_low = |i: &usize| {
                far(at(*i)) <= far(at(i + 1)) && far(at(*i)) <= far(at(*i) - TAU / SEARCHED as f64)
            };
            (0..SEARCHED)
                .filter(is_low)
                .map(|i| lowest(&far, at(i), TAU / SEARCHED as f64))
                .collect()
        }
        _ => Vec::new(),
    }
}

/// The place of the least value of a function near `at` (ternary search).
fn lowest(f: &dyn Fn(f64) -> f64, at: f64, width: f64) -> f64 {
    let (mut a, mut b) = (at - width, at + width);
    for _ in 0..crate::geometry::MOST_ROUNDS {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if f(c) < f(d) { b = d } else { a = c }
    }
    0.5 * (a + b)
}
