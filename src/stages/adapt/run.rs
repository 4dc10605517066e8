//! The fits of one stage: it makes them, counts them, and reports its progress.

use super::attempt::Attempt;
use super::moves::correct::FIRM_AREA;
use super::moves::tangent;
use super::problem::Problem;
use super::state::State;
use super::work::Work;
use crate::error::Result;
use crate::progress::Progress;
use crate::stages::fit;

/// After so many steps by tangent distances that gained little, there are no more of them: where
/// parameters run well already they cost a solve each and gain nothing. One may be idle by chance.
const MOST_IDLE_STEPS: usize = 2;

/// Makes fits.
pub(crate) struct FitRun<'a> {
    pub problem: &'a Problem<'a>,
    /// How many fits were made.
    pub fits: usize,
    /// The work that they took.
    pub work: Work,
    idle_steps: usize,
    /// The standard deviation of the noise, in mm, if it keeps surfaces from a named tolerance.
    pub hindrance: Option<f64>,
    progress: &'a mut Progress<'a>,
}

impl<'a> FitRun<'a> {
    /// A run that goes on after so many `fits` and so much `work` on another map.
    pub(super) fn new(
        problem: &'a Problem<'a>,
        (fits, work): (usize, Work),
        progress: &'a mut Progress<'a>,
    ) -> Self {
        FitRun { problem, fits, work, idle_steps: 0, hindrance: None, progress }
    }

    /// Fits a surface to a state.
    pub(super) fn fit(&mut self, state: State) -> Result<Attempt> {
        // How many fits follow is not known. As many as were made is a guess.
        (self.progress)(self.fits as f64 / (self.fits + 1) as f64)?;
        let (problem, method) = (self.problem, self.problem.options.method);
        let (mut surface, report) = fit::fit(&state.samples(problem), state.knots.clone(), method)?;
        problem.pin_corners(&mut surface);
        self.fits += 1;
        let mut attempt = Attempt::new(problem, state, surface, report);
        if method == fit::Method::Refined && self.idle_steps < MOST_IDLE_STEPS {
            let (next, is_idle) = tangent::step(problem, attempt);
            self.idle_steps += usize::from(is_idle);
            attempt = next;
        }
        if problem.goal.named {
            let last = attempt.corrected(problem, FIRM_AREA);
            problem.stay_at_loops(&attempt.surface, &last, &mut attempt.foot_points);
        }
        self.work.count(problem, &attempt);
        Ok(attempt)
    }
}
