//! The equations for steps of some control points of a net while the others stay in place. Each
//! point has three coordinates, which couple.

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::coupled::CoupledPoints;
use crate::geometry::Vector;
use crate::geometry::sets::Sets;

/// The number of control points that a control point is stored as coupled with: those up to three
/// rows further and three columns to either side.
const COUPLED: usize = 28;

/// The index of the control point itself among these.
const SELF: usize = 3;

/// The matrices that couple a control point with each of these.
pub(crate) type CouplingBlocks = [Matrix3<f64>; COUPLED];

/// Symmetric equations for steps of the control points that are free.
pub(crate) struct BlockSystem {
    width: usize,
    /// The free control points in ascending order.
    pub free: Vec<usize>,
    /// The index in `free` of each control point.
    place: Vec<Option<u32>>,
    blocks: Vec<CouplingBlocks>,
    right: Vec<Vector>,
    /// The connected components, which are solved independently.
    parts: Vec<CoupledPoints>,
}

impl BlockSystem {
    /// Equations without terms. A row of the net has `width` control points. `None` if there is not
    /// enough memory for the solution.
    pub(super) fn new(width: usize, is_free: &[bool]) -> Option<Self> {
        let free: Vec<usize> = (0..is_free.len()).filter(|&at| is_free[at]).collect();
        let mut place = vec![None; is_free.len()];
        free.iter().zip(0..).for_each(|(&at, n)| place[at] = Some(n));
        let mut system =
            BlockSystem { width, free, place, blocks: vec![], right: vec![], parts: vec![] };
        let mut sets = Sets::new(system.free.len());
        for a in 0..system.free.len() {
            system.coupled(a).for_each(|(_, b)| sets.join(a, b as usize));
        }
        let sets = sets.members().into_par_iter();
        let parts: Option<_> =
            sets.map(|of| CoupledPoints::new(of, |a| system.coupled(a))).collect();
        system.parts = parts?;
        Some(system.cleared())
    }

    /// The same equations without terms.
    pub(crate) fn cleared(mut self) -> Self {
        self.blocks.clear();
        self.blocks.resize(self.free.len(), [Matrix3::zeros(); COUPLED]);
        self.right.clear();
        self.right.resize(self.free.len(), Vector::zeros());
        self
    }

    /// Whether exactly these control points are free.
    pub(crate) fn is_for(&self, is_free: &[bool]) -> bool {
        self.place.iter().zip(is_free).all(|(place, free)| place.is_some() == *free)
    }

    /// The free control points from free point `a` on that couple with it: the numbers of the
    /// blocks and the indices in `free`. Both are ascending.
    fn coupled(&self, a: usize) -> impl Iterator<Item = (usize, u32)> + '_ {
        let at = self.free[a];
        (SELF..COUPLED).filter_map(move |k| {
            let to = at + k / 7 * self.width + k % 7 - SELF;
            let same_rows = at / self.width + k / 7 == to / self.width;
            Some((k, self.place.get(to).copied().flatten().filter(|_| same_rows)?))
        })
    }

    /// Adds a term that keeps each control point in place with a weight.
    pub(crate) fn anchor(&mut self, weight: f64) {
        self.blocks.iter_mut().for_each(|of| of[SELF] += Matrix3::identity() * weight);
    }

    /// The equations of every fourth strip of cells, beginning with strip `first`. No two of these
    /// strips influence the same rows of the net, so that they can be filled in parallel.
    pub(crate) fn strips(&mut self, first: usize) -> Vec<StripEquations<'_>> {
        let (width, rows) = (self.width, self.place.len() / self.width);
        let begin = |row: usize| self.free.partition_point(|&at| at < row * width);
        let (mut blocks, mut right) = (&mut self.blocks[..], &mut self.right[..]);
        let mut done = 0;
        let mut strips = Vec::new();
        for number in (first..rows - 3).step_by(4) {
            let (from, to) = (begin(number), begin(number + 4));
            let own = blocks.split_at_mut(from - done).1.split_at_mut(to - from);
            let forces = right.split_at_mut(from - done).1.split_at_mut(to - from);
            let place = &self.place[number * width..(number + 4) * width];
            strips.push(StripEquations {
                number,
                width,
                place,
                from,
                blocks: own.0,
                right: forces.0,
            });
            (blocks, right, done) = (own.1, forces.1, to);
        }
        strips
    }

    /// The steps in the order of `free`. `None` if the equations are singular.
    pub(crate) fn solve(&mut self) -> Option<Vec<Vector>> {
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

/// The equations of the four rows of the net that a strip of cells influences.
pub(crate) struct StripEquations<'a> {
    /// The number of the strip, counted along u.
    pub number: usize,
    width: usize,
    /// The indices among the free control points of those in these rows.
    place: &'a [Option<u32>],
    /// The first of these indices.
    from: usize,
    blocks: &'a mut [CouplingBlocks],
    right: &'a mut [Vector],
}

impl StripEquations<'_> {
    /// The equations of the control points of cell `q`.
    pub(crate) fn cell(&mut self, q: usize) -> CellEquations<'_> {
        let at = |k: usize| self.place[k / 4 * self.width + q + k % 4];
        let indices = std::array::from_fn(|k| at(k).map(|n| n as usize - self.from));
        CellEquations { indices, blocks: self.blocks, right: self.right }
    }
}

/// The equations of a cell's 16 control points, which are numbered row by row.
pub(crate) struct CellEquations<'a> {
    indices: [Option<usize>; 16],
    blocks: &'a mut [CouplingBlocks],
    right: &'a mut [Vector],
}

impl CellEquations<'_> {
    /// Adds to the right-hand side of control point `k` if it is free.
    pub(crate) fn pull(&mut self, k: usize, force: Vector) {
        if let Some(n) = self.indices[k] {
            self.right[n] += force;
        }
    }

    /// Adds a block to row `k` and column `l`, and the transposed block to row `l` and column `k`.
    /// `l` must not be less than `k`.
    pub(crate) fn couple(&mut self, k: usize, l: usize, block: &Matrix3<f64>) {
        if let (Some(n), Some(_)) = (self.indices[k], self.indices[l]) {
            self.blocks[n][7 * (l / 4 - k / 4) + SELF + l % 4 - k % 4] += block;
        }
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
        let mut system = BlockSystem::new(width, &is_free).unwrap();
        let mut dense = DMatrix::<f64>::zeros(3 * rows * width, 3 * rows * width);
        let mut pulled = vec![0.0; 3 * rows * width];
        let number = |k: usize| ((k * 7919) % 101) as f64 / 101.0 - 0.5;
        // The terms are squares of random linear functions of the cells' control points.
        for (n, (p, q)) in (0..6).map(|n| (n / 3, n % 3)).enumerate() {
            let at: Vec<usize> = (0..16).map(|k| (p + k / 4) * width + q + k % 4).collect();
            let g: Vec<Vector> =
                (0..16).map(|k| Vector::from_fn(|x, _| number(48 * n + 3 * k + x))).collect();
            let mut strips = system.strips(p);
            assert_eq!((strips.len(), strips[0].number), (1, p));
            let mut cell = strips[0].cell(q);
            for (i, j) in (0..256).map(|k| (k / 16, k % 16)) {
                let block = g[i] * g[j].transpose();
                if i <= j {
                    cell.couple(i, j, &block);
                }
                let mut view = dense.fixed_view_mut::<3, 3>(3 * at[i], 3 * at[j]);
                view += block;
            }
            for (i, at) in at.into_iter().enumerate() {
                let force = Vector::new(1.0, at as f64, g[i].x);
                cell.pull(i, force);
                (0..3).for_each(|x| pulled[3 * at + x] += force[x]);
            }
        }
        system.anchor(1.0);
        dense += DMatrix::identity(3 * rows * width, 3 * rows * width);
        let of: Vec<usize> =
            system.free.iter().flat_map(|&at| [3 * at, 3 * at + 1, 3 * at + 2]).collect();
        let part = dense.select_rows(&of).select_columns(&of);
        let right = of.iter().map(|&k| pulled[k]);
        let exact = part.cholesky().unwrap().solve(&DVector::from_iterator(of.len(), right));
        let steps = system.solve().unwrap();
        for (n, step) in steps.iter().enumerate() {
            assert!((0..3).all(|x| (step[x] - exact[3 * n + x]).abs() < 1e-9));
        }
    }
}
