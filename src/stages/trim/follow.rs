//! A cubic B-spline that follows a polygon of the parameter plane.
//!
//! The input is a polygon, closed or with fixed ends, and the room that the curve has around each of its corners.
//! The output is a curve that stays in its room. It begins with few knots. Spans that leave their room are halved,
//! so that knots are dense where the polygon needs them.

use std::collections::BTreeSet;

use super::least_squares::{Knots, nearest_curve};
use super::polygon::{Polygon, lengths};
use super::{Options, corners};
use crate::geometry::{MOST_ROUNDS, Point, Uv, segment_distance};
use crate::spline::{Curve, MOST_SPANS, Surface, runs};

/// The number of spans that a closed curve starts with.
const FIRST_SPANS: f64 = 6.0;

/// The nearest point of the curve is searched within this many mean edges in each direction.
const AROUND: f64 = 3.0;

/// The number of chords in each direction on which the nearest point is searched.
const CHORDS: i32 = 24;

/// The number of points of the curve for each edge of the polygon that are compared with the polygon.
const PLACES_AN_EDGE: f64 = 2.0;

/// The number of edges in each direction that a point of the curve is compared with. A fair curve
/// passes the teeth of the polygon near the middle, so that the nearest edge can be a neighbour.
const SIDES: usize = 3;

/// The shortest span, as a share of a mean edge of the polygon. The tip of a tooth is rounded over one
/// span.
const SHORTEST_OF_EDGE: f64 = 0.0125;

/// The shortest span, as a share of the tolerance. It applies where this is shorter than
/// [`SHORTEST_OF_EDGE`].
const SHORTEST_OF_TOLERANCE: f64 = 0.125;

/// The shortest span of a curve that need not follow every tooth, as a share of a mean edge. Spans
/// of a tenth of an edge pass every vertex at a fraction of an edge.
const SHORTEST_FAIR: f64 = 0.1;

/// The shortest span of all, as a share of a mean edge. It applies where a loop would cross
/// itself or another loop, and where the tolerance is extremely small.
const SHORTEST_EVER: f64 = 1e-3;

/// A curve that follows a polygon.
#[derive(Debug, Clone)]
pub(crate) struct Follower<'a> {
    polygon: Polygon<'a>,
    knots: Knots,
    curve: Curve<2>,
    /// Whether the curve has as few knots as its room allows. Then every point of the curve must be near the
    /// polygon, too, because it passes teeth in the middle.
    is_fair: bool,
    /// The length of the shortest span, as a difference of parameters.
    shortest: f64,
}

/// A place that a curve is to follow: the foot point of a vertex, and the distance of the vertex from it, in mm.
type PlacedFoot = (Uv, f64);

impl<'a> Follower<'a> {
    /// The curve around foot points, with corners where they have some, and at the positions `sharp`. It begins
    /// at its first corner. Returns the position where it begins, too. Control points stay within `range`. `None`
    /// if the foot points are one place.
    pub(super) fn around(
        surface: &'a Surface,
        feet: &[PlacedFoot],
        options: &Options,
        sharp: &[usize],
        range: [f64; 2],
    ) -> Option<(Self, usize)> {
        let points: Vec<_> = feet.iter().map(|foot| surface.point(foot.0)).collect();
        let mut corners = corners::find(&points, lengths(&points, true)?.1);
        corners.extend(sharp);
        corners.sort_unstable();
        corners.dedup();
        let first = corners.first().copied().unwrap_or(0);
        let mut places: Vec<_> = feet.iter().map(|foot| (foot.0, options.room(foot.1))).collect();
        places.rotate_left(first);
        let (polygon, total) = Polygon::new(surface, &places, true, range)?;
        let corners: Vec<f64> = corners.iter().map(|&i| polygon.parameters[i - first]).collect();
        let knots = Knots { breaks: first_breaks(&corners), corners };
        Some((Follower::new(polygon, knots, options, total)?, first))
    }

    /// The curve between two ends along foot points. Control points stay within `range`. `None` if all are at one place.
    pub(super) fn between(
        surface: &'a Surface,
        ends: [Uv; 2],
        feet: &[PlacedFoot],
        options: &Options,
        range: [f64; 2],
    ) -> Option<Self> {
        let [first, last] = ends.map(|end| (end, options.room(0.0)));
        let inner = feet.iter().map(|foot| (foot.0, options.room(foot.1)));
        let places: Vec<_> = std::iter::once(first).chain(inner).chain([last]).collect();
        let (polygon, total) = Polygon::new(surface, &places, false, range)?;
        let knots = Knots { breaks: vec![0.0], corners: Vec::new() };
        Follower::new(polygon, knots, options, total)
    }

    fn new(polygon: Polygon<'a>, knots: Knots, options: &Options, total: f64) -> Option<Self> {
        let curve = nearest_curve(&polygon, &knots)?;
        let edge = 1.0 / polygon.edges() as f64;
        let is_fair = options.is_fair();
        let shortest = match is_fair && !options.keeps_vertices {
            true => SHORTEST_FAIR * edge,
            false => (SHORTEST_OF_EDGE * edge)
                .min(SHORTEST_OF_TOLERANCE * options.tolerance / total)
                .max(SHORTEST_EVER * edge),
        };
        let mut follower = Follower { polygon, knots, curve, is_fair, shortest };
        follower.follow();
        Some(follower)
    }

    /// Halves spans until the curve is in its room everywhere or the spans have the shortest
    /// length.
    fn follow(&mut self) {
        for _ in 0..MOST_ROUNDS {
            let far = self.spans_beyond(self.shortest);
            if far.is_empty() || self.halve(far).is_none() {
                break;
            }
        }
    }

    /// Makes the room half as wide, and follows the polygon again.
    pub(super) fn tighten(&mut self) {
        self.polygon.room.iter_mut().for_each(|room| *room *= 0.5);
        self.follow();
    }

    /// Halves the spans at the given parameters and beside them, down to a thousandth of an edge. `None`, with
    /// nothing changed, if there are none to be halved.
    pub(super) fn halve_at(&mut self, places: impl Iterator<Item = f64>) -> Option<()> {
        let spans: BTreeSet<usize> = places.flat_map(|t| self.spans_around(t)).collect();
        if spans.is_empty() {
            return None;
        }
        self.halve(spans)
    }

    /// The number of corners of the polygon before a parameter.
    pub(super) fn before(&self, t: f64) -> usize {
        self.polygon.before(t)
    }

    /// The corner of a closed polygon nearest to a parameter, before or after it.
    pub(super) fn nearest(&self, t: f64) -> usize {
        let after = self.polygon.before(t);
        let end = |i: usize| self.polygon.parameters.get(i).copied().unwrap_or(1.0);
        let back = after > 0 && t - end(after - 1) < end(after) - t;
        (after - usize::from(back)) % self.polygon.uv.len()
    }

    /// The spans that leave their room and whose halves would be longer than `least`. A corner of the polygon at a
    /// knot belongs to the spans on both sides.
    fn spans_beyond(&self, least: f64) -> Vec<usize> {
        let Polygon { parameters, room, is_closed, .. } = &self.polygon;
        let far = |&i: &usize| {
            let (a, b) = self.knots.span(i);
            let end = self.polygon.before(b);
            let next = if *is_closed { end % parameters.len() } else { end };
            let at_end = parameters[next] == if *is_closed { b.fract() } else { b };
            let mut held = (self.polygon.before(a)..end).chain(at_end.then_some(next));
            // Where faces rest on fills, the foot point of a single vertex may be far from its neighbours'.
            let tells = *is_closed || held.clone().count() > 1;
            tells
                && self.is_longer(i, least)
                && (held.any(|k| !self.is_near(k, room[k]))
                    || self.is_fair && self.leaves_room(a, b))
        };
        (0..self.knots.breaks.len()).filter(far).collect()
    }

    /// Whether the halves of span `i` are longer than `least`.
    fn is_longer(&self, i: usize, least: f64) -> bool {
        let (a, b) = self.knots.span(i);
        b - a > 2.0 * least
    }

    /// Whether the curve passes corner `k` of the polygon at the distance `room` or nearer, in mm. At a corner of
    /// the curve, only the place with the same parameter counts.
    fn is_near(&self, k: usize, room: f64) -> bool {
        let t = self.polygon.parameters[k];
        let off = |t: f64| {
            let t = if self.polygon.is_closed { t.rem_euclid(1.0) } else { t.clamp(0.0, 1.0) };
            self.polygon.off(self.curve.point(t), k)
        };
        let here = off(t);
        if here.coords.norm() <= room || self.knots.corners.contains(&t) {
            return here.coords.norm() <= room;
        }
        let step = AROUND / self.polygon.edges() as f64 / f64::from(CHORDS);
        let chord = |a: Point, b: Point| segment_distance(Point::origin(), a, b) <= room;
        let (mut before, mut after) = (here, here);
        (1..=CHORDS).any(|i| {
            let (first, last) = (off(t - step * f64::from(i)), off(t + step * f64::from(i)));
            let near = chord(first, before) || chord(after, last);
            (before, after) = (first, last);
            near
        })
    }

    /// Whether the curve between two parameters leaves its room around the polygon.
    fn leaves_room(&self, a: f64, b: f64) -> bool {
        let Polygon { room, is_closed, .. } = &self.polygon;
        let (n, edges) = (self.polygon.uv.len(), self.polygon.edges());
        let count = (PLACES_AN_EDGE * (b - a) * edges as f64).ceil().max(2.0) as usize;
        (0..count).any(|i| {
            let t = a + (b - a) * (i as f64 + 0.5) / count as f64;
            let at = self.curve.point(t);
            let own = self.polygon.before(t).clamp(1, edges) - 1;
            let room = room[own].max(room[(own + 1) % n]);
            let jet = &self.polygon.jets[own];
            let corner = |k: usize| {
                let off = self.polygon.uv[k % n].coords - at;
                Point::from(jet.su * off.x + jet.sv * off.y)
            };
            let is_near =
                |k: usize| segment_distance(Point::origin(), corner(k), corner(k + 1)) <= room;
            // The own edge, and then those beside it in the order of their distance.
            let beside = (1..=SIDES as isize).flat_map(|by| [own as isize - by, own as isize + by]);
            let beside = beside.filter(|k| *is_closed || (0..edges as isize).contains(k));
            !is_near(own) && !beside.map(|k| k.rem_euclid(edges as isize) as usize).any(is_near)
        })
    }

    /// The span that contains `t` and its two neighbours, without those too short to be halved.
    fn spans_around(&self, t: f64) -> impl Iterator<Item = usize> + '_ {
        let n = self.knots.breaks.len();
        let i = self.knots.breaks.partition_point(|&b| b <= t).max(1) - 1;
        let least = SHORTEST_EVER / self.polygon.edges() as f64;
        let around = [i + n - 1, i, i + 1].into_iter().map(move |i| i % n);
        around.filter(move |&i| self.is_longer(i, least))
    }

    /// Halves spans and fits the curve again. `None`, with nothing changed, if the fit is singular.
    fn halve(&mut self, spans: impl IntoIterator<Item = usize>) -> Option<()> {
        let mut knots = self.knots.clone();
        let halves = spans.into_iter().map(|i| self.knots.span(i)).map(|(a, b)| 0.5 * (a + b));
        knots.breaks.extend(halves);
        knots.breaks.sort_by(f64::total_cmp);
        self.curve = nearest_curve(&self.polygon, &knots)?;
        self.knots = knots;
        Some(())
    }

    /// The curve, divided into clamped arcs from corner to corner. Long arcs are divided again
    /// at knots. A closed curve has at least two arcs, because an edge needs two different ends.
    pub(super) fn arcs(&self) -> Vec<Curve<2>> {
        let Knots { breaks, corners } = &self.knots;
        let mut ends = if corners.is_empty() { vec![0.0] } else { corners.clone() };
        let least = if self.polygon.is_closed && ends.len() < 2 { 2 } else { 1 };
        ends.push(1.0);
        let mut cuts = Vec::new();
        for w in ends.windows(2) {
            let inside = breaks.iter().copied().filter(|&t| w[0] < t && t < w[1]);
            let breaks: Vec<f64> = std::iter::once(w[0]).chain(inside).chain([w[1]]).collect();
            let mut ends = runs(&breaks, MOST_SPANS, least);
            ends.pop();
            cuts.extend(ends);
        }
        cuts.push(1.0);
        cuts.windows(2).map(|w| self.curve.part(w[0], w[1])).collect()
    }
}

/// The knots that a closed curve starts with: spans of about equal length between corners.
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
