//! Preconditioned conjugate gradients on the normal equations.
//!
//! The input is the equations, an approximate inverse and a net to start at. The output is a net
//! nearer to the least-squares optimum.

use rayon::prelude::*;

use super::normal::{NormalEquations, PaddedPoint};
use super::precondition::Preconditioner;
use super::tasks;
use super::weight::Weight;
use crate::geometry::{BLOCK, MOST_ROUNDS, ROUNDING};

/// The solution is accurate enough when the gain of two steps is below this share of the remaining
/// sum of squares. Then the root mean square error is within half of this share of the optimum.
const GAIN: f64 = 1e-4;

/// Returns the net of the least-squares optimum and the number of steps. `None` if it takes too
/// many steps.
pub(crate) fn solve(
    equations: &NormalEquations,
    inverse: &Preconditioner,
    start: Vec<PaddedPoint>,
) -> Option<(Vec<PaddedPoint>, usize)> {
    let (net, steps, done) = improve(equations, inverse, start)?;
    done.then_some((net, steps))
}

/// Returns a net nearer to the optimum than `start`, the number of steps, and whether the net is
/// the optimum. `None` if a number overflows.
pub(crate) fn improve<W: Weight>(
    equations: &NormalEquations<W>,
    inverse: &Preconditioner,
    start: Vec<PaddedPoint>,
) -> Option<(Vec<PaddedPoint>, usize, bool)> {
    let (nu, nv) = (equations.shape[0], equations.shape[1]);
    let rows = |v: &mut Vec<PaddedPoint>,
                f: &(dyn Fn(usize, &mut [PaddedPoint]) -> PaddedPoint + Sync)|
     -> PaddedPoint {
        let rows = v.par_chunks_mut(nv).enumerate().with_min_len(tasks(nv));
        // The sum is in the order of the rows, so it does not depend on the number of threads.
        rows.map(|(i, row)| f(i, row)).collect::<Vec<_>>().into_iter().sum()
    };
    let zeros = || vec![PaddedPoint::zeros(); nu * nv];
    let (mut x, mut r) = (start, zeros());
    let (mut z, mut p, mut ap) = (zeros(), zeros(), zeros());
    let mut rz = PaddedPoint::zeros();
    // The sum of squares of a net x is that of the zero net minus x · (b + r).
    let known = rows(&mut r, &|i, r| {
        equations.row_times(i, &x, r);
        let (b, x) = (&equations.right[i * nv..][..nv], &x[i * nv..][..nv]);
        r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
        dot(x, b) + dot(x, r)
    });
    let mut left = equations.squares - known.sum();
    let mut before = f64::INFINITY;
    // Equations that need more steps have wide regions without samples, and the direct solver is faster
    // for them.
    for step in 0..MOST_ROUNDS {
        inverse.apply(&r, &mut z);
        let next = W::coupled(rows(&mut z, &|i, z| dot(z, &r[i * nv..][..nv])));
        let beta = ratio(next, rz);
        rz = next;
        rows(&mut p, &|i, p| {
            let z = &z[i * nv..][..nv];
            p.iter_mut().zip(z).for_each(|(p, z)| *p = z + beta.component_mul(p));
            PaddedPoint::zeros()
        });
        let bends = W::coupled(rows(&mut ap, &|i, ap| {
            equations.row_times(i, &p, ap);
            dot(ap, &p[i * nv..][..nv])
        }));
        let alpha = ratio(rz, bends);
        let tasks = (x.par_chunks_mut(BLOCK), r.par_chunks_mut(BLOCK));
        let along = (p.par_chunks(BLOCK), ap.par_chunks(BLOCK));
        tasks.into_par_iter().zip(along).for_each(|((x, r), (p, ap))| {
            x.iter_mut().zip(p).for_each(|(x, p)| *x += alpha.component_mul(p));
            r.iter_mut().zip(ap).for_each(|(r, ap)| *r -= alpha.component_mul(ap));
        });
        let gain = alpha.dot(&rz);
        left -= gain;
        if !left.is_finite() {
            return None;
        }
        // What is left of data without a residual is rounding.
        let rounded = ROUNDING * equations.squares;
        let sure = (left - rounded).max(0.0);
        if gain + before <= GAIN * sure + ROUNDING * rounded {
            return Some((x, step + 1, true));
        }
        before = gain;
    }
    Some((x, MOST_ROUNDS, false))
}

fn dot(a: &[PaddedPoint], b: &[PaddedPoint]) -> PaddedPoint {
    a.iter().zip(b).fold(PaddedPoint::zeros(), |sum, (x, y)| sum + x.component_mul(y))
}

fn ratio(a: PaddedPoint, b: PaddedPoint) -> PaddedPoint {
    a.zip_map(&b, |x, y| if y > 0.0 { x / y } else { 0.0 })
}
