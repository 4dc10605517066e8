//! Mending a surface between its points: samples inside the triangles that it leaves hold it,
//! too, and the control points around them move. Another fit would bring folds back that have
//! been taken out.

use super::correct::LEAST_AREA;
use super::reweight::reweight;
use crate::deviation::MissedTriangle;
use crate::geometry::Uv;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::inner::Maker;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;
use crate::stages::fit::{self, STIFFNESSES};

/// The share of the tolerance from which on a vertex gets more weight. Most have enough, so that
/// the aim may be closer than that of inner samples.
const AIM_OF_VERTICES: f64 = 0.97;

/// An attempt's surface brought nearer to the vertices that it misses and to the triangles that
/// it has `left`. `None` if the equations have no solution without more folds.
pub(crate) fn mend(problem: &Problem, of: &Attempt, left: &[MissedTriangle]) -> Option<Attempt> {
    let limit = AIM_OF_VERTICES * problem.goal.tolerance;
    let mut state = reweight(problem, of, limit, LEAST_AREA);
    let maker = maker(problem, of);
    state.inner.hold(left, &maker, &problem.measured_triangles);
    let vertices = state.vertices(problem);
    let missed = (of.foot_points.measured().zip(&state.uv)).filter(|(d, _)| *d > limit);
    let around: Vec<Uv> = missed.map(|(_, &at)| at).chain(around(&state, left)).collect();
    let (samples, holds) = (state.samples(problem), state.holds(problem));
    let slide = |now: Vec<Uv>, wanted: Vec<Uv>| state.slid(problem, now, wanted);
    let task = fit::Mending {
        surface: &of.surface,
        samples: &samples,
        vertices: &vertices,
        holds: &holds,
        slide: &slide,
        around: &around,
    };
    let found = STIFFNESSES.iter().rev().find_map(|&stiffness| fit::mend(&task, stiffness))?;
    Some(Attempt::moved(problem, &state, found.surface, found.uv, of.fit))
}

/// What makes samples in the triangles over an attempt's surface.
pub(crate) fn maker<'m>(problem: &'m Problem, of: &'m Attempt) -> Maker<'m> {
    Maker::new(&problem.map.patch.mesh, &problem.holds, &of.state.uv, &of.surface)
}

/// Where on the map the samples inside triangles are.
pub(crate) fn around(state: &State, left: &[MissedTriangle]) -> impl Iterator<Item = Uv> {
    let inner = left.iter().flat_map(|left| state.inner.of(left.triangle));
    inner.map(|at| state.inner.all[at].uv(&state.uv))
}
