//! Points of the curves of a CAD file.
//!
//! The input is a curve and what the file says about the part that an edge uses. The output is the
//! parameter range of this part and points on it.

use formats::cad::{CadCurve, CurveShape};
use formats::spline::SplineCurve;
use nalgebra::SVector;

use super::loops::COMPARED;
use crate::geometry::NEGLIGIBLE;

/// The segment of a curve that an edge uses.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveSegment<'a, const D: usize> {
    shape: &'a CurveShape<D>,
    pub(super) range: (f64, f64),
}

impl<'a, const D: usize> CurveSegment<'a, D> {
    /// The segment of a curve. The file gives it by parameters or by its end points. If it gives
    /// neither, the segment is the whole curve. `None` if an unbounded curve has neither.
    pub(super) fn new(curve: &'a CadCurve<D>, ends: Option<[[f64; D]; 2]>) -> Option<Self> {
        let shape = &curve.shape;
        let range = match (curve.range, ends, shape) {
            (Some(range), ..) => range,
            (None, Some(ends), _) => between(shape, ends.map(SVector::from))?,
            (None, None, CurveShape::Spline(spline)) => spline.knots().range(),
            (None, None, _) => return None,
        };
        let proper = range.0 < range.1 && range.0.is_finite() && range.1.is_finite();
        proper.then_some(CurveSegment { shape, range })
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
        CurveSegment::new(&CadCurve { shape: curve.shape.clone(), range: Some(range) }, None)?;
        Some(CurveSegment { shape: &curve.shape, range })
    }

    pub(super) fn point(&self, t: f64) -> SVector<f64, D> {
        point(self.shape, t)
    }

    /// The ends of the segment and the knots between them. The curve is smooth between these
    /// parameters.
    pub(super) fn breaks(&self) -> Vec<f64> {
        let (a, b) = self.range;
        let mut breaks = vec![a];
        if let CurveShape::Spline(spline) = self.shape {
            breaks.extend(spline.knots().breaks().into_iter().filter(|t| a < *t && *t < b));
        }
        breaks.push(b);
        breaks
    }
}

fn point<const D: usize>(shape: &CurveShape<D>, t: f64) -> SVector<f64, D> {
    let vector = |a: &[f64; D]| SVector::from(*a);
    match shape {
        CurveShape::Line { origin, direction } => vector(origin) + vector(direction) * t,
        CurveShape::Ellipse { centre, x, y } => {
            vector(centre) + vector(x) * t.cos() + vector(y) * t.sin()
        }
        CurveShape::Spline(spline) => on_spline(spline, t),
    }
}

fn on_spline<const D: usize>(spline: &SplineCurve<D>, t: f64) -> SVector<f64, D> {
    SVector::from(spline.point(t))
}

/// The parameters of two points of a curve. The first is the lower one.
fn between<const D: usize>(
    shape: &CurveShape<D>,
    [from, to]: [SVector<f64, D>; 2],
) -> Option<(f64, f64)> {
    match shape {
        CurveShape::Line { origin, direction } => {
            let (o, d) = (SVector::from(*origin), SVector::<f64, D>::from(*direction));
            let at = |p: SVector<f64, D>| (p - o).dot(&d) / d.norm_squared();
            Some((at(from), at(to)))
        }
        CurveShape::Ellipse { centre, x, y } => {
            let [centre, x, y] = [centre, x, y].map(|a| SVector::<f64, D>::from(*a));
            let at = |p: SVector<f64, D>| {
                let along = |axis: SVector<f64, D>| (p - centre).dot(&axis) / axis.norm_squared();
                along(y).atan2(along(x))
            };
            let (start, mut end) = (at(from), at(to));
            // If both points are the same, the segment is the whole ellipse.
            if end <= start || (to - from).norm() <= NEGLIGIBLE * x.norm() {
                end = start + (end - start).rem_euclid(std::f64::consts::TAU);
                let closed = end - start < NEGLIGIBLE;
                end += if closed { std::f64::consts::TAU } else { 0.0 };
            }
            Some((start, end))
        }
        CurveShape::Spline(spline) => Some(between_on_spline(spline, from, to)),
    }
}

/// A point coincides with an end of a curve if their distance is at most this share of the curve's
/// size.
const SAME: f64 = 1e-5;

fn between_on_spline<const D: usize>(
    spline: &SplineCurve<D>,
    from: SVector<f64, D>,
    to: SVector<f64, D>,
) -> (f64, f64) {
    let (low, high) = spline.knots().range();
    let first = SVector::from(spline.poles()[0]);
    let size = spline.poles().iter().map(|p| (SVector::from(*p) - first).norm());
    let same = SAME * size.fold(0.0, f64::max);
    let is_at = |t: f64, p: SVector<f64, D>| (on_spline(spline, t) - p).norm() <= same;
    let start = if is_at(low, from) { low } else { nearest(spline, from) };
    let end = if is_at(high, to) { high } else { nearest(spline, to) };
    // If the edge of a closed curve begins elsewhere than the curve, use the whole curve.
    if start < end { (start, end) } else { (low, high) }
}

/// The parameter of the curve's point nearest to `p`.
fn nearest<const D: usize>(spline: &SplineCurve<D>, p: SVector<f64, D>) -> f64 {
    let away = |t: f64| (on_spline(spline, t) - p).norm_squared();
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
