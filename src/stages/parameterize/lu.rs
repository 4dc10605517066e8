//! LU factors of sparse matrices, made and used on the thread that asks for them. faer would
//! share the work as a setting of the whole process says.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use faer::{Conj, Mat, Par};

/// The LU factors of a square matrix, rows exchanged for the largest pivots.
#[derive(Debug)]
pub(crate) struct Lu {
    symbolic: SymbolicLu<u32>,
    numeric: NumericLu<u32, f64>,
}

impl Lu {
    /// Factorizes a matrix.
    ///
    /// # Errors
    /// The pattern of the matrix is that of a singular one, or there is no memory for the
    /// factors.
    pub(super) fn new(matrix: SparseColMatRef<'_, u32, f64>) -> Result<Self, LuError> {
        let symbolic = factorize_symbolic_lu(matrix.symbolic(), Default::default())?;
        let room = symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
        let mut room = MemBuffer::try_new(room)?;
        let mut numeric = NumericLu::new();
        symbolic.factorize_numeric_lu(
            &mut numeric,
            matrix,
            Par::Seq,
            MemStack::new(&mut room),
            Default::default(),
        )?;
        Ok(Lu { symbolic, numeric })
    }

    /// Replaces the right sides, one a column, by their solutions.
    pub(crate) fn solve(&self, right: &mut Mat<f64>) {
        let room = self.symbolic.solve_in_place_scratch::<f64>(right.ncols(), Par::Seq);
        let mut room = MemBuffer::new(room);
        LuRef::new_unchecked(&self.symbolic, &self.numeric).solve_in_place_with_conj(
            Conj::No,
            right.as_mut(),
            Par::Seq,
            MemStack::new(&mut room),
        );
    }
}
