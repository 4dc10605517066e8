//! Conjugate gradients on the normal equations, from the blended fit.
//!
//! The preconditioner is the Kronecker product of the marginal mass matrices,
//! scaled to the diagonal of the true one: samples spread like a product of two
//! densities would make it exact.

use super::normal::Equations;
use crate::geometry::Vector;

/// Steps at the most; a solve that needs more has cells without samples.
const MAX_STEPS: usize = 400;

/// The residual, relative to the right-hand side, at which the solve ends.
const RESIDUAL: f64 = 1e-10;

/// The net of the least-squares optimum, and the steps taken.
pub fn solve(equations: &Equations, start: Vec<Vector>) -> (Vec<Vector>, usize) {
    let preconditioner = Preconditioner::new(equations);
    let mut x = start;
    let mut r = minus(&equations.right, &equations.times(&x));
    let goal = RESIDUAL * RESIDUAL * dot(&equations.right, &equations.right).sum();
    let mut z = preconditioner.apply(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    for step in 0..MAX_STEPS {
        if dot(&r, &r).sum() <= goal {
            return (x, step);
        }
        let ap = equations.times(&p);
        let alpha = ratio(rz, dot(&p, &ap));
        for i in 0..x.len() {
            x[i] += alpha.component_mul(&p[i]);
            r[i] -= alpha.component_mul(&ap[i]);
        }
        z = preconditioner.apply(&r);
        let next = dot(&r, &z);
        let beta = ratio(next, rz);
        for i in 0..p.len() {
            p[i] = z[i] + beta.component_mul(&p[i]);
        }
        rz = next;
    }
    (x, MAX_STEPS)
}

fn minus(a: &[Vector], b: &[Vector]) -> Vec<Vector> {
    a.iter().zip(b).map(|(x, y)| x - y).collect()
}

/// The three coordinates are three systems with one matrix.
fn dot(a: &[Vector], b: &[Vector]) -> Vector {
    a.iter().zip(b).fold(Vector::zeros(), |sum, (x, y)| sum + x.component_mul(y))
}

fn ratio(a: Vector, b: Vector) -> Vector {
    a.zip_map(&b, |x, y| if y > 0.0 { x / y } else { 0.0 })
}

struct Preconditioner {
    u: Band,
    v: Band,
    scale: Vec<f64>,
}

impl Preconditioner {
    fn new(equations: &Equations) -> Self {
        let [u, v] = equations.marginals.each_ref().map(|m| steadied(m));
        let centre = equations.rows[0].len() / 2;
        let nv = equations.shape[1];
        let diagonal = |at: usize| u[at / nv][0] * v[at % nv][0];
        let scale = equations
            .rows
            .iter()
            .enumerate()
            .map(|(at, row)| (diagonal(at) / row[centre]).sqrt())
            .collect();
        Preconditioner { u: Band::new(u), v: Band::new(v), scale }
    }

    fn apply(&self, r: &[Vector]) -> Vec<Vector> {
        let mut z: Vec<Vector> = r.iter().zip(&self.scale).map(|(r, s)| r * *s).collect();
        let (nu, nv) = (self.u.0.len(), self.v.0.len());
        for i in 0..nu {
            self.v.solve(&mut z, i * nv, 1);
        }
        for j in 0..nv {
            self.u.solve(&mut z, j, nv);
        }
        z.iter_mut().zip(&self.scale).for_each(|(z, s)| *z *= *s);
        z
    }
}

/// A marginal matrix whose diagonal is lifted a little: without samples under
/// a function it would be singular.
fn steadied(band: &[[f64; 4]]) -> Vec<[f64; 4]> {
    let mean = band.iter().map(|b| b[0]).sum::<f64>() / band.len() as f64;
    band.iter().map(|b| [b[0] + 1e-6 * mean, b[1], b[2], b[3]]).collect()
}

/// Cholesky factor of a symmetric matrix of bandwidth 3: `[i][d]` is entry
/// (i, i − d).
struct Band(Vec<[f64; 4]>);

impl Band {
    fn new(mut a: Vec<[f64; 4]>) -> Self {
        for i in 0..a.len() {
            for d in (0..=3.min(i)).rev() {
                let j = i - d;
                let mut sum = a[i][d];
                for k in i.saturating_sub(3)..j {
                    if j - k <= 3 {
                        sum -= a[i][i - k] * a[j][j - k];
                    }
                }
                a[i][d] = if d == 0 { sum.max(f64::MIN_POSITIVE).sqrt() } else { sum / a[j][0] };
            }
        }
        Band(a)
    }

    /// Solves in place along the entries start, start + stride, …
    fn solve(&self, x: &mut [Vector], start: usize, stride: usize) {
        let n = self.0.len();
        let at = |i: usize| start + i * stride;
        for i in 0..n {
            for d in 1..=3.min(i) {
                let known = x[at(i - d)];
                x[at(i)] -= known * self.0[i][d];
            }
            x[at(i)] /= self.0[i][0];
        }
        for i in (0..n).rev() {
            for d in 1..=3.min(n - 1 - i) {
                let known = x[at(i + d)];
                x[at(i)] -= known * self.0[i + d][d];
            }
            x[at(i)] /= self.0[i][0];
        }
    }
}
