//! Blended local fits (Tekumalla and Cohen 2005, section 3.5).
//!
//! The input is samples sorted by knot cell. The output is a control net and a weight for each
//! control point.
//!
//! Each knot cell gets 16 coefficients from a weighted least-squares fit to the points of the cell
//! and its eight neighbours. The weight is 1 inside the cell. Outside it falls off as a Gaussian
//! over the width of the neighbour. The 16 basis functions are the polynomials of the B-splines on
//! the cell, extrapolated beyond it. A literal reading of the paper would cut them off at the cell,
//! and then the points outside would pull the fit towards zero. A control point is the weighted
//! mean of the estimates of all cells that it belongs to. The weight of an estimate is the diagonal
//! entry of the cell's Gram matrix.
//!
//! The Gaussian depends only on the position of a point in its own cell. So one visit to each point
//! yields everything that its nine cells need: sums of powers under each of the nine windows.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::knot_cells::KnotCells;
use super::moments::{Moments, powers};
use super::normal::PaddedPoint;
use crate::spline::spans::{Cubic, PAIRS, Sextic, Span, products};

type Gram = SMatrix<f64, 16, 16>;
type Coefficients = SMatrix<f64, 16, 3>;

/// Computes the control net and the weight of each control point. The weight is 0 where no samples
/// determine the control point.
pub(super) fn fit(cells: &KnotCells) -> (Vec<PaddedPoint>, Vec<f64>) {
    let [across, down] = cells.counts();
    let mut blend = Blend::new(across, down);
    let strip = |p: usize| -> Vec<Windowed> {
        (0..down).into_par_iter().map(|q| Windowed::new(cells, p, q)).collect()
    };
    // Only three strips of cells are in memory at a time.
    let mut around = [None, None, Some(strip(0))];
    for p in 0..across {
        around.rotate_left(1);
        around[2] = (p + 1 < across).then(|| strip(p + 1));
        let local = |q: usize| local_fit(cells, &around, p, q);
        let fits: Vec<LocalFit> = (0..down).into_par_iter().map(local).collect();
        fits.iter().enumerate().for_each(|(q, fit)| blend.add(p, q, fit));
    }
    (blend.net(), blend.weights)
}

/// The sums over the points of one cell under nine windows, `[u][v]`: those of the cells before it,
/// of itself, and of the cells after it.
struct Windowed([[Moments; 3]; 3]);

impl Windowed {
    fn new(cells: &KnotCells, p: usize, q: usize) -> Self {
        let mut sums = [0; 3].map(|_| [0; 3].map(|_| Moments::zero()));
        for sample in cells.samples::<f64>(p, q) {
            let (s, t) = (powers(sample.place.x), powers(sample.place.y));
            let (us, vs) = (windows(sample.place.x), windows(sample.place.y));
            for (row, u) in sums.iter_mut().zip(us) {
                for (sums, v) in row.iter_mut().zip(vs) {
                    sums.add(sample.weight * u * v, &s, &t, sample.point);
                }
            }
        }
        Windowed(sums)
    }
}

/// The windows of the previous cell, of the cell itself and of the next cell, at a position from
/// −1 to 1 in the cell. A window is 1 inside its cell and exp(−d²/(w/2)²) at the distance d outside
/// it, where w is the width of the neighbour (from the paper).
fn windows(s: f64) -> [f64; 3] {
    [(-(1.0 + s) * (1.0 + s)).exp(), 1.0, (-(1.0 - s) * (1.0 - s)).exp()]
}

/// The estimates of one cell for its 16 control points.
struct LocalFit {
    coefficients: Coefficients,
    /// The weights of the estimates: the diagonal of the Gram matrix. They are 0 if there are no
    /// points.
    weights: SVector<f64, 16>,
}

fn local_fit(
    cells: &KnotCells,
    around: &[Option<Vec<Windowed>>; 3],
    p: usize,
    q: usize,
) -> LocalFit {
    let (mut gram, mut right, mut count) = (Products::zeros(), Coefficients::zeros(), 0);
    let [across, down] = cells.counts();
    for (dp, strip) in around.iter().enumerate().filter(|(dp, _)| (1..=across).contains(&(p + dp)))
    {
        let Some(strip) = strip else { continue };
        let u = Continued::new(cells, 0, p + dp - 1, p);
        for dq in (0..3).filter(|dq| (1..=down).contains(&(q + dq))) {
            let v = Continued::new(cells, 1, q + dq - 1, q);
            let sums = &strip[q + dq - 1].0[2 - dp][2 - dq];
            u.add_gram(&v, sums, &mut gram);
            u.add_right(&v, sums, &mut right);
            count += cells.count(p + dp - 1, q + dq - 1);
        }
    }
    if count == 0 {
        return LocalFit { coefficients: Coefficients::zeros(), weights: SVector::zeros() };
    }
    let mut local = solve(cells, p, q, &full(&gram), &right);
    // A local fit has full weight from one point for each coefficient on.
    local.weights *= (count as f64 / local.weights.len() as f64).min(1.0).powi(2);
    local
}

/// Sums of products of two functions in u and two functions in v, indexed by [`PAIRS`].
type Products = SMatrix<f64, 10, 10>;

/// The four basis functions of one span as polynomials over another span.
struct Continued {
    basis: [Cubic; 4],
    products: [Sextic; 10],
}

impl Continued {
    fn new(cells: &KnotCells, axis: usize, to: usize, of: usize) -> Self {
        let span: &Span = &cells.spans[axis].all[to];
        let basis = if to == of { span.basis } else { span.pieces(cells.knots[axis], of) };
        Continued { products: products(&basis), basis }
    }

    fn add_gram(&self, v: &Continued, sums: &Moments, to: &mut Products) {
        for (n, product) in v.products.iter().enumerate() {
            let mut across = [0.0; 8];
            for (row, c) in sums.gram.iter().zip(product) {
                across.iter_mut().zip(row).for_each(|(sum, m)| *sum += c * m);
            }
            for (m, product) in self.products.iter().enumerate() {
                to[(m, n)] += product.iter().zip(&across).map(|(c, s)| c * s).sum::<f64>();
            }
        }
    }

    fn add_right(&self, v: &Continued, sums: &Moments, to: &mut Coefficients) {
        for (b, piece) in v.basis.iter().enumerate() {
            for (axis, rows) in sums.right.iter().enumerate() {
                let mut across = [0.0; 4];
                for (row, c) in rows.iter().zip(piece) {
                    across.iter_mut().zip(row).for_each(|(sum, m)| *sum += c * m);
                }
                for (a, piece) in self.basis.iter().enumerate() {
                    let sum = piece.iter().zip(&across).map(|(c, s)| c * s).sum::<f64>();
                    to[(4 * a + b, axis)] += sum;
                }
            }
        }
    }
}

/// The Gram matrix of the 16 functions.
fn full(products: &Products) -> Gram {
    let mut gram = Gram::zeros();
    for (m, (a, c)) in PAIRS.into_iter().enumerate() {
        for (n, (b, d)) in PAIRS.into_iter().enumerate() {
            let value = products[(m, n)];
            for (k, l) in [(4 * a + b, 4 * c + d), (4 * a + d, 4 * c + b)] {
                gram[(k, l)] = value;
                gram[(l, k)] = value;
            }
        }
    }
    gram
}

/// Solves for the coefficients of a cell. The regression plane of the points determines what the
/// points leave open. It is a spline over the Greville abscissae. The plane has a small weight that
/// vanishes with the number of points. Without it, few points determine the extrapolated
/// polynomials so badly that control points would lie far away.
fn solve(cells: &KnotCells, p: usize, q: usize, gram: &Gram, right: &Coefficients) -> LocalFit {
    let plane = SMatrix::<f64, 16, 3>::from_fn(|k, c| {
        let [u, v] = [(0, p + k / 4), (1, q + k % 4)];
        [1.0, cells.knots[0].greville(u.1), cells.knots[1].greville(v.1)][c]
    });
    let plane_gram = plane.transpose() * gram * plane;
    let damp = SMatrix::<f64, 3, 3>::identity() * (1e-12 * plane_gram.trace());
    let prior =
        (plane_gram + damp).cholesky().map(|f| plane * f.solve(&(plane.transpose() * right)));
    let prior = prior.unwrap_or_else(Coefficients::zeros);
    let pull = 1e-13 + 1e-2 * (8.0 / plane_gram[(0, 0)].max(1.0)).powi(6);
    let weak = pull * gram.trace() / 16.0;
    match (gram + Gram::identity() * weak).cholesky() {
        Some(f) => {
            LocalFit { coefficients: f.solve(&(right + prior * weak)), weights: gram.diagonal() }
        }
        None => LocalFit { coefficients: prior, weights: SVector::zeros() },
    }
}

/// The weighted means of the estimates of all cells.
struct Blend {
    counts: [usize; 2],
    sums: Vec<PaddedPoint>,
    weights: Vec<f64>,
}

impl Blend {
    fn new(across: usize, down: usize) -> Self {
        let size = (across + 3) * (down + 3);
        Blend {
            counts: [across, down],
            sums: vec![PaddedPoint::zeros(); size],
            weights: vec![0.0; size],
        }
    }

    fn add(&mut self, p: usize, q: usize, local: &LocalFit) {
        let [across, down] = self.counts;
        for k in (0..16).filter(|k| {
            estimators(p + k / 4, across).contains(&p) && estimators(q + k % 4, down).contains(&q)
        }) {
            let at = (p + k / 4) * (down + 3) + q + k % 4;
            let row = local.coefficients.row(k);
            self.sums[at] += PaddedPoint::new(row[0], row[1], row[2], 0.0) * local.weights[k];
            self.weights[at] += local.weights[k];
        }
    }

    fn net(&self) -> Vec<PaddedPoint> {
        let mean =
            |(sum, &w): (&PaddedPoint, &f64)| if w > 0.0 { sum / w } else { PaddedPoint::zeros() };
        self.sums.iter().zip(&self.weights).map(mean).collect()
    }
}

/// The cells along one parameter whose estimates of control point `i` are averaged. These are all
/// four cells in the support of its basis function. The last two control points at either end come
/// from the last cell alone. The paper averages the middle two cells with equal weights. The
/// weights of the estimates make it possible to use the outer ones, too.
fn estimators(i: usize, cells: usize) -> std::ops::Range<usize> {
    match i {
        1 => 0..1,
        _ if i == cells + 1 => cells - 1..cells,
        _ => i.saturating_sub(3)..(i + 1).min(cells),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_come_from_one_cell_and_the_rest_from_all() {
        let all: Vec<_> = (0..8).map(|i| estimators(i, 5)).collect();
        assert_eq!(all, [0..1, 0..1, 0..3, 0..4, 1..5, 2..5, 4..5, 4..5]);
        assert_eq!((0..4).map(|i| estimators(i, 1)).collect::<Vec<_>>(), vec![0..1; 4]);
    }

    #[test]
    fn windows_fall_off_by_the_neighbours_width() {
        // At a cell's end the window of the cell after it begins to fall off.
        assert_eq!(windows(1.0)[1..], [1.0, 1.0]);
        assert!((windows(0.0)[0] - (-1f64).exp()).abs() < 1e-12);
        assert!((windows(1.0)[0] - (-4f64).exp()).abs() < 1e-12);
    }
}
