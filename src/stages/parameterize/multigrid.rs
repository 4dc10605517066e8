//! A multigrid cycle by smoothed aggregation, used as a preconditioner of Krylov methods.

use faer::Par;
use faer::sparse::linalg::matmul::sparse_sparse_matmul;
use rayon::prelude::*;

use super::aggregates;
use super::lu::Lu;
use super::sparse::{self, Matrix, UvPair};
use crate::geometry::BLOCK;

/// A system with at most this number of unknowns is solved directly.
pub(crate) const DIRECT_SIZE: usize = 500;

/// A coarser level is used only if it has at most this share of the unknowns.
const MAX_COARSENING: f64 = 0.7;

/// A linear system and a sequence of coarser systems that approximate it.
#[derive(Debug)]
pub(crate) struct Multigrid {
    levels: Vec<GridLevel>,
    last: Lu,
}

/// What a cycle writes on one level: the solution before a sweep or its residual, and both
/// sides of the next smaller system.
#[derive(Debug)]
pub(crate) struct Room {
    x: Vec<UvPair>,
    coarse_b: Vec<UvPair>,
    coarse_x: Vec<UvPair>,
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
        let last = Lu::new(matrix.to_col_major().ok()?.as_ref()).ok()?;
        (!levels.is_empty()).then_some(Multigrid { levels, last })
    }

    /// The matrix of the finest system.
    pub(crate) fn matrix(&self) -> &Matrix {
        &self.levels[0].matrix
    }

    /// Room for [`Multigrid::apply`].
    pub(crate) fn room(&self) -> Vec<Room> {
        let zeros = |n: usize| vec![[0.0; 2]; n];
        let of = |level: &GridLevel| {
            let (n, few) = (level.matrix.nrows(), level.prolongation.ncols());
            Room { x: zeros(n), coarse_b: zeros(few), coarse_x: zeros(few) }
        };
        self.levels.iter().map(of).collect()
    }

    /// Writes about what solves the largest system for `b` into `x`.
    pub(crate) fn apply(&self, b: &[UvPair], x: &mut [UvPair], room: &mut [Room]) {
        self.cycle(&self.levels, b, x, room);
    }

    /// The same for the first of these levels.
    fn cycle(&self, levels: &[GridLevel], b: &[UvPair], x: &mut [UvPair], room: &mut [Room]) {
        let (Some((here, smaller)), Some((own, room))) =
            (levels.split_first(), room.split_first_mut())
        else {
            return self.solve_last(b, x);
        };
        x.fill([0.0; 2]);
        own.x.fill([0.0; 2]);
        here.sweep(b, &own.x, x, false);
        sparse::residual(&here.matrix, b, x, &mut own.x);
        sparse::fill(&mut own.coarse_b, |i, _| sparse::product(&here.restriction, i, &own.x));
        self.cycle(smaller, &own.coarse_b, &mut own.coarse_x, room);
        sparse::fill(x, |i, x| {
            let step = sparse::product(&here.prolongation, i, &own.coarse_x);
            [x[0] + step[0], x[1] + step[1]]
        });
        own.x.copy_from_slice(x);
        here.sweep(b, &own.x, x, true);
    }

    fn solve_last(&self, b: &[UvPair], x: &mut [UvPair]) {
        let mut solution = faer::Mat::from_fn(b.len(), 2, |i, k| b[i][k]);
        self.last.solve(&mut solution);
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
