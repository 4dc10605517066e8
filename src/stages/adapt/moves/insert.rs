//! Knot insertion where a surface misses points.

use super::correct::{FIRM_AREA, correct};
use crate::geometry::uv_bounds;
use crate::spline::KnotVector;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;
use crate::stages::knots::{self, InsertionLimits, Miss};

/// The state of an attempt, corrected, with knots in the middles of the spans that `misses` call
/// for. `None` if there are none to insert.
pub(crate) fn insert(
    problem: &Problem,
    of: &Attempt,
    misses: &[Miss],
    bounds: &InsertionLimits,
) -> Option<State> {
    let knots = finer_knots(of, misses, bounds)?;
    Some(State { knots, ..correct(problem, of, FIRM_AREA) })
}

/// The knots alone.
pub(crate) fn finer_knots(
    of: &Attempt,
    misses: &[Miss],
    bounds: &InsertionLimits,
) -> Option<[KnotVector; 2]> {
    let reach = uv_bounds(&of.state.inner.after(of.state.uv.clone()));
    let knots = knots::insert(&of.surface, misses, reach, bounds);
    (knots != of.state.knots).then_some(knots)
}
