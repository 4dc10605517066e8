//! How knots and fit turned out.

use crate::stages::{fit, knots};

/// How knots and fit turned out.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Adapted {
    /// The last fit.
    pub fit: fit::Report,
    /// The placement of knots by κ; `None` if the user named a net.
    pub knots: Option<knots::Report>,
    /// κ, in mm; `None` if the user named a net.
    pub kappa: Option<f64>,
    /// How many fits were made.
    pub rounds: usize,
    /// Where the surface folds; `None` for blended local fits, whose folds stay.
    pub folds: Option<Folds>,
    /// Mean distance, in mm, between a sample and the surface at the parameter that the
    /// sample was fitted with.
    pub mean_error: f64,
    /// The standard deviation of the noise, in mm, if only a surface that follows the noise
    /// would keep the named tolerance. Knots were then inserted no further.
    pub hindrance: Option<f64>,
    /// Whether the work for the named tolerance came to its bound: about three times that of a run without one.
    pub is_spent: bool,
}

impl Adapted {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Adapted {
            kappa: self.kappa.map(|kappa| factor * kappa),
            mean_error: factor * self.mean_error,
            hindrance: self.hindrance.map(|noise| factor * noise),
            ..self
        }
    }
}

/// Where a surface folds: its normal, sampled evenly over every knot cell, points to the other
/// side than the scan's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Folds {
    /// Jacobian samples that are inverted.
    pub inverted: usize,
    /// All Jacobian samples.
    pub samples: usize,
}
