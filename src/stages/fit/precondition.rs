//! A preconditioner: a cheap approximate inverse of the normal equations.
//!
//! If the samples were spread evenly over the domain, the matrix would be the Kronecker product of
//! two band matrices, ∫ B_i B_i′ du and ∫ B_j B_j′ dv. Scaling to the true diagonal accounts for
//! the uneven density of samples.
//!
//! This is a bad approximation where the fairing term dominates. There and a few control points
//! beyond, the equations are solved directly. The two inverses are added (additive Schwarz).

use rayon::prelude::*;

use super::normal::{Factor, NormalEquations, PaddedPoint};
use super::{fairing, tasks};
use crate::error::Result;
use crate::spline::spans::{KnotSpans, PAIRS};

/// The approximate inverse.
pub(crate) struct Preconditioner {
    /// The inverse for evenly spread samples.
    even: Option<Even>,
    /// The inverse for the control points that samples determine weakly or not at all.
    weak: Option<Factor>,
}

/// The scaled inverse of a Kronecker product.
struct Even {
    u: Band,
    v: Band,
    scale: Vec<f64>,
}

/// Samples determine a control point weakly if the fairing term makes up more than this share of
/// its diagonal.
const WEAK: f64 = 0.05;

/// Samples do not determine a control point at all if the fairing term makes up more than this
/// share of its diagonal.
const FREE: f64 = 0.5;

/// The number of rows and columns around weak points for which the equations are solved directly.
const OVERLAP: usize = 3;

/// If more than one in this many control points is determined weakly, a direct solution of the
/// whole net is cheaper than the preconditioner.
const WEAK_SHARE: usize = 5;

impl Preconditioner {
    /// The preconditioner of equations over the given spans. `None` if so many control points are
    /// determined weakly that a direct solution of the whole net is cheaper.
    pub(super) fn new(equations: &NormalEquations, spans: &[KnotSpans; 2]) -> Result<Option<Self>> {
        let [u, v] = spans.each_ref().map(mass);
        let even = u.iter().flat_map(|a| v.iter().map(move |b| a[0] * b[0]));
        let own = equations.diagonal();
        let shares: Vec<f64> =
            equations.unsupported.iter().zip(&own).map(|(fairing, all)| fairing / all).collect();
        let scale = even.zip(&own).zip(&shares).map(|((even, own), &share)| {
            // A control point with an empty row of the matrix is not determined, either.
            let held = share < FREE && *own > 0.0;
            if held { (even / own).sqrt() } else { 0.0 }
        });
        let scale = scale.collect();
        let weak = around(equations.shape, |at| shares[at] > WEAK);
        if WEAK_SHARE * weak.len() > own.len() {
            return Ok(None);
        }
        let weak = (!weak.is_empty()).then(|| equations.factor(weak)).transpose()?;
        let even = Some(Even { u: Band::new(u), v: Band::new(v), scale });
        Ok(Some(Preconditioner { even, weak }))
    }

    /// The exact inverse of `equations`. It serves as a preconditioner for similar equations.
    pub(crate) fn direct(equations: &NormalEquations) -> Result<Self> {
        let count = equations.shape[0] * equations.shape[1];
        let all = equations.factor((0..count as u32).collect())?;
        Ok(Preconditioner { even: None, weak: Some(all) })
    }

    /// Stores the product of the approximate inverse and `r` in `z`.
    pub(crate) fn apply(&self, r: &[PaddedPoint], z: &mut [PaddedPoint]) {
        match &self.even {
            Some(even) => even.apply(r, z),
            None => z.fill(PaddedPoint::zeros()),
        }
        if let Some(weak) = &self.weak {
            let corrections = weak.solve(r);
            weak.points().iter().zip(corrections).for_each(|(&at, c)| z[at as usize] += c);
        }
    }
}

impl Even {
    fn apply(&self, r: &[PaddedPoint], z: &mut [PaddedPoint]) {
        let (nu, nv) = (self.u.0.len(), self.v.0.len());
        let columns = |first: usize, count: usize| {
            let mut part = Vec::with_capacity(nu * count);
            for at in (0..nu).map(|i| i * nv + first) {
                let row = r[at..at + count].iter().zip(&self.scale[at..at + count]);
                part.extend(row.map(|(r, s)| r * *s));
            }
            self.u.solve_columns(&mut part, count);
            part
        };
        let width = tasks(nu).min(nv);
        let starts: Vec<usize> = (0..nv).step_by(width).collect();
        let parts: Vec<Vec<PaddedPoint>> =
            starts.into_par_iter().map(|j| columns(j, width.min(nv - j))).collect();
        let rows = z.par_chunks_mut(nv).zip(self.scale.par_chunks(nv)).enumerate();
        rows.with_min_len(tasks(nv)).for_each(|(i, (row, scale))| {
            let mut first = 0;
            for part in &parts {
                let count = part.len() / nu;
                row[first..first + count].copy_from_slice(&part[i * count..][..count]);
                first += count;
            }
            self.v.solve_columns(row, 1);
            row.iter_mut().zip(scale).for_each(|(z, s)| *z *= *s);
        });
    }
}

/// The points of a net within [`OVERLAP`] rows and columns of a chosen point, in ascending order.
fn around([nu, nv]: [usize; 2], chosen: impl Fn(usize) -> bool) -> Vec<u32> {
    let mut near = vec![false; nu * nv];
    for at in (0..nu * nv).filter(|&at| chosen(at)) {
        let (i, j) = (at / nv, at % nv);
        for row in i.saturating_sub(OVERLAP)..(i + OVERLAP + 1).min(nu) {
            near[row * nv + j.saturating_sub(OVERLAP)..row * nv + (j + OVERLAP + 1).min(nv)]
                .fill(true);
        }
    }
    (0..near.len()).filter(|&at| near[at]).map(|at| at as u32).collect()
}

/// The mass matrix: ∫ B_i B_{i+d} over all spans, at `[i][d]`.
fn mass(spans: &KnotSpans) -> Vec<[f64; 4]> {
    let mut band = vec![[0.0; 4]; spans.all.len() + 3];
    for (n, span) in spans.all.iter().enumerate() {
        for (value, (a, c)) in fairing::energies(span)[0].iter().zip(PAIRS) {
            band[n + a][c - a] += span.half() * value;
        }
    }
    band
}

/// The Cholesky factor of a symmetric matrix of bandwidth 3: `[i][0]` is the reciprocal of entry
/// (i, i), and `[i][d]` is entry (i, i − d).
struct Band(Vec<[f64; 4]>);

impl Band {
    /// Factors the matrix whose entry (i, i + d) is `upper[i][d]`.
    fn new(upper: Vec<[f64; 4]>) -> Self {
        let mut l: Vec<[f64; 4]> = Vec::with_capacity(upper.len());
        for i in 0..upper.len() {
            let mut row = [0.0; 4];
            for d in (1..=3.min(i)).rev() {
                let j = i - d;
                // Columns before j in which both rows have entries.
                let known = (1..=j.min(3 - d)).map(|k| row[d + k] * l[j][k]).sum::<f64>();
                row[d] = (upper[j][d] - known) * l[j][0];
            }
            let known = row[1..].iter().map(|x| x * x).sum::<f64>();
            row[0] = 1.0 / (upper[i][0] - known).max(f64::MIN_POSITIVE).sqrt();
            l.push(row);
        }
        Band(l)
    }

    /// Solves in place for `count` columns that `x` contains row by row.
    fn solve_columns(&self, x: &mut [PaddedPoint], count: usize) {
        let n = self.0.len();
        for (i, l) in self.0.iter().enumerate() {
            let (before, row) = x.split_at_mut(i * count);
            for (c, to) in row[..count].iter_mut().enumerate() {
                let mut sum = *to;
                for d in 1..=3.min(i) {
                    sum -= before[(i - d) * count + c] * l[d];
                }
                *to = sum * l[0];
            }
        }
        for i in (0..n).rev() {
            let (row, after) = x.split_at_mut((i + 1) * count);
            for (c, to) in row[i * count..].iter_mut().enumerate() {
                let mut sum = *to;
                for d in 1..=3.min(n - 1 - i) {
                    sum -= after[(d - 1) * count + c] * self.0[i + d][d];
                }
                *to = sum * self.0[i][0];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn band_factors_solve() {
        let upper: Vec<[f64; 4]> = (0..9).map(|i| [9.0 + f64::from(i), 2.0, -1.0, 0.5]).collect();
        let truth: Vec<PaddedPoint> =
            (0..18).map(|i| PaddedPoint::repeat(f64::from(i * i % 7))).collect();
        let entry = |i: usize, j: usize| {
            let (low, d) = (i.min(j), i.abs_diff(j));
            if d < 4 { upper[low][d] } else { 0.0 }
        };
        let mut x: Vec<PaddedPoint> =
            (0..18).map(|n| (0..9).map(|j| truth[2 * j + n % 2] * entry(n / 2, j)).sum()).collect();
        Band::new(upper.clone()).solve_columns(&mut x, 2);
        assert!(x.iter().zip(&truth).all(|(x, t)| (x - t).amax() < 1e-12));
    }
}
