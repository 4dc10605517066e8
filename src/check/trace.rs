//! Conversion of edges to polylines on their surface.
//!
//! The input is an edge as a CAD file has it: a curve in space, pcurves, or both. The output is parameter points
//! whose chords are near the edge, and between each two of them a point in the middle.

use std::cell::Cell;
use std::sync::Arc;

use formats::cad::{CadCurve, CadEdge};
use nalgebra::center;

use super::closure::Pole;
use super::curve::CurveSegment;
use super::surface::Domain;
use crate::geometry::{NEGLIGIBLE, Point, Uv, segment_distance};
use crate::spline::ParametricSurface;

/// A corner of a polyline: its parameter point and its point on the surface.
pub(super) type TracePoint = (Uv, Point);

/// The polyline of an edge in the direction of its loop.
pub(super) struct Trace {
    /// Its corners. Every second one is in the middle of a piece, so their number is odd.
    pub(super) corners: Vec<TracePoint>,
    /// Whether it follows a pcurve of the file.
    pub(super) is_by_pcurve: bool,
}

/// Converts edges to polylines.
pub(super) struct Tracer<'a> {
    pub(super) surface: &'a Domain<'a>,
    /// The largest distance of chords from curves, in mm.
    pub(super) chord: f64,
    /// The largest distance, in mm, of an edge from its surface, or between two edges that should meet.
    pub(super) gap: f64,
    /// The largest distance of an edge from the trace of a pcurve that stands for it.
    pub(super) agreed: f64,
    /// The largest distance found so far between an edge's curve in space and the trace of its
    /// pcurve, in mm.
    pub(super) off_surface: f64,
}

/// The number of points of an edge that are compared with its other representation.
pub(super) const COMPARED: usize = 64;

/// The ends of an edge are at those of its pcurve if they are no farther from each other, as a multiple of the
/// largest distance of chords. Files have vertices with ten digits and more.
const ENDS: f64 = 10.0;

/// The largest number of times that a piece is halved.
const MOST_HALVINGS: usize = 16;

/// The smallest number of pieces of a whole curve. A wave may cross a single chord in its middle,
/// where the error would then appear to be zero.
const FEWEST: usize = 16;

/// The place of an edge at a parameter. The second argument is a parameter point near it, if one is known.
type PlaceOnEdge<'f> = &'f dyn Fn(f64, Option<Uv>) -> Result<TracePoint, String>;

impl Tracer<'_> {
    /// The polyline of an edge. `last` is the end of the loop so far. `taken` has the pcurves that the loop has
    /// used. `None` if the edge has no length.
    ///
    /// # Errors
    /// The edge has no curve, or is not on the surface.
    pub(super) fn edge<'b>(
        &mut self,
        edge: &'b CadEdge,
        last: Option<Uv>,
        taken: &mut Vec<TakenPcurve<'b>>,
    ) -> Result<Option<Trace>, String> {
        let curve = match &edge.curve {
            Some(curve) => match CurveSegment::new(curve, edge.ends) {
                Some(part) => Some(part),
                None if self.is_short(edge) => return Ok(None),
                None => return Err("an edge has no length".into()),
            },
            None => None,
        };
        let pcurve = chosen(edge, curve.as_ref(), last, taken);
        let trace = pcurve.map(|pcurve| self.along_pcurve(&pcurve)).transpose()?;
        let trace = trace.map(|trace| along(trace, edge.pcurve_forward));
        let Some(curve) = curve else {
            let trace = trace.ok_or("an edge has no curve")?;
            return Ok(Some(Trace { corners: trace, is_by_pcurve: true }));
        };
        if let (Some(trace), Some(pcurve)) = (trace, pcurve) {
            let same_way = edge.forward == edge.pcurve_forward;
            let mut off = self.apart(&pcurve, &curve, same_way);
            // Some files have parameters of the other side of a pole.
            let is_within = trace.iter().all(|corner| self.is_within(corner.0));
            let mut agrees = off <= self.agreed;
            if off > self.chord {
                off = off.min(distance_between(&trace, &self.line(&curve)));
                // The two may have other parameters, and then the range of the pcurve is known from its ends.
                agrees |= off <= self.agreed && self.has_ends(&trace, &curve, edge.forward);
            }
            if agrees && is_within {
                self.off_surface = self.off_surface.max(off);
                return Ok(Some(Trace { corners: trace, is_by_pcurve: true }));
            }
        }
        // There is no pcurve, or it does not agree with the curve in space. Project the latter.
        let projected = along(self.projected(&curve, last)?, edge.forward);
        Ok(Some(Trace { corners: projected, is_by_pcurve: false }))
    }

    /// Whether a parameter point is in the range of the surface.
    fn is_within(&self, at: Uv) -> bool {
        (0..2).all(|axis| {
            let (low, high) = self.surface.closure.ranges[axis];
            let width = if (high - low).is_finite() { NEGLIGIBLE * (high - low) } else { 0.0 };
            (low - width..=high + width).contains(&at[axis])
        })
    }

    /// Whether a trace begins and ends where the edge on a curve does.
    fn has_ends(&self, trace: &[TracePoint], curve: &CurveSegment<3>, forward: bool) -> bool {
        let (from, to) = if forward { curve.range } else { (curve.range.1, curve.range.0) };
        let is_at = |corner: Option<&TracePoint>, t: f64| {
            corner.is_some_and(|c| (c.1 - Point::from(curve.point(t))).norm() <= ENDS * self.chord)
        };
        is_at(trace.first(), from) && is_at(trace.last(), to)
    }

    /// Whether an edge begins where it ends.
    fn is_short(&self, edge: &CadEdge) -> bool {
        let apart = |[a, b]: [[f64; 3]; 2]| (Point::from(a) - Point::from(b)).norm();
        edge.ends.is_some_and(|ends| apart(ends) <= self.gap)
    }

    /// The polyline of a pcurve.
    fn along_pcurve(&self, pcurve: &CurveSegment<2>) -> Result<Vec<TracePoint>, String> {
        let at = |t: f64, _| {
            let uv = Uv::from(pcurve.point(t));
            Ok((uv, self.surface.point(uv)))
        };
        self.polyline(&pcurve.breaks(), pcurve.is_straight(), &at)
    }

    /// The polyline of the feet of a curve in space.
    fn projected(
        &mut self,
        curve: &CurveSegment<3>,
        last: Option<Uv>,
    ) -> Result<Vec<TracePoint>, String> {
        let farthest = Cell::new(0.0);
        let at = |t: f64, hint: Option<Uv>| {
            let p = Point::from(curve.point(t));
            let mut at = self.surface.locate(p, hint.or(last), self.gap);
            if let (Some(pole), Some(hint)) = (self.pole(p), hint) {
                // Around a pole, the other parameter is that of the neighbour.
                at = hint;
                at[pole.axis] = pole.value;
            }
            let on_it = self.surface.point(at);
            let off = (on_it - p).norm();
            if off > self.gap {
                return Err(format!("an edge is {off:.3e} mm off its surface"));
            }
            farthest.set(off.max(farthest.get()));
            Ok((at, on_it))
        };
        let mut breaks = curve.breaks();
        self.add_poles(curve, &mut breaks);
        let line = self.polyline(&breaks, curve.is_straight(), &at)?;
        self.off_surface = self.off_surface.max(farthest.get());
        Ok(line)
    }

    /// Adds the parameters at which a curve goes through poles.
    fn add_poles(&self, curve: &CurveSegment<3>, breaks: &mut Vec<f64>) {
        for pole in &self.surface.closure.poles {
            let away = |t: f64| (Point::from(curve.point(t)) - pole.point).norm();
            let (from, to) = curve.range;
            let step = (to - from) / COMPARED as f64;
            let at = |i: usize| from + step * i as f64;
            let is_low =
                |i: &usize| away(at(*i)) <= away(at(i - 1)) && away(at(*i)) <= away(at(i + 1));
            for i in (1..COMPARED).filter(is_low) {
                let (mut a, mut b) = (at(i - 1), at(i + 1));
                for _ in 0..80 {
                    let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                    if away(c) < away(d) { b = d } else { a = c }
                }
                let t = 0.5 * (a + b);
                let is_inside = (t - from).min(to - t) > NEGLIGIBLE * (to - from);
                if is_inside && away(t) <= self.chord {
                    breaks.push(t);
                }
            }
        }
        breaks.sort_by(f64::total_cmp);
    }

    /// The pole at a point, if there is one.
    pub(super) fn pole(&self, p: Point) -> Option<&Pole> {
        self.surface.closure.poles.iter().find(|pole| (pole.point - p).norm() <= self.at_pole())
    }

    /// A point is at a pole if it is no farther from it. Files round vertices to less.
    fn at_pole(&self) -> f64 {
        2.0 * self.chord
    }

    /// A polyline with middles. It is smooth between breaks.
    fn polyline(
        &self,
        breaks: &[f64],
        is_straight: bool,
        at: PlaceOnEdge,
    ) -> Result<Vec<TracePoint>, String> {
        let pieces = if is_straight { 1 } else { (FEWEST / breaks.len()).max(2) };
        let inner = |w: &[f64], i: usize| w[0] + (w[1] - w[0]) * i as f64 / pieces as f64;
        let ts = breaks.windows(2).flat_map(|w| (0..pieces).map(move |i| inner(w, i)));
        let ts: Vec<f64> = ts.chain(breaks.last().copied()).collect();
        // Begin in the middle, because the ends may be poles, around which one parameter has no meaning.
        let middle = (ts.len() - 1) / 2;
        let first = 0.5 * (ts[middle] + ts[middle + 1]);
        let start = at(first, None)?;
        let mut nodes = vec![start; ts.len()];
        let mut hint = start.0;
        for i in (0..=middle).rev() {
            nodes[i] = at(ts[i], Some(hint))?;
            hint = nodes[i].0;
        }
        hint = start.0;
        for i in middle + 1..ts.len() {
            nodes[i] = at(ts[i], Some(hint))?;
            hint = nodes[i].0;
        }
        let mut line = vec![nodes[0]];
        for i in 1..ts.len() {
            self.refine(
                at,
                [(ts[i - 1], nodes[i - 1]), (ts[i], nodes[i])],
                MOST_HALVINGS,
                &mut line,
            )?;
        }
        self.turn_at_poles(&mut line);
        Ok(line)
    }

    /// Continues a polyline from `from`, where it ends, to `to`.
    fn refine(
        &self,
        at: PlaceOnEdge,
        [from, to]: [(f64, TracePoint); 2],
        halvings: usize,
        line: &mut Vec<TracePoint>,
    ) -> Result<(), String> {
        let between = |a: Uv, b: Uv| center(&a, &b);
        let t = 0.5 * (from.0 + to.0);
        let middle = at(t, Some(between(from.1.0, to.1.0)))?;
        // A side of the polygon, in space and in the parameter plane, must be near the edge.
        let is_near = |a: (f64, TracePoint), b: (f64, TracePoint)| {
            let uv = between(a.1.0, b.1.0);
            let quarter = at(0.5 * (a.0 + b.0), Some(uv))?.1;
            let off = |p: Point| segment_distance(p, a.1.1, b.1.1);
            Ok::<bool, String>(
                off(quarter) <= self.chord && off(self.surface.point(uv)) <= self.chord,
            )
        };
        let middle = (t, middle);
        if halvings == 0 || is_near(from, middle)? && is_near(middle, to)? {
            line.extend([middle.1, to.1]);
            return Ok(());
        }
        self.refine(at, [from, middle], halvings - 1, line)?;
        self.refine(at, [middle, to], halvings - 1, line)
    }

    /// At a pole, sets the parameter that has no meaning there to that of the neighbour.
    fn turn_at_poles(&self, line: &mut [TracePoint]) {
        let last = line.len() - 1;
        for (end, neighbour) in [(0, 1), (last, last - 1)] {
            if let Some(pole) = self.pole(line[end].1) {
                let other = 1 - pole.axis;
                line[end].0[other] = line[neighbour].0[other];
            }
        }
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
    fn line(&self, curve: &CurveSegment<3>) -> Vec<Point> {
        let at = |t: f64| Point::from(curve.point(t));
        crate::spline::chords::chords(&curve.breaks(), &at, |p| *p, self.chord)
    }
}

/// A pcurve of an edge that a loop has used.
pub(super) type TakenPcurve<'a> = &'a Arc<CadCurve<2>>;

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
