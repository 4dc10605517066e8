//! A fairing term for what the samples leave open: thin-plate energy
//! ∫ |S_xx|² + 2 |S_xy|² + |S_yy|² over the patch laid flat, in mm.
//!
//! Its weight is such that only detail far below a cell's size would feel it
//! where there are samples.

use super::cells::Cells;
use super::normal::{Equations, REACH};
use crate::spline::{KnotVector, Samples};

/// The term damps detail of this share of a mean cell's diameter by half.
const SHARE: f64 = 0.01;

/// Adds the term to the matrix.
pub fn add(equations: &mut Equations, samples: &Samples, cells: &Cells) {
    let [lu, lv] = extent(samples);
    let [across, down] = cells.counts();
    let total: f64 = samples.weights.iter().sum();
    let density = total / (lu * lv);
    let diameter = (lu / across as f64).hypot(lv / down as f64);
    let weight = density * (SHARE * diameter).powi(4) * lu * lv;
    let (u, v) = (Products::new(cells.u, lu), Products::new(cells.v, lv));
    let nv = equations.shape[1];
    for (at, row) in equations.rows.iter_mut().enumerate() {
        let (i, j) = (at / nv, at % nv);
        for (entry, value) in row.iter_mut().enumerate() {
            let [mu, mv] = [(&u, i, entry / REACH), (&v, j, entry % REACH)]
                .map(|(products, i, d)| [0, 1, 2].map(|k| products.of[k][i][d]));
            *value += weight * (mu[2] * mv[0] + 2.0 * mu[1] * mv[1] + mu[0] * mv[2]);
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

/// Integrals of products of derivatives of order 0, 1, 2 of basis functions
/// along one parameter, over a length of `length`: `of[k][i][d + 3]` for
/// functions i and i + d.
struct Products {
    of: [Vec<[f64; REACH]>; 3],
}

impl Products {
    fn new(knots: &KnotVector, length: f64) -> Self {
        let mut of = [(); 3].map(|()| vec![[0.0; REACH]; knots.functions()]);
        for span in knots.breaks().windows(2) {
            for (node, share) in gauss4() {
                let (width, t) = (span[1] - span[0], span[0] + node * (span[1] - span[0]));
                let b = knots.basis(t);
                for (k, table) in of.iter_mut().enumerate() {
                    let scale = share * width / length.powi(2 * k as i32);
                    let d = &b.derivative[k];
                    for i in 0..4 {
                        for j in 0..4 {
                            table[b.first + i][j + 3 - i] += scale * d[i] * d[j];
                        }
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
