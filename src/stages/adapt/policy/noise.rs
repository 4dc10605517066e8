//! The policy for a goal that nobody named: knots are weighed against the noise. A control point
//! must take more off the misfit than it adds to what is fitted of the noise (Akaike 1974).
//!
//! With noise of a known standard deviation σ the best of several nets is that with
//! the smallest Σ (d/σ)² + 2 n, over the distances d of all points, for n
//! control points, each of which moves in one direction that matters. Points that were
//! smoothed stand for those measured: the noise that smoothing took off is the same for
//! all nets.

use super::{remove_knots, tolerance};
use crate::error::Result;
use crate::rules;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::moves::insert::insert;
use crate::stages::adapt::moves::reject;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::run::FitRun;
use crate::stages::knots::{InsertionLimits, Miss};
use crate::statistics::outlying;

/// What a control point must take off the sum of squares, in variances of the noise (Akaike).
const PRICE: f64 = 2.0;

/// The rounds in a row without a better score after which there are no more. One worse net may
/// come before a better one; each takes longer to fit than the best.
const PATIENCE: usize = 2;

/// Inserts knots and removes knots as long as the score falls. Where smoothed points are beyond
/// the tolerance after that, knots are inserted as for a named one; where smoothing is off, such
/// points may be outliers.
pub(crate) fn search(run: &mut FitRun, start: Attempt) -> Result<Attempt> {
    let problem = run.problem;
    let best = insert_knots(run, start)?;
    let worth = |of: &Attempt| score(problem, of, problem.goal.noise());
    let is_better = |best: &Attempt, next: &Attempt| worth(next) < worth(best);
    let best = remove_knots(run, best, |run, state| run.fit(state), is_better)?;
    match problem.options.noise > 0.0 {
        true => Ok(best),
        false => tolerance::insert_knots(run, best),
    }
}

/// The most control points if nobody named a tolerance.
pub(crate) fn largest_net(problem: &Problem) -> usize {
    problem.options.knots.largest_net_for(problem.goal, problem.measured())
}

/// Inserts knots as long as they bring more than they cost.
fn insert_knots(run: &mut FitRun, start: Attempt) -> Result<Attempt> {
    let problem = run.problem;
    let depth = problem.options.knots.depth;
    let bounds = InsertionLimits {
        depth: depth.unwrap_or(rules::MOST_HALVINGS),
        most: largest_net(problem),
        price: PRICE,
    };
    let mut best = start;
    let mut last: Option<Attempt> = None;
    let mut idle = 0;
    while idle < PATIENCE {
        let now = last.as_ref().unwrap_or(&best);
        let misses = misfits(problem, now);
        let Some(state) = insert(problem, now, &misses, &bounds) else { break };
        let next = run.fit(state)?;
        let noise = problem.goal.noise();
        if score(problem, &next, noise) < score(problem, &best, noise) {
            (best, last, idle) = (next, None, 0);
        } else {
            (last, idle) = (Some(next), idle + 1);
        }
    }
    Ok(best)
}

/// The score of an attempt for a standard deviation of the noise; the smallest is the best.
pub(crate) fn score(problem: &Problem, of: &Attempt, noise: f64) -> f64 {
    let misfit: f64 = squares(problem, of, noise).sum();
    misfit + PRICE * of.surface.net.len() as f64
}

/// Where the measured vertices are, and the squares of their distances; 0 for outliers.
fn misfits(problem: &Problem, of: &Attempt) -> Vec<Miss> {
    let squares = squares(problem, of, problem.goal.noise()).zip(&of.state.uv);
    let mut all: Vec<Miss> = squares.map(|(square, &uv)| (uv, square)).collect();
    let outliers = reject::outliers(problem, &of.foot_points.distances);
    outliers.into_iter().for_each(|v| all[v].1 = 0.0);
    all
}

/// The squares of the measured vertices' distances, in variances of the noise, as often as vertices of
/// the scan stand behind them. Points that are as far off as outliers count no more than these: a few
/// of them are not the shape's.
fn squares(problem: &Problem, of: &Attempt, noise: f64) -> impl Iterator<Item = f64> {
    let far = outlying(problem.measured());
    let square = move |d: f64| (d / noise).min(far).powi(2);
    of.foot_points.measured().zip(&problem.counts).map(move |(d, count)| count * square(d))
}
