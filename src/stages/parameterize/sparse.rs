//! Sparse matrices stored by rows, applied to vectors of points in the plane.

use crate::geometry::BLOCK;
use faer::sparse::{SparseRowMat, SymbolicSparseRowMat};
use rayon::prelude::*;

/// A sparse matrix by rows. The columns of each row ascend.
pub type Matrix = SparseRowMat<u32, f64>;

/// Two unknowns, u and v, with the same matrix row.
pub(crate) type UvPair = [f64; 2];

/// Builds a matrix from its rows. `row` fills an empty vector with pairs of column and value,
/// without repeating a column.
pub(crate) fn from_rows(
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
pub(crate) fn row(matrix: &Matrix, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let range = matrix.symbolic().row_range(i);
    let columns = matrix.symbolic().col_idx()[range.clone()].iter();
    columns.zip(&matrix.val()[range]).map(|(&j, &a)| (j as usize, a))
}

/// The product of a row and a vector.
pub(crate) fn product(matrix: &Matrix, i: usize, x: &[UvPair]) -> UvPair {
    row(matrix, i).fold([0.0; 2], |sum, (j, a)| [sum[0] + a * x[j][0], sum[1] + a * x[j][1]])
}

/// Replaces each entry of `out` by `make(index, entry)`.
pub fn fill(out: &mut [UvPair], make: impl Fn(usize, UvPair) -> UvPair + Sync + Send) {
    out.par_chunks_mut(BLOCK).enumerate().for_each(|(k, block)| {
        block.iter_mut().enumerate().for_each(|(i, value)| *value = make(k * BLOCK + i, *value));
    });
}

/// Computes b − Ax into `out`.
pub(crate) fn residual(matrix: &Matrix, b: &[UvPair], x: &[UvPair], out: &mut [UvPair]) {
    fill(out, |i, _| {
        let ax = product(matrix, i, x);
        [b[i][0] - ax[0], b[i][1] - ax[1]]
    });
}

/// Adds `factor` times `step` to `x`.
pub(crate) fn add(x: &mut [UvPair], factor: f64, step: &[UvPair]) {
    fill(x, |i, x| [0, 1].map(|k| x[k] + factor * step[i][k]));
}
