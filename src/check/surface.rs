//! A surface of a CAD file over a rectangle of its parameter plane.

use std::sync::Arc;

use formats::cad::{CadCurve, CadSurface, CurveShape};
use formats::spline::SplineKnots;

use super::closure::Closure;
use super::jets;
use crate::geometry::{MOST_ROUNDS, ROUNDING, Uv, Vector};
use crate::spline::{ACCURACY, Jet, KnotVector, ParametricSurface, Surface};

/// A surface over a rectangle of its parameter plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Domain<'a> {
    pub(super) surface: &'a CadSurface,
    pub(super) closure: &'a Closure,
    ranges: [(f64, f64); 2],
}

/// The step of finite differences of first derivatives, as a share of the range. At this step the
/// rounding error and the truncation error are both small.
const DIFFERENCE: f64 = 1e-4;

impl<'a> Domain<'a> {
    /// The surface over its whole range.
    pub(super) fn whole(surface: &'a CadSurface, closure: &'a Closure) -> Self {
        Domain { surface, closure, ranges: closure.ranges }
    }

    /// The part of the surface within the rectangle from `low` to `high`. A periodic parameter goes around once at
    /// most.
    pub(super) fn within(&self, [low, high]: [Uv; 2]) -> Self {
        let part = |axis: usize| {
            let (from, to) = self.ranges[axis];
            let (a, b) = (low[axis].clamp(from, to), high[axis].clamp(from, to));
            (a, self.closure.periods[axis].map_or(b, |period| b.min(a + period)))
        };
        Domain { ranges: [part(0), part(1)], ..*self }
    }

    /// The surface once around where it is periodic.
    pub(super) fn once(&self) -> Self {
        let ranges =
            [0, 1].map(|axis| match (self.closure.wraps[axis], self.closure.periods[axis]) {
                (Some(range), _) => range,
                (None, Some(period)) => self.between_poles(axis).unwrap_or((0.0, period)),
                (None, None) => self.ranges[axis],
            });
        Domain { ranges, ..*self }
    }

    /// The range between the two poles of a surface whose meridian goes through its axis twice. The other half of
    /// the meridian is the same surface, or another part of it.
    fn between_poles(&self, axis: usize) -> Option<(f64, f64)> {
        let mut poles = self.closure.poles.iter().filter(|pole| pole.axis == axis);
        match (poles.next(), poles.next(), poles.next()) {
            (Some(a), Some(b), None) => Some((a.value.min(b.value), a.value.max(b.value))),
            _ => None,
        }
    }

    /// Whether the surface comes together at two poles, and its parts between them differ.
    pub(super) fn has_two_parts(&self) -> bool {
        (0..2).any(|axis| {
            let (Some(period), Some((low, high))) =
                (self.closure.periods[axis], self.between_poles(axis))
            else {
                return false;
            };
            let at = |t: f64| self.point(if axis == 0 { Uv::new(t, 0.0) } else { Uv::new(0.0, t) });
            let (middle, other) = (0.5 * (low + high), 0.5 * (low + high + period));
            let ends = [at(low), at(high)];
            let reach = |t: f64| ends.iter().map(|end| (at(t) - end).norm()).sum::<f64>();
            (reach(middle) - reach(other)).abs() > ACCURACY * reach(middle)
        })
    }

    /// Whether the range is finite in both parameters.
    pub(super) fn is_bounded(&self) -> bool {
        self.ranges.iter().all(|(from, to)| from.is_finite() && to.is_finite())
    }

    /// Whether the surface has no border: it is periodic or ends in poles in both parameters.
    pub(super) fn is_closed(&self) -> bool {
        let ends_in_poles = |axis: usize| {
            let (low, high) = self.closure.ranges[axis];
            let is_pole =
                |t: f64| self.closure.poles.iter().any(|pole| pole.axis == axis && pole.value == t);
            is_pole(low) && is_pole(high)
        };
        (0..2).all(|axis| self.closure.periods[axis].is_some() || ends_in_poles(axis))
    }

    /// Whether some parameter is periodic.
    pub(super) fn is_periodic(&self) -> bool {
        self.closure.periods.iter().any(Option::is_some)
    }

    fn wrapped(&self, at: Uv) -> Uv {
        let of = |axis: usize| match self.closure.wraps[axis] {
            Some((low, high)) if at[axis] < low || at[axis] > high => {
                low + (at[axis] - low).rem_euclid(high - low)
            }
            _ => at[axis],
        };
        Uv::new(of(0), of(1))
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
            let [a, b] = [a, b].map(|at| jets::jet(self.surface, self.wrapped(at)));
            (length > 0.0).then(|| [(b.su - a.su) / length, (b.sv - a.sv) / length])
        });
        if let (Some(u), Some(v)) = (u, v) {
            (jet.suu, jet.suv, jet.svv) = (u[0], 0.5 * (u[1] + v[0]), v[1]);
        }
        jet
    }

    /// The ends of a range of a parameter, and the knots between them.
    pub(super) fn knots_between(&self, axis: usize, (from, to): (f64, f64)) -> Vec<f64> {
        let [u, v] = knots(self.surface);
        let inner = if axis == 0 { u } else { v };
        let mut inside: Vec<f64> = match self.closure.wraps[axis] {
            Some((low, high)) if (to - from).is_finite() => {
                let period = high - low;
                let [first, last] = [from, to].map(|t| ((t - low) / period).floor());
                // A face goes around once, and its rings do not go much farther.
                let rounds = (0..MOST_ROUNDS).map(|i| first + i as f64);
                let shifts = rounds.take_while(|round| *round <= last).map(|round| round * period);
                shifts.flat_map(|shift| inner.iter().map(move |t| t + shift)).collect()
            }
            _ => inner,
        };
        // Images of one knot differ by rounding.
        let same = if (to - from).is_finite() { ROUNDING * (to - from) } else { 0.0 };
        inside.retain(|t| from + same < *t && *t < to - same);
        inside.dedup_by(|t, before| *t - *before <= same);
        std::iter::once(from).chain(inside).chain(std::iter::once(to)).collect()
    }

    /// Whether the rectangle is within the range over which splines are defined.
    pub(super) fn is_unwrapped(&self) -> bool {
        (0..2).all(|axis| {
            let (from, to) = self.ranges[axis];
            self.closure.wraps[axis].is_none_or(|(low, high)| low <= from && to <= high)
        })
    }
}

impl ParametricSurface for Domain<'_> {
    fn jet(&self, at: Uv) -> Jet {
        let here = jets::jet(self.surface, self.wrapped(at));
        if is_offset(self.surface) { self.bent(here, at) } else { here }
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        self.ranges
    }

    fn fast_form(&self) -> Option<Arc<dyn ParametricSurface>> {
        let CadSurface::Spline(spline) = self.surface else { return None };
        if spline.weights().is_some() || !self.is_unwrapped() {
            return None;
        }
        let knots = |k: &SplineKnots| KnotVector::try_new(k.degree(), k.knots().to_vec()).ok();
        let net = spline.poles().iter().map(|p| Vector::from(*p)).collect();
        Surface::try_new(knots(spline.u())?, knots(spline.v())?, net).ok()?.fast_form()
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|axis| self.knots_between(axis, self.ranges[axis]))
    }
}

fn is_offset(surface: &CadSurface) -> bool {
    match surface {
        CadSurface::Offset { .. } => true,
        CadSurface::Part { base, .. } => is_offset(base),
        _ => false,
    }
}

/// The knots of a surface in u and in v. There are none where it is no spline.
fn knots(surface: &CadSurface) -> [Vec<f64>; 2] {
    match surface {
        CadSurface::Spline(s) => [s.u().breaks(), s.v().breaks()],
        CadSurface::Extrusion { curve: CadCurve { shape: CurveShape::Spline(s), .. }, .. } => {
            [s.knots().breaks(), Vec::new()]
        }
        CadSurface::Revolution { curve: CadCurve { shape: CurveShape::Spline(s), .. }, .. } => {
            [Vec::new(), s.knots().breaks()]
        }
        CadSurface::Offset { base, .. } | CadSurface::Part { base, .. } => knots(base),
        _ => [Vec::new(), Vec::new()],
    }
}
