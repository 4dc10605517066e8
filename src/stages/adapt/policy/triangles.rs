//! A surface that keeps a named tolerance between its points, too.
//!
//! Where a triangle spans several knot cells, a fit to the vertices leaves the surface free.
//! It is mended there until it keeps to the triangles, and gets knots where that is not enough.

use super::{FEW_POINTS, HOPELESS, MOST_ROUNDS, PATIENCE, tolerance};
use crate::deviation::MissedTriangle;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::inner::AIM;
use crate::stages::adapt::moves::correct::FIRM_AREA;
use crate::stages::adapt::moves::insert::finer_knots;
use crate::stages::adapt::moves::mend::{around, maker, mend};
use crate::stages::adapt::moves::unfold::inverted;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::run::FitRun;
use crate::stages::adapt::state::State;
use crate::stages::adapt::work::{MEND, MOST};

/// A triangle with so many knot cells in the mean is one of a needle that the map has drawn out
/// beyond all use: looking at all of them takes longer than all the fits.
const MOST_CELLS: f64 = 256.0;

/// Misses of an attempt.
struct Misses {
    /// Triangles that it leaves by more than the aim.
    left: Vec<MissedTriangle>,
    /// Vertices and triangles beyond the tolerance that are more than may be.
    count: usize,
}

/// Mends the surface in triangles that it leaves by more than a named tolerance. Takes and
/// returns how many of its Jacobian samples are inverted, too.
pub(crate) fn hold(run: &mut FitRun, start: Attempt, inverted_before: usize) -> (Attempt, usize) {
    let problem = run.problem;
    if !problem.goal.named || cells_a_triangle(problem, &start) > MOST_CELLS {
        return (start, inverted_before);
    }
    let misses = misses(problem, &start);
    if misses.count == 0 || is_hopeless(problem, &start, &misses) {
        return (start, inverted_before);
    }
    match best_mended(run, &start, misses) {
        Some(best) => {
            let inverted = inverted(problem, &best);
            (best, inverted)
        }
        None => (start, inverted_before),
    }
}

/// The attempt that misses least after mends, with more knots where these do not get further;
/// `None` if none misses less than the first one.
fn best_mended(run: &mut FitRun, start: &Attempt, mut misses: Misses) -> Option<Attempt> {
    let problem = run.problem;
    let (mut best, mut least, mut now) = (None, misses.count, start.clone());
    for round in 0..MOST_ROUNDS {
        let (mut idle, before) = (0, least);
        while least > 0 && idle < PATIENCE && !run.work.exceeds(problem, MOST) {
            let Some(next) = mend(problem, &now, &misses.left) else { break };
            run.work.add(problem, &next, MEND);
            (misses, now, idle) = (self::misses(problem, &next), next, idle + 1);
            if misses.count < least {
                (best, least, idle) = (Some(now.clone()), misses.count, 0);
            }
        }
        // More knots that do not help once do not help twice.
        let has_gained = round == 0 || least < before;
        if least == 0 || !has_gained || run.work.exceeds(problem, MOST) {
            break;
        }
        match with_knots(problem, &now, &misses.left) {
            Some(finer) if round + 1 < MOST_ROUNDS => now = finer,
            _ => break,
        }
    }
    best
}

/// How many knot cells, the narrowest ones, a measured triangle has in the mean.
fn cells_a_triangle(problem: &Problem, of: &Attempt) -> f64 {
    let maker = maker(problem, of);
    let measured = &problem.measured_triangles;
    let all: f64 = measured.iter().map(|&t| maker.spanned(t).powi(2)).sum();
    all / measured.len().max(1) as f64
}

/// What an attempt misses.
fn misses(problem: &Problem, of: &Attempt) -> Misses {
    let left = problem.left(&of.surface, &of.corrected(problem, FIRM_AREA), AIM);
    let beyond = left.iter().filter(|left| left.ratio > 1.0).count();
    let spared = problem.goal.outliers * problem.measured_triangles.len() as f64;
    let points = of.beyond(problem).0.saturating_sub(problem.spared());
    Misses { left, count: beyond.saturating_sub(spared as usize) + points }
}

/// Whether an attempt misses more than mends bring back, as fits of crumpled needles do.
fn is_hopeless(problem: &Problem, of: &Attempt, misses: &Misses) -> bool {
    of.beyond(problem).0 > problem.spared() + problem.share(FEW_POINTS)
        || misses.left.len() as f64 > HOPELESS * problem.measured_triangles.len() as f64
}

/// The same surface over more knots, where it misses vertices and triangles; `None` if there are
/// none to insert, or the user has named them.
fn with_knots(problem: &Problem, of: &Attempt, left: &[MissedTriangle]) -> Option<Attempt> {
    if !problem.options.knots.are_searched() {
        return None;
    }
    let next_uv = of.corrected(problem, FIRM_AREA);
    let mut misses = of.misses(&next_uv, problem.goal.tolerance);
    misses.extend(around(&of.state, left).map(|at| (at, 1.0)));
    let knots = finer_knots(of, &misses, &tolerance::bounds(problem))?;
    let surface = of.surface.over(knots.clone());
    let state = State { knots, ..of.state.clone() };
    let is_finer = surface.net.len() > of.surface.net.len();
    is_finer.then(|| Attempt { state, surface, fit: of.fit, foot_points: of.foot_points.clone() })
}
