//! A loop that is as fair as the uncertainty of its rim lets it be: it stays within some room
//! around the rim, in both directions, with as few knots as it can.

use super::closed::fit;
use super::course::Course;
use crate::geometry::{Point, segment_distance};

/// The curve is compared with the rim at so many places an edge of this, and with so many
/// edges each way: the rim is a polygon, and a fair curve passes its teeth near the middle.
const PLACES_AN_EDGE: f64 = 2.0;
const SIDES: usize = 3;

/// Of so many knots that follow each other one is taken out at a time, so that the spans
/// that this joins lie apart.
const STRIDE: usize = 3;

/// Rounds over all knots at the most. Each takes out about a third of what is left to take.
const ROUNDS: usize = 8;

/// A closed cubic needs as many spans.
const LEAST_SPANS: usize = 4;

/// Fits with other weights after a knot was taken out, at the most.
const PRESSES: usize = 3;

/// A vertex gets more weight from this share of its room on, at most so many times as much at
/// once, and at most so many times as much as others: the equations keep their digits.
const PRESSED: f64 = 0.85;
const MOST_PRESSURE: f64 = 9.0;
const MOST_WEIGHT: f64 = 1e3;

impl Course<'_> {
    /// The farthest that the curve between two parameters is from the rim, as a share of its
    /// room there, at places between the vertices.
    pub(super) fn leaves_rim(&self, a: f64, b: f64) -> f64 {
        self.places(a, b).map(|(share, _)| share).fold(0.0, f64::max)
    }

    /// Places between two parameters: how far the curve is from the rim there, as a share of
    /// its room, and the vertex before.
    fn places(&self, a: f64, b: f64) -> impl Iterator<Item = (f64, usize)> + '_ {
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
            let sides = (0..=2 * SIDES).map(|i| k + n * SIDES + i - SIDES);
            let off = sides.map(|i| segment_distance(Point::origin(), corner(i), corner(i + 1)));
            let room = self.room[k].max(self.room[(k + 1) % n]);
            (off.fold(f64::INFINITY, f64::min) / room, k)
        })
    }

    /// Gives vertices that the curve cannot come near enough to, however short its spans, the
    /// room that it takes.
    pub(super) fn take_room(&mut self) {
        let mut room = self.room.clone();
        for i in self.spans_beyond(0.0) {
            let (a, b) = self.span(i);
            let far = self.places(a, b).filter(|(share, _)| *share > 1.0);
            far.for_each(|(share, k)| room[k] = room[k].max(share * self.room[k]));
        }
        (0..room.len()).for_each(|k| room[k] = room[k].max(self.distance(k)));
        self.room = room;
    }

    /// Takes out knots, those at corners left, as long as the curve stays in its room.
    pub(super) fn thin(&mut self) {
        for _ in 0..ROUNDS {
            let before = self.knots.breaks.len();
            (0..STRIDE).for_each(|first| self.thin_from(first));
            if self.knots.breaks.len() == before {
                break;
            }
        }
    }

    /// The same for one knot of each few, from the `first` on.
    fn thin_from(&mut self, first: usize) {
        let (knots, curve) = (self.knots.clone(), self.curve.clone());
        let weights = self.polygon.weights.clone();
        let is_held = |t: &f64| *t == 0.0 || knots.corners.contains(t);
        let chosen = knots.breaks.iter().skip(first).step_by(STRIDE);
        let mut out: Vec<f64> = chosen.copied().filter(|t| !is_held(t)).collect();
        // Knots in and beside spans that leave their room are put back, until none does.
        while !out.is_empty() && knots.breaks.len() - out.len() >= LEAST_SPANS {
            self.knots.breaks.clone_from(&knots.breaks);
            self.knots.breaks.retain(|t| !out.contains(t));
            self.polygon.weights.clone_from(&weights);
            let Some(far) = self.pressed() else { break };
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

    /// Fits the curve over its knots, again with more weight on vertices that it is far from
    /// (Lawson's iteration towards the smallest maximum), and returns the ranges of the spans
    /// that leave their room all the same.
    fn pressed(&mut self) -> Option<Vec<(f64, f64)>> {
        self.curve = fit(&self.polygon, &self.knots)?;
        let mut far = self.spans_beyond(0.0);
        for _ in 0..PRESSES {
            if far.is_empty() {
                break;
            }
            for k in 0..self.room.len() {
                let share = self.distance(k) / (PRESSED * self.room[k]);
                if share > 1.0 {
                    let weight = &mut self.polygon.weights[k];
                    *weight = (*weight * share.powi(2).min(MOST_PRESSURE)).min(MOST_WEIGHT);
                }
            }
            self.curve = fit(&self.polygon, &self.knots)?;
            far = self.spans_beyond(0.0);
        }
        Some(far.into_iter().map(|i| self.span(i)).collect())
    }
}
