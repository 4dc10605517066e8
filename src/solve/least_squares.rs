//! Sparse linear least-squares problems whose unknowns are points.

use faer::Mat;
use rayon::prelude::*;

use crate::geometry::Vector;
use crate::solve::cholesky::{Pattern, least_degree};

/// The normal equations of a sparse least-squares problem, whose targets are points. Their pattern is
/// analysed once.
pub(crate) struct SparseNormal {
    /// Column b has the rows `starts[b]..starts[b + 1]` of `rows`, of the lower triangle.
    starts: Vec<usize>,
    rows: Vec<usize>,
    pattern: Pattern,
    values: Vec<f64>,
    right: Mat<f64>,
}

impl SparseNormal {
    /// The equations of unknowns of which those of one column occur together. A column needs only the
    /// unknowns from its own one on, in any order and any number of times. Returns `None` if memory does not
    /// suffice.
    pub(crate) fn new(mut columns: Vec<Vec<usize>>) -> Option<Self> {
        columns.par_iter_mut().for_each(|rows| {
            rows.sort_unstable();
            rows.dedup();
        });
        let mut starts = vec![0];
        starts.extend(columns.iter().scan(0, |end, rows| {
            *end += rows.len();
            Some(*end)
        }));
        let rows = columns.concat();
        let order = least_degree(&starts, &rows)?;
        let pattern = Pattern::new(starts.clone(), rows.clone(), &order)?;
        let (values, right) = (vec![0.0; rows.len()], Mat::zeros(columns.len(), 3));
        Some(SparseNormal { starts, rows, pattern, values, right })
    }

    /// Sets all entries to zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
        self.right = Mat::zeros(self.right.nrows(), 3);
    }

    /// Adds to an entry of the matrix if it is in the lower triangle.
    pub(crate) fn add(&mut self, a: usize, b: usize, value: f64) {
        if a >= b && value != 0.0 {
            let column = self.starts[b]..self.starts[b + 1];
            if let Ok(k) = self.rows[column].binary_search(&a) {
                self.values[self.starts[b] + k] += value;
            }
        }
    }

    /// Adds to a right side.
    pub(crate) fn add_right(&mut self, a: usize, value: Vector) {
        (0..3).for_each(|k| self.right[(a, k)] += value[k]);
    }

    /// Adds that the combination of unknowns is the target.
    pub(crate) fn add_row(&mut self, row: &[(usize, f64)], weight: f64, target: Vector) {
        for &(a, x) in row {
            self.add_right(a, weight * x * target);
            row.iter().for_each(|&(b, y)| self.add(a, b, weight * x * y));
        }
    }

    /// The unknowns. Returns `None` if they are not determined.
    pub(crate) fn solve(&mut self) -> Option<Vec<Vector>> {
        self.pattern.solve(&self.values, Some(&mut self.right))?;
        let right = &self.right;
        let unknown = |v: usize| Vector::new(right[(v, 0)], right[(v, 1)], right[(v, 2)]);
        Some((0..right.nrows()).map(unknown).collect())
    }
}
