//! The course of one trim loop: knots where the rim needs them.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::closed::{Knots, Polygon, arcs, fit};
use super::{Options, Rim, corners, needles};
use crate::geometry::{Point, Uv, segment_distance};
use crate::spline::{Curve, Jet, Surface, foot_point};

/// Spans that a loop begins with.
const FIRST_SPANS: f64 = 6.0;

/// Spans are no shorter than this share of a mean edge, or of the tolerance where
/// that is less: a tooth's tip is rounded over a span.
const SHORTEST: f64 = 0.0125;
const SHORTEST_OF_TOLERANCE: f64 = 0.125;

/// The same of a loop that need not follow every tooth: spans of a tenth of an edge pass
/// every vertex within a share of it.
const SHORTEST_FAIR: f64 = 0.1;

/// But where the loop would cross itself or another one, or the tolerance is below all
/// sense, they are no shorter than this share of an edge.
const SHORTEST_EVER: f64 = 1e-3;

/// The nearest place is looked for within so many mean edges, on so many chords each
/// way.
const AROUND: f64 = 3.0;
const CHORDS: i32 = 24;

/// Corners of this kind at the most: where more would be needed, needles go.
const MOST_SHARP: usize = 32;

/// Rounds of halving: more than enough to come from a sixth to the shortest.
const ROUNDS: usize = 40;

/// A loop as it stands.
#[derive(Debug, Clone)]
pub struct Course<'a> {
    surface: &'a Surface,
    rim: Cow<'a, Rim>,
    pub(super) polygon: Polygon,
    /// The surface at the polygon's corners.
    pub(super) jets: Vec<Jet>,
    /// How far, in mm, the curve may be from each of them within the surface.
    pub(super) room: Vec<f64>,
    pub(super) knots: Knots,
    /// Shorter spans, by their parameters, are not made.
    shortest: f64,
    /// Position of the rim's vertex at parameter 0.
    first: usize,
    on_map: bool,
    /// Vertices of the rim at which the loop has a corner, though the rim bends too
    /// little for one.
    sharp: Vec<usize>,
    pub(super) curve: Curve<2>,
    /// Whether the curve shall have as few knots as the room lets it.
    is_fair: bool,
    /// The curve as it was before knots were taken out.
    thick: Option<(Knots, Curve<2>)>,
}

impl<'a> Course<'a> {
    /// The loop with the fewest knots that is within the tolerance of the rim. `None`:
    /// the rim is a point.
    pub fn new(surface: &'a Surface, rim: &'a Rim, options: &Options) -> Option<Self> {
        Course::around(surface, Cow::Borrowed(rim), options, false, Vec::new())
    }

    /// Rim vertices are taken at their feet on the surface, or, if `on_map`, at
    /// the parameter points that the map gave them: feet of a ragged rim can run
    /// across each other, those cannot.
    fn around(
        surface: &'a Surface,
        rim: Cow<'a, Rim>,
        options: &Options,
        on_map: bool,
        sharp: Vec<usize>,
    ) -> Option<Self> {
        let foot = |(p, at): (_, &Uv)| foot_point(surface, p, *at).0;
        let mut uv = match on_map {
            true => rim.uv.clone(),
            false => rim.points.iter().copied().zip(&rim.uv).map(foot).collect(),
        };
        let mut points: Vec<_> = uv.iter().map(|&at| surface.point(at)).collect();
        let off = points.iter().zip(&rim.points).map(|(foot, p)| (foot - p).norm());
        let mut room: Vec<f64> = off.map(|off| options.room(off)).collect();
        let (walked, total) = lengths(&points)?;
        let mut corners = corners::find(&points, &walked, total);
        corners.extend(&sharp);
        corners.sort_unstable();
        corners.dedup();
        let first = corners.first().copied().unwrap_or(0);
        uv.rotate_left(first);
        points.rotate_left(first);
        room.rotate_left(first);
        let (walked, total) = lengths(&points)?;
        let parameters: Vec<f64> = walked.iter().map(|s| s / total).collect();
        let corners: Vec<f64> = corners.iter().map(|&i| parameters[i - first]).collect();
        let knots = Knots { breaks: first_breaks(&corners), corners };
        let jets = uv.iter().map(|&at| surface.jet(at)).collect();
        let weights = vec![1.0; uv.len()];
        let polygon = Polygon { parameters, uv, weights };
        let curve = fit(&polygon, &knots)?;
        let edge = 1.0 / polygon.uv.len() as f64;
        let shortest = match options.is_fair() && !options.keeps_vertices {
            true => SHORTEST_FAIR * edge,
            false => (SHORTEST * edge)
                .min(SHORTEST_OF_TOLERANCE * options.tolerance / total)
                .max(SHORTEST_EVER * edge),
        };
        let mut course = Course {
            surface,
            rim,
            polygon,
            jets,
            room,
            knots,
            shortest,
            first,
            on_map,
            sharp,
            curve,
            is_fair: options.is_fair(),
            thick: None,
        };
        course.follow();
        if course.is_fair {
            let thick = (course.knots.clone(), course.curve.clone());
            course.take_room();
            course.thin();
            course.thick = Some(thick);
        }
        Some(course)
    }

    /// Halves spans until the curve is everywhere in its room, or they are the shortest.
    fn follow(&mut self) {
        for _ in 0..ROUNDS {
            let far = self.spans_beyond(self.shortest);
            if far.is_empty() || self.halve(far).is_none() {
                break;
            }
        }
    }

    /// The arcs of the loop.
    pub fn arcs(&self) -> Vec<Curve<2>> {
        arcs(&self.curve, &self.knots)
    }

    /// The rim's vertex next to a parameter.
    pub fn vertex(&self, t: f64) -> Point {
        let n = self.rim.points.len();
        self.rim.points[(self.first + self.polygon.before(t).min(n - 1)) % n]
    }

    /// Gives the loop the knots back that were taken out; then lets it follow its rim more
    /// closely around places; where it does so
    /// already, or there are none, along the map's parameter points; then with a corner
    /// at the first of the places, which may be the tip of a slit; last, needles left
    /// out. `None`: none of this can be.
    pub fn tighten(&mut self, places: &[Option<f64>], options: &Options) -> Option<()> {
        if let Some((knots, curve)) = self.thick.take() {
            (self.knots, self.curve) = (knots, curve);
            self.polygon.weights.fill(1.0);
            return Some(());
        }
        let spans: BTreeSet<usize> =
            places.iter().flatten().flat_map(|&t| self.spans_around(t)).collect();
        if !spans.is_empty() && self.halve(spans).is_some() {
            return Some(());
        }
        let tip = places.iter().flatten().next().map(|&t| self.nearest(t));
        let new_tip = tip.filter(|tip| !self.sharp.contains(tip) && self.sharp.len() < MOST_SHARP);
        let (rim, sharp) = match new_tip {
            _ if !self.on_map => (self.rim.clone(), Vec::new()),
            Some(tip) => (self.rim.clone(), [&self.sharp[..], &[tip]].concat()),
            None => {
                let kept = needles::without(&self.rim.uv);
                if kept.len() == self.rim.uv.len() {
                    return None;
                }
                (Cow::Owned(self.rim.only(&kept)), Vec::new())
            }
        };
        *self = Course::around(self.surface, rim, options, true, sharp)?;
        Some(())
    }

    /// The rim's vertex nearest to a parameter, on either side of it.
    fn nearest(&self, t: f64) -> usize {
        let n = self.rim.points.len();
        let after = self.polygon.before(t);
        let end = |i: usize| self.polygon.parameters.get(i).copied().unwrap_or(1.0);
        let back = after > 0 && t - end(after - 1) < end(after) - t;
        (self.first + after - usize::from(back)) % n
    }

    /// The ends of span `i`.
    pub(super) fn span(&self, i: usize) -> (f64, f64) {
        let breaks = &self.knots.breaks;
        (breaks[i], breaks.get(i + 1).copied().unwrap_or(1.0))
    }

    /// Spans that leave their room and whose halves would be longer than `least`. A vertex at
    /// a knot, as at a corner, is held by the spans on both sides.
    pub(super) fn spans_beyond(&self, least: f64) -> Vec<usize> {
        let n = self.polygon.uv.len();
        let far = |&i: &usize| {
            let (a, b) = self.span(i);
            let end = self.polygon.before(b);
            let at_end = self.polygon.parameters[end % n] == b.fract();
            let mut held = (self.polygon.before(a)..end).chain(at_end.then_some(end % n));
            self.is_longer(i, least)
                && (held.any(|k| self.distance(k) > self.room[k])
                    || self.is_fair && self.leaves_rim(a, b) > 1.0)
        };
        (0..self.knots.breaks.len()).filter(far).collect()
    }

    /// Whether the halves of span `i` are longer than `least`.
    fn is_longer(&self, i: usize, least: f64) -> bool {
        let (a, b) = self.span(i);
        b - a > 2.0 * least
    }

    /// The distance in mm of corner `k` of the polygon from the curve on the surface: from the
    /// place with its parameter, or the nearest one around.
    pub(super) fn distance(&self, k: usize) -> f64 {
        let t = self.polygon.parameters[k];
        let off = |t: f64| {
            let at = self.surface.clamp(self.curve.point(t.rem_euclid(1.0)).into());
            Point::from(self.surface.point(at) - self.jets[k].s)
        };
        let same = off(t).coords.norm();
        if same <= self.room[k] || self.knots.corners.contains(&t) {
            return same;
        }
        let around = AROUND / self.polygon.uv.len() as f64;
        let place = |i: i32| off(t + around * f64::from(i) / f64::from(CHORDS));
        let places: Vec<Point> = (-CHORDS..=CHORDS).map(place).collect();
        let chords = places.windows(2).map(|c| segment_distance(Point::origin(), c[0], c[1]));
        chords.fold(same, f64::min)
    }

    /// The span that holds `t` and its neighbours, those that may be halved.
    fn spans_around(&self, t: f64) -> impl Iterator<Item = usize> + '_ {
        let n = self.knots.breaks.len();
        let i = self.knots.breaks.partition_point(|&b| b <= t).max(1) - 1;
        let least = SHORTEST_EVER / self.polygon.uv.len() as f64;
        let around = [i + n - 1, i, i + 1].into_iter().map(move |i| i % n);
        around.filter(move |&i| self.is_longer(i, least))
    }

    /// Halves spans; `None`, and all as it was, if that makes no curve.
    fn halve(&mut self, spans: impl IntoIterator<Item = usize>) -> Option<()> {
        let mut knots = self.knots.clone();
        let halves = spans.into_iter().map(|i| self.span(i)).map(|(a, b)| 0.5 * (a + b));
        knots.breaks.extend(halves);
        knots.breaks.sort_by(f64::total_cmp);
        self.curve = fit(&self.polygon, &knots)?;
        self.knots = knots;
        Some(())
    }
}

/// Spans of about equal length between corners.
fn first_breaks(corners: &[f64]) -> Vec<f64> {
    let mut ends = if corners.is_empty() { vec![0.0] } else { corners.to_vec() };
    ends.push(1.0);
    let spans = |w: &[f64]| {
        let (a, b) = (w[0], w[1]);
        let count = (FIRST_SPANS * (b - a)).ceil().max(1.0) as usize;
        (0..count).map(move |i| a + (b - a) * i as f64 / count as f64).collect::<Vec<_>>()
    };
    ends.windows(2).flat_map(spans).collect()
}

/// Lengths from point 0 to each point along a closed polygon, and all around it;
/// `None` if that is no positive number. Points that coincide are kept apart.
fn lengths(points: &[Point]) -> Option<(Vec<f64>, f64)> {
    let n = points.len();
    let side = |i: usize| (points[(i + 1) % n] - points[i]).norm();
    let around: f64 = (0..n).map(side).sum();
    let least = 1e-6 * around / n as f64;
    let mut walked = Vec::with_capacity(n);
    let mut total = 0.0;
    for i in 0..n {
        walked.push(total);
        total += side(i).max(least);
    }
    (total > 0.0 && total.is_finite()).then_some((walked, total))
}
