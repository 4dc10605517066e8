//! Aggregation of unknowns for algebraic multigrid (Vaněk, Mandel, Brezina, "Algebraic multigrid by
//! smoothed aggregation", 1996).

use super::sparse::{self, Matrix};
use crate::geometry::NONE;

/// The threshold of the strength of a connection. An off-diagonal entry is strong if its square
/// exceeds this share of the product of the two diagonal entries.
const STRENGTH: f64 = 0.08 * 0.08;

/// The damping of the Jacobi step that smooths the prolongation.
const JACOBI_DAMPING: f64 = 2.0 / 3.0;

/// The smoothed prolongation from the aggregates to the rows. The second matrix is the same for the
/// transposed system; its transpose restricts residuals to the aggregates.
pub(crate) fn smoothed_prolongations(
    matrix: &Matrix,
    transposed: &Matrix,
    diagonal: &[f64],
) -> [Matrix; 2] {
    let (of, count) = aggregates(matrix, diagonal);
    let smoothed = |matrix: &Matrix| {
        sparse::from_rows([diagonal.len(), count], |i, entries| {
            entries.push((of[i], 1.0));
            for (j, a) in sparse::row(matrix, i) {
                let value = -JACOBI_DAMPING * a / diagonal[i];
                match entries.iter_mut().find(|e| e.0 == of[j]) {
                    Some(entry) => entry.1 += value,
                    None => entries.push((of[j], value)),
                }
            }
        })
    };
    [smoothed(matrix), smoothed(transposed)]
}

/// The aggregate of each row, and the number of aggregates. First come the rows with all their
/// strong connections, where these do not overlap. Neighbouring rows join them, and the remaining
/// rows form further aggregates.
fn aggregates(matrix: &Matrix, diagonal: &[f64]) -> (Vec<u32>, usize) {
    let n = diagonal.len();
    let strong = |i: usize| {
        sparse::row(matrix, i)
            .filter(move |&(j, a)| j != i && a * a > STRENGTH * diagonal[i] * diagonal[j])
    };
    let mut of = vec![NONE; n];
    let mut count = 0;
    for i in 0..n {
        let free = of[i] == NONE && strong(i).all(|(j, _)| of[j] == NONE);
        if free && strong(i).next().is_some() {
            of[i] = count;
            strong(i).for_each(|(j, _)| of[j] = count);
            count += 1;
        }
    }
    let cores = of.clone();
    for i in (0..n).filter(|&i| cores[i] == NONE) {
        let beside = strong(i).filter(|&(j, _)| cores[j] != NONE);
        if let Some((j, _)) = beside.min_by(|a, b| a.1.total_cmp(&b.1)) {
            of[i] = cores[j];
        }
    }
    for i in 0..n {
        if of[i] == NONE {
            let free: Vec<usize> = strong(i).map(|(j, _)| j).filter(|&j| of[j] == NONE).collect();
            of[i] = count;
            free.into_iter().for_each(|j| of[j] = count);
            count += 1;
        }
    }
    (of, count as usize)
}
