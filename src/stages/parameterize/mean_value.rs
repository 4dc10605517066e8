//! The map of the paper: every inner vertex is the mean of its neighbours with mean value weights
//! (Floater 2003). All vertices are solved for at once.

use rayon::prelude::*;

use super::bicgstab::{self, Limits};
use super::multigrid::{DIRECT_SIZE, Multigrid};
use super::solve;
use super::sparse::{self, Matrix, UvPair};
use crate::error::Result;
use crate::geometry::{NONE, Point, ROUNDING, Uv};
use crate::mesh::one_rings::OneRings;

/// The reduction of the residual in one round of BiCGStab.
const ROUND_REDUCTION: f64 = 1e-6;

/// The largest number of steps in a round, and the largest number of rounds.
const MAX_STEPS: [usize; 2] = [60, 8];

/// The number of balancing steps of the scales of the rows.
const BALANCING: usize = 10;

/// Moves the inner vertices to the solution: each is the mean of its neighbours with mean value
/// weights. The boundary must already be in place.
///
/// The solver is BiCGStab (van der Vorst 1992), preconditioned by a multigrid cycle. A direct
/// solver is used for few vertices, or if the iteration does not converge.
pub(crate) fn map(points: &[Point], rings: &OneRings, at: &mut [Uv]) -> Result<()> {
    let inner: Vec<u32> = (0..rings.len() as u32)
        .filter(|&v| !rings.on_boundary(v) && !rings.ring(v).is_empty())
        .collect();
    let many = inner.len() > DIRECT_SIZE;
    match many.then(|| MeanValueSystem::new(points, rings, &inner, at).iterated()).flatten() {
        Some(found) => {
            inner.iter().zip(found).for_each(|(&v, x)| at[v as usize] = x.into());
            Ok(())
        }
        None => solve::mean_value(points, rings, &inner, at),
    }
}

/// The linear equations of the map.
struct MeanValueSystem {
    matrix: Matrix,
    right: Vec<UvPair>,
}

impl MeanValueSystem {
    fn new(points: &[Point], rings: &OneRings, inner: &[u32], at: &[Uv]) -> Self {
        let mut unknown = vec![NONE; rings.len()];
        inner.iter().enumerate().for_each(|(i, &v)| unknown[v as usize] = i as u32);
        let shares = |i: usize| {
            let v = inner[i];
            solve::shares(points[v as usize], rings.ring(v), points)
        };
        let matrix = sparse::from_rows([inner.len(); 2], |i, entries| {
            let shares = shares(i);
            entries.push((i as u32, shares.iter().map(|s| s.1).sum()));
            let inside = shares.iter().filter(|s| unknown[s.0 as usize] != NONE);
            entries.extend(inside.map(|s| (unknown[s.0 as usize], -s.1)));
        });
        let right = |i: usize| {
            let on_boundary = |w: &u32| unknown[*w as usize] == NONE;
            if !rings.ring(inner[i]).iter().any(on_boundary) {
                return [0.0; 2];
            }
            let known = shares(i).into_iter().filter(|s| unknown[s.0 as usize] == NONE);
            known.fold([0.0; 2], |sum, (w, share)| {
                let at = at[w as usize];
                [sum[0] + share * at.x, sum[1] + share * at.y]
            })
        };
        let right = (0..inner.len()).into_par_iter().map(right).collect();
        MeanValueSystem { matrix, right }
    }

    /// Scales rows until the columns, too, nearly sum to zero, as those of a symmetric matrix do.
    /// Slivers make some rows thousands of times as heavy as others, and the coarse systems would
    /// represent only those rows.
    fn balance(&mut self) -> Option<()> {
        let columns = self.matrix.to_col_major().ok()?.into_transpose();
        let mut scales = vec![1.0; self.right.len()];
        for _ in 0..BALANCING {
            let scaled = |i: usize| {
                let (mut sum, mut diagonal) = (0.0, 1.0);
                for (j, a) in sparse::row(&columns, i) {
                    sum += a * scales[j];
                    diagonal = if i == j { a } else { diagonal };
                }
                scales[i] - 0.5 * sum / diagonal
            };
            scales = (0..scales.len()).into_par_iter().map(scaled).collect();
        }
        let mut end = 0;
        for (i, scale) in scales.iter().enumerate() {
            let start = std::mem::replace(&mut end, self.matrix.symbolic().row_range(i).end);
            self.matrix.val_mut()[start..end].iter_mut().for_each(|a| *a *= scale);
            self.right[i] = self.right[i].map(|b| b * scale);
        }
        Some(())
    }

    /// The solution, or `None` if BiCGStab does not converge.
    fn iterated(mut self) -> Option<Vec<UvPair>> {
        self.balance()?;
        let grid = Multigrid::new(self.matrix)?;
        let mut room = grid.room();
        let limits = Limits { residual: ROUND_REDUCTION, steps: MAX_STEPS[0] };
        let mut x = vec![[0.0; 2]; self.right.len()];
        let (mut step, mut residual) = (x.clone(), self.right.clone());
        for _ in 0..MAX_STEPS[1] {
            // Whether a round ends by its residual or not, what it came to counts.
            let round = |b: &[UvPair], x: &mut [UvPair]| grid.apply(b, x, &mut room);
            let found = bicgstab::solve(grid.matrix(), round, &residual, &limits);
            sparse::add(&mut x, 1.0, &found);
            sparse::residual(grid.matrix(), &self.right, &x, &mut residual);
            grid.apply(&residual, &mut step, &mut room);
            let farthest = step.as_flattened().iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if !step.as_flattened().iter().all(|s| s.is_finite()) {
                return None;
            }
            // The side of the square is 1.
            if farthest < ROUNDING {
                return Some(x);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::one_rings::tests::grid;

    /// A wavy grid of 60 × 60 points. Every fifth column is narrower by the factor `thin`. The
    /// boundary is placed on that of the square.
    fn sheet(thin: f64) -> (Vec<Point>, OneRings, Vec<Uv>) {
        let patch = grid(60);
        let rings = OneRings::new(&patch.mesh, &patch.outer);
        let at: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y) / 59.0).collect();
        let bent = |p: &Point| {
            let x = p.x - (1.0 - 1.0 / thin) * (p.x / 5.0).floor();
            Point::new(x, p.y, 4.0 * (0.4 * p.x).sin() * (0.3 * p.y).cos())
        };
        (patch.mesh.points.iter().map(bent).collect(), rings, at)
    }

    fn lost(rings: &OneRings, at: &[Uv]) -> Vec<Uv> {
        let start = |v: usize| if rings.on_boundary(v as u32) { at[v] } else { Uv::origin() };
        (0..at.len()).map(start).collect()
    }

    #[test]
    fn rounds_come_to_the_direct_solution() {
        for thin in [1.0, 1e4] {
            let (points, rings, at) = sheet(thin);
            let inner: Vec<u32> = (0..at.len() as u32).filter(|&v| !rings.on_boundary(v)).collect();
            let mut direct = at.clone();
            solve::mean_value(&points, &rings, &inner, &mut direct).unwrap();
            let system = MeanValueSystem::new(&points, &rings, &inner, &lost(&rings, &at));
            let found = system.iterated().expect("rounds that settle");
            let far = |(&v, x): (&u32, &UvPair)| (direct[v as usize] - Uv::from(*x)).norm();
            let farthest = inner.iter().zip(&found).map(far).fold(0.0, f64::max);
            assert!(farthest < 1e-11, "{thin}: {farthest}");
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let (points, rings, at) = sheet(10.0);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut at = lost(&rings, &at);
            pool.install(|| map(&points, &rings, &mut at)).unwrap();
            at.iter().map(|p| [p.x.to_bits(), p.y.to_bits()]).collect::<Vec<_>>()
        };
        assert_eq!(on(1), on(3));
    }
}
