//! Knots of a loop that it can do without.

use super::closed::fit;
use super::course::Course;

/// Of so many knots that follow each other one is taken out at a time, so that the spans
/// that this joins lie apart.
const STRIDE: usize = 3;

/// Rounds over all knots at the most. Each takes out about a third of what is left to take.
const ROUNDS: usize = 4;

const PRESSES: usize = 3;
const MOST_PRESSURE: f64 = 9.0;
const MOST_WEIGHT: f64 = 1e3;

/// A closed cubic needs as many spans.
const LEAST_SPANS: usize = 4;

impl Course<'_> {
    /// Takes out knots, those at corners left, as long as the spans that this joins stay in
    /// their room.
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
        let far_before = self.far_ranges();
        let is_held = |t: &f64| *t == 0.0 || knots.corners.contains(t);
        let chosen = knots.breaks.iter().skip(first).step_by(STRIDE);
        let mut out: Vec<f64> = chosen.copied().filter(|t| !is_held(t)).collect();
        // Knots in and beside spans that leave their room are put back, until none does.
        while !out.is_empty() && knots.breaks.len() - out.len() >= LEAST_SPANS {
            self.knots.breaks.clone_from(&knots.breaks);
            self.knots.breaks.retain(|t| !out.contains(t));
            let Some(thinner) = fit(&self.polygon, &self.knots) else { break };
            self.curve = thinner;
            let was_far = |(a, b): &(f64, f64)| far_before.iter().any(|(c, d)| c < b && a < d);
            let new = |far: Vec<(f64, f64)>| -> Vec<_> { far.into_iter().filter(|r| !was_far(r)).collect() };
            let mut far = new(self.far_ranges());
            self.polygon.weights.clone_from(&weights);
            for _ in 0..PRESSES {
                if far.is_empty() || self.press().is_none() {
                    break;
                }
                far = new(self.far_ranges());
            }
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

    /// Fits the curve again with more weight on the vertices that are beyond their room
    /// (Lawson's iteration towards the smallest maximum).
    fn press(&mut self) -> Option<()> {
        for k in 0..self.room.len() {
            let beyond = self.distance(k) / self.room[k];
            if beyond > 0.9 {
                let weight = &mut self.polygon.weights[k];
                *weight = (*weight * (1.2 * beyond).powi(2).min(MOST_PRESSURE)).min(MOST_WEIGHT);
            }
        }
        self.curve = fit(&self.polygon, &self.knots)?;
        Some(())
    }

    /// The ranges of the spans that leave their room.
    fn far_ranges(&self) -> Vec<(f64, f64)> {
        self.spans_beyond(0.0).into_iter().map(|i| self.span(i)).collect()
    }
}
