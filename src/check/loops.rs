//! Conversion of loops of edges to closed polygons on their surface.
//!
//! The input is the edges of a loop as a CAD file has them: a curve in space, pcurves, or both. The
//! output is a closed polygon of parameter points whose chords are near the edges.

use std::sync::Arc;

use formats::cad::{CadCurve, CadEdge};
use nalgebra::{Point2, Vector2};

use super::curve::CurveSegment;
use super::surface::Domain;
use crate::geometry::{Point, Uv, segment_distance};
use crate::spline::chords::chords;
use crate::spline::{ParametricSurface, foot_point};

/// A corner of a polygon: its parameter point and its point on the surface.
pub(super) type TracePoint = (Uv, Point);

/// Converts loops to polygons.
pub(super) struct Tracer<'a> {
    pub(super) surface: &'a Domain<'a>,
    /// The largest distance of chords from curves, in mm.
    pub(super) chord: f64,
    /// The largest distance, in mm, between two representations of an edge or between two edges
    /// that should meet.
    pub(super) gap: f64,
    /// The largest distance found so far between an edge's curve in space and the trace of its
    /// pcurve, in mm.
    pub(super) off_surface: f64,
}

/// The number of points of an edge that are compared with its other representation.
pub(super) const COMPARED: usize = 64;

impl Tracer<'_> {
    /// The polygon of a loop. The first corner is not repeated at the end.
    ///
    /// # Errors
    /// An edge has no curve or is not on the surface, or the loop does not close in the parameter
    /// plane.
    pub(super) fn polygon(&mut self, edges: &[CadEdge]) -> Result<Vec<TracePoint>, String> {
        let (mut all, mut taken): (Vec<TracePoint>, Vec<TakenPcurve>) = (Vec::new(), Vec::new());
        // Do not begin with a seam edge, because nothing tells which of its two pcurves is meant.
        let first = edges.iter().position(|edge| edge.pcurves.len() < 2).unwrap_or(0);
        for edge in edges[first..].iter().chain(&edges[..first]) {
            let last = all.last().map(|c| c.0);
            let mut line = self.edge(edge, last, &mut taken)?;
            if let (Some(&end), Some(&start)) = (all.last(), line.first())
                && self.joint_gap(end, start) > self.gap
            {
                self.shift(&mut line, end.0 - start.0);
            }
            if let (Some(&end), Some(&start)) = (all.last(), line.first()) {
                self.check_joint(end, start)?;
            }
            all.extend(line);
        }
        match (all.last(), all.first()) {
            (Some(&end), Some(&start)) => self.check_joint(end, start)?,
            _ => return Err("it has a loop without edges".into()),
        }
        let is_finite = |c: &TracePoint| c.0.iter().chain(c.1.iter()).all(|x| x.is_finite());
        if !all.iter().all(is_finite) {
            return Err("a loop has a point with infinite coordinates".into());
        }
        all.dedup_by_key(|c| c.0);
        Ok(all)
    }

    /// Moves a line by whole periods to the end of the previous edge, which is at the given vector from
    /// its start.
    fn shift(&self, line: &mut [TracePoint], gap: Vector2<f64>) {
        for (axis, period) in self.surface.periods().into_iter().enumerate() {
            let Some(period) = period else { continue };
            let shift = period * (gap[axis] / period).round();
            line.iter_mut().for_each(|corner| corner.0[axis] += shift);
        }
    }

    /// The largest distance of a corner from the next one, and from the line between their parameter
    /// points. This line is long where the file omits the edge of a pole.
    fn joint_gap(&self, end: TracePoint, start: TracePoint) -> f64 {
        let between =
            [0.25, 0.5, 3.0 / 4.0].map(|s| self.surface.point(end.0 + s * (start.0 - end.0)));
        let farthest = between.iter().chain([&start.1]).map(|p| (p - end.1).norm());
        farthest.fold(0.0, f64::max)
    }

    /// Checks that two consecutive corners are the same point in space, and that the line between
    /// their parameter points is, too.
    fn check_joint(&self, end: TracePoint, start: TracePoint) -> Result<(), String> {
        if self.joint_gap(end, start) <= self.gap {
            return Ok(());
        }
        let [x, y, z]: [f64; 3] = end.1.coords.into();
        Err(format!("a loop does not close on its surface, near ({x:.3}, {y:.3}, {z:.3}) mm"))
    }

    /// The polyline of an edge in the direction of its loop. `last` is the end of the loop so far.
    /// `taken` has the pcurves that the loop has used.
    fn edge<'b>(
        &mut self,
        edge: &'b CadEdge,
        last: Option<Uv>,
        taken: &mut Vec<TakenPcurve<'b>>,
    ) -> Result<Vec<TracePoint>, String> {
        let curve = match &edge.curve {
            Some(curve) => {
                let part = CurveSegment::new(curve, edge.ends);
                Some(part.ok_or("an edge has no length")?)
            }
            None => None,
        };
        let pcurve = chosen(edge, curve.as_ref(), last, taken);
        let trace = pcurve.map(|pcurve| along(self.trace(&pcurve), edge.pcurve_forward));
        let Some(curve) = curve else {
            return trace.ok_or_else(|| "an edge has no curve".into());
        };
        let line = self.chords(&curve, edge.forward);
        if let (Some(trace), Some(pcurve)) = (trace, pcurve) {
            let same_way = edge.forward == edge.pcurve_forward;
            let by_parameter = self.apart(&pcurve, &curve, same_way);
            let off = distance_between(&trace, &line).min(by_parameter);
            if off <= self.gap {
                self.off_surface = self.off_surface.max(off);
                return Ok(trace);
            }
        }
        // There is no pcurve, or it does not agree with the curve in space. Project the latter.
        let projected = self.projected(&line, last);
        let off = projected.iter().zip(&line).map(|(c, p)| (c.1 - p).norm()).fold(0.0, f64::max);
        if off > self.gap {
            return Err(format!("an edge is {off:.3e} mm off its surface"));
        }
        self.off_surface = self.off_surface.max(off);
        Ok(projected)
    }

    /// The polyline of a pcurve.
    fn trace(&self, pcurve: &CurveSegment<2>) -> Vec<TracePoint> {
        let at = |t: f64| {
            let uv = Uv::from(pcurve.point(t));
            (uv, self.surface.point(uv))
        };
        chords(&pcurve.breaks(), &at, |c: &TracePoint| c.1, self.chord)
    }

    /// The largest distance of a curve from the trace of its pcurve at equal parameters. It is
    /// infinite if they do not have the same range.
    fn apart(&self, pcurve: &CurveSegment<2>, curve: &CurveSegment<3>, same_way: bool) -> f64 {
        if pcurve.range != curve.range {
            return f64::INFINITY;
        }
        let (a, b) = curve.range;
        let off = |i: usize| {
            let t = a + (b - a) * i as f64 / (4 * COMPARED) as f64;
            let on_surface = self.surface.point(Uv::from(pcurve.point(t)));
            let t = if same_way { t } else { a + (b - t) };
            (Point::from(curve.point(t)) - on_surface).norm()
        };
        (0..=4 * COMPARED).map(off).fold(0.0, f64::max)
    }

    /// The polyline of a curve in space.
    fn chords(&self, curve: &CurveSegment<3>, forward: bool) -> Vec<Point> {
        let at = |t: f64| Point::from(curve.point(t));
        along(chords(&curve.breaks(), &at, |p| *p, self.chord), forward)
    }

    /// The foot points of a polyline's points on the surface. The search for each one starts at the
    /// previous one.
    fn projected(&self, line: &[Point], last: Option<Uv>) -> Vec<TracePoint> {
        let mut at = last.unwrap_or_else(|| self.nearest_start(line[0]));
        line.iter()
            .map(|&p| {
                at = foot_point(self.surface, p, at).0;
                (at, self.surface.point(at))
            })
            .collect()
    }

    /// A parameter point near the foot point of `p`: the nearest one of a grid.
    fn nearest_start(&self, p: Point) -> Uv {
        let axes = self.surface.breaks().map(|breaks| samples(&breaks));
        let mut best = (f64::INFINITY, Uv::origin());
        for &u in &axes[0] {
            for &v in &axes[1] {
                let away = (self.surface.point(Point2::new(u, v)) - p).norm();
                if away < best.0 {
                    best = (away, Point2::new(u, v));
                }
            }
        }
        best.1
    }
}

/// A pcurve of an edge that a loop has used.
type TakenPcurve<'a> = &'a Arc<CadCurve<2>>;

/// The pcurve of an edge. A seam edge has two. Then it is the one that the loop has not used, or the
/// one that continues the loop.
fn chosen<'a>(
    edge: &'a CadEdge,
    curve: Option<&CurveSegment<3>>,
    last: Option<Uv>,
    taken: &mut Vec<TakenPcurve<'a>>,
) -> Option<CurveSegment<'a, 2>> {
    let part = |pcurve: &'a Arc<CadCurve<2>>| match (pcurve.range, curve) {
        (None, Some(curve)) => CurveSegment::over(pcurve, curve.range),
        _ => CurveSegment::new(pcurve, None),
    };
    let start = |p: &CurveSegment<2>| {
        let t = if edge.pcurve_forward { p.range.0 } else { p.range.1 };
        Uv::from(p.point(t))
    };
    let left = |pcurve: &&'a Arc<CadCurve<2>>| !taken.iter().any(|used| Arc::ptr_eq(used, pcurve));
    let seam = edge.pcurves.len() > 1;
    let parts = edge.pcurves.iter().filter(|pcurve| !seam || left(pcurve));
    let parts: Vec<_> = parts.filter_map(|pcurve| Some((pcurve, part(pcurve)?))).collect();
    let (used, found) = match (&parts[..], last) {
        ([first, second, ..], Some(last)) => {
            let away = |(_, p): &(_, CurveSegment<2>)| (start(p) - last).norm();
            if away(second) < away(first) { second } else { first }
        }
        // By convention the first pcurve belongs to the use along the edge.
        ([_, second, ..], None) if !edge.pcurve_forward => second,
        ([first, ..], _) => first,
        ([], _) => return None,
    };
    if seam {
        taken.push(used);
    }
    Some(*found)
}

/// Parameters that cover an axis. For an unbounded axis they cover the range of an angle.
fn samples(breaks: &[f64]) -> Vec<f64> {
    let (Some(&low), Some(&high)) = (breaks.first(), breaks.last()) else { return Vec::new() };
    if !low.is_finite() || !high.is_finite() {
        return (-4..=4).map(|i| f64::from(i) * std::f64::consts::FRAC_PI_4).collect();
    }
    let pieces = (64 / breaks.len()).max(2);
    let piece = |w: &[f64], i: usize| w[0] + (w[1] - w[0]) * (i as f64 + 0.5) / pieces as f64;
    breaks.windows(2).flat_map(|w| (0..pieces).map(move |i| piece(w, i))).collect()
}

fn along<T>(mut line: Vec<T>, forward: bool) -> Vec<T> {
    if !forward {
        line.reverse();
    }
    line
}

/// The largest distance of evenly chosen corners of a trace from a polyline.
fn distance_between(trace: &[TracePoint], line: &[Point]) -> f64 {
    let step = trace.len().div_ceil(COMPARED);
    let compared = trace.iter().step_by(step).chain(trace.last());
    let nearest = |p: Point| {
        line.windows(2).map(|w| segment_distance(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
    };
    compared.map(|c| nearest(c.1)).fold(0.0, f64::max)
}
