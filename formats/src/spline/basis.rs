//! B-spline basis functions of any supported degree (Cox–de Boor recursion; The NURBS Book, Piegl
//! and Tiller 1997).

use super::{MAX_DEGREE, SplineKnots};

/// The number of basis functions of the highest degree.
const ROOM: usize = MAX_DEGREE + 1;

/// The non-zero basis functions at a parameter and their first two derivatives. Function `j`
/// belongs to pole `first + j`.
#[derive(Debug, Clone)]
pub struct SplineBasis {
    /// The index of the first pole with a non-zero function.
    pub first: usize,
    /// `derivative[k][j]` is the `k`-th derivative of function `j`.
    pub derivative: [[f64; ROOM]; 3],
}

impl SplineBasis {
    /// Evaluates the functions at `t`, which is clamped to the range.
    pub fn new(knots: &SplineKnots, t: f64) -> Self {
        let (low, high) = knots.range();
        let (t, p, k) = (t.clamp(low, high), knots.degree(), knots.knots());
        let span = span(knots, t);
        let mut row = [0.0; ROOM];
        row[0] = 1.0;
        let mut lower = [[0.0; ROOM]; 2]; // of degrees p − 1 and p − 2
        for d in 1..=p {
            if d == p {
                lower[0] = row;
            } else if d + 1 == p {
                lower[1] = row;
            }
            raise(&mut row, k, span, d, t);
        }
        let first = differentiated(&lower[0], k, span, p);
        let second = if p > 1 {
            differentiated(&differentiated(&lower[1], k, span, p - 1), k, span, p)
        } else {
            [0.0; ROOM]
        };
        SplineBasis { first: span - p, derivative: [row, first, second] }
    }
}

/// The index of the non-empty knot span that contains `t`.
fn span(knots: &SplineKnots, t: f64) -> usize {
    let k = knots.knots();
    let (first, last) = (knots.degree(), knots.poles() - 1);
    let mut span = (first + k[first + 1..=last].partition_point(|&x| x <= t)).min(last);
    while k[span] == k[span + 1] && span > first {
        span -= 1;
    }
    while k[span] == k[span + 1] && span < last {
        span += 1;
    }
    span
}

/// Computes the functions of degree d from those of degree d − 1 (Cox–de Boor recursion).
fn raise(row: &mut [f64; ROOM], k: &[f64], span: usize, d: usize, t: f64) {
    let mut saved = 0.0;
    for r in 0..d {
        let (left, right) = (k[span + r + 1 - d], k[span + r + 1]);
        let part = row[r] / (right - left);
        row[r] = saved + (right - t) * part;
        saved = (t - left) * part;
    }
    row[d] = saved;
}

/// Computes the derivatives of the functions of degree d from the functions of degree d − 1 (The
/// NURBS Book, eq. 2.7).
fn differentiated(lower: &[f64; ROOM], k: &[f64], span: usize, d: usize) -> [f64; ROOM] {
    let mut upper = [0.0; ROOM];
    for r in 0..d {
        let part = d as f64 * lower[r] / (k[span + r + 1] - k[span + r + 1 - d]);
        upper[r] -= part;
        upper[r + 1] += part;
    }
    upper
}
