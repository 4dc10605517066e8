//! Knots and fit in turn, until the surface reaches its goal with few knots.
//!
//! The paper takes κ and a depth from the user, and places knots once; so does
//! this if the user names κ. Otherwise the paper's knots for a κ of the tolerance (a mean,
//! while the tolerance bounds a maximum) are the start. Where the surface fitted
//! over them still misses points, knot spans are halved: a region that a
//! polynomial of its own fits need not be one that a spline, bound to its
//! neighbours, can follow. If nobody named a tolerance, knots are weighed against the
//! noise instead. Between fits, the parameters of the samples are corrected. Folds are removed from
//! the last surface.
//!
//! It has three parts. A state (`state.rs`) is all that a fit starts from, as a value: knots,
//! parameters, weights, outliers. Moves (`moves/`) make new states from what a fit has shown. A
//! policy (`policy/`) for each goal says which move comes next. `problem.rs` has what stays the
//! same meanwhile, an attempt (`attempt.rs`) is a state with its surface, and `run.rs` makes the
//! fits.

mod attempt;
mod goal;
mod inner;
mod moves;
mod options;
mod policy;
mod problem;
mod report;
mod run;
mod sparse;
mod start;
mod state;
mod weights;
mod work;

pub use goal::Goal;
pub use options::{KnotOptions, Options};
pub use report::{Adapted, Folds};

use crate::error::{Result, of};
use crate::geometry::Uv;
use crate::mesh::Parameterized;
use crate::progress::{self, Progress};
use crate::rules;
use crate::spline::Surface;
use crate::stages::{fit, knots};
use attempt::Attempt;
use moves::correct::FIRM_AREA;
use problem::Problem;
use run::FitRun;
use work::Work;

/// Fits a surface to the map's vertices, in mm over [0, 1]². The map's parameters are
/// corrected, and where its triangles are sparse it gets more vertices.
///
/// # Errors
/// [`Error::Option`](crate::error::Error::Option): the goal is not one, or the knots for the
/// κ or depth that is named make a larger net than allowed.
/// [`Error::Singular`](crate::error::Error::Singular): the equations have no solution.
pub fn fit(map: &mut Parameterized, options: &Options, goal: &Goal) -> Result<(Surface, Adapted)> {
    fit_with(map, options, goal, &mut progress::ignore)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`fit`](fn@fit), and what `progress` answers.
pub fn fit_with(
    map: &mut Parameterized,
    options: &Options,
    goal: &Goal,
    progress: &mut Progress,
) -> Result<(Surface, Adapted)> {
    options.knots.check()?;
    rules::length(goal.tolerance).map_err(of("tolerance"))?;
    rules::share(goal.outliers).map_err(of("outliers"))?;
    let problem = Problem::new(map, options, goal);
    let mut run = FitRun::new(&problem, (0, Work::default()), progress);
    let (state, placed) = start::start(&problem)?;
    let best = policy::search(&mut run, state)?;
    let uv = last_parameters(&problem, &best);
    let (surface, adapted, uv) = if sparse::needs_vertices(&problem, &best, &uv) {
        let before = (run.fits, run.work);
        map.uv = uv;
        sparse::halve(map, &best.surface);
        let problem = Problem::new(map, options, goal);
        let mut run = FitRun::new(&problem, before, progress);
        let best = policy::go_on(&mut run, best)?;
        finish(run, best, placed)?
    } else {
        finish(run, best, placed)?
    };
    map.uv = uv;
    Ok((surface, adapted))
}

/// The surface with its report, and the parameters on it.
fn finish(
    mut run: FitRun,
    best: Attempt,
    placed: Option<knots::Report>,
) -> Result<(Surface, Adapted, Vec<Uv>)> {
    let (best, folds) = policy::finish(&mut run, best)?;
    let problem = run.problem;
    let asked = &problem.options.knots;
    let adapted = Adapted {
        fit: best.fit,
        knots: placed,
        kappa: asked.net.is_none().then(|| asked.kappa.unwrap_or(problem.goal.tolerance)),
        rounds: run.fits,
        folds,
        mean_error: fit::mean_error(&best.surface, &best.state.samples(problem)),
        hindrance: run.hindrance,
        is_spent: run.work.is_spent,
    };
    let uv = last_parameters(problem, &best);
    Ok((best.surface, adapted, uv))
}

/// The parameters that the vertices move to after an attempt, towards their foot points; after
/// blended local fits they stay.
fn last_parameters(problem: &Problem, of: &Attempt) -> Vec<Uv> {
    match problem.options.method {
        fit::Method::Blend => of.state.uv.clone(),
        _ => of.corrected(problem, FIRM_AREA),
    }
}
