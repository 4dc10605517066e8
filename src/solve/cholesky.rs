//! Cholesky factors of sparse matrices: [`Cholesky`] of one matrix, and [`Pattern`] of many
//! with one and the same pattern, with their determinants.
//!
//! Both work on the thread that calls them. faer would share the work as a setting of the
//! whole process says, and the order of its sums would depend on the number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLltRef,
};
use faer::sparse::linalg::{LltError, SupernodalThreshold, amd};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::{Conj, Index, Mat, Par, Side};

/// The Cholesky factor of a sparse symmetric matrix.
#[derive(Debug)]
pub(crate) struct Cholesky<I: Index> {
    symbolic: SymbolicCholesky<I>,
    factor: Vec<f64>,
}

impl<I: Index> Cholesky<I> {
    /// Reads the lower triangle of the matrix.
    ///
    /// # Errors
    /// The matrix is not positive definite, or there is no memory for the factor.
    pub(crate) fn new(matrix: SparseColMatRef<'_, I, f64>) -> Result<Self, LltError> {
        let (side, params) = (Side::Lower, CholeskySymbolicParams::default());
        let order = SymmetricOrdering::Amd;
        let symbolic = factorize_symbolic_cholesky(matrix.symbolic(), side, order, params)?;
        let mut factor = Vec::new();
        factor.try_reserve_exact(symbolic.len_val())?;
        factor.resize(symbolic.len_val(), 0.0);
        let room = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut room = MemBuffer::try_new(room)?;
        symbolic.factorize_numeric_llt(
            &mut factor,
            matrix,
            side,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut room),
            Default::default(),
        )?;
        Ok(Cholesky { symbolic, factor })
    }

    /// Replaces the right sides, one a column, by their solutions.
    pub(crate) fn solve(&self, right: &mut Mat<f64>) {
        let room = self.symbolic.solve_in_place_scratch::<f64>(right.ncols(), Par::Seq);
        let mut room = MemBuffer::new(room);
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            right.as_mut(),
            Par::Seq,
            MemStack::new(&mut room),
        );
    }
}

/// The analysed sparsity pattern of the lower triangle of a symmetric matrix, with working memory.
pub(crate) struct Pattern {
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
    room: MemBuffer,
    factor: Vec<f64>,
}

impl Pattern {
    /// Analyses a pattern. Column j has its entries at `starts[j]..starts[j + 1]` of `rows`; they
    /// ascend and lie on and below the diagonal. `order` is the elimination order. Returns `None`
    /// if memory does not suffice.
    pub(crate) fn new(starts: Vec<usize>, rows: Vec<usize>, order: &[usize]) -> Option<Self> {
        let n = order.len();
        let mut inverse = vec![0; n];
        order.iter().enumerate().for_each(|(place, &i)| inverse[i] = place);
        let order = SymmetricOrdering::Custom(PermRef::new_checked(order, &inverse, n));
        let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        // A supernodal factor gives access to its diagonal.
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(pattern.as_ref(), Side::Lower, order, params).ok()?;
        let factoring = symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let solving = symbolic.solve_in_place_scratch::<f64>(3, Par::Seq);
        let room = MemBuffer::try_new(factoring.or(solving)).ok()?;
        let factor = vec![0.0; symbolic.len_val()];
        Some(Pattern { pattern, symbolic, room, factor })
    }

    /// Factorizes the matrix with the given entries, in the order of the pattern, and returns the
    /// logarithm of its determinant. If `right` is given it is replaced by the solution; it may
    /// have at most three columns. Returns `None` if the matrix is not positive definite.
    pub(crate) fn solve(&mut self, values: &[f64], right: Option<&mut Mat<f64>>) -> Option<f64> {
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), values);
        let stack = MemStack::new(&mut self.room);
        let regular = Default::default();
        let llt = self
            .symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                matrix,
                Side::Lower,
                regular,
                Par::Seq,
                stack,
                Default::default(),
            )
            .ok()?;
        if let Some(right) = right {
            llt.solve_in_place_with_conj(Conj::No, right.as_mut(), Par::Seq, stack);
        }
        log_determinant(&self.symbolic, &self.factor)
    }
}

/// An elimination order with little fill-in (approximate minimum degree), for a pattern as in
/// [`Pattern::new`]. Returns `None` if memory does not suffice.
pub(crate) fn least_degree(starts: &[usize], rows: &[usize]) -> Option<Vec<usize>> {
    let n = starts.len() - 1;
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, starts, None, rows);
    let mut room = MemBuffer::try_new(amd::order_scratch::<usize>(n, rows.len())).ok()?;
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let stack = MemStack::new(&mut room);
    amd::order(&mut order, &mut inverse, pattern, Default::default(), stack).ok()?;
    Some(order)
}

/// The logarithm of the determinant, or `None` if the factor is not supernodal. [`Pattern::new`]
/// forces a supernodal factor.
fn log_determinant(symbolic: &SymbolicCholesky<usize>, factor: &[f64]) -> Option<f64> {
    let SymbolicCholeskyRaw::Supernodal(nodes) = symbolic.raw() else { return None };
    let factor = SupernodalLltRef::new(nodes, factor);
    let blocks = (0..nodes.n_supernodes()).map(|s| factor.supernode(s).val());
    Some(2.0 * blocks.flat_map(|b| (0..b.ncols()).map(move |k| b[(k, k)].ln())).sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_determinant_and_the_solution_of_a_chain_are_known() {
        // Second differences with fixed ends. The determinant is n + 1.
        let n = 50;
        let starts: Vec<usize> = (0..n).map(|j| 2 * j).chain([2 * n - 1]).collect();
        let rows: Vec<usize> = (0..2 * n - 1).map(|k| k / 2 + k % 2).collect();
        let values: Vec<f64> =
            (0..2 * n - 1).map(|k| if k % 2 == 0 { 2.0 } else { -1.0 }).collect();
        for order in [(0..n).rev().collect(), least_degree(&starts, &rows).unwrap()] {
            let mut pattern = Pattern::new(starts.clone(), rows.clone(), &order).unwrap();
            let mut x = Mat::from_fn(n, 1, |i, _| if i == 0 { 1.0 } else { 0.0 });
            let log = pattern.solve(&values, Some(&mut x)).unwrap();
            assert!((log - 51f64.ln()).abs() < 1e-10);
            assert!((x[(0, 0)] - 50.0 / 51.0).abs() < 1e-12);
            let negative: Vec<f64> = values.iter().map(|v| -v).collect();
            assert!(pattern.solve(&negative, None).is_none());
        }
    }
}
