//! How samples hold a surface that may slide along them.

use nalgebra::Matrix3;

use crate::geometry::Vector;

/// Weight of a sample's distance along the surface, of that across it.
const ALONG: f64 = 0.05;

/// How a sample holds a surface.
#[derive(Debug, Clone, Copy)]
pub struct TangentDistance {
    /// The normal of what was measured there, of length 1.
    pub normal: Vector,
    /// The matrix of the squared distance that it is held by: of a plane, a line or a
    /// point.
    pub metric: Matrix3<f64>,
    /// Which of its parameters may change.
    pub moves: [bool; 2],
}

impl TangentDistance {
    /// The matrix of the squared distance, with little of what is along the surface. A
    /// sample whose parameters are stuck holds the surface in all directions.
    pub fn of(&self, stuck: bool) -> Matrix3<f64> {
        match stuck {
            true => Matrix3::identity(),
            false => Matrix3::identity() * ALONG + self.metric * (1.0 - ALONG),
        }
    }
}
