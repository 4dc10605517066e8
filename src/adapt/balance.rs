//! How fine a net should be where nobody named a tolerance: a control point must take
//! more off the misfit than it adds to what is fitted of the noise (Akaike 1974).
//!
//! With noise of a known standard deviation σ the best of several nets is that with
//! the smallest Σ (d/σ)² + 2 n: of the distances d of all points, and the number n of
//! control points, each of which moves in one direction that matters. Points that were
//! smoothed stand for those measured: the noise that smoothing took off is the same for
//! all nets.

use super::deepest;
use super::search::{Attempt, Search};
use crate::error::Result;
use crate::knots::{self, InsertionLimits};

/// What a control point must take off the sum of squares, in variances of the noise.
const PRICE: f64 = 2.0;

/// Measured points a control point at the least: smoothing looks at dozens of points at
/// a time, so that nothing is left for finer nets to follow.
pub(super) const POINTS_A_CONTROL_POINT: usize = 2;

/// Halvings beyond those that leave one to four points of an even scan, where scans
/// are denser or the map is crushed.
const DEEPER: u32 = 2;

/// Fits that may follow each other without a better one.
const PATIENCE: usize = 2;

impl Search<'_> {
    /// The standard deviation of the noise, in mm.
    pub(super) fn noise(&self) -> f64 {
        self.goal.tolerance / super::TOLERANCE_OF_NOISE
    }

    /// The less, the better.
    fn score(&self, attempt: &Attempt) -> f64 {
        let misfit: f64 = attempt.feet.squares(self.noise()).sum();
        misfit + PRICE * attempt.surface.net.len() as f64
    }

    /// Control points at the most where nobody named a tolerance.
    pub(super) fn most_for_noise(&self) -> usize {
        self.options.knots.max_net.min(self.target.measured() / POINTS_A_CONTROL_POINT)
    }

    /// Puts in knots as long as they bring more than they cost.
    pub fn enrich(&mut self, start: Attempt) -> Result<Attempt> {
        let asked = &self.options.knots;
        let measured = self.target.measured();
        let bounds = InsertionLimits {
            depth: asked.depth.unwrap_or_else(|| deepest(measured) + DEEPER),
            most: self.most_for_noise(),
            price: PRICE,
        };
        let mut best = start;
        let mut last: Option<Attempt> = None;
        let mut idle = 0;
        while idle < PATIENCE {
            let now = last.as_ref().unwrap_or(&best);
            self.doubt(now);
            let misses = self.target.squares(&now.feet, self.noise());
            let knots = knots::insert(&now.surface, &misses, self.target.reach(), &bounds);
            if knots == [now.surface.u.clone(), now.surface.v.clone()] {
                break;
            }
            self.resume(now);
            let next = self.attempt(knots)?;
            if self.score(&next) < self.score(&best) {
                (best, last, idle) = (next, None, 0);
            } else {
                (last, idle) = (Some(next), idle + 1);
            }
        }
        Ok(best)
    }

    /// Takes out knot lines that bring less than they cost.
    pub fn thin(&mut self, start: Attempt) -> Result<Attempt> {
        self.take_out(start, |search, best, next| search.score(next) < search.score(best))
    }
}
