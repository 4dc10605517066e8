//! The moves of the fit. Each takes an attempt, that is a state with its surface and foot points,
//! and returns a state that can be fitted as it is, or another attempt if the surface itself
//! moves. None changes what it is given, so that moves need no order.
//!
//! All that go on from an attempt begin with [`correct`](fn@correct::correct): parameters become
//! those of the foot points, and outliers are rejected anew.

pub mod correct;
pub mod insert;
pub mod mend;
pub mod reject;
pub mod remove;
pub mod reweight;
pub mod tangent;
pub mod unfold;

#[cfg(test)]
mod tests;
