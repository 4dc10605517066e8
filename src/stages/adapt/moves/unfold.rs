//! Taking folds out of an attempt's surface over the same net.

use super::correct::{LEAST_AREA, correct};
use crate::geometry::Uv;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::problem::Problem;
use crate::stages::fit;

/// What came of it.
pub(crate) struct WithoutFolds {
    /// How many Jacobian samples of the surface are inverted.
    pub before: usize,
    /// Attempts with fewer, each closer to the points than those before it, and how many
    /// Jacobian samples of each are inverted.
    pub found: Vec<(Attempt, usize)>,
}

/// Spreads the control points around folds, with one of the `stiffnesses` after the other.
pub(crate) fn unfold(problem: &Problem, of: &Attempt, stiffnesses: &[f64]) -> WithoutFolds {
    let state = correct(problem, of, LEAST_AREA);
    let slide = |now: Vec<Uv>, wanted: Vec<Uv>| state.slid(problem, now, wanted);
    let samples = state.samples(problem);
    let holds = state.holds(problem);
    let unfolded = fit::unfold(&of.surface, &samples, &holds, &slide, stiffnesses);
    let attempt = |found: fit::UnfoldedSurface| {
        (Attempt::moved(problem, &state, found.surface, found.uv, of.fit), found.folds)
    };
    WithoutFolds {
        before: unfolded.before,
        found: unfolded.found.into_iter().map(attempt).collect(),
    }
}

/// How many Jacobian samples of an attempt's surface are inverted.
pub(crate) fn inverted(problem: &Problem, of: &Attempt) -> usize {
    let state = correct(problem, of, LEAST_AREA);
    fit::inverted_samples(&of.surface, &state.vertices(problem), &problem.holds)
}
