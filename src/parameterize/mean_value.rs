//! The paper's map: every inner vertex the mean of its neighbours by mean value
//! weights (Floater 2003), all of them at once.

use rayon::prelude::*;

use super::bicgstab::{self, Limits};
use super::multigrid::{FEW, Multigrid};
use super::solve;
use super::sparse::{self, Matrix, Pair};
use super::stars::Stars;
use crate::error::Result;
use crate::geometry::{Point, Uv};

/// Every vertex is nearer than this to where it should be, as the last correction
/// tells; the square's side is 1.
const NEAR: f64 = 1e-12;

/// The residual that a round of BiCGStab leaves, as a share of the one before.
const ROUND: f64 = 1e-6;

/// Steps of a round, and rounds, at the most.
const MOST: [usize; 2] = [60, 8];

/// Times that the rows' scales are balanced.
const BALANCING: usize = 10;

/// Moves the inner vertices to where each is its neighbours' mean by mean value
/// weights; the boundary is where it should be.
///
/// By BiCGStab (van der Vorst 1992) with a multigrid cycle as its preconditioner, and
/// directly where there are few vertices or that does not settle.
pub fn map(points: &[Point], stars: &Stars, at: &mut [Uv]) -> Result<()> {
    let inner: Vec<u32> = (0..stars.len() as u32)
        .filter(|&v| !stars.on_boundary(v) && !stars.ring(v).is_empty())
        .collect();
    let many = inner.len() > FEW;
    match many.then(|| System::new(points, stars, &inner, at).iterated()).flatten() {
        Some(found) => {
            inner.iter().zip(found).for_each(|(&v, x)| at[v as usize] = x.into());
            Ok(())
        }
        None => solve::mean_value(points, stars, &inner, at),
    }
}

/// The equations.
struct System {
    matrix: Matrix,
    right: Vec<Pair>,
}

impl System {
    fn new(points: &[Point], stars: &Stars, inner: &[u32], at: &[Uv]) -> Self {
        let mut unknown = vec![u32::MAX; stars.len()];
        inner.iter().enumerate().for_each(|(i, &v)| unknown[v as usize] = i as u32);
        let shares = |i: usize| {
            let v = inner[i];
            solve::shares(points[v as usize], stars.ring(v), points)
        };
        let matrix = sparse::from_rows([inner.len(); 2], |i, entries| {
            let shares = shares(i);
            entries.push((i as u32, shares.iter().map(|s| s.1).sum()));
            let inside = shares.iter().filter(|s| unknown[s.0 as usize] != u32::MAX);
            entries.extend(inside.map(|s| (unknown[s.0 as usize], -s.1)));
        });
        let right = |i: usize| {
            let on_boundary = |w: &u32| unknown[*w as usize] == u32::MAX;
            if !stars.ring(inner[i]).iter().any(on_boundary) {
                return [0.0; 2];
            }
            let known = shares(i).into_iter().filter(|s| unknown[s.0 as usize] == u32::MAX);
            known.fold([0.0; 2], |sum, (w, share)| {
                let at = at[w as usize];
                [sum[0] + share * at.x, sum[1] + share * at.y]
            })
        };
        let right = (0..inner.len()).into_par_iter().map(right).collect();
        System { matrix, right }
    }

    /// Scales rows until columns, too, nearly sum to nothing, as those of a symmetric
    /// matrix do: slivers make some rows thousands of times as heavy as others, and smaller
    /// systems would resemble those alone.
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

    /// The solution, if rounds of BiCGStab come near enough to it.
    fn iterated(mut self) -> Option<Vec<Pair>> {
        self.balance()?;
        let grid = Multigrid::new(self.matrix)?;
        let mut room = grid.room();
        let limits = Limits { residual: ROUND, steps: MOST[0] };
        let mut x = vec![[0.0; 2]; self.right.len()];
        let (mut step, mut residual) = (x.clone(), self.right.clone());
        for _ in 0..MOST[1] {
            // Whether a round ends by its residual or not, what it came to counts.
            let round = |b: &[Pair], x: &mut [Pair]| grid.apply(b, x, &mut room);
            let found = bicgstab::solve(grid.matrix(), round, &residual, &limits);
            sparse::add(&mut x, 1.0, &found);
            sparse::residual(grid.matrix(), &self.right, &x, &mut residual);
            grid.apply(&residual, &mut step, &mut room);
            let farthest = step.as_flattened().iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if !step.as_flattened().iter().all(|s| s.is_finite()) {
                return None;
            }
            if farthest < NEAR {
                return Some(x);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameterize::stars::tests::grid;

    /// A wavy grid of 60 × 60 points, `thin` times as narrow in every fifth column, its
    /// boundary laid on the square's.
    fn sheet(thin: f64) -> (Vec<Point>, Stars, Vec<Uv>) {
        let patch = grid(60);
        let stars = Stars::new(&patch.mesh, &patch.outer);
        let at: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y) / 59.0).collect();
        let bent = |p: &Point| {
            let x = p.x - (1.0 - 1.0 / thin) * (p.x / 5.0).floor();
            Point::new(x, p.y, 4.0 * (0.4 * p.x).sin() * (0.3 * p.y).cos())
        };
        (patch.mesh.points.iter().map(bent).collect(), stars, at)
    }

    fn lost(stars: &Stars, at: &[Uv]) -> Vec<Uv> {
        let start = |v: usize| if stars.on_boundary(v as u32) { at[v] } else { Uv::origin() };
        (0..at.len()).map(start).collect()
    }

    #[test]
    fn rounds_come_to_the_direct_solution() {
        for thin in [1.0, 1e4] {
            let (points, stars, at) = sheet(thin);
            let inner: Vec<u32> = (0..at.len() as u32).filter(|&v| !stars.on_boundary(v)).collect();
            let mut direct = at.clone();
            solve::mean_value(&points, &stars, &inner, &mut direct).unwrap();
            let system = System::new(&points, &stars, &inner, &lost(&stars, &at));
            let found = system.iterated().expect("rounds that settle");
            let far = |(&v, x): (&u32, &Pair)| (direct[v as usize] - Uv::from(*x)).norm();
            let farthest = inner.iter().zip(&found).map(far).fold(0.0, f64::max);
            assert!(farthest < 1e-11, "{thin}: {farthest}");
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let (points, stars, at) = sheet(10.0);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut at = lost(&stars, &at);
            pool.install(|| map(&points, &stars, &mut at)).unwrap();
            at.iter().map(|p| [p.x.to_bits(), p.y.to_bits()]).collect::<Vec<_>>()
        };
        assert_eq!(on(1), on(3));
    }
}
