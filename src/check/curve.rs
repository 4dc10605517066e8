//! Segments of the curves of a CAD file.
//!
//! The input is a curve and what the file says about the part that an edge uses. The output is the
//! parameter range of this part and points on it.

use std::f64::consts::TAU;

use formats::cad::{CadCurve, CurveShape};
use formats::spline::SplineCurve;
use nalgebra::SVector;

use super::jets::curve_jet;
use super::trace::COMPARED;
use crate::geometry::NEGLIGIBLE;

/// The segment of a curve that an edge uses.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveSegment<'a, const D: usize> {
    shape: &'a CurveShape<D>,
    pub(super) range: (f64, f64),
    /// The range of a closed spline. The segment may go over its end.
    closed: Option<(f64, f64)>,
}

impl<'a, const D: usize> CurveSegment<'a, D> {
    /// The segment of a curve. The file gives it by parameters or by its end points. If it gives
    /// neither, the segment is the whole curve. `None` if an unbounded curve has neither.
    pub(super) fn new(curve: &'a CadCurve<D>, ends: Option<[[f64; D]; 2]>) -> Option<Self> {
        let shape = &curve.shape;
        let mut closed = None;
        let range = match (curve.range, ends, shape) {
            (Some(range), None, _) => range,
            (_, Some(ends), CurveShape::Spline(spline)) => {
                closed = closed_range(spline);
                between_on_spline(spline, closed, ends.map(SVector::from))
            }
            (_, Some(ends), _) => between(shape, ends.map(SVector::from))?,
            (None, None, CurveShape::Spline(spline)) => spline.knots().range(),
            (None, None, CurveShape::Ellipse { .. }) => (0.0, TAU),
            (None, None, _) => return None,
        };
        is_proper(range).then_some(CurveSegment { shape, range, closed })
    }

    /// The segment of a curve over a range. If the range of a spline does not contain it, the
    /// segment is the whole spline.
    pub(super) fn over(curve: &'a CadCurve<D>, range: (f64, f64)) -> Option<Self> {
        let range = match &curve.shape {
            CurveShape::Spline(spline) => {
                let (low, high) = spline.knots().range();
                let inside = low <= range.0 && range.1 <= high;
                if inside { range } else { (low, high) }
            }
            _ => range,
        };
        is_proper(range).then_some(CurveSegment { shape: &curve.shape, range, closed: None })
    }

    pub(super) fn point(&self, t: f64) -> SVector<f64, D> {
        let t = match self.closed {
            Some((low, high)) if t > high => t - (high - low),
            _ => t,
        };
        match self.shape {
            CurveShape::Spline(spline) => SVector::from(spline.point(t)),
            shape => curve_jet(shape, t)[0],
        }
    }

    /// The ends of the segment and the knots between them. The curve is smooth between these
    /// parameters.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let (a, b) = self.range;
        let mut breaks = vec![a];
        if let CurveShape::Spline(spline) = self.shape {
            let knots = spline.knots().breaks();
            let period = self.closed.map(|(low, high)| high - low);
            let again = period.map(|period| knots.iter().skip(1).map(move |t| t + period));
            let all = knots.iter().copied().chain(again.into_iter().flatten());
            breaks.extend(all.filter(|t| a < *t && *t < b));
        }
        breaks.push(b);
        breaks
    }

    /// Whether the segment is straight.
    pub(super) fn is_straight(&self) -> bool {
        matches!(self.shape, CurveShape::Line { .. })
    }
}

fn is_proper((from, to): (f64, f64)) -> bool {
    from < to && from.is_finite() && to.is_finite()
}

/// The parameters of two points of a curve that is no spline. The first is the lower one.
fn between<const D: usize>(
    shape: &CurveShape<D>,
    [from, to]: [SVector<f64, D>; 2],
) -> Option<(f64, f64)> {
    // The coordinate of a point along an axis, as a multiple of the axis.
    let along = |p: SVector<f64, D>, centre: &[f64; D], axis: &[f64; D]| {
        let axis = SVector::<f64, D>::from(*axis);
        (p - SVector::from(*centre)).dot(&axis) / axis.norm_squared()
    };
    match shape {
        CurveShape::Line { origin, direction } => {
            Some((along(from, origin, direction), along(to, origin, direction)))
        }
        CurveShape::Ellipse { centre, x, y } => {
            let at = |p| along(p, centre, y).atan2(along(p, centre, x));
            let (start, mut end) = (at(from), at(to));
            let size = SVector::<f64, D>::from(*x).norm();
            // If both points are the same, the segment is the whole ellipse.
            if end <= start || (to - from).norm() <= NEGLIGIBLE * size {
                end = start + (end - start).rem_euclid(TAU);
                let closed = end - start < NEGLIGIBLE;
                end += if closed { TAU } else { 0.0 };
            }
            Some((start, end))
        }
        CurveShape::Hyperbola { centre, y, .. } => {
            Some((along(from, centre, y).asinh(), along(to, centre, y).asinh()))
        }
        CurveShape::Parabola { vertex, y, .. } => {
            Some((along(from, vertex, y), along(to, vertex, y)))
        }
        CurveShape::Spline(_) => None,
    }
}

/// A point coincides with an end of a curve if their distance is at most this share of the curve's
/// size.
const SAME: f64 = 1e-5;

/// The distance below which two points of a spline are the same.
fn same<const D: usize>(spline: &SplineCurve<D>) -> f64 {
    let first = SVector::from(spline.poles()[0]);
    let size = spline.poles().iter().map(|p| (SVector::<f64, D>::from(*p) - first).norm());
    SAME * size.fold(0.0, f64::max)
}

/// The range of a spline whose ends meet.
fn closed_range<const D: usize>(spline: &SplineCurve<D>) -> Option<(f64, f64)> {
    let [a, b] = spline.ends().map(SVector::<f64, D>::from);
    ((a - b).norm() <= same(spline)).then(|| spline.knots().range())
}

fn between_on_spline<const D: usize>(
    spline: &SplineCurve<D>,
    closed: Option<(f64, f64)>,
    [from, to]: [SVector<f64, D>; 2],
) -> (f64, f64) {
    let (low, high) = spline.knots().range();
    let same = same(spline);
    let is_at = |t: f64, p: SVector<f64, D>| (SVector::from(spline.point(t)) - p).norm() <= same;
    let start = if is_at(low, from) { low } else { nearest(spline, from) };
    let end = if is_at(high, to) { high } else { nearest(spline, to) };
    match closed {
        // The edge of a closed curve may begin elsewhere than the curve, or go over its end.
        Some((low, high)) if end <= start || (to - from).norm() <= same => {
            (start, if (to - from).norm() <= same { start } else { end } + (high - low))
        }
        _ if start < end => (start, end),
        _ => (low, high),
    }
}

/// The parameter of the curve's point nearest to `p`.
fn nearest<const D: usize>(spline: &SplineCurve<D>, p: SVector<f64, D>) -> f64 {
    let away = |t: f64| (SVector::from(spline.point(t)) - p).norm_squared();
    let breaks = spline.knots().breaks();
    let (mut best, mut width) = (breaks[0], 0.0);
    for span in breaks.windows(2) {
        let step = (span[1] - span[0]) / COMPARED as f64;
        for t in (0..=COMPARED).map(|i| span[0] + step * i as f64) {
            if away(t) < away(best) || width == 0.0 {
                (best, width) = (t, step);
            }
        }
    }
    // Ternary search between the two neighbouring samples.
    let (low, high) = spline.knots().range();
    let (mut a, mut b) = ((best - width).max(low), (best + width).min(high));
    for _ in 0..80 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if away(c) < away(d) { b = d } else { a = c }
    }
    0.5 * (a + b)
}
