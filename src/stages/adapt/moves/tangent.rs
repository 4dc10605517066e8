//! A step by tangent distances (Wang, Pottmann, Liu, 2006): points may slide along the surface
//! that is fitted to them across it.

use super::correct::FIRM_AREA;
use super::reject;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;
use crate::stages::fit;

/// A step that leaves more than this share of the rms is idle: 7 % are not worth its solve.
const IDLE: f64 = 0.93;

/// The better one of an attempt and of the surface after one step, and whether the step was idle.
/// Both have their outliers rejected.
pub(crate) fn step(problem: &Problem, mut from: Attempt) -> (Attempt, bool) {
    from.state.outliers = reject::outliers(problem, &from.foot_points.distances);
    let state = State { uv: from.corrected(problem, FIRM_AREA), ..from.state.clone() };
    let samples = state.samples(problem);
    let mut stuck = problem.stuck(&state.uv, &from.foot_points);
    stuck.resize(samples.len(), false);
    let refit = fit::refit(&from.surface, &samples, &state.holds(problem), &stuck);
    let Some(mut surface) = refit else { return (from, false) };
    drop(samples);
    problem.pin_corners(&mut surface);
    let next = Attempt::new(problem, state, surface, from.fit);
    let (before, after) = (from.rms(), next.rms());
    (if after < before { next } else { from }, after > IDLE * before)
}
