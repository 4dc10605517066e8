//! Solvers of linear systems.

pub(crate) mod cholesky;
pub(crate) mod least_squares;
