//! Moments of the samples of one knot cell: sums of products of powers.
//!
//! A B-spline is a cubic polynomial on a cell. So least squares needs only the sums Σ w sᵏ tˡ for
//! k, l ≤ 6 and Σ w sᵏ tˡ p for k, l ≤ 3. These are 49 + 48 sums, and each sample is visited once.

use super::knot_cells::KnotCells;
use super::weight::Weight;
use crate::geometry::Vector;

/// The sums of one cell.
#[derive(Debug, Clone)]
pub(crate) struct Moments<W = f64> {
    /// `gram[l][k]` = Σ w sᵏ tˡ. The last column is not used.
    pub gram: [[W; 8]; 7],
    /// `right[axis][l][k]` = Σ w sᵏ tˡ p.
    pub right: [[[f64; 4]; 4]; 3],
    /// Σ w p².
    pub squares: f64,
}

impl<W: Weight> Moments<W> {
    /// The sums over no samples.
    pub(crate) fn zero() -> Self {
        Moments { gram: [[W::even(0.0); 8]; 7], right: [[[0.0; 4]; 4]; 3], squares: 0.0 }
    }

    /// The sums over cell (p, q).
    pub(super) fn of(cells: &KnotCells, p: usize, q: usize) -> Self {
        let mut sums = Moments::zero();
        for sample in cells.samples::<W>(p, q) {
            let (s, t) = (powers(sample.place.x), powers(sample.place.y));
            sums.add(sample.weight, &s, &t, sample.point);
            sums.squares += sample.weight.pull(sample.point).dot(&sample.point);
        }
        sums
    }

    /// Adds a sample to all sums except `squares`. The arguments are its weight, the powers of its
    /// position, and its point.
    pub(crate) fn add(&mut self, weight: W, s: &[f64; 8], t: &[f64; 8], point: Vector) {
        for (row, t) in self.gram.iter_mut().zip(t) {
            let wt = weight * *t;
            row.iter_mut().zip(s).for_each(|(sum, s)| *sum += wt * *s);
        }
        let pull = weight.pull(point);
        for (axis, rows) in self.right.iter_mut().enumerate() {
            let wx = pull[axis];
            for (row, t) in rows.iter_mut().zip(t) {
                let wxt = wx * t;
                row.iter_mut().zip(s).for_each(|(sum, s)| *sum += wxt * s);
            }
        }
    }
}

/// 1, x, …, x⁷.
pub(crate) fn powers(x: f64) -> [f64; 8] {
    let x2 = x * x;
    let x4 = x2 * x2;
    [1.0, x, x2, x2 * x, x4, x4 * x, x4 * x2, x4 * x2 * x]
}
