//! Weights of samples. A number weights distances in all directions equally. A symmetric matrix
//! weights normal distances more than tangential ones.

use std::ops::{AddAssign, Mul};

use nalgebra::Matrix3;

use super::knot_cells::KnotCells;
use super::normal::PaddedPoint;
use crate::geometry::Vector;

/// A weight of a sample, or a sum of weights times products of basis functions.
pub(crate) trait Weight: Copy + Send + Sync + AddAssign + Mul<f64, Output = Self> {
    /// A weight that is equal in all directions.
    fn even(weight: f64) -> Self;

    /// The weight of sample `i`.
    fn of(cells: &KnotCells, i: usize) -> Self;

    /// The mean over all directions.
    fn mean(self) -> f64;

    /// The weight times a sample's point.
    fn pull(self, p: Vector) -> Vector;

    /// The weight times a control point.
    fn times(self, x: &PaddedPoint) -> PaddedPoint;

    /// Converts sums over control points, one for each coordinate, for the step lengths of
    /// conjugate gradients. Coordinates that a matrix couples have one common step length.
    fn coupled(sums: PaddedPoint) -> PaddedPoint;
}

impl Weight for f64 {
    fn even(weight: f64) -> f64 {
        weight
    }

    fn of(cells: &KnotCells, i: usize) -> f64 {
        cells.samples.weights[i]
    }

    fn mean(self) -> f64 {
        self
    }

    fn pull(self, p: Vector) -> Vector {
        self * p
    }

    fn times(self, x: &PaddedPoint) -> PaddedPoint {
        x * self
    }

    /// The coordinates are independent systems with the same matrix.
    fn coupled(sums: PaddedPoint) -> PaddedPoint {
        sums
    }
}

/// A symmetric matrix with the entries xx, yy, zz, xy, yz, zx.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Metric([f64; 6]);

impl From<&Matrix3<f64>> for Metric {
    fn from(m: &Matrix3<f64>) -> Self {
        Metric([m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(1, 2)], m[(2, 0)]])
    }
}

impl AddAssign for Metric {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(a, b)| *a += b);
    }
}

impl Mul<f64> for Metric {
    type Output = Metric;

    fn mul(self, factor: f64) -> Metric {
        Metric(self.0.map(|entry| entry * factor))
    }
}

impl Weight for Metric {
    fn even(weight: f64) -> Metric {
        Metric([weight, weight, weight, 0.0, 0.0, 0.0])
    }

    fn of(cells: &KnotCells, i: usize) -> Metric {
        cells.metrics[i] * cells.samples.weights[i]
    }

    fn mean(self) -> f64 {
        (self.0[0] + self.0[1] + self.0[2]) / 3.0
    }

    fn pull(self, p: Vector) -> Vector {
        self.times(&p.push(0.0)).xyz()
    }

    fn times(self, x: &PaddedPoint) -> PaddedPoint {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        PaddedPoint::new(
            xx * x[0] + xy * x[1] + zx * x[2],
            xy * x[0] + yy * x[1] + yz * x[2],
            zx * x[0] + yz * x[1] + zz * x[2],
            0.0,
        )
    }

    fn coupled(sums: PaddedPoint) -> PaddedPoint {
        // Equal parts, so that the sum over the coordinates stays the same.
        PaddedPoint::repeat(sums.mean())
    }
}
