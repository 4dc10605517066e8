//! The normal equations of the global least-squares fit, with the fairing term.

use faer::sparse::{SparseColMat, Triplet};
use nalgebra::Vector4;
use rayon::prelude::*;

use super::cells::Cells;
use super::fairing::{self, Fairing};
use super::strips::Strip;
use super::weight::Weight;
use crate::cholesky::Cholesky;
use crate::error::{self, Result};
use crate::spline::spans::{PAIRS, Span};

/// A control point in the solvers: its coordinates and a zero.
pub type Lane = Vector4<f64>;

/// Least squares plus a fairing term, as one sparse symmetric system.
///
/// The functions are products, and so is every sum over samples in one cell of
/// two of them: B_i B_i′ (u) · B_j B_j′ (v) is the same for (i, j), (i′, j′) and
/// for (i, j′), (i′, j). Of the 49 couplings of a control point 16 are left.
pub struct Equations<W = f64> {
    /// Control points in u and v.
    pub shape: [usize; 2],
    /// `bands[(4 i + d) nv + j][e]` couples (i, j) with (i + d, j + e), and (i, j + e)
    /// with (i + d, j).
    bands: Vec<[W; 4]>,
    /// The right-hand side.
    pub right: Vec<Lane>,
    /// Σ w p², the residual of a net of zeros.
    pub squares: f64,
    /// What of the diagonal is due to the fairing term.
    pub unsupported: Vec<f64>,
}

/// Every control point is held at the samples' centre with this share of what the
/// fairing term adds to its diagonal.
const ANCHOR: f64 = 1e-11;

impl<W: Weight> Equations<W> {
    /// Sums up the samples, a visit each.
    pub fn new(cells: &Cells) -> Self {
        let strips = strips(cells);
        let mut equations = Equations::fairing(&strips, cells);
        let spans = &cells.spans[0].all;
        equations.rows().for_each(|(i, (bands, right))| {
            for p in strips_of(i, strips.len()) {
                Row { span: &spans[p], number: i - p }.add_strip(&strips[p], bands, right);
            }
        });
        equations.squares = strips.iter().map(|s| s.squares).sum();
        equations
    }

    fn fairing(strips: &[Strip<W>], cells: &Cells) -> Self {
        let [nu, nv] = cells.counts().map(|n| n + 3);
        let mut equations = Equations {
            shape: [nu, nv],
            bands: vec![[W::ZERO; 4]; 4 * nu * nv],
            right: vec![Lane::zeros(); nu * nv],
            squares: 0.0,
            unsupported: Vec::new(),
        };
        let fairing = fairing::strips(strips, cells);
        let spans = &cells.spans[0].all;
        equations.rows().for_each(|(i, (bands, _))| {
            for p in strips_of(i, strips.len()) {
                Row { span: &spans[p], number: i - p }.add_fairing(&fairing[p], bands);
            }
        });
        equations.unsupported = equations.diagonal();
        // The term alone leaves planes open, and samples may be too few to tell one.
        for at in 0..nu * nv {
            let anchor = W::even(ANCHOR * equations.unsupported[at]);
            equations.bands[4 * nv * (at / nv) + at % nv][0] += anchor;
        }
        equations
    }

    /// The rows of the net, each with its couplings and its right-hand side.
    fn rows(
        &mut self,
    ) -> impl IndexedParallelIterator<Item = (usize, (&mut [[W; 4]], &mut [Lane]))> {
        let nv = self.shape[1];
        self.bands.par_chunks_mut(4 * nv).zip(self.right.par_chunks_mut(nv)).enumerate()
    }

    /// The couplings of rows i and i + d of the net.
    fn band(&self, i: usize, d: usize) -> &[[W; 4]] {
        let nv = self.shape[1];
        &self.bands[(4 * i + d) * nv..][..nv]
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.shape[0]).flat_map(|i| self.band(i, 0).iter().map(|b| b[0].mean())).collect()
    }

    /// Row `i` of the matrix times a net.
    pub fn row_times(&self, i: usize, net: &[Lane], out: &mut [Lane]) {
        let [nu, nv] = self.shape;
        out.fill(Lane::zeros());
        for other in i.saturating_sub(3)..(i + 4).min(nu) {
            let band = self.band(i.min(other), i.abs_diff(other));
            add_band(band, &net[other * nv..][..nv], out);
        }
    }

    /// The same with each matrix's mean over all directions for a weight.
    pub fn mean(&self) -> Equations {
        Equations {
            shape: self.shape,
            bands: self.bands.par_iter().map(|band| band.map(W::mean)).collect(),
            right: Vec::new(),
            squares: self.squares,
            unsupported: self.unsupported.clone(),
        }
    }
}

impl Equations {
    /// Holds every control point of a net where it is with a weight of its own,
    /// by the fairing term alone where that is zero.
    pub fn holding(net: &[Lane], weights: &[f64], cells: &Cells) -> Self {
        let mut equations = Equations::fairing(&strips(cells), cells);
        let nv = equations.shape[1];
        for (at, (p, &w)) in net.iter().zip(weights).enumerate() {
            equations.bands[4 * nv * (at / nv) + at % nv][0] += w;
            equations.right[at] += p * w;
            equations.squares += p.norm_squared() * w;
        }
        equations
    }

    /// The solution by sparse Cholesky.
    pub fn solve_directly(&self) -> Result<Vec<Lane>> {
        let [nu, nv] = self.shape;
        Ok(self.factor((0..(nu * nv) as u32).collect())?.solve(&self.right))
    }

    /// Cholesky factor of the rows and columns of some control points, in
    /// growing order.
    pub fn factor(&self, points: Vec<u32>) -> Result<Factor> {
        let [nu, nv] = self.shape;
        let mut number = vec![u32::MAX; nu * nv];
        points.iter().zip(0..).for_each(|(&point, n)| number[point as usize] = n);
        let mut triplets = Vec::with_capacity(25 * points.len());
        let mut couple = |low: usize, high: usize, value: f64| {
            let (low, high) = (number[low], number[high]);
            if low != u32::MAX && high != u32::MAX {
                triplets.push(Triplet::new(high, low, value));
            }
        };
        for point in points.iter().map(|&point| point as usize) {
            let (i, j) = (point / nv, point % nv);
            for d in 0..4.min(nu - i) {
                let band = self.band(i, d);
                for (e, &value) in band[j].iter().enumerate().take(nv - j) {
                    couple(point, point + d * nv + e, value);
                }
                for e in 1..4.min(j + 1) {
                    if d > 0 {
                        couple(point, point + d * nv - e, band[j - e][e]);
                    }
                }
            }
        }
        let n = points.len();
        let failed = error::unsolved("fit");
        let matrix = SparseColMat::<u32, f64>::try_new_from_triplets(n, n, &triplets)
            .map_err(|why| failed(why.into()))?;
        drop(triplets);
        Cholesky::new(matrix.as_ref())
            .map(|cholesky| Factor { points, cholesky })
            .map_err(|why| failed(why.into()))
    }
}

/// A direct solver for some of the control points.
pub struct Factor {
    points: Vec<u32>,
    cholesky: Cholesky<u32>,
}

impl Factor {
    /// The control points, in growing order.
    pub fn points(&self) -> &[u32] {
        &self.points
    }

    /// The solution for these points, the others held at zero. `right` has an
    /// entry for every control point.
    pub fn solve(&self, right: &[Lane]) -> Vec<Lane> {
        let of = |n: usize, axis: usize| right[self.points[n] as usize][axis];
        let mut x = faer::Mat::from_fn(self.points.len(), 3, of);
        self.cholesky.solve(&mut x);
        (0..x.nrows()).map(|n| Lane::new(x[(n, 0)], x[(n, 1)], x[(n, 2)], 0.0)).collect()
    }
}

fn strips<W: Weight>(cells: &Cells) -> Vec<Strip<W>> {
    (0..cells.counts()[0]).into_par_iter().map(|p| Strip::new(cells, p)).collect()
}

/// The strips of cells, of `count`, that row `i` of the net reaches into.
fn strips_of(i: usize, count: usize) -> std::ops::Range<usize> {
    i.saturating_sub(3)..(i + 1).min(count)
}

/// Adds a symmetric matrix of bandwidth 3, `band[j][e]` its entry (j, j + e),
/// times `x`.
fn add_band<W: Weight>(band: &[[W; 4]], x: &[Lane], out: &mut [Lane]) {
    let n = x.len();
    for j in 0..n {
        let mut sum = out[j] + band[j][0].times(&x[j]);
        if (3..n - 3).contains(&j) {
            let (x, b) = (&x[j - 3..j + 4], &band[j - 3..j + 1]);
            sum += b[3][1].times(&x[4]) + b[3][2].times(&x[5]) + b[3][3].times(&x[6]);
            sum += b[2][1].times(&x[2]) + b[1][2].times(&x[1]) + b[0][3].times(&x[0]);
        } else {
            for e in 1..4 {
                if j + e < n {
                    sum += band[j][e].times(&x[j + e]);
                }
                if j >= e {
                    sum += band[j - e][e].times(&x[j - e]);
                }
            }
        }
        out[j] = sum;
    }
}

/// Function `number` of a span, which belongs to the row of the net in question.
struct Row<'a> {
    span: &'a Span,
    number: usize,
}

impl Row<'_> {
    /// The pairs that the function is the first of: (place in [`PAIRS`], how
    /// much further the second one is).
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let pairs = PAIRS.iter().enumerate();
        pairs.filter(|(_, (a, _))| *a == self.number).map(|(n, (a, c))| (n, c - a))
    }

    fn add_strip<W: Weight>(&self, strip: &Strip<W>, bands: &mut [[W; 4]], right: &mut [Lane]) {
        let nv = right.len();
        for (pair, d) in self.pairs() {
            let product = &self.span.products[pair];
            for (to, gram) in bands[d * nv..][..nv].iter_mut().zip(&strip.gram) {
                for (c, row) in product.iter().zip(gram) {
                    to.iter_mut().zip(row).for_each(|(to, m)| *to += *m * *c);
                }
            }
        }
        let piece = &self.span.basis[self.number];
        for (to, sums) in right.iter_mut().zip(&strip.right) {
            for (axis, sums) in sums.iter().enumerate() {
                to[axis] += piece.iter().zip(sums).map(|(c, m)| c * m).sum::<f64>();
            }
        }
    }

    fn add_fairing<W: Weight>(&self, fairing: &Fairing, bands: &mut [[W; 4]]) {
        let nv = fairing.of[0].len();
        let energies = fairing::energies(self.span);
        for (pair, d) in self.pairs() {
            for (order, sums) in fairing.of.iter().enumerate() {
                let c = energies[2 - order][pair];
                for (to, row) in bands[d * nv..][..nv].iter_mut().zip(sums) {
                    to.iter_mut().zip(row).for_each(|(to, m)| *to += W::even(c * m));
                }
            }
        }
    }
}
