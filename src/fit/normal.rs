//! The normal equations of the global least-squares fit.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::cells::Cells;
use super::fairing;
use crate::error::{Error, Result};
use crate::geometry::Vector;
use crate::spline::{KnotVector, Samples};

/// Neighbours along one parameter with which a cubic's control point shares a
/// cell: three on each side and itself.
pub const REACH: usize = 7;

/// A row of the matrix: entry (di + 3) * 7 + dj + 3 couples control point
/// (i, j) with (i + di, j + dj).
pub type Row = [f64; REACH * REACH];

/// Least squares plus a weak fairing term, as one sparse symmetric system.
pub struct Equations {
    /// Control points in u and v.
    pub shape: [usize; 2],
    /// The matrix, a row a control point.
    pub rows: Vec<Row>,
    /// The right-hand side.
    pub right: Vec<Vector>,
    /// Marginal mass matrices, for the preconditioner: lower bands of
    /// Σ w b(u) b(u)ᵀ and of the same in v.
    pub marginals: [Vec<[f64; 4]>; 2],
}

struct CellSums {
    gram: SMatrix<f64, 16, 16>,
    right: SMatrix<f64, 16, 3>,
}

impl Equations {
    /// Sums up the samples cell by cell and adds the fairing term.
    pub fn new(samples: &Samples, cells: &Cells) -> Self {
        let [across, down] = cells.counts();
        let shape = [across + 3, down + 3];
        let size = shape[0] * shape[1];
        let mut equations = Equations {
            shape,
            rows: vec![[0.0; REACH * REACH]; size],
            right: vec![Vector::zeros(); size],
            marginals: [marginal(samples, cells.u, 0), marginal(samples, cells.v, 1)],
        };
        // A strip of cells at a time keeps the sums of all cells out of memory.
        for p in 0..across {
            let sums: Vec<CellSums> =
                (0..down).into_par_iter().map(|q| cell_sums(samples, cells, p, q)).collect();
            for (q, sums) in sums.iter().enumerate() {
                equations.scatter(p, q, sums);
            }
        }
        fairing::add(&mut equations, samples, cells);
        equations
    }

    fn scatter(&mut self, p: usize, q: usize, sums: &CellSums) {
        for k in 0..16 {
            let (i, j) = (p + k / 4, q + k % 4);
            let at = i * self.shape[1] + j;
            self.right[at] += sums.right.row(k).transpose();
            for l in 0..16 {
                let entry = (l / 4 + 3 - k / 4) * REACH + l % 4 + 3 - k % 4;
                self.rows[at][entry] += sums.gram[(k.max(l), k.min(l))];
            }
        }
    }

    /// The neighbours of a control point that exist: (entry in the row, index).
    pub fn couplings(&self, at: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let [nu, nv] = self.shape;
        let (i, j) = (at / nv, at % nv);
        (0..REACH * REACH).filter_map(move |entry| {
            let (ii, jj) = (i + entry / REACH, j + entry % REACH);
            let inside = (3..nu + 3).contains(&ii) && (3..nv + 3).contains(&jj);
            inside.then(|| (entry, (ii - 3) * nv + jj - 3))
        })
    }

    /// The matrix times a net.
    pub fn times(&self, net: &[Vector]) -> Vec<Vector> {
        let row = |at: usize| {
            let terms = self.couplings(at).map(|(entry, other)| net[other] * self.rows[at][entry]);
            terms.fold(Vector::zeros(), |sum, term| sum + term)
        };
        (0..net.len()).into_par_iter().map(row).collect()
    }

    /// The solution by sparse Cholesky.
    pub fn solve_directly(&self) -> Result<Vec<Vector>> {
        let n = self.rows.len();
        let mut triplets = Vec::with_capacity(25 * n);
        for at in 0..n {
            let lower = self.couplings(at).filter(|&(_, other)| other <= at);
            triplets.extend(
                lower.map(|(entry, other)| {
                    Triplet::new(at as u32, other as u32, self.rows[at][entry])
                }),
            );
        }
        let singular = Error::Singular("fit");
        let Ok(matrix) = SparseColMat::<u32, f64>::try_new_from_triplets(n, n, &triplets) else {
            return Err(singular);
        };
        let Ok(factor) = matrix.sp_cholesky(faer::Side::Lower) else { return Err(singular) };
        let right = faer::Mat::from_fn(n, 3, |i, axis| self.right[i][axis]);
        let x = factor.solve(&right);
        Ok((0..n).map(|i| Vector::new(x[(i, 0)], x[(i, 1)], x[(i, 2)])).collect())
    }
}

fn cell_sums(samples: &Samples, cells: &Cells, p: usize, q: usize) -> CellSums {
    let mut sums = CellSums { gram: SMatrix::zeros(), right: SMatrix::zeros() };
    for &i in cells.samples(p, q) {
        let (at, i) = (samples.uv[i as usize], i as usize);
        let bu = cells.u.basis_in(p + 3, at.x).derivative[0];
        let bv = cells.v.basis_in(q + 3, at.y).derivative[0];
        let basis = SVector::<f64, 16>::from_fn(|k, _| bu[k / 4] * bv[k % 4]);
        sums.gram.syger(samples.weights[i], &basis, &basis, 1.0);
        sums.right.ger(samples.weights[i], &basis, &samples.points[i].coords, 1.0);
    }
    sums
}

/// Lower band of Σ w b bᵀ along one parameter: `band[i][d]` couples i and i − d.
fn marginal(samples: &Samples, knots: &KnotVector, axis: usize) -> Vec<[f64; 4]> {
    let mut band = vec![[0.0; 4]; knots.functions()];
    for (at, w) in samples.uv.iter().zip(&samples.weights) {
        let b = knots.basis(at[axis]);
        for k in 0..4 {
            for l in 0..=k {
                band[b.first + k][k - l] += w * b.derivative[0][k] * b.derivative[0][l];
            }
        }
    }
    band
}
