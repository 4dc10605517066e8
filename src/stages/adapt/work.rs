//! The work that a named tolerance may take, in counted units, so that it ends at the same place on every machine.
//!
//! The bound is a multiple of the work of a run whose tolerance nobody names. Such a run stops at the net that is worth
//! its noise. The fits of a named tolerance pass this net on their way, and so they tell its size.

use super::attempt::Attempt;
use super::policy::noise::score;
use super::problem::Problem;

/// The work of a fit for a control point, in multiples of that for a point. The times of fits to scans of
/// 25,000 points over 11,000 control points and of 44,000 points over 2,500 agree with it.
const CONTROL_POINT: f64 = 4.0;

/// The work of a mend, or of taking folds out in one way, in fits. They also solve for the whole net.
pub(super) const MEND: f64 = 1.0;

/// The fits of a run whose tolerance nobody names: 10 to 14 on scans of all kinds.
const FITS: f64 = 12.0;

/// From how many such runs on a named tolerance gets no fits for fewer knots.
pub(super) const MOST_FOR_FEWER_KNOTS: f64 = 2.0;

/// The same for more knots.
pub(super) const MOST_FOR_MORE_KNOTS: f64 = 2.5;

/// The same for mends between points, which come last.
pub(super) const MOST: f64 = 3.0;

/// The work that was done.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Work {
    done: f64,
    /// The net that is worth its noise: its score and the number of its control points.
    worth: Option<(f64, usize)>,
    /// Whether the bound has ended anything.
    pub is_spent: bool,
}

impl Work {
    /// Counts a fit, and remembers its net if it is worth more than those before.
    pub(super) fn count(&mut self, problem: &Problem, of: &Attempt) {
        self.add(problem, of, 1.0);
        // Nothing else has a bound.
        if !problem.goal.named || problem.options.worth <= 0.0 {
            return;
        }
        let score = score(problem, of, problem.options.worth);
        if self.worth.is_none_or(|worth| score < worth.0) {
            self.worth = Some((score, of.surface.net.len()));
        }
    }

    /// Adds the work of so many fits over the net of an attempt.
    pub(super) fn add(&mut self, problem: &Problem, of: &Attempt, fits: f64) {
        self.done += fits * of_net(problem, of.surface.net.len());
    }

    /// Whether the work for a named tolerance has passed that of so many `runs` without one. It is then spent.
    pub(super) fn exceeds(&mut self, problem: &Problem, runs: f64) -> bool {
        let Some((_, net)) = self.worth else { return false };
        let largest = problem.options.knots.largest_worth(problem.measured());
        let run = FITS * of_net(problem, net.min(largest));
        let exceeds = self.done > runs * run;
        self.is_spent |= exceeds;
        exceeds
    }
}

/// The work of a fit with so many control points.
fn of_net(problem: &Problem, net: usize) -> f64 {
    problem.measured() as f64 + CONTROL_POINT * net as f64
}
