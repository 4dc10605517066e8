//! A fairing term for what the samples leave open: thin-plate energy
//! ∫ |S_xx|² + 2 |S_xy|² + |S_yy|² over the patch laid flat, in mm.
//!
//! In cells with samples its weight is such that only detail far below a
//! cell's size would feel it; in cells with few or none it is stronger.

use super::cells::Cells;
use super::normal::{Equations, REACH};
use crate::spline::{KnotVector, Samples};

/// The term damps detail of this share of a mean cell's diameter by half.
const SHARE: f64 = 0.02;

/// Cells with fewer samples than this feel it more and more.
const FEW: f64 = 16.0;

/// Adds the term to the matrix.
pub fn add(equations: &mut Equations, samples: &Samples, cells: &Cells) {
    let [lu, lv] = extent(samples);
    let [across, down] = cells.counts();
    let total: f64 = samples.weights.iter().sum();
    let density = total / (lu * lv);
    let diameter = (lu / across as f64).hypot(lv / down as f64);
    let weight = density * (SHARE * diameter).powi(4) * lu * lv;
    let u: Vec<Products> = (0..across).map(|p| Products::new(cells.u, p + 3, lu)).collect();
    let v: Vec<Products> = (0..down).map(|q| Products::new(cells.v, q + 3, lv)).collect();
    let nv = equations.shape[1];
    for (p, q) in (0..across).flat_map(|p| (0..down).map(move |q| (p, q))) {
        let count = cells.samples(p, q).len() as f64;
        let here = weight * (1.0 + (FEW / (1.0 + count)).powi(4));
        for k in 0..16 {
            let row = &mut equations.rows[(p + k / 4) * nv + q + k % 4];
            for l in 0..16 {
                let [mu, mv] = [(&u[p], k / 4, l / 4), (&v[q], k % 4, l % 4)]
                    .map(|(products, i, j)| [0, 1, 2].map(|order| products.of[order][i][j]));
                let entry = (l / 4 + 3 - k / 4) * REACH + l % 4 + 3 - k % 4;
                row[entry] += here * (mu[2] * mv[0] + 2.0 * mu[1] * mv[1] + mu[0] * mv[2]);
            }
        }
    }
}

/// The lengths, in mm, of the patch along u and v: mean distance of samples in
/// space over their distance in the plane, by least squares on the linear map.
fn extent(samples: &Samples) -> [f64; 2] {
    let n = samples.len() as f64;
    let mean_uv = samples.uv.iter().fold(nalgebra::Vector2::zeros(), |s, p| s + p.coords) / n;
    let mean = samples.points.iter().fold(nalgebra::Vector3::zeros(), |s, p| s + p.coords) / n;
    let mut gram = nalgebra::Matrix2::zeros();
    let mut right = nalgebra::Matrix2x3::zeros();
    for (uv, p) in samples.uv.iter().zip(&samples.points) {
        let d = uv.coords - mean_uv;
        gram += d * d.transpose();
        right += d * (p.coords - mean).transpose();
    }
    let size = samples.points.iter().map(|p| (p.coords - mean).norm()).sum::<f64>() / n;
    let slopes = gram.try_inverse().map(|inverse| inverse * right);
    // A rolled-up sheet has no linear part; its size stands in.
    [0, 1].map(|k| slopes.map_or(size, |s| s.row(k).norm()).max(size).max(f64::MIN_POSITIVE))
}

/// Integrals over one knot span of products of derivatives of order 0, 1, 2 of
/// its four basis functions, along one parameter of length `length`.
struct Products {
    of: [[[f64; 4]; 4]; 3],
}

impl Products {
    fn new(knots: &KnotVector, span: usize, length: f64) -> Self {
        let (a, b) = (knots.knots()[span], knots.knots()[span + 1]);
        let mut of = [[[0.0; 4]; 4]; 3];
        for (node, share) in gauss4() {
            let basis = knots.basis_in(span, a + node * (b - a));
            for (order, table) in of.iter_mut().enumerate() {
                let scale = share * (b - a) / length.powi(2 * order as i32);
                let d = &basis.derivative[order];
                for i in 0..4 {
                    for j in 0..4 {
                        table[i][j] += scale * d[i] * d[j];
                    }
                }
            }
        }
        Products { of }
    }
}

/// Nodes and weights over [0, 1], exact to degree 7: products of cubics.
fn gauss4() -> [(f64, f64); 4] {
    let inner = (3.0 / 7.0 - 2.0 / 7.0 * (6f64 / 5.0).sqrt()).sqrt();
    let outer = (3.0 / 7.0 + 2.0 / 7.0 * (6f64 / 5.0).sqrt()).sqrt();
    let (wi, wo) = ((18.0 + 30f64.sqrt()) / 72.0, (18.0 - 30f64.sqrt()) / 72.0);
    [(-outer, wo), (-inner, wi), (inner, wi), (outer, wo)].map(|(x, w)| (0.5 + 0.5 * x, w))
}
