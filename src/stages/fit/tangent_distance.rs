//! The tangent-distance term of a sample (Wang, Pottmann, Liu 2006): distances normal to the
//! surface count fully, and distances along it count little.

use nalgebra::Matrix3;

use crate::geometry::Vector;

/// The weight of a sample's tangential distance, relative to its normal distance.
const TANGENTIAL: f64 = 0.05;

/// The tangent-distance term of a sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TangentDistance {
    /// The unit normal of the measured surface at the sample.
    pub normal: Vector,
    /// The matrix of the squared distance to a plane, a line or a point.
    pub metric: Matrix3<f64>,
    /// Which of the sample's parameters u and v may change.
    pub moves: [bool; 2],
}

impl TangentDistance {
    /// The matrix of the squared distance with a small weight for tangential distances. If the
    /// parameters of the sample are `stuck`, distances in all directions count fully.
    pub(crate) fn of(&self, stuck: bool) -> Matrix3<f64> {
        match stuck {
            true => Matrix3::identity(),
            false => Matrix3::identity() * TANGENTIAL + self.metric * (1.0 - TANGENTIAL),
        }
    }
}
