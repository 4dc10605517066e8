//! How much a sample's distance from the surface counts: the same in all directions, by
//! a number, or more across the surface than along it, by a matrix.

use std::ops::{AddAssign, Mul};

use nalgebra::Matrix3;

use super::cells::Cells;
use super::normal::Lane;
use crate::geometry::Vector;

/// A weight, and what sums of them, times products of functions, do to control points.
pub trait Weight: Copy + Send + Sync + AddAssign + Mul<f64, Output = Self> {
    /// None.
    const ZERO: Self;

    /// The same in all directions.
    fn even(weight: f64) -> Self;

    /// That of sample `i`.
    fn of(cells: &Cells, i: usize) -> Self;

    /// The mean over all directions.
    fn mean(self) -> f64;

    /// Of a sample at `p`.
    fn pull(self, p: Vector) -> Vector;

    /// Of a control point.
    fn times(self, x: &Lane) -> Lane;

    /// Sums over control points, one for each coordinate, as steps of conjugate gradients
    /// need them.
    fn coupled(sums: Lane) -> Lane;
}

impl Weight for f64 {
    const ZERO: f64 = 0.0;

    fn even(weight: f64) -> f64 {
        weight
    }

    fn of(cells: &Cells, i: usize) -> f64 {
        cells.samples.weights[i]
    }

    fn mean(self) -> f64 {
        self
    }

    fn pull(self, p: Vector) -> Vector {
        self * p
    }

    fn times(self, x: &Lane) -> Lane {
        x * self
    }

    /// The coordinates are systems of their own with one matrix.
    fn coupled(sums: Lane) -> Lane {
        sums
    }
}

/// A symmetric matrix: its entries xx, yy, zz, xy, yz, zx.
#[derive(Debug, Clone, Copy)]
pub struct Metric([f64; 6]);

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
    const ZERO: Metric = Metric([0.0; 6]);

    fn even(weight: f64) -> Metric {
        Metric([weight, weight, weight, 0.0, 0.0, 0.0])
    }

    fn of(cells: &Cells, i: usize) -> Metric {
        cells.metrics[i] * cells.samples.weights[i]
    }

    fn mean(self) -> f64 {
        (self.0[0] + self.0[1] + self.0[2]) / 3.0
    }

    fn pull(self, p: Vector) -> Vector {
        self.times(&p.push(0.0)).xyz()
    }

    fn times(self, x: &Lane) -> Lane {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        Lane::new(
            xx * x[0] + xy * x[1] + zx * x[2],
            xy * x[0] + yy * x[1] + yz * x[2],
            zx * x[0] + yz * x[1] + zz * x[2],
            0.0,
        )
    }

    fn coupled(sums: Lane) -> Lane {
        // In equal parts, so that the lanes add up to it.
        Lane::repeat(sums.mean())
    }
}
