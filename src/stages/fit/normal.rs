//! The normal equations of the global least-squares fit with the fairing term.
//!
//! The input is samples sorted by knot cell. The output is the sparse symmetric system, which this
//! module also factors and solves by sparse Cholesky.

use faer::sparse::{SparseColMat, Triplet};
use nalgebra::Vector4;
use rayon::prelude::*;

use super::fairing::{self, Fairing};
use super::knot_cells::KnotCells;
use super::strips::StripSums;
use super::weight::Weight;
use crate::error::{self, Result};
use crate::geometry::NONE;
use crate::solve::cholesky::Cholesky;
use crate::spline::spans::{PAIRS, Span};

/// A control point in the solvers: its three coordinates and a zero.
pub(crate) type PaddedPoint = Vector4<f64>;

/// Least squares plus a fairing term as one sparse symmetric system.
///
/// The basis functions are tensor products. So the product of two of them,
/// B_i B_i′ (u) · B_j B_j′ (v), is the same for (i, j), (i′, j′) and for (i, j′), (i′, j). Because
/// of this and of symmetry, 16 of the 49 couplings of a control point are stored.
pub(crate) struct NormalEquations<W = f64> {
    /// The numbers of control points in u and v.
    pub shape: [usize; 2],
    /// `bands[(4 i + d) nv + j][e]` couples (i, j) with (i + d, j + e), and (i, j + e)
    /// with (i + d, j).
    bands: Vec<[W; 4]>,
    /// The right-hand side.
    pub right: Vec<PaddedPoint>,
    /// Σ w p², which is the residual of the zero net.
    pub squares: f64,
    /// The part of the diagonal that comes from the fairing term.
    pub unsupported: Vec<f64>,
}

/// The weight that holds every control point at the centre of the samples, as a share of the
/// fairing term's diagonal. It makes the equations regular if the samples do not determine a plane.
const ANCHOR: f64 = 1e-11;

impl<W: Weight> NormalEquations<W> {
    /// Sums up the samples. Each sample is visited once.
    pub(super) fn new(cells: &KnotCells) -> Self {
        let strips = strips(cells);
        let mut equations = NormalEquations::fairing(&strips, cells);
        let spans = &cells.spans[0].all;
        equations.rows().for_each(|(i, (bands, right))| {
            for p in strips_of(i, strips.len()) {
                SpanFunction { span: &spans[p], number: i - p }.add_strip(&strips[p], bands, right);
            }
        });
        equations.squares = strips.iter().map(|s| s.squares).sum();
        equations
    }

    fn fairing(strips: &[StripSums<W>], cells: &KnotCells) -> Self {
        let [nu, nv] = cells.counts().map(|n| n + 3);
        let mut equations = NormalEquations {
            shape: [nu, nv],
            bands: vec![[W::even(0.0); 4]; 4 * nu * nv],
            right: vec![PaddedPoint::zeros(); nu * nv],
            squares: 0.0,
            unsupported: Vec::new(),
        };
        let fairing = fairing::strips(strips, cells);
        let spans = &cells.spans[0].all;
        equations.rows().for_each(|(i, (bands, _))| {
            for p in strips_of(i, strips.len()) {
                SpanFunction { span: &spans[p], number: i - p }.add_fairing(&fairing[p], bands);
            }
        });
        equations.unsupported = equations.diagonal();
        // The term alone does not determine a plane, and the samples may be too few for it.
        for at in 0..nu * nv {
            let anchor = W::even(ANCHOR * equations.unsupported[at]);
            equations.bands[4 * nv * (at / nv) + at % nv][0] += anchor;
        }
        equations
    }

    /// The rows of the net, with the couplings and the right-hand side of each row.
    fn rows(
        &mut self,
    ) -> impl IndexedParallelIterator<Item = (usize, (&mut [[W; 4]], &mut [PaddedPoint]))> {
        let nv = self.shape[1];
        self.bands.par_chunks_mut(4 * nv).zip(self.right.par_chunks_mut(nv)).enumerate()
    }

    /// The couplings between rows i and i + d of the net.
    fn band(&self, i: usize, d: usize) -> &[[W; 4]] {
        let nv = self.shape[1];
        &self.bands[(4 * i + d) * nv..][..nv]
    }

    /// The diagonal of the matrix, averaged over all directions.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        (0..self.shape[0]).flat_map(|i| self.band(i, 0).iter().map(|b| b[0].mean())).collect()
    }

    /// Multiplies the rows of the matrix that belong to row `i` of the net with a net.
    pub(crate) fn row_times(&self, i: usize, net: &[PaddedPoint], out: &mut [PaddedPoint]) {
        let [nu, nv] = self.shape;
        out.fill(PaddedPoint::zeros());
        for other in i.saturating_sub(3)..(i + 4).min(nu) {
            let band = self.band(i.min(other), i.abs_diff(other));
            add_band(band, &net[other * nv..][..nv], out);
        }
    }

    /// The equations with the mean over all directions instead of each matrix.
    pub(crate) fn mean(&self) -> NormalEquations {
        NormalEquations {
            shape: self.shape,
            bands: self.bands.par_iter().map(|band| band.map(W::mean)).collect(),
            right: Vec::new(),
            squares: self.squares,
            unsupported: self.unsupported.clone(),
        }
    }
}

impl NormalEquations {
    /// Equations that hold every control point of a net in place with its own weight. Where the
    /// weight is 0, the fairing term alone determines the control point.
    pub(crate) fn holding(net: &[PaddedPoint], weights: &[f64], cells: &KnotCells) -> Self {
        let mut equations = NormalEquations::fairing(&strips(cells), cells);
        let nv = equations.shape[1];
        for (at, (p, &w)) in net.iter().zip(weights).enumerate() {
            equations.bands[4 * nv * (at / nv) + at % nv][0] += w;
            equations.right[at] += p * w;
            equations.squares += p.norm_squared() * w;
        }
        equations
    }

    /// The solution by sparse Cholesky.
    pub(crate) fn solve_directly(&self) -> Result<Vec<PaddedPoint>> {
        let [nu, nv] = self.shape;
        Ok(self.factor((0..(nu * nv) as u32).collect())?.solve(&self.right))
    }

    /// The Cholesky factor of the rows and columns of some control points, which must be in
    /// ascending order.
    pub(crate) fn factor(&self, points: Vec<u32>) -> Result<Factor> {
        let [nu, nv] = self.shape;
        let mut number = vec![NONE; nu * nv];
        points.iter().zip(0..).for_each(|(&point, n)| number[point as usize] = n);
        let mut triplets = Vec::with_capacity(25 * points.len());
        let mut couple = |low: usize, high: usize, value: f64| {
            let (low, high) = (number[low], number[high]);
            if low != NONE && high != NONE {
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

/// A direct solver for a subset of the control points.
pub(crate) struct Factor {
    points: Vec<u32>,
    cholesky: Cholesky<u32>,
}

impl Factor {
    /// The control points in ascending order.
    pub(crate) fn points(&self) -> &[u32] {
        &self.points
    }

    /// The solution for these points if all others are zero. `right` has an entry for every control
    /// point.
    pub(crate) fn solve(&self, right: &[PaddedPoint]) -> Vec<PaddedPoint> {
        let of = |n: usize, axis: usize| right[self.points[n] as usize][axis];
        let mut x = faer::Mat::from_fn(self.points.len(), 3, of);
        self.cholesky.solve(&mut x);
        (0..x.nrows()).map(|n| PaddedPoint::new(x[(n, 0)], x[(n, 1)], x[(n, 2)], 0.0)).collect()
    }
}

fn strips<W: Weight>(cells: &KnotCells) -> Vec<StripSums<W>> {
    (0..cells.counts()[0]).into_par_iter().map(|p| StripSums::new(cells, p)).collect()
}

/// Those of `count` strips of cells that row `i` of the net influences.
fn strips_of(i: usize, count: usize) -> std::ops::Range<usize> {
    i.saturating_sub(3)..(i + 1).min(count)
}

/// Adds to `out` the product of `x` and a symmetric matrix of bandwidth 3 whose entry (j, j + e) is
/// `band[j][e]`.
fn add_band<W: Weight>(band: &[[W; 4]], x: &[PaddedPoint], out: &mut [PaddedPoint]) {
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

/// Basis function `number` of a span. It belongs to one row of the net.
struct SpanFunction<'a> {
    span: &'a Span,
    number: usize,
}

impl SpanFunction<'_> {
    /// The pairs whose first function this is: the index in [`PAIRS`], and the difference between
    /// the numbers of the two functions.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let pairs = PAIRS.iter().enumerate();
        pairs.filter(|(_, (a, _))| *a == self.number).map(|(n, (a, c))| (n, c - a))
    }

    fn add_strip<W: Weight>(
        &self,
        strip: &StripSums<W>,
        bands: &mut [[W; 4]],
        right: &mut [PaddedPoint],
    ) {
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
