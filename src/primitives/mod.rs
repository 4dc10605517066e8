//! Planes, cylinders, cones, spheres and tori: distances, normals, and fits to points.
//!
//! A [`Primitive`] is one of the five. [`fit`] moves a start onto points by least squares of orthogonal
//! distances, `starts` proposes such starts from a few points with normals.

pub(crate) mod contact;
mod fit;
mod motions;
#[cfg(test)]
mod parameters;
mod primitive;
pub(crate) mod round_numbers;
mod starts;
pub(crate) mod tangency;
#[cfg(test)]
mod tests;
mod uncertainty;

pub use fit::{FitOptions, FitSample, PrimitiveFit, fit};
pub use motions::Motions;
pub(crate) use motions::{Covariance, MOST_PARAMETERS, MotionRow};
pub use primitive::{Primitive, PrimitiveKind};
pub(crate) use starts::{OrientedPoint, starts, with_axis};
pub use uncertainty::Uncertainty;
