//! Preconditioned BiCGStab (H. A. van der Vorst, "Bi-CGSTAB: a fast and smoothly converging
//! variant of Bi-CG for the solution of nonsymmetric linear systems", 1992), with the
//! preconditioner on the right.
//!
//! Sums run in a fixed order, so that the result has the same bytes on any number of threads.

use rayon::prelude::*;

use super::sparse::{self, Matrix, UvPair};
use crate::geometry::BLOCK;

/// When to stop.
pub(crate) struct Limits {
    /// The residual that is small enough, as a share of the right side. Norms are Euclidean.
    pub residual: f64,
    /// The largest number of steps.
    pub steps: usize,
}

/// Solves `matrix` x = `right` from x = 0. u and v are the unknowns of one system.
/// `precondition` takes a right side and overwrites a second vector with an approximate
/// solution for it.
///
/// The result is what the last step came to. The caller must look at the residual that it
/// leaves; the numbers are not finite where the method breaks down.
pub(crate) fn solve(
    matrix: &Matrix,
    mut precondition: impl FnMut(&[UvPair], &mut [UvPair]),
    right: &[UvPair],
    limits: &Limits,
) -> Vec<UvPair> {
    let zeros = || vec![[0.0; 2]; right.len()];
    let (mut x, mut r, mut p) = (zeros(), right.to_vec(), right.to_vec());
    let (mut direction, mut v, mut t) = (zeros(), zeros(), zeros());
    let small = limits.residual.powi(2) * dot(right, right);
    let mut rho = dot(right, &r);
    if rho == 0.0 {
        return x;
    }
    for _ in 0..limits.steps {
        precondition(&p, &mut direction);
        multiply(matrix, &direction, &mut v);
        let alpha = rho / dot(right, &v);
        sparse::add(&mut x, alpha, &direction);
        sparse::add(&mut r, -alpha, &v);
        if dot(&r, &r) < small {
            break;
        }
        precondition(&r, &mut direction);
        multiply(matrix, &direction, &mut t);
        let omega = dot(&t, &r) / dot(&t, &t);
        sparse::add(&mut x, omega, &direction);
        sparse::add(&mut r, -omega, &t);
        if dot(&r, &r) < small {
            break;
        }
        let before = std::mem::replace(&mut rho, dot(right, &r));
        let beta = rho / before * (alpha / omega);
        // p = r + beta (p - omega v)
        sparse::fill(&mut p, |i, p| [0, 1].map(|k| r[i][k] + beta * (p[k] - omega * v[i][k])));
    }
    x
}

fn multiply(matrix: &Matrix, x: &[UvPair], out: &mut [UvPair]) {
    sparse::fill(out, |i, _| sparse::product(matrix, i, x));
}

fn dot(a: &[UvPair], b: &[UvPair]) -> f64 {
    let of = |(a, b): (&[UvPair], &[UvPair])| -> f64 {
        a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
    };
    let blocks: Vec<f64> = a.par_chunks(BLOCK).zip(b.par_chunks(BLOCK)).map(of).collect();
    blocks.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::super::lu::Lu;
    use super::*;

    /// Flow along a line of `n` cells with some diffusion: not symmetric.
    fn flow(n: usize) -> Matrix {
        sparse::from_rows([n; 2], |i, row| {
            row.push((i as u32, 3.0));
            row.extend((i > 0).then(|| (i as u32 - 1, -1.9)));
            row.extend((i + 1 < n).then(|| (i as u32 + 1, -0.9)));
        })
    }

    fn right(n: usize) -> Vec<UvPair> {
        (0..n).map(|i| [(0.7 * i as f64).sin(), (0.1 * i as f64).cos()]).collect()
    }

    #[test]
    fn it_comes_to_the_direct_solution_with_a_preconditioner_and_without() {
        let n = 2000;
        let (matrix, right) = (flow(n), right(n));
        let mut direct = faer::Mat::from_fn(n, 2, |i, k| right[i][k]);
        Lu::new(matrix.to_col_major().unwrap().as_ref()).unwrap().solve(&mut direct);
        let limits = Limits { residual: 1e-13, steps: 500 };
        let none = |b: &[UvPair], x: &mut [UvPair]| x.copy_from_slice(b);
        // By the diagonal and what is below it.
        let below = |b: &[UvPair], x: &mut [UvPair]| {
            for i in 0..b.len() {
                let before = if i > 0 { x[i - 1] } else { [0.0; 2] };
                x[i] = [0, 1].map(|k| (b[i][k] + 1.9 * before[k]) / 3.0);
            }
        };
        let plain = solve(&matrix, none, &right, &limits);
        for found in [plain, solve(&matrix, below, &right, &limits)] {
            let off =
                |(i, x): (usize, &UvPair)| (x[0] - direct[(i, 0)]).hypot(x[1] - direct[(i, 1)]);
            let farthest = found.iter().enumerate().map(off).fold(0.0, f64::max);
            assert!(farthest < 1e-10, "{farthest}");
        }
        let few = Limits { residual: 1e-13, steps: 3 };
        let early = solve(&matrix, none, &right, &few);
        assert!((early[n / 2][0] - direct[(n / 2, 0)]).abs() > 1e-8, "it stops where it must");
    }

    #[test]
    fn nothing_on_the_right_has_the_solution_zero() {
        let none = |b: &[UvPair], x: &mut [UvPair]| x.copy_from_slice(b);
        let limits = Limits { residual: 1e-6, steps: 9 };
        assert_eq!(solve(&flow(5), none, &[[0.0; 2]; 5], &limits), [[0.0; 2]; 5]);
    }
}
