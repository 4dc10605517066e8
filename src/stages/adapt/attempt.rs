//! The surface that a state leads to, and how far it is from the points.

use super::moves::correct::LEAST_AREA;
use super::problem::Problem;
use super::state::State;
use crate::geometry::Uv;
use crate::spline::Surface;
use crate::stages::fit;
use crate::stages::knots::Miss;

/// A state, the surface fitted to it, and where on this the vertices' foot points are.
#[derive(Clone)]
pub(crate) struct Attempt {
    pub state: State,
    pub surface: Surface,
    pub fit: fit::Report,
    pub foot_points: FootPoints,
}

impl Attempt {
    /// A `surface` for a state, with the foot points found from the state's parameters.
    pub(super) fn new(problem: &Problem, state: State, surface: Surface, fit: fit::Report) -> Self {
        let foot_points = problem.foot_points(&surface, &state.uv);
        Attempt { state, surface, fit, foot_points }
    }

    /// The attempt at a surface that has moved while the samples of a state slid to `uv`. The
    /// vertices follow to their foot points.
    pub(crate) fn moved(
        problem: &Problem,
        state: &State,
        surface: Surface,
        mut uv: Vec<Uv>,
        fit: fit::Report,
    ) -> Self {
        uv.truncate(state.uv.len());
        let state = State { uv, ..state.clone() };
        let mut attempt = Attempt::new(problem, state, surface, fit);
        attempt.state.uv = attempt.corrected(problem, LEAST_AREA);
        if problem.goal.named {
            let Attempt { state, surface, foot_points, .. } = &mut attempt;
            problem.stay_at_loops(surface, &state.uv, foot_points);
        }
        attempt
    }

    /// The parameters that the vertices may move to, towards their foot points, while every
    /// triangle keeps the share `least_area` of its area on the map.
    pub(crate) fn corrected(&self, problem: &Problem, least_area: f64) -> Vec<Uv> {
        let wanted = self.foot_points.uv.clone();
        problem.corrected(self.state.uv.clone(), wanted, least_area)
    }

    /// How many measured vertices are beyond the tolerance, and the largest distance, in mm.
    pub(crate) fn beyond(&self, problem: &Problem) -> (usize, f64) {
        self.foot_points.beyond(problem.goal.tolerance)
    }

    /// Whether no more points are beyond the tolerance than may be.
    pub(crate) fn is_met(&self, problem: &Problem) -> bool {
        self.beyond(problem).0 <= problem.spared()
    }

    /// Root mean square of the measured vertices' distances without outliers, in mm.
    pub(crate) fn rms(&self) -> f64 {
        self.foot_points.rms_without(&self.state.outliers)
    }

    /// The vertices beyond the tolerance: the parameters `uv` that they have in the next fit, and
    /// their distances in tolerances.
    pub(crate) fn misses(&self, uv: &[Uv], tolerance: f64) -> Vec<Miss> {
        let measured = self.foot_points.measured().zip(uv);
        measured.filter(|(d, _)| *d > tolerance).map(|(d, &uv)| (uv, d / tolerance)).collect()
    }
}

/// The vertices' foot points on a surface.
#[derive(Clone)]
pub(crate) struct FootPoints {
    pub uv: Vec<Uv>,
    /// The vertices' distances from them, in mm.
    pub distances: Vec<f64>,
    /// How many vertices, the first ones, were measured.
    pub measured: usize,
}

impl FootPoints {
    /// The distances of the measured vertices.
    pub(super) fn measured(&self) -> impl Iterator<Item = f64> + '_ {
        self.distances[..self.measured].iter().copied()
    }

    /// How many measured vertices are farther than `limit`, and the largest distance.
    pub(crate) fn beyond(&self, limit: f64) -> (usize, f64) {
        let beyond = self.measured().filter(|d| *d > limit).count();
        (beyond, self.measured().fold(0.0, f64::max))
    }

    /// Root mean square of the measured vertices' distances without some of them.
    pub(crate) fn rms_without(&self, outliers: &[usize]) -> f64 {
        let all: f64 = self.measured().map(|d| d * d).sum();
        let outlying: f64 = outliers.iter().map(|&v| self.distances[v].powi(2)).sum();
        let count = self.measured - outliers.len();
        ((all - outlying).max(0.0) / count.max(1) as f64).sqrt()
    }
}
