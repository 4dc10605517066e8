//! Conjugate gradients on the normal equations.

use rayon::prelude::*;

use super::normal::{Equations, Lane};
use super::precondition::Preconditioner;
use super::weight::Weight;
use super::{TASK, tasks};

/// Steps at the most. Equations that need more have wide regions without
/// samples, and are solved faster directly.
const MAX_STEPS: usize = 60;

/// The solve ends when what two steps gained is this share of the sum of squares
/// left: the root mean square is within half of it of the optimum's.
const GAIN: f64 = 1e-4;

/// What is left is known up to this share of the sum of squares at the start. Data
/// that are exact to that are followed until two steps gain no more than ...
const ROUNDING: f64 = 1e-12;

/// ... this share.
const EXACT: f64 = 1e-24;

/// The net of the least-squares optimum, and the steps taken; `None` where it
/// takes too many.
pub fn solve(
    equations: &Equations,
    inverse: &Preconditioner,
    start: Vec<Lane>,
) -> Option<(Vec<Lane>, usize)> {
    let (net, steps, done) = improve(equations, inverse, start)?;
    done.then_some((net, steps))
}

/// A net nearer to the optimum than the one given, the steps taken, and whether it is
/// the optimum; `None` if numbers ran out of range.
pub fn improve<W: Weight>(
    equations: &Equations<W>,
    inverse: &Preconditioner,
    start: Vec<Lane>,
) -> Option<(Vec<Lane>, usize, bool)> {
    let (nu, nv) = (equations.shape[0], equations.shape[1]);
    let rows = |v: &mut Vec<Lane>, f: &(dyn Fn(usize, &mut [Lane]) -> Lane + Sync)| -> Lane {
        let rows = v.par_chunks_mut(nv).enumerate().with_min_len(tasks(nv));
        // Summed in the order of the rows, whatever thread did them.
        rows.map(|(i, row)| f(i, row)).collect::<Vec<_>>().into_iter().sum()
    };
    let zeros = || vec![Lane::zeros(); nu * nv];
    let (mut x, mut r) = (start, zeros());
    let (mut z, mut p, mut ap) = (zeros(), zeros(), zeros());
    let mut rz = Lane::zeros();
    // The sum of squares of a net is that of zeros less x · (b + r).
    let known = rows(&mut r, &|i, r| {
        equations.row_times(i, &x, r);
        let (b, x) = (&equations.right[i * nv..][..nv], &x[i * nv..][..nv]);
        r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
        dot(x, b) + dot(x, r)
    });
    let mut left = equations.squares - known.sum();
    let mut before = f64::INFINITY;
    for step in 0..MAX_STEPS {
        inverse.apply(&r, &mut z);
        let next = W::coupled(rows(&mut z, &|i, z| dot(z, &r[i * nv..][..nv])));
        let beta = ratio(next, rz);
        rz = next;
        rows(&mut p, &|i, p| {
            let z = &z[i * nv..][..nv];
            p.iter_mut().zip(z).for_each(|(p, z)| *p = z + beta.component_mul(p));
            Lane::zeros()
        });
        let bends = W::coupled(rows(&mut ap, &|i, ap| {
            equations.row_times(i, &p, ap);
            dot(ap, &p[i * nv..][..nv])
        }));
        let alpha = ratio(rz, bends);
        let tasks = (x.par_chunks_mut(TASK), r.par_chunks_mut(TASK));
        let along = (p.par_chunks(TASK), ap.par_chunks(TASK));
        tasks.into_par_iter().zip(along).for_each(|((x, r), (p, ap))| {
            x.iter_mut().zip(p).for_each(|(x, p)| *x += alpha.component_mul(p));
            r.iter_mut().zip(ap).for_each(|(r, ap)| *r -= alpha.component_mul(ap));
        });
        let gain = alpha.dot(&rz);
        left -= gain;
        if !left.is_finite() {
            return None;
        }
        let sure = (left - ROUNDING * equations.squares).max(0.0);
        if gain + before <= GAIN * sure + EXACT * equations.squares {
            return Some((x, step + 1, true));
        }
        before = gain;
    }
    Some((x, MAX_STEPS, false))
}

fn dot(a: &[Lane], b: &[Lane]) -> Lane {
    a.iter().zip(b).fold(Lane::zeros(), |sum, (x, y)| sum + x.component_mul(y))
}

fn ratio(a: Lane, b: Lane) -> Lane {
    a.zip_map(&b, |x, y| if y > 0.0 { x / y } else { 0.0 })
}
