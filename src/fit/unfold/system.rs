//! The equations for some control points of a net, the others held: three
//! coordinates each, which couple.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::part::Part;
use crate::geometry::Vector;
use crate::sets::Sets;

/// A control point couples with those up to three rows further and three columns
/// to either side, …
const COUPLED: usize = 28;

/// … among which this one is itself.
const SELF: usize = 3;

/// What a control point has with each of those that it couples with.
pub type Blocks = [Matrix3<f64>; COUPLED];

/// Symmetric equations for steps of the control points that are free.
pub struct System {
    width: usize,
    /// The free control points in growing order.
    pub free: Vec<usize>,
    /// The place in `free` of a control point.
    place: Vec<Option<u32>>,
    blocks: Vec<Blocks>,
    right: Vec<Vector>,
    /// Of those that couple, each solved by itself.
    parts: Vec<Part>,
}

impl System {
    /// Equations without terms; `width` control points are in a row of the net. `None` if
    /// there is no memory for their solution.
    pub fn new(width: usize, is_free: &[bool]) -> Option<Self> {
        let free: Vec<usize> = (0..is_free.len()).filter(|&at| is_free[at]).collect();
        let mut place = vec![None; is_free.len()];
        free.iter().zip(0..).for_each(|(&at, n)| place[at] = Some(n));
        let mut system =
            System { width, free, place, blocks: vec![], right: vec![], parts: vec![] };
        let mut sets = Sets::new(system.free.len());
        for a in 0..system.free.len() {
            system.coupled(a).for_each(|(_, b)| sets.join(a, b as usize));
        }
        let sets = sets.members().into_par_iter();
        let parts: Option<_> = sets.map(|of| Part::new(of, |a| system.coupled(a))).collect();
        system.parts = parts?;
        system.clear();
        Some(system)
    }

    /// Takes all terms out.
    pub fn clear(&mut self) {
        self.blocks = vec![[Matrix3::zeros(); COUPLED]; self.free.len()];
        self.right = vec![Vector::zeros(); self.free.len()];
    }

    /// Whether these control points are free, and no others.
    pub fn is_for(&self, is_free: &[bool]) -> bool {
        self.place.iter().zip(is_free).all(|(place, free)| place.is_some() == *free)
    }

    /// The free control points not before one of them that couple with it: which ones of
    /// its blocks, and their places in `free`, both growing.
    fn coupled(&self, a: usize) -> impl Iterator<Item = (usize, u32)> + '_ {
        let at = self.free[a];
        (SELF..COUPLED).filter_map(move |k| {
            let to = (at + k / 7 * self.width + k % 7).checked_sub(SELF)?;
            let same_rows = at / self.width + k / 7 == to / self.width;
            Some((k, self.place.get(to).copied().flatten().filter(|_| same_rows)?))
        })
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
            let columns = b % self.width + SELF - a % self.width;
            self.blocks[n as usize][7 * rows + columns] += block;
        }
    }

    /// The steps, in the order of `free`; `None` if the equations are singular.
    pub fn solve(&mut self) -> Option<Vec<Vector>> {
        let (blocks, right) = (&self.blocks, &self.right);
        let solved = self.parts.par_iter_mut().map(|part| part.solve(blocks, right));
        let solved: Vec<Vec<Vector>> = solved.collect::<Option<_>>()?;
        let mut steps = vec![Vector::zeros(); self.free.len()];
        for (part, solved) in self.parts.iter().zip(solved) {
            part.points.iter().zip(solved).for_each(|(&a, step)| steps[a as usize] = step);
        }
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
        let mut system = System::new(width, &is_free).unwrap();
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
