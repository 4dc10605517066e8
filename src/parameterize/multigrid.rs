//! A multigrid cycle by smoothed aggregation, as a preconditioner of Krylov methods.

use faer::Par;
use faer::sparse::linalg::matmul::sparse_sparse_matmul;
use rayon::prelude::*;

use super::aggregates;
use super::lu::Lu;
use super::sparse::{self, BLOCK, Matrix, Pair};

/// A system of no more unknowns is solved directly.
pub const FEW: usize = 500;

/// A level worth having leaves this share of the unknowns at the most.
const FEWER: f64 = 0.7;

/// A system, and ever smaller ones that resemble it.
#[derive(Debug)]
pub struct Multigrid {
    levels: Vec<Level>,
    last: Lu,
}

/// What a cycle writes on one level: the solution before a sweep or its residual, and both
/// sides of the next smaller system.
#[derive(Debug)]
pub struct Room {
    x: Vec<Pair>,
    coarse_b: Vec<Pair>,
    coarse_x: Vec<Pair>,
}

/// A system and how it becomes the next smaller one.
#[derive(Debug)]
struct Level {
    matrix: Matrix,
    diagonal: Vec<f64>,
    /// From the next level's unknowns to this one's, and back.
    prolongation: Matrix,
    restriction: Matrix,
}

impl Multigrid {
    /// For a square matrix whose diagonal is positive. `None` if that is singular, too
    /// large for the memory, or no smaller system resembles it.
    pub fn new(mut matrix: Matrix) -> Option<Self> {
        let mut levels: Vec<Level> = Vec::new();
        while matrix.nrows() > FEW {
            let level = Level::new(matrix)?;
            let coarse = level.coarse()?;
            let few = FEWER * level.diagonal.len() as f64;
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

    /// The largest system.
    pub fn matrix(&self) -> &Matrix {
        &self.levels[0].matrix
    }

    /// Room for [`Multigrid::apply`].
    pub fn room(&self) -> Vec<Room> {
        let zeros = |n: usize| vec![[0.0; 2]; n];
        let of = |level: &Level| {
            let (n, few) = (level.matrix.nrows(), level.prolongation.ncols());
            Room { x: zeros(n), coarse_b: zeros(few), coarse_x: zeros(few) }
        };
        self.levels.iter().map(of).collect()
    }

    /// Writes about what solves the largest system for `b` into `x`.
    pub fn apply(&self, b: &[Pair], x: &mut [Pair], room: &mut [Room]) {
        self.cycle(&self.levels, b, x, room);
    }

    /// The same for the first of these levels.
    fn cycle(&self, levels: &[Level], b: &[Pair], x: &mut [Pair], room: &mut [Room]) {
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

    fn solve_last(&self, b: &[Pair], x: &mut [Pair]) {
        let mut solution = faer::Mat::from_fn(b.len(), 2, |i, k| b[i][k]);
        self.last.solve(&mut solution);
        x.iter_mut().enumerate().for_each(|(i, x)| *x = [solution[(i, 0)], solution[(i, 1)]]);
    }
}

impl Level {
    fn new(matrix: Matrix) -> Option<Self> {
        let on_it = |i: usize| sparse::row(&matrix, i).find(|e| e.0 == i).map_or(0.0, |e| e.1);
        let diagonal: Vec<f64> = (0..matrix.nrows()).into_par_iter().map(on_it).collect();
        let transposed = matrix.to_col_major().ok()?.into_transpose();
        let [prolongation, back] = aggregates::slopes(&matrix, &transposed, &diagonal);
        let restriction = back.to_col_major().ok()?.into_transpose();
        Some(Level { matrix, diagonal, prolongation, restriction })
    }

    /// The next smaller system: the restriction of the matrix' product with the
    /// prolongation.
    fn coarse(&self) -> Option<Matrix> {
        let product = |a, b| sparse_sparse_matmul(a, b, 1.0, Par::Seq).ok();
        // Matrices by columns from those by rows: all are transposed.
        let half = product(self.prolongation.transpose(), self.matrix.transpose())?;
        Some(product(half.as_ref(), self.restriction.transpose())?.into_transpose())
    }

    /// Gauss and Seidel's method from `old`, block by block: within a block with its
    /// own new values.
    fn sweep(&self, b: &[Pair], old: &[Pair], x: &mut [Pair], backwards: bool) {
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
