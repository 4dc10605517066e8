//! Loops of edges as closed polygons on their surface.

use std::sync::Arc;

use formats::cad::{CadCurve, CadEdge};
use nalgebra::Point2;

use super::curve::Part;
use super::surface::Domain;
use crate::geometry::{Point, Uv, segment_distance};
use crate::spline::chords::chords;
use crate::spline::{ParametricSurface, foot_point};

/// A corner of a polygon: its parameter point, and its place on the surface.
pub(super) type Corner = (Uv, Point);

/// Makes polygons of loops.
pub(super) struct Tracer<'a> {
    pub(super) surface: &'a Domain<'a>,
    /// How near chords keep to curves, in mm.
    pub(super) chord: f64,
    /// How far apart two descriptions of one edge may be, in mm, or two edges
    /// that should meet.
    pub(super) gap: f64,
    /// The farthest that an edge's curve in space is from its pcurve's trace.
    pub(super) off_surface: f64,
}

/// How many places of an edge are looked at.
const LOOKED_AT: usize = 64;

impl Tracer<'_> {
    /// The polygon of a loop, without its first corner again at its end.
    ///
    /// # Errors
    /// An edge has no curve at all or is not on the surface, or the loop does not
    /// close in the parameter plane.
    pub(super) fn polygon(&mut self, edges: &[CadEdge]) -> Result<Vec<Corner>, String> {
        let mut all: Vec<Corner> = Vec::new();
        // Where a loop begins with a seam nothing says which of its sides is meant.
        let first = edges.iter().position(|edge| edge.pcurves.len() < 2).unwrap_or(0);
        for edge in edges[first..].iter().chain(&edges[..first]) {
            let last = all.last().map(|c| c.0);
            let mut line = self.edge(edge, last)?;
            if let (Some(period), Some(last), Some(start)) =
                (self.surface.period(), last, line.first())
            {
                let shift = period * ((last.x - start.0.x) / period).round();
                line.iter_mut().for_each(|corner| corner.0.x += shift);
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
        let is_finite = |c: &Corner| c.0.iter().chain(c.1.iter()).all(|x| x.is_finite());
        if !all.iter().all(is_finite) {
            return Err("a loop runs to where numbers end".into());
        }
        all.dedup_by_key(|c| c.0);
        Ok(all)
    }

    /// Whether two corners that follow each other are one place, and so is what
    /// is between them in the parameter plane (all of it, where a pole's edge was
    /// left out).
    fn check_joint(&self, end: Corner, start: Corner) -> Result<(), String> {
        let between = [0.25, 0.5, 0.75].map(|s| self.surface.point(end.0 + s * (start.0 - end.0)));
        let farthest = between.iter().chain([&start.1]).map(|p| (p - end.1).norm());
        if farthest.fold(0.0, f64::max) <= self.gap {
            return Ok(());
        }
        let [x, y, z]: [f64; 3] = end.1.coords.into();
        Err(format!("a loop does not close on its surface, near ({x:.3}, {y:.3}, {z:.3}) mm"))
    }

    /// The polyline of an edge along its loop, which is at `last` so far.
    fn edge(&mut self, edge: &CadEdge, last: Option<Uv>) -> Result<Vec<Corner>, String> {
        let curve = match &edge.curve {
            Some(curve) => {
                let part = Part::new(curve, edge.ends);
                Some(part.ok_or("an edge has no length")?)
            }
            None => None,
        };
        let pcurve = chosen(edge, curve.as_ref(), last);
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
        // No pcurve, or one that is not the curve's: the curve is the master.
        let projected = self.projected(&line, last);
        let off = projected.iter().zip(&line).map(|(c, p)| (c.1 - p).norm()).fold(0.0, f64::max);
        if off > self.gap {
            return Err(format!("an edge is {off:.3e} mm off its surface"));
        }
        self.off_surface = self.off_surface.max(off);
        Ok(projected)
    }

    /// The polyline of a pcurve.
    fn trace(&self, pcurve: &Part<2>) -> Vec<Corner> {
        let at = |t: f64| {
            let uv = Uv::from(pcurve.point(t));
            (uv, self.surface.point(uv))
        };
        chords(&pcurve.breaks(), &at, |c: &Corner| c.1, self.chord)
    }

    /// The farthest that a curve is from its pcurve's trace at equal parameter, if
    /// they have one in common.
    fn apart(&self, pcurve: &Part<2>, curve: &Part<3>, same_way: bool) -> f64 {
        if pcurve.range != curve.range {
            return f64::INFINITY;
        }
        let (a, b) = curve.range;
        let off = |i: usize| {
            let t = a + (b - a) * i as f64 / (4 * LOOKED_AT) as f64;
            let on_surface = self.surface.point(Uv::from(pcurve.point(t)));
            let t = if same_way { t } else { a + (b - t) };
            (Point::from(curve.point(t)) - on_surface).norm()
        };
        (0..=4 * LOOKED_AT).map(off).fold(0.0, f64::max)
    }

    /// The polyline of a curve in space.
    fn chords(&self, curve: &Part<3>, forward: bool) -> Vec<Point> {
        let at = |t: f64| Point::from(curve.point(t));
        along(chords(&curve.breaks(), &at, |p| *p, self.chord), forward)
    }

    /// The feet on the surface of a line's points, each searched from the one
    /// before.
    fn projected(&self, line: &[Point], last: Option<Uv>) -> Vec<Corner> {
        let mut at = last.unwrap_or_else(|| self.nearest_start(line[0]));
        line.iter()
            .map(|&p| {
                at = foot_point(self.surface, p, at).0;
                (at, self.surface.point(at))
            })
            .collect()
    }

    /// A parameter point near the foot of `p`: the best of many.
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

/// The pcurve of an edge; of a seam's two, the one that goes on where the loop is.
fn chosen<'a>(edge: &'a CadEdge, curve: Option<&Part<3>>, last: Option<Uv>) -> Option<Part<'a, 2>> {
    let part = |pcurve: &'a Arc<CadCurve<2>>| match (pcurve.range, curve) {
        (None, Some(curve)) => Part::over(pcurve, curve.range),
        _ => Part::new(pcurve, None),
    };
    let start = |p: &Part<2>| {
        let t = if edge.pcurve_forward { p.range.0 } else { p.range.1 };
        Uv::from(p.point(t))
    };
    let parts: Vec<Part<2>> = edge.pcurves.iter().filter_map(part).collect();
    match (&parts[..], last) {
        ([first, second, ..], Some(last)) => {
            let away = |p: &Part<2>| (start(p) - last).norm();
            Some(if away(second) < away(first) { *second } else { *first })
        }
        // By custom the first is that of the use along the edge.
        ([_, second, ..], None) if !edge.pcurve_forward => Some(*second),
        ([first, ..], _) => Some(*first),
        ([], _) => None,
    }
}

/// Parameters that cover an axis; of an endless one, an angle's.
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

/// The farthest that some corners of a trace, evenly chosen, are from a line.
fn distance_between(trace: &[Corner], line: &[Point]) -> f64 {
    let step = trace.len().div_ceil(LOOKED_AT);
    let looked_at = trace.iter().step_by(step).chain(trace.last());
    let nearest = |p: Point| {
        line.windows(2).map(|w| segment_distance(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
    };
    looked_at.map(|c| nearest(c.1)).fold(0.0, f64::max)
}
