//! Solvers of linear systems, and the search along a step.

pub(crate) mod cholesky;
pub(crate) mod least_squares;

/// The most halvings of a step. Nearly always one suffices where the whole step does not.
const HALVINGS: i32 = 10;

/// The shares of a step that are tried until one helps: all of it, the half, a quarter and so on.
pub(crate) fn shares() -> impl Iterator<Item = f64> {
    (0..HALVINGS).map(|k| 0.5f64.powi(k))
}
