//! The fit of one trim loop.
//!
//! The input is a rim and the surface. The output is a closed curve in (u, v) whose knots are dense
//! where the rim needs them: spans are halved until the curve stays in its room around the rim.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::closed::{ClosedKnots, ClosedPolygon, arcs, fit};
use super::{Options, Rim, corners, needles};
use crate::geometry::{MOST_ROUNDS, NEGLIGIBLE, Point, Uv, segment_distance};
use crate::spline::{Curve, Jet, Surface, foot_point};

/// The number of spans that a loop starts with.
const FIRST_SPANS: f64 = 6.0;

/// The shortest span, as a share of a mean edge of the rim. The tip of a tooth is rounded over one
/// span.
const SHORTEST_OF_EDGE: f64 = 0.0125;

/// The shortest span, as a share of the tolerance. It applies where this is shorter than
/// [`SHORTEST_OF_EDGE`].
const SHORTEST_OF_TOLERANCE: f64 = 0.125;

/// The shortest span of a loop that need not follow every tooth, as a share of a mean edge. Spans
/// of a tenth of an edge pass every vertex at a fraction of an edge.
const SHORTEST_FAIR: f64 = 0.1;

/// The shortest span of all, as a share of a mean edge. It applies where the loop would cross
/// itself or another loop, and where the tolerance is extremely small.
const SHORTEST_EVER: f64 = 1e-3;

/// The nearest point of the curve is searched within this many mean edges in each direction.
const AROUND: f64 = 3.0;

/// The number of chords in each direction on which the nearest point is searched.
const CHORDS: i32 = 24;

/// The largest number of additional corners. If more are needed, needles are removed instead.
const MAX_SHARP: usize = 32;

/// The current state of a loop.
#[derive(Debug, Clone)]
pub(crate) struct LoopFit<'a> {
    surface: &'a Surface,
    rim: Cow<'a, Rim>,
    pub(super) polygon: ClosedPolygon,
    /// The surface and its derivatives at the polygon's corners.
    pub(super) jets: Vec<Jet>,
    /// How far the curve may be from each corner, measured on the surface in mm.
    pub(super) room: Vec<f64>,
    pub(super) knots: ClosedKnots,
    /// The length of the shortest span, as a difference of parameters.
    shortest: f64,
    /// The position of the rim's vertex at parameter 0.
    first: usize,
    /// Whether the polygon consists of the parameter points of the map instead of foot points.
    on_map: bool,
    /// Vertices of the rim at which the loop has a corner although corner detection found none.
    sharp: Vec<usize>,
    pub(super) curve: Curve<2>,
    /// Whether the curve has as few knots as its room allows.
    is_fair: bool,
    /// The knots and the curve before knots were removed.
    before_removal: Option<(ClosedKnots, Curve<2>)>,
}

impl<'a> LoopFit<'a> {
    /// Fits the loop of a rim. `None` if the rim is a single point.
    pub fn new(surface: &'a Surface, rim: &'a Rim, options: &Options) -> Option<Self> {
        LoopFit::around(surface, Cow::Borrowed(rim), options, false, Vec::new())
    }

    /// Fits the loop to the foot points of the rim's vertices, or, if `on_map`, to the parameter
    /// points that the map gave them. The foot points of a ragged rim can cross each other, but
    /// the points of the map cannot.
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
        let knots = ClosedKnots { breaks: first_breaks(&corners), corners };
        let jets = uv.iter().map(|&at| surface.jet(at)).collect();
        let weights = vec![1.0; uv.len()];
        let polygon = ClosedPolygon { parameters, uv, weights };
        let curve = fit(&polygon, &knots)?;
        let edge = 1.0 / polygon.uv.len() as f64;
        let shortest = match options.is_fair() && !options.keeps_vertices {
            true => SHORTEST_FAIR * edge,
            false => (SHORTEST_OF_EDGE * edge)
                .min(SHORTEST_OF_TOLERANCE * options.tolerance / total)
                .max(SHORTEST_EVER * edge),
        };
        let mut loop_fit = LoopFit {
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
            before_removal: None,
        };
        loop_fit.follow();
        if loop_fit.is_fair {
            let before_removal = (loop_fit.knots.clone(), loop_fit.curve.clone());
            loop_fit.widen_room();
            loop_fit.remove_knots();
            loop_fit.before_removal = Some(before_removal);
        }
        Some(loop_fit)
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

    /// The arcs of the loop in the parameter plane.
    pub(crate) fn arcs(&self) -> Vec<Curve<2>> {
        arcs(&self.curve, &self.knots)
    }

    /// The rim's vertex that follows a parameter.
    pub fn vertex(&self, t: f64) -> Point {
        let n = self.rim.points.len();
        self.rim.points[(self.first + self.polygon.before(t).min(n - 1)) % n]
    }

    /// Makes the loop follow its rim more closely around the parameters `places`, where it has a
    /// fault. It takes the first of these measures that is possible:
    /// 1. It restores the knots that were removed.
    /// 2. It halves the spans around the places.
    /// 3. It fits the loop to the parameter points of the map.
    /// 4. It adds a corner at the first place, which may be the tip of a slit.
    /// 5. It removes needles from the rim.
    ///
    /// `None` if none of them is possible.
    pub(crate) fn tighten(&mut self, places: &[Option<f64>], options: &Options) -> Option<()> {
        if let Some((knots, curve)) = self.before_removal.take() {
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
        let new_tip = tip.filter(|tip| !self.sharp.contains(tip) && self.sharp.len() < MAX_SHARP);
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
        *self = LoopFit::around(self.surface, rim, options, true, sharp)?;
        Some(())
    }

    /// The rim's vertex nearest to a parameter, before or after it.
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

    /// The spans that leave their room and whose halves would be longer than `least`. A vertex at a
    /// knot, for example at a corner, belongs to the spans on both sides.
    pub(super) fn spans_beyond(&self, least: f64) -> Vec<usize> {
        let n = self.polygon.uv.len();
        let far = |&i: &usize| {
            let (a, b) = self.span(i);
            let end = self.polygon.before(b);
            let at_end = self.polygon.parameters[end % n] == b.fract();
            let mut held = (self.polygon.before(a)..end).chain(at_end.then_some(end % n));
            self.is_longer(i, least)
                && (held.any(|k| self.distance_if_above(k, self.room[k]) > self.room[k])
                    || self.is_fair && self.leaves_room(a, b))
        };
        (0..self.knots.breaks.len()).filter(far).collect()
    }

    /// Whether the halves of span `i` are longer than `least`.
    fn is_longer(&self, i: usize, least: f64) -> bool {
        let (a, b) = self.span(i);
        b - a > 2.0 * least
    }

    /// The distance in mm of corner `k` of the polygon from the curve on the surface: the distance
    /// at its own parameter, or the smallest one nearby.
    pub(super) fn distance(&self, k: usize) -> f64 {
        self.distance_if_above(k, 0.0)
    }

    /// The same, or some distance that is not above `enough` if the distance is not. This is found sooner,
    /// because the search begins at the corner's own parameter.
    pub(super) fn distance_if_above(&self, k: usize, enough: f64) -> f64 {
        let t = self.polygon.parameters[k];
        let off = |t: f64| {
            let at = self.surface.clamp(self.curve.point(t.rem_euclid(1.0)).into());
            Point::from(self.surface.point(at) - self.jets[k].s)
        };
        let here = off(t);
        let same = here.coords.norm();
        if same <= self.room[k] || self.knots.corners.contains(&t) {
            return same;
        }
        let around = AROUND / self.polygon.uv.len() as f64;
        let place = |i: i32| off(t + around * f64::from(i) / f64::from(CHORDS));
        let chord = |a: Point, b: Point| segment_distance(Point::origin(), a, b);
        let (mut before, mut after, mut least) = (here, here, same);
        for i in 1..=CHORDS {
            let (first, last) = (place(-i), place(i));
            least = least.min(chord(first, before)).min(chord(after, last));
            if least <= enough {
                break;
            }
            (before, after) = (first, last);
        }
        least
    }

    /// The span that contains `t` and its two neighbours, without those too short to be halved.
    fn spans_around(&self, t: f64) -> impl Iterator<Item = usize> + '_ {
        let n = self.knots.breaks.len();
        let i = self.knots.breaks.partition_point(|&b| b <= t).max(1) - 1;
        let least = SHORTEST_EVER / self.polygon.uv.len() as f64;
        let around = [i + n - 1, i, i + 1].into_iter().map(move |i| i % n);
        around.filter(move |&i| self.is_longer(i, least))
    }

    /// Halves spans and fits the curve again. `None`, with nothing changed, if the fit is singular.
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

/// The knots that a loop starts with: spans of about equal length between corners.
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

/// The lengths along a closed polygon from point 0 to each point, and the total length. `None` if
/// the total is not a positive finite number. Coincident points get a small distance.
fn lengths(points: &[Point]) -> Option<(Vec<f64>, f64)> {
    let n = points.len();
    let side = |i: usize| (points[(i + 1) % n] - points[i]).norm();
    let around: f64 = (0..n).map(side).sum();
    let least = NEGLIGIBLE * around / n as f64;
    let mut walked = Vec::with_capacity(n);
    let mut total = 0.0;
    for i in 0..n {
        walked.push(total);
        total += side(i).max(least);
    }
    (total > 0.0 && total.is_finite()).then_some((walked, total))
}
