//! Reweighting (Lawson's iteration towards the smallest maximum): least squares leave single
//! points far off that the net could reach, and these get more weight.

use super::correct::correct;
use crate::stages::adapt::attempt::{Attempt, FootPoints};
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;
use crate::stages::adapt::weights::CORNER;

/// The largest factor of a weight at a time: that of a point five tolerances off. One that is
/// farther may be beyond the net's reach, and must not outvote all others at once.
pub(crate) const MOST_RAISE: f64 = 25.0;

/// The state of an attempt, corrected, with more weight on the measured points that are farther
/// than `limit`.
pub(crate) fn reweight(problem: &Problem, of: &Attempt, limit: f64, least_area: f64) -> State {
    let mut state = correct(problem, of, least_area);
    raise(&mut state.weights, &of.foot_points, limit);
    state
}

/// Multiplies the weights of measured points by the squares of their distances in limits.
pub(crate) fn raise(weights: &mut [f64], foot_points: &FootPoints, limit: f64) {
    for (weight, d) in weights.iter_mut().zip(foot_points.measured()).filter(|(_, d)| *d > limit) {
        *weight = (*weight * (d / limit).powi(2).min(MOST_RAISE)).min(CORNER);
    }
}
