//! The equations for some control points of a net, the others held: three
//! coordinates each, which couple.

use faer::Mat;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::Matrix3;

use crate::geometry::Vector;

/// A control point couples with those up to three rows further and three columns
/// to either side.
const COUPLED: usize = 28;

/// Symmetric equations for steps of the control points that are free.
pub struct System {
    width: usize,
    /// The free control points in growing order.
    pub free: Vec<usize>,
    /// The place in `free` of a control point.
    place: Vec<Option<u32>>,
    blocks: Vec<[Matrix3<f64>; COUPLED]>,
    right: Vec<Vector>,
}

impl System {
    /// Equations without terms; `width` control points are in a row of the net.
    pub fn new(width: usize, is_free: &[bool]) -> Self {
        let free: Vec<usize> = (0..is_free.len()).filter(|&at| is_free[at]).collect();
        let mut place = vec![None; is_free.len()];
        free.iter().zip(0..).for_each(|(&at, n)| place[at] = Some(n));
        let (blocks, right) =
            (vec![[Matrix3::zeros(); COUPLED]; free.len()], vec![Vector::zeros(); free.len()]);
        System { width, free, place, blocks, right }
    }

    /// Adds to the right-hand side of a control point, if it is free.
    pub fn pull(&mut self, at: usize, force: Vector) {
        if let Some(n) = self.place[at] {
            self.right[n as usize] += force;
        }
    }

    /// Adds to the block of row `a` and column `b`, and the transposed one to that
    /// of row `b` and column `a`. `b` must not be before `a`.
    pub fn couple(&mut self, a: usize, b: usize, block: &Matrix3<f64>) {
        if let (Some(n), Some(_)) = (self.place[a], self.place[b]) {
            let rows = b / self.width - a / self.width;
            let columns = b % self.width + 3 - a % self.width;
            self.blocks[n as usize][7 * rows + columns] += block;
        }
    }

    /// The steps, in the order of `free`; `None` if the equations are singular.
    pub fn solve(&self) -> Option<Vec<Vector>> {
        let n = self.free.len();
        let mut triplets = Vec::with_capacity(9 * n * COUPLED / 2);
        for (a, (&at, blocks)) in self.free.iter().zip(&self.blocks).enumerate() {
            for (k, block) in blocks.iter().enumerate() {
                let Some(to) = (at + (k / 7) * self.width + k % 7).checked_sub(3) else { continue };
                let same_rows = at / self.width + k / 7 == to / self.width;
                let Some(b) = self.place.get(to).copied().flatten().filter(|_| same_rows) else {
                    continue;
                };
                let b = b as usize;
                for (x, y) in (0..9).map(|i| (i / 3, i % 3)) {
                    // Rows of the lower triangle: the second point's coordinates.
                    if b > a || b == a && y >= x {
                        triplets.push(Triplet::new(
                            (3 * b + y) as u32,
                            (3 * a + x) as u32,
                            block[(x, y)],
                        ));
                    }
                }
            }
        }
        let size = 3 * n;
        let matrix = SparseColMat::<u32, f64>::try_new_from_triplets(size, size, &triplets).ok()?;
        let factor = matrix.sp_cholesky(faer::Side::Lower).ok()?;
        let x = factor.solve(&Mat::from_fn(size, 1, |i, _| self.right[i / 3][i % 3]));
        let step = |k: usize| Vector::new(x[(3 * k, 0)], x[(3 * k + 1, 0)], x[(3 * k + 2, 0)]);
        let steps: Vec<Vector> = (0..n).map(step).collect();
        steps.iter().all(|s| s.norm().is_finite()).then_some(steps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn free_points_are_solved_for_and_others_stay() {
        let (rows, width) = (5, 6);
        let is_free: Vec<bool> = (0..rows * width).map(|n| n % 4 > 0).collect();
        let mut system = System::new(width, &is_free);
        let mut dense = DMatrix::<f64>::zeros(3 * rows * width, 3 * rows * width);
        let number = |k: usize| ((k * 7919) % 101) as f64 / 101.0 - 0.5;
        // A sum of squares of random sums over four by four points.
        for (n, (p, q)) in (0..6).map(|n| (n / 3, n % 3)).enumerate() {
            let at: Vec<usize> = (0..16).map(|k| (p + k / 4) * width + q + k % 4).collect();
            let g: Vec<Vector> =
                (0..16).map(|k| Vector::from_fn(|x, _| number(48 * n + 3 * k + x))).collect();
            for (i, j) in (0..256).map(|k| (k / 16, k % 16)) {
                let block = g[i] * g[j].transpose();
                if i <= j {
                    system.couple(at[i], at[j], &block);
                }
                let mut view = dense.fixed_view_mut::<3, 3>(3 * at[i], 3 * at[j]);
                view += block;
            }
        }
        for at in 0..rows * width {
            system.couple(at, at, &Matrix3::identity());
            system.pull(at, Vector::new(1.0, at as f64, -2.0));
            let mut view = dense.fixed_view_mut::<3, 3>(3 * at, 3 * at);
            view += Matrix3::identity();
        }
        let of: Vec<usize> =
            system.free.iter().flat_map(|&at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let part = dense.select_rows(&of).select_columns(&of);
        let right = of.iter().map(|&k| [1.0, (k / 3) as f64, -2.0][k % 3]);
        let exact = part.cholesky().unwrap().solve(&DVector::from_iterator(of.len(), right));
        let steps = system.solve().unwrap();
        for (n, step) in steps.iter().enumerate() {
            assert!((0..3).all(|x| (step[x] - exact[3 * n + x]).abs() < 1e-9));
        }
    }
}
