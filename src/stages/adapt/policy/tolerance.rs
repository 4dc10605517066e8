//! The policy for a named tolerance: more weight on the points that are missed, more knots where
//! that is not enough, and then as few knots as keep the tolerance.

use super::{HOPELESS, PATIENCE, SAME, hindrance, noise, remove_knots};
use crate::error::Result;
use crate::rules;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::moves::correct::{FIRM_AREA, correct};
use crate::stages::adapt::moves::insert::finer_knots;
use crate::stages::adapt::moves::reweight::reweight;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::run::FitRun;
use crate::stages::adapt::state::State;
use crate::stages::adapt::work::MOST_FOR_MORE_KNOTS;
use crate::stages::knots::InsertionLimits;

/// The most times that weights are raised over the same knots. Each takes a fit, after which more
/// knots can help as well.
const MOST_REWEIGHTED: usize = 3;

/// Weights are raised again if they leave no more than this share of the points beyond the
/// tolerance. A fit that brings back fewer of them is better spent on more knots.
const REWEIGHTING_PAYS: f64 = 0.7;

/// Inserts knots until the tolerance is met, and then removes those that it does not need.
pub(crate) fn search(run: &mut FitRun, start: Attempt) -> Result<Attempt> {
    let problem = run.problem;
    let best = insert_knots(run, start)?;
    match best.is_met(problem) {
        true => remove_knots(run, best, fit_reweighted, |_, next| next.is_met(problem)),
        false => Ok(best),
    }
}

/// Inserts knots where points are missed until the tolerance is met or nothing helps.
pub(crate) fn insert_knots(run: &mut FitRun, start: Attempt) -> Result<Attempt> {
    let problem = run.problem;
    let mut best = reweighted(run, start)?;
    let mut last: Option<Attempt> = None;
    let mut idle = 0;
    loop {
        let now = last.as_ref().unwrap_or(&best);
        let is_spent = run.work.exceeds(problem, MOST_FOR_MORE_KNOTS);
        if now.is_met(problem) || idle >= PATIENCE || is_spent {
            break;
        }
        run.hindrance = hindrance::hindering_noise(problem, now);
        if run.hindrance.is_some() {
            break;
        }
        let state = correct(problem, now, FIRM_AREA);
        let misses = now.misses(&state.uv, problem.goal.tolerance);
        let Some(knots) = finer_knots(now, &misses, &bounds(problem)) else { break };
        let next = fit_reweighted(run, State { knots, ..state })?;
        let (after, before) = (next.beyond(problem), best.beyond(problem));
        let has_gained = after.0 as f64 <= SAME * before.0 as f64 || after.1 <= SAME * before.1;
        idle = if has_gained { 0 } else { idle + 1 };
        if after < before {
            (best, last) = (next, None);
        } else {
            last = Some(next);
        }
    }
    Ok(best)
}

/// What bounds the knots that are inserted where points are missed.
pub(crate) fn bounds(problem: &Problem) -> InsertionLimits {
    let asked = &problem.options.knots;
    InsertionLimits {
        depth: asked.depth.unwrap_or(rules::MOST_HALVINGS),
        most: if problem.goal.named { asked.largest_net() } else { noise::largest_net(problem) },
        price: 0.0,
    }
}

fn fit_reweighted(run: &mut FitRun, state: State) -> Result<Attempt> {
    let attempt = run.fit(state)?;
    reweighted(run, attempt)
}

/// Raises the weights of the points that a surface misses as long as that brings them back.
fn reweighted(run: &mut FitRun, mut best: Attempt) -> Result<Attempt> {
    let problem = run.problem;
    let few = problem.share(HOPELESS);
    for _ in 0..MOST_REWEIGHTED {
        let before = best.beyond(problem).0;
        if best.is_met(problem) || before > few {
            break;
        }
        let next = run.fit(reweight(problem, &best, problem.goal.tolerance, FIRM_AREA))?;
        if next.beyond(problem).0 as f64 > REWEIGHTING_PAYS * before as f64 {
            break;
        }
        best = next;
    }
    Ok(best)
}
