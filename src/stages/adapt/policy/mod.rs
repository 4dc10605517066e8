//! The order of the moves for each goal: [`tolerance`] for one that the user named, [`noise`] for
//! one that nobody named. What follows is the same for both: parameters are corrected over the
//! last knots, folds are taken out ([`folds`]), and the surface is held between its points
//! ([`triangles`]).

mod folds;
mod hindrance;
pub(super) mod noise;
mod tolerance;
mod triangles;

use super::attempt::Attempt;
use super::moves::correct::{FIRM_AREA, correct};
use super::moves::remove::remove;
use super::report::Folds;
use super::run::FitRun;
use super::state::State;
use super::work::{MOST_FOR_FEWER_KNOTS, MOST_FOR_MORE_KNOTS};
use crate::error::Result;
use crate::stages::fit;

/// The share of points or triangles beyond a tolerance from which on neither weights nor gentler
/// ways bring them back, but knots alone. Fits of real scans leave at most 2 % of the triangles,
/// those of crumpled needles most.
const HOPELESS: f64 = 0.1;

/// The share of points beyond the tolerance that is few: mends, which are local, may still bring them
/// back, and if nobody named the tolerance, a surface without folds may lose them. Nobody asked for these
/// points, while CAD cannot offset a surface that folds.
const FEW_POINTS: f64 = 0.01;

/// The most rounds in which knots are inserted for a surface without folds, or for one that keeps to
/// triangles. It bounds the time, as fits or mends follow each round.
const MOST_ROUNDS: usize = 4;

/// The most rounds in a row that gain nothing. A round may insert a few knots only, and several such
/// rounds may come before one that gains.
const PATIENCE: usize = 5;

/// What leaves more than this share is as before: at 5 % a round, halving takes over a dozen fits.
const SAME: f64 = 0.95;

/// The share of the knot lines that is removed at first. A quarter may fail where an eighth does
/// not, and then half as much is tried.
const FIRST_REMOVED: f64 = 0.25;

/// The share of the knot lines that is not worth another fit.
const LEAST_REMOVED: f64 = 0.02;

/// The most corrections of the parameters over knots that stay, which bounds the time where each
/// of them pays.
const MOST_CORRECTIONS: usize = 5;

/// A correction that leaves more than this share of the rms is the last one: the next would gain
/// less than 3 % for the time of a fit.
const LEAST_GAIN: f64 = 0.97;

/// Looks for knots over which a fit reaches the goal, unless the user named them.
pub(crate) fn search(run: &mut FitRun, state: State) -> Result<Attempt> {
    let options = run.problem.options;
    let mut best = run.fit(state)?;
    if options.knots.are_searched() {
        best = match run.problem.goal.named {
            true => tolerance::search(run, best)?,
            false => noise::search(run, best)?,
        };
    }
    match options.method {
        fit::Method::Blend => Ok(best),
        _ => correct_parameters(run, best),
    }
}

/// Goes on from an attempt over the map as it was before it got more vertices.
pub(crate) fn go_on(run: &mut FitRun, before: Attempt) -> Result<Attempt> {
    let mut state = State { knots: before.state.knots, ..State::new(run.problem) };
    let weights = state.weights.iter_mut().zip(&before.state.weights);
    weights.for_each(|(weight, before)| *weight = *before);
    let mut best = run.fit(state)?;
    if run.problem.goal.named && run.problem.options.knots.are_searched() {
        best = tolerance::insert_knots(run, best)?;
    }
    correct_parameters(run, best)
}

/// The surface without folds as far as the goal allows, and without leaving the mesh between its
/// points. The folds of blended local fits stay.
pub(crate) fn finish(run: &mut FitRun, best: Attempt) -> Result<(Attempt, Option<Folds>)> {
    if run.problem.options.method == fit::Method::Blend {
        return Ok((best, None));
    }
    let (best, inverted) = folds::take_out(run, best)?;
    let (best, inverted) = triangles::hold(run, best, inverted);
    let samples = fit::jacobian_samples([&best.surface.u, &best.surface.v]);
    Ok((best, Some(Folds { inverted, samples })))
}

/// Corrects the parameters over the same knots as long as it pays.
fn correct_parameters(run: &mut FitRun, start: Attempt) -> Result<Attempt> {
    let problem = run.problem;
    let mut best = start;
    for _ in 0..MOST_CORRECTIONS {
        if run.work.exceeds(problem, MOST_FOR_MORE_KNOTS) {
            break;
        }
        let next = run.fit(correct(problem, &best, FIRM_AREA))?;
        // Outliers of the one count for neither.
        let before = best.foot_points.rms_without(&next.state.outliers);
        let after = next.rms();
        if best.is_met(problem) && !next.is_met(problem) || after >= before {
            break;
        }
        best = next;
        if after > LEAST_GAIN * before {
            break;
        }
    }
    Ok(best)
}

/// Removes knot lines as long as what `fit` makes without them is to be kept, given the best
/// attempt so far and the new one.
fn remove_knots(
    run: &mut FitRun,
    start: Attempt,
    fit: impl Fn(&mut FitRun, State) -> Result<Attempt>,
    is_kept: impl Fn(&Attempt, &Attempt) -> bool,
) -> Result<Attempt> {
    let mut best = start;
    let mut share = FIRST_REMOVED;
    while share >= LEAST_REMOVED && !run.work.exceeds(run.problem, MOST_FOR_FEWER_KNOTS) {
        let Some(state) = remove(run.problem, &best, share) else { break };
        let next = fit(run, state)?;
        if is_kept(&best, &next) {
            best = next;
        } else {
            share *= 0.5;
        }
    }
    Ok(best)
}
