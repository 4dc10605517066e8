//! Knot removal for fair loops.
//!
//! The input is a loop that follows its rim closely. The output is a loop with as few knots as
//! possible that stays within its room around the rim: every vertex is near the curve, and every
//! point of the curve is near the rim. After each removal the vertices are reweighted by Lawson's
//! iteration.

use super::closed::fit;
use super::loop_fit::LoopFit;
use crate::geometry::{MOST_ROUNDS, Point, segment_distance};

/// The number of points of the curve for each edge of the rim that are compared with the rim.
const PLACES_AN_EDGE: f64 = 2.0;

/// The number of edges in each direction that a point of the curve is compared with. A fair curve
/// passes the teeth of the polygon near the middle, so that the nearest edge can be a neighbour.
const SIDES: usize = 3;

/// In one step, one of this many consecutive knots is removed, so that the joined spans are not
/// neighbours.
const STRIDE: usize = 3;

/// A closed cubic spline needs at least this many spans.
pub(super) const MIN_SPANS: usize = 4;

/// The largest number of fits with new weights after knots were removed.
const REWEIGHTINGS: usize = 3;

/// A vertex gets more weight if its distance from the curve exceeds this share of its room.
const REWEIGHTED_FROM: f64 = 0.85;

/// The largest factor by which the weight of a vertex grows at once.
const MAX_FACTOR: f64 = 9.0;

/// The largest weight of a vertex, where 1 is the weight at the start. The bound keeps the
/// equations well conditioned.
const MAX_WEIGHT: f64 = 1e3;

impl LoopFit<'_> {
    /// Whether the curve between two parameters leaves its room around the rim.
    pub(super) fn leaves_room(&self, a: f64, b: f64) -> bool {
        self.places(a, b, 1.0).any(|(share, _)| share > 1.0)
    }

    /// Points of the curve between two parameters. Each item has the distance of the point from
    /// the rim, as a share of its room, and the vertex before it. A share that is not above `enough` may be larger
    /// than it is, but not above `enough`. It is found sooner, because the nearest edge is mostly the first one.
    fn places(&self, a: f64, b: f64, enough: f64) -> impl Iterator<Item = (f64, usize)> + '_ {
        let n = self.polygon.uv.len();
        let count = (PLACES_AN_EDGE * (b - a) * n as f64).ceil().max(2.0) as usize;
        let place = move |i: usize| a + (b - a) * (i as f64 + 0.5) / count as f64;
        (0..count).map(place).map(move |t| {
            let k = (self.polygon.before(t) + n - 1) % n;
            let (jet, at) = (&self.jets[k], self.curve.point(t));
            let corner = |i: usize| {
                let off = self.polygon.uv[i % n].coords - at;
                Point::from(jet.su * off.x + jet.sv * off.y)
            };
            let room = self.room[k].max(self.room[(k + 1) % n]);
            let share =
                |i: usize| segment_distance(Point::origin(), corner(i), corner(i + 1)) / room;
            let own = k + n * SIDES;
            let mut least = share(own);
            for i in 1..=SIDES {
                if least <= enough {
                    break;
                }
                least = least.min(share(own - i)).min(share(own + i));
            }
            (least, k)
        })
    }

    /// Widens the room of vertices that the curve does not come near enough to even with its
    /// shortest spans.
    pub(super) fn widen_room(&mut self) {
        let mut room = self.room.clone();
        for i in self.spans_beyond(0.0) {
            let (a, b) = self.span(i);
            let far = self.places(a, b, 1.0).filter(|(share, _)| *share > 1.0);
            far.for_each(|(share, k)| room[k] = room[k].max(share * self.room[k]));
        }
        (0..room.len()).for_each(|k| room[k] = room[k].max(self.distance(k)));
        self.room = room;
    }

    /// Removes knots as long as the curve stays in its room. Knots at corners stay.
    pub(super) fn remove_knots(&mut self) {
        for _ in 0..MOST_ROUNDS {
            let before = self.knots.breaks.len();
            (0..STRIDE).for_each(|first| self.remove_every_third(first));
            if self.knots.breaks.len() == before {
                break;
            }
        }
    }

    /// Removes one of every [`STRIDE`] knots, beginning with knot `first`, as far as the curve
    /// stays in its room.
    fn remove_every_third(&mut self, first: usize) {
        let (knots, curve) = (self.knots.clone(), self.curve.clone());
        let weights = self.polygon.weights.clone();
        let is_held = |t: &f64| *t == 0.0 || knots.corners.contains(t);
        let chosen = knots.breaks.iter().skip(first).step_by(STRIDE);
        let mut out: Vec<f64> = chosen.copied().filter(|t| !is_held(t)).collect();
        // Put back the knots in and beside spans that leave their room, until no span does.
        while !out.is_empty() && knots.breaks.len() - out.len() >= MIN_SPANS {
            self.knots.breaks.clone_from(&knots.breaks);
            self.knots.breaks.retain(|t| !out.contains(t));
            self.polygon.weights.clone_from(&weights);
            let Some(far) = self.reweighted() else { break };
            if far.is_empty() {
                return;
            }
            let count = out.len();
            let beside = |t: f64, (a, b): (f64, f64)| 2.0 * a - b < t && t < 2.0 * b - a;
            out.retain(|&t| !far.iter().any(|&range| beside(t, range)));
            if out.len() == count {
                break;
            }
        }
        (self.knots, self.curve, self.polygon.weights) = (knots, curve, weights);
    }

    /// Fits the curve over its knots and repeats the fit with more weight on vertices that are far
    /// from it (Lawson's iteration, which tends to the smallest maximum). Returns the parameter
    /// ranges of the spans that still leave their room. `None` if a fit is singular.
    fn reweighted(&mut self) -> Option<Vec<(f64, f64)>> {
        self.curve = fit(&self.polygon, &self.knots)?;
        let mut far = self.spans_beyond(0.0);
        for _ in 0..REWEIGHTINGS {
            if far.is_empty() {
                break;
            }
            for k in 0..self.room.len() {
                let enough = REWEIGHTED_FROM * self.room[k];
                let share = self.distance_if_above(k, enough) / enough;
                if share > 1.0 {
                    let weight = &mut self.polygon.weights[k];
                    *weight = (*weight * share.powi(2).min(MAX_FACTOR)).min(MAX_WEIGHT);
                }
            }
            self.curve = fit(&self.polygon, &self.knots)?;
            far = self.spans_beyond(0.0);
        }
        Some(far.into_iter().map(|i| self.span(i)).collect())
    }
}
