//! What a fit must reach.

/// A tolerance that nobody named, in standard deviations of the noise: nearly all points of a
/// surface that follows the shape keep it.
pub(crate) const TOLERANCE_OF_NOISE: f64 = 3.0;

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
    /// The goal that a `noise` allows, given by its standard deviation in mm.
    pub fn of_noise(noise: f64) -> Self {
        let tolerance = TOLERANCE_OF_NOISE * noise;
        // The share of normal noise that is beyond this tolerance.
        let outliers = libm::erfc(TOLERANCE_OF_NOISE / std::f64::consts::SQRT_2);
        Goal { tolerance, named: false, outliers }
    }

    /// The standard deviation of the noise, in mm, that a tolerance which nobody named stands for.
    pub(super) fn noise(&self) -> f64 {
        self.tolerance / TOLERANCE_OF_NOISE
    }
}
