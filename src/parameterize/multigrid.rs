//! A multigrid cycle by smoothed aggregation, used as a preconditioner of Krylov methods.

use faer::dyn_stack::{MemStack, StackReq};
use faer::matrix_free::{LinOp, Precond};
use faer::prelude::Solve;
use faer::sparse::linalg::matmul::sparse_sparse_matmul;
use faer::sparse::linalg::solvers::Lu;
use faer::{MatMut, MatRef, Par};
use rayon::prelude::*;

use super::aggregates;
use super::sparse::{self, BLOCK, Matrix, UvPair};

/// A system with at most this number of unknowns is solved directly.
pub const DIRECT_SIZE: usize = 500;

/// A coarser level is used only if it has at most this share of the unknowns.
const MAX_COARSENING: f64 = 0.7;

/// A linear system and a sequence of coarser systems that approximate it.
#[derive(Debug)]
pub struct Multigrid {
    levels: Vec<GridLevel>,
    last: Lu<u32, f64>,
}

/// A system and its transfer to the next coarser one.
#[derive(Debug)]
struct GridLevel {
    matrix: Matrix,
    diagonal: Vec<f64>,
    /// The maps from the unknowns of the next level to those of this one, and back.
    prolongation: Matrix,
    restriction: Matrix,
}

impl Multigrid {
    /// Builds the levels for a square matrix with a positive diagonal. Returns `None` if the matrix
    /// is singular or too large for the memory, or if it cannot be coarsened.
    pub fn new(mut matrix: Matrix) -> Option<Self> {
        let mut levels: Vec<GridLevel> = Vec::new();
        while matrix.nrows() > DIRECT_SIZE {
            let level = GridLevel::new(matrix)?;
            let coarse = level.coarse()?;
            let few = MAX_COARSENING * level.diagonal.len() as f64;
            if coarse.nrows() as f64 > few {
                matrix = level.matrix;
                break;
            }
            levels.push(level);
            matrix = coarse;
        }
        let last = matrix.to_col_major().ok()?.sp_lu().ok()?;
        (!levels.is_empty()).then_some(Multigrid { levels, last })
    }

    /// The matrix of the finest system.
    pub fn matrix(&self) -> &Matrix {
        &self.levels[0].matrix
    }

    /// Approximately solves the system of `level` for the right-hand side `b`, into `x`.
    fn cycle(&self, level: usize, b: &[UvPair], x: &mut [UvPair], stack: &mut MemStack) {
        let Some(here) = self.levels.get(level) else { return self.solve_last(b, x) };
        let (n, few) = (x.len(), here.prolongation.ncols());
        let (mut room, stack) = stack.make_with(n, |_| [0.0; 2]);
        x.fill([0.0; 2]);
        here.sweep(b, &room, x, false);
        sparse::residual(&here.matrix, b, x, &mut room);
        let (mut coarse_b, stack) = stack.make_with(few, |_| [0.0; 2]);
        sparse::fill(&mut coarse_b, |i, _| sparse::product(&here.restriction, i, &room));
        let (mut coarse_x, stack) = stack.make_with(few, |_| [0.0; 2]);
        self.cycle(level + 1, &coarse_b, &mut coarse_x, stack);
        sparse::fill(x, |i, x| {
            let step = sparse::product(&here.prolongation, i, &coarse_x);
            [x[0] + step[0], x[1] + step[1]]
        });
        room.copy_from_slice(x);
        here.sweep(b, &room, x, true);
    }

    fn solve_last(&self, b: &[UvPair], x: &mut [UvPair]) {
        let right = faer::Mat::from_fn(b.len(), 2, |i, k| b[i][k]);
        let solution = self.last.solve(&right);
        x.iter_mut().enumerate().for_each(|(i, x)| *x = [solution[(i, 0)], solution[(i, 1)]]);
    }
}

impl GridLevel {
    fn new(matrix: Matrix) -> Option<Self> {
        let on_it = |i: usize| sparse::row(&matrix, i).find(|e| e.0 == i).map_or(0.0, |e| e.1);
        let diagonal: Vec<f64> = (0..matrix.nrows()).into_par_iter().map(on_it).collect();
        let transposed = matrix.to_col_major().ok()?.into_transpose();
        let [prolongation, back] =
            aggregates::smoothed_prolongations(&matrix, &transposed, &diagonal);
        let restriction = back.to_col_major().ok()?.into_transpose();
        Some(GridLevel { matrix, diagonal, prolongation, restriction })
    }

    /// The matrix of the next coarser system: restriction times matrix times prolongation.
    fn coarse(&self) -> Option<Matrix> {
        let product = |a, b| sparse_sparse_matmul(a, b, 1.0, Par::Seq).ok();
        // The product is computed on the transposed matrices, because these are stored by columns.
        let half = product(self.prolongation.transpose(), self.matrix.transpose())?;
        Some(product(half.as_ref(), self.restriction.transpose())?.into_transpose())
    }

    /// One Gauss–Seidel sweep from `old`, block by block. Within a block the new values are used.
    fn sweep(&self, b: &[UvPair], old: &[UvPair], x: &mut [UvPair], backwards: bool) {
        x.par_chunks_mut(BLOCK).enumerate().for_each(|(k, block)| {
            let first = k * BLOCK;
            for place in 0..block.len() {
                let place = if backwards { block.len() - 1 - place } else { place };
                let i = first + place;
                let mut rest = b[i];
                for (j, a) in sparse::row(&self.matrix, i) {
                    let x = *block.get(j.wrapping_sub(first)).unwrap_or(&old[j]);
                    rest = [rest[0] - a * x[0], rest[1] - a * x[1]];
                }
                let x = &mut block[place];
                *x = [x[0] + rest[0] / self.diagonal[i], x[1] + rest[1] / self.diagonal[i]];
            }
        });
    }
}

/// A column as a slice of pairs.
fn pairs(column: MatRef<'_, f64>) -> Option<&[UvPair]> {
    Some(column.col(0).try_as_col_major()?.as_slice().as_chunks().0)
}

fn pairs_mut(column: MatMut<'_, f64>) -> Option<&mut [UvPair]> {
    Some(column.col_mut(0).try_as_col_major_mut()?.as_slice_mut().as_chunks_mut().0)
}

/// The matrix of the finest system, applied to columns of pairs.
#[derive(Debug)]
pub struct Operator<'a>(pub &'a Matrix);

impl LinOp<f64> for Operator<'_> {
    fn apply_scratch(&self, _: usize, _: Par) -> StackReq {
        StackReq::EMPTY
    }

    fn nrows(&self) -> usize {
        2 * self.0.nrows()
    }

    fn ncols(&self) -> usize {
        2 * self.0.ncols()
    }

    fn apply(&self, out: MatMut<'_, f64>, x: MatRef<'_, f64>, _: Par, _: &mut MemStack) {
        if let (Some(out), Some(x)) = (pairs_mut(out), pairs(x)) {
            sparse::fill(out, |i, _| sparse::product(self.0, i, x));
        }
    }

    fn conj_apply(&self, out: MatMut<'_, f64>, x: MatRef<'_, f64>, par: Par, room: &mut MemStack) {
        self.apply(out, x, par, room);
    }
}

impl LinOp<f64> for Multigrid {
    fn apply_scratch(&self, _: usize, _: Par) -> StackReq {
        let of = |level: &GridLevel| {
            let pairs = level.matrix.nrows() + 2 * level.prolongation.ncols();
            StackReq::new::<UvPair>(pairs + 3)
        };
        StackReq::all_of(&self.levels.iter().map(of).collect::<Vec<_>>())
    }

    fn nrows(&self) -> usize {
        2 * self.matrix().nrows()
    }

    fn ncols(&self) -> usize {
        self.nrows()
    }

    fn apply(&self, out: MatMut<'_, f64>, b: MatRef<'_, f64>, _: Par, room: &mut MemStack) {
        if let (Some(x), Some(b)) = (pairs_mut(out), pairs(b)) {
            self.cycle(0, b, x, room);
        }
    }

    fn conj_apply(&self, out: MatMut<'_, f64>, b: MatRef<'_, f64>, par: Par, room: &mut MemStack) {
        self.apply(out, b, par, room);
    }
}

impl Precond<f64> for Multigrid {}
