//! The moves of the fit. Each takes an attempt, that is a state with its surface and foot points,
//! and returns a state that can be fitted as it is, or another attempt if the surface itself
//! moves. None changes what it is given, so that moves need no order.
//!
//! All that go on from an attempt begin with [`correct`](fn@correct::correct): parameters become
//! those of the foot points, and outliers are rejected anew.

pub(crate) mod correct;
pub(super) mod insert;
pub(crate) mod mend;
pub(crate) mod reject;
pub(super) mod remove;
pub(crate) mod reweight;
pub(crate) mod tangent;
pub(crate) mod unfold;

#[cfg(test)]
mod tests;
