//! Sparse matrices by rows, and what they make of a plane's points.

use faer::sparse::{SparseRowMat, SymbolicSparseRowMat};
use rayon::prelude::*;

/// A sparse matrix by rows, the columns of each in ascending order.
pub type Matrix = SparseRowMat<u32, f64>;

/// Two unknowns, u and v, that share the rows of a matrix.
pub type Pair = [f64; 2];

/// Rows that one thread takes at a time. Where results depend on it, it is this
/// and not the number of threads that counts.
pub const BLOCK: usize = 1 << 13;

/// A matrix from its rows: `row` puts pairs of column and value, no column twice, into
/// an empty vector.
pub fn from_rows(
    size: [usize; 2],
    row: impl Fn(usize, &mut Vec<(u32, f64)>) + Sync + Send,
) -> Matrix {
    let block = |first: usize| {
        let mut entries: Vec<(u32, f64)> = Vec::new();
        let (mut columns, mut values, mut counts) = (Vec::new(), Vec::new(), Vec::new());
        for i in first..size[0].min(first + BLOCK) {
            entries.clear();
            row(i, &mut entries);
            entries.sort_unstable_by_key(|e| e.0);
            columns.extend(entries.iter().map(|e| e.0));
            values.extend(entries.iter().map(|e| e.1));
            counts.push(entries.len() as u32);
        }
        (columns, values, counts)
    };
    let blocks: Vec<_> =
        (0..size[0].div_ceil(BLOCK)).into_par_iter().map(|k| block(k * BLOCK)).collect();
    let count = blocks.iter().map(|b| b.0.len()).sum();
    let (mut columns, mut values) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut starts = vec![0];
    let mut end = 0;
    for (of_columns, of_values, counts) in blocks {
        columns.extend(of_columns);
        values.extend(of_values);
        for count in counts {
            end += count;
            starts.push(end);
        }
    }
    let pattern = SymbolicSparseRowMat::new_checked(size[0], size[1], starts, None, columns);
    Matrix::new(pattern, values)
}

/// The columns and values of a row.
pub fn row(matrix: &Matrix, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let range = matrix.symbolic().row_range(i);
    let columns = matrix.symbolic().col_idx()[range.clone()].iter();
    columns.zip(&matrix.val()[range]).map(|(&j, &a)| (j as usize, a))
}

/// A row times a vector.
pub fn product(matrix: &Matrix, i: usize, x: &[Pair]) -> Pair {
    row(matrix, i).fold([0.0; 2], |sum, (j, a)| [sum[0] + a * x[j][0], sum[1] + a * x[j][1]])
}

/// Puts into each place of `out` what its number and its value make.
pub fn fill(out: &mut [Pair], make: impl Fn(usize, Pair) -> Pair + Sync + Send) {
    out.par_chunks_mut(BLOCK).enumerate().for_each(|(k, block)| {
        block.iter_mut().enumerate().for_each(|(i, value)| *value = make(k * BLOCK + i, *value));
    });
}

/// b − Ax, into `out`.
pub fn residual(matrix: &Matrix, b: &[Pair], x: &[Pair], out: &mut [Pair]) {
    fill(out, |i, _| {
        let ax = product(matrix, i, x);
        [b[i][0] - ax[0], b[i][1] - ax[1]]
    });
}

/// Adds `factor` times `step` to `x`.
pub fn add(x: &mut [Pair], factor: f64, step: &[Pair]) {
    fill(x, |i, x| [0, 1].map(|k| x[k] + factor * step[i][k]));
}
