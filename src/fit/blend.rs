//! Blended local fits (Tekumalla & Cohen 2005, section 3.5).
//!
//! A knot cell's 16 coefficients are those of the weighted least-squares fit
//! to the points of the cell and its eight neighbours, with full weight inside
//! the cell and a Gaussian flank as wide as the neighbour beyond. The 16 basis
//! functions are the polynomials that the B-splines are on the cell, continued
//! outside it: cut off at the cell, as a literal reading of the paper has it,
//! the flanks' points would pull the fit towards zero. A control point is the
//! mean of the estimates by the cells in which its function matters most.

use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

use super::cells::Cells;
use crate::geometry::Vector;
use crate::spline::{KnotVector, Samples};

type Gram = SMatrix<f64, 16, 16>;
type Coefficients = SMatrix<f64, 16, 3>;

/// The control net.
pub fn fit(samples: &Samples, cells: &Cells) -> Vec<Vector> {
    let [across, down] = cells.counts();
    let local: Vec<Coefficients> = (0..across * down)
        .into_par_iter()
        .map(|n| local_fit(samples, cells, n / down, n % down))
        .collect();
    let mut net = Vec::with_capacity((across + 3) * (down + 3));
    for i in 0..across + 3 {
        for j in 0..down + 3 {
            let mut sum = Vector::zeros();
            let (us, vs) = (estimators(i, across), estimators(j, down));
            for p in us.clone() {
                for q in vs.clone() {
                    let row = local[p * down + q].row(4 * (i - p) + j - q);
                    sum += row.transpose();
                }
            }
            net.push(sum / (us.len() * vs.len()) as f64);
        }
    }
    net
}

/// The cells, along one parameter, whose estimates of control point `i` are
/// averaged. Cell p owns the control points p … p+3, and the two in the middle
/// are its best; the ends have one cell only.
fn estimators(i: usize, cells: usize) -> std::ops::Range<usize> {
    let first = if i < 2 { 0 } else { (i - 2).min(cells - 1) };
    let last = if i < 2 { 0 } else { (i - 1).min(cells - 1) };
    first..last + 1
}

/// Points that a local fit needs: one a coefficient.
const FEWEST: usize = 16;

fn local_fit(samples: &Samples, cells: &Cells, p: usize, q: usize) -> Coefficients {
    let [across, down] = cells.counts();
    let within = |reach: usize| {
        let (ps, qs) = (around(p, reach, across), around(q, reach, down));
        ps.flat_map(move |pp| qs.clone().map(move |qq| cells.samples(pp, qq)))
    };
    // The paper's nine cells; more where those hold too few points.
    let enough = |reach: &usize| within(*reach).map(<[u32]>::len).sum::<usize>() >= FEWEST;
    let most = across.max(down);
    let reach = (1..most).find(enough).unwrap_or(most);
    let windows = [Window::new(cells.u, p, reach), Window::new(cells.v, q, reach)];
    let mut sums = Sums::new();
    for &i in within(reach).flatten() {
        let (at, i) = (samples.uv[i as usize], i as usize);
        let weight = samples.weights[i] * windows[0].at(at.x) * windows[1].at(at.y);
        let bu = cells.u.basis_in(p + 3, at.x).derivative[0];
        let bv = cells.v.basis_in(q + 3, at.y).derivative[0];
        let basis = SVector::<f64, 16>::from_fn(|k, _| bu[k / 4] * bv[k % 4]);
        sums.add(weight, &basis, samples.points[i].coords, at.coords);
    }
    sums.solve(cells, p, q)
}

/// The cells up to `reach` beside `cell`, of `count`.
fn around(cell: usize, reach: usize, count: usize) -> std::ops::Range<usize> {
    cell.saturating_sub(reach)..(cell + reach + 1).min(count)
}

/// The paper's window over one cell: 1 inside, exp(−d²/(w/2)²) at a distance d
/// beyond a side, where w is the width of the neighbour (or neighbours) there.
struct Window {
    low: f64,
    high: f64,
    before: f64,
    after: f64,
}

impl Window {
    fn new(knots: &KnotVector, cell: usize, reach: usize) -> Self {
        let k = knots.knots();
        let (low, high) = (k[cell + 3], k[cell + 4]);
        let first = k[(cell + 3).saturating_sub(reach).max(3)];
        let last = k[(cell + 4 + reach).min(knots.functions())];
        Window { low, high, before: low - first, after: last - high }
    }

    fn at(&self, t: f64) -> f64 {
        let flank = |d: f64, width: f64| (-(2.0 * d / width).powi(2)).exp();
        if t < self.low {
            flank(self.low - t, self.before)
        } else if t > self.high {
            flank(t - self.high, self.after)
        } else {
            1.0
        }
    }
}

/// Sums over a cell's points: for the 16 coefficients, and for the plane
/// a + b u + c v that stands in where the points do not determine them.
struct Sums {
    gram: Gram,
    right: Coefficients,
    plane_gram: SMatrix<f64, 3, 3>,
    plane_right: SMatrix<f64, 3, 3>,
}

impl Sums {
    fn new() -> Self {
        Sums {
            gram: SMatrix::zeros(),
            right: SMatrix::zeros(),
            plane_gram: SMatrix::zeros(),
            plane_right: SMatrix::zeros(),
        }
    }

    fn add(&mut self, weight: f64, b: &SVector<f64, 16>, p: Vector, uv: nalgebra::Vector2<f64>) {
        let plane = SVector::<f64, 3>::new(1.0, uv.x, uv.y);
        self.gram.syger(weight, b, b, 1.0);
        self.right.ger(weight, b, &p, 1.0);
        self.plane_gram.ger(weight, &plane, &plane, 1.0);
        self.plane_right.ger(weight, &plane, &p, 1.0);
    }

    /// The coefficients that the points determine, and for the rest of the
    /// space those of the points' plane: a spline over the Greville abscissae
    /// reproduces it. The plane's pull vanishes with the points' number; few
    /// points determine the continued polynomials so badly that they would
    /// throw the control points far off.
    fn solve(&self, cells: &Cells, p: usize, q: usize) -> Coefficients {
        let damp = SMatrix::<f64, 3, 3>::identity() * (1e-12 * self.plane_gram.trace());
        let plane = (self.plane_gram + damp).cholesky().map(|f| f.solve(&self.plane_right));
        let plane = plane.unwrap_or_else(SMatrix::zeros);
        let prior = Coefficients::from_fn(|k, axis| {
            let (u, v) = (cells.u.greville(p + k / 4), cells.v.greville(q + k % 4));
            plane[(0, axis)] + plane[(1, axis)] * u + plane[(2, axis)] * v
        });
        let count = self.plane_gram[(0, 0)];
        let pull = 1e-9 + 1e-2 * (8.0 / count.max(1.0)).powi(6);
        let weak = pull * self.gram.trace() / 16.0;
        let gram = self.gram + Gram::identity() * weak;
        let factor = gram.cholesky();
        factor.map_or(prior, |f| f.solve(&(self.right + prior * weak)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_come_from_one_cell_and_the_rest_from_two() {
        let all: Vec<_> = (0..7).map(|i| estimators(i, 4)).collect();
        assert_eq!(all, [0..1, 0..1, 0..2, 1..3, 2..4, 3..4, 3..4]);
        assert_eq!((0..4).map(|i| estimators(i, 1)).collect::<Vec<_>>(), vec![0..1; 4]);
    }

    #[test]
    fn the_window_falls_off_by_the_neighbours_width() {
        let knots = KnotVector::clamped(3, &[0.0, 0.4, 0.5, 1.0], 1);
        let w = Window::new(&knots, 1, 1);
        assert_eq!([w.at(0.4), w.at(0.45), w.at(0.5)], [1.0; 3]);
        assert!((w.at(0.2) - (-1f64).exp()).abs() < 1e-12);
        assert!((w.at(0.75) - (-1f64).exp()).abs() < 1e-12);
    }
}
