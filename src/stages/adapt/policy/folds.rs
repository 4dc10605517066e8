//! Surfaces without folds that keep the goal.

use super::{FEW_POINTS, HOPELESS, MOST_ROUNDS, tolerance};
use crate::error::Result;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::moves::correct::{FIRM_AREA, correct};
use crate::stages::adapt::moves::insert::finer_knots;
use crate::stages::adapt::moves::reweight::raise;
use crate::stages::adapt::moves::unfold::unfold;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::run::FitRun;
use crate::stages::adapt::state::State;
use crate::stages::adapt::work::{MEND, MOST, MOST_FOR_MORE_KNOTS};
use crate::stages::fit::STIFFNESSES;

/// What became of an attempt's folds.
struct UnfoldTrial {
    /// The fewest inverted Jacobian samples.
    inverted: usize,
    /// The attempt with these that keeps the goal, …
    found: Option<Attempt>,
    /// … or the last one that does not, but might.
    lost: Option<Attempt>,
}

/// Takes folds out as far as that does not lose the goal. If a named tolerance would be
/// lost, knots are inserted where it is. Returns how many Jacobian samples stay inverted, too.
pub(crate) fn take_out(run: &mut FitRun, start: Attempt) -> Result<(Attempt, usize)> {
    let problem = run.problem;
    let may_insert = problem.goal.named && problem.options.knots.are_searched();
    let mut finer: Option<Attempt> = None;
    let mut before = None;
    let mut best: Option<(Attempt, usize)> = None;
    for round in 0..=MOST_ROUNDS {
        let now = finer.as_ref().unwrap_or(&start);
        let UnfoldTrial { inverted, found, lost } = unfolded(run, now);
        before.get_or_insert(inverted);
        // Once there is a surface with fewer folds, knots are inserted one more time.
        let is_second = best.is_some();
        if let Some(found) = found
            && best.as_ref().is_none_or(|(_, least)| inverted < *least)
        {
            best = Some((found, inverted));
        }
        let is_done = inverted == 0 || is_second || round == MOST_ROUNDS;
        let pays = !is_done && may_insert && now.is_met(problem);
        let pays = pays && !run.work.exceeds(problem, MOST_FOR_MORE_KNOTS);
        let Some(lost) = lost.filter(|_| pays) else { break };
        let Some(next) = with_knots_for(run, now, lost)? else { break };
        finer = Some(next);
    }
    Ok(best.unwrap_or((start, before.unwrap_or(0))))
}

/// Fits `now` again, with more knots where the surface without folds has `lost` points, and with
/// the weights that these need. `None` if there are no knots to insert or the goal is not met.
fn with_knots_for(run: &mut FitRun, now: &Attempt, mut lost: Attempt) -> Result<Option<Attempt>> {
    let problem = run.problem;
    let tolerance = problem.goal.tolerance;
    let bounds = tolerance::bounds(problem);
    let Some(knots) = finer_knots(&lost, &lost.misses(&lost.state.uv, tolerance), &bounds) else {
        return Ok(None);
    };
    let next = run.fit(State { knots, ..correct(problem, now, FIRM_AREA) })?;
    let mut next = tolerance::insert_knots(run, next)?;
    if !next.is_met(problem) {
        return Ok(None);
    }
    raise(&mut lost.state.weights, &lost.foot_points, tolerance);
    let weights = next.state.weights.iter_mut().zip(&lost.state.weights);
    weights.for_each(|(weight, raised)| *weight = weight.max(*raised));
    Ok(Some(next))
}

/// Tries to take folds out over the same net; if a tolerance is named, in gentler
/// ways, too, that start with less stiffness and more weight on the points that are lost.
fn unfolded(run: &mut FitRun, start: &Attempt) -> UnfoldTrial {
    let problem = run.problem;
    let mut tried = UnfoldTrial { inverted: usize::MAX, found: None, lost: None };
    let mut start = start.clone();
    let ways = if problem.goal.named { STIFFNESSES.len() } else { 1 };
    for way in 0..ways {
        if let Some(lost) = &tried.lost {
            raise(&mut start.state.weights, &lost.foot_points, problem.goal.tolerance);
        }
        try_way(problem, &start, &STIFFNESSES[way..], &mut tried);
        let is_hopeless = tried.found.is_none() && tried.lost.is_none();
        run.work.add(problem, &start, MEND);
        if tried.inverted == 0 || is_hopeless || run.work.exceeds(problem, MOST) {
            break;
        }
    }
    tried
}

/// Tries one way to take folds out.
fn try_way(problem: &Problem, start: &Attempt, stiffnesses: &[f64], tried: &mut UnfoldTrial) {
    let given_up = if problem.goal.named { 0 } else { problem.share(FEW_POINTS) };
    let most = start.beyond(problem).0.max(problem.spared()) + given_up;
    let unfolded = unfold(problem, start, stiffnesses);
    tried.inverted = tried.inverted.min(unfolded.before);
    for (attempt, inverted) in unfolded.found {
        let beyond = attempt.beyond(problem).0;
        // Later ones are closer to the samples.
        if beyond > most {
            tried.lost = (beyond <= problem.share(HOPELESS)).then_some(attempt);
        } else if inverted <= tried.inverted {
            (tried.inverted, tried.found) = (inverted, Some(attempt));
        }
    }
}
