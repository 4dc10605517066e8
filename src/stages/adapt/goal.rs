//! What a fit must reach.

use crate::statistics::{SIGNIFICANT, level};

/// What a fit must reach.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// The largest distance between a point and the surface, in mm.
    pub tolerance: f64,
    /// Whether the user named the tolerance. One that nobody named stands for the noise.
    pub named: bool,
    /// The share of the points that may exceed the tolerance.
    pub outliers: f64,
}

impl Goal {
    /// The goal that a `noise` allows, given by its standard deviation in mm: nearly all points of a
    /// surface that follows the shape keep the tolerance.
    pub(crate) fn of_noise(noise: f64) -> Self {
        Goal { tolerance: SIGNIFICANT * noise, named: false, outliers: level() }
    }

    /// The standard deviation of the noise, in mm, that a tolerance which nobody named stands for.
    pub(crate) fn noise(&self) -> f64 {
        self.tolerance / SIGNIFICANT
    }
}
