//! Knot removal where knot lines bring little.

use super::correct::{FIRM_AREA, correct};
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;
use crate::stages::knots;

/// The state of an attempt, corrected, without that `share` of the inner knot lines which does
/// the least for the surface. `None` if there are none to remove.
pub(crate) fn remove(problem: &Problem, of: &Attempt, share: f64) -> Option<State> {
    let (knots, count) = knots::remove(&of.surface, share);
    (count > 0).then(|| State { knots, ..correct(problem, of, FIRM_AREA) })
}
