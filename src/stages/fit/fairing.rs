//! A fairing term for control points that the samples do not determine.
//!
//! The input is the sums over the strips of cells. The output is the integrals of the thin-plate
//! energy ∫ |S_xx|² + 2 |S_xy|² + |S_yy|² dx dy for each strip. Here x and y are lengths in mm
//! along u and v that are measured for each cell.
//!
//! In a cell without samples nearby, the term is almost as strong as samples would be. Its weight
//! falls off steeply with the number of samples in the cell and its eight neighbours. Where all of
//! them are covered, the remaining weight only keeps the equations regular. It also keeps the
//! surface smooth where it extends beyond the samples.

use rayon::prelude::*;

use super::knot_cells::KnotCells;
use super::strips::{Census, StripSums};
use super::weight::Weight;
use crate::spline::spans::{Cubic, PAIRS, Span, products};

/// The weight of the term in a cell without samples, as a share of the weight of the samples in a
/// mean cell.
const EMPTY: f64 = 1e-2;

/// The least share of [`EMPTY`] in a cell that has parts without samples, where the surface extends
/// beyond the samples. It is multiplied by the square of the share of these parts. Where samples
/// end within a cell, only a few of them determine its control points.
const UNSUPPORTED: f64 = 1e-3;

/// The number of samples, spread over the cell, from which on the term fades.
const FADE_FROM: f64 = 4.0;

/// Integrals over a strip of cells: `of[order][j][d]` is the integral of the weight times the
/// derivatives of order `order` of B_j and B_{j+d} in v. It belongs to the derivatives of order
/// 2 − `order` in u.
pub(crate) struct Fairing {
    pub of: [Vec<[f64; 4]>; 3],
}

/// The term of each strip.
pub(crate) fn strips<W: Weight>(strips: &[StripSums<W>], cells: &KnotCells) -> Vec<Fairing> {
    let metric = Lengths::new(strips, cells);
    let energies: Vec<[[f64; 10]; 3]> = cells.spans[1].all.iter().map(energies).collect();
    (0..strips.len()).into_par_iter().map(|p| strip(p, strips, &metric, &energies)).collect()
}

fn strip<W: Weight>(
    p: usize,
    strips: &[StripSums<W>],
    metric: &Lengths,
    energies: &[[[f64; 10]; 3]],
) -> Fairing {
    let strip = &strips[p];
    let around = &strips[p.saturating_sub(1)..(p + 2).min(strips.len())];
    let across: Vec<f64> = (0..strip.cells.len())
        .map(|q| around.iter().map(|strip| strip.cells[q].covering).sum())
        .collect();
    let unsupported = if metric.open { UNSUPPORTED } else { 0.0 };
    let mut of = [0; 3].map(|_| vec![[0.0; 4]; strip.cells.len() + 3]);
    for (q, (cell, energy)) in strip.cells.iter().zip(energies).enumerate() {
        let [x, y] = metric.half(p, q, cell);
        let covering: f64 = across[q.saturating_sub(1)..(q + 2).min(across.len())].iter().sum();
        let fade = (FADE_FROM / (FADE_FROM + covering))
            .powi(6)
            .max(unsupported * cell.unsupported.powi(2));
        let weight = EMPTY * fade * metric.weight * x.min(y).powi(4);
        let scales = [x.powi(-4), 2.0 / (x * y).powi(2), y.powi(-4)];
        for order in 0..3 {
            let scale = weight * scales[order];
            for (value, (b, d)) in energy[order].iter().zip(PAIRS) {
                of[order][q + b][d - b] += scale * value;
            }
        }
    }
    Fairing { of }
}

/// Integrals over a span, with s from −1 to 1, of the products of the [`PAIRS`] of basis functions,
/// of their first derivatives in s, and of their second derivatives.
pub(crate) fn energies(span: &Span) -> [[f64; 10]; 3] {
    let mut pieces = span.basis;
    [0; 3].map(|_| {
        let products = products(&pieces);
        pieces = pieces.map(derivative);
        products.map(|p| (0..4).map(|i| 2.0 * p[2 * i] / (2 * i + 1) as f64).sum())
    })
}

fn derivative([_, b, c, d]: Cubic) -> Cubic {
    [b, 2.0 * c, 3.0 * d, 0.0]
}

/// The half lengths of cells along u and along v, in mm.
struct Lengths {
    /// Lengths in mm per unit of u and of v: means over the strips of cells along v and along u.
    lengths: [Vec<Option<f64>>; 2],
    /// The means of these over all cells.
    mean: [f64; 2],
    /// Half widths of the spans in u and in v, as differences of parameters.
    halves: [Vec<f64>; 2],
    /// Σ w of a mean cell.
    weight: f64,
    /// Whether the samples end inside the domain.
    open: bool,
}

impl Lengths {
    fn new<W: Weight>(strips: &[StripSums<W>], cells: &KnotCells) -> Self {
        let halves = cells.spans.each_ref().map(|s| s.all.iter().map(Span::half).collect());
        let [across, down] = cells.counts();
        let mut sums = [vec![(0.0, 0.0); across], vec![(0.0, 0.0); down]];
        let mut total = [(0.0, 0.0); 2];
        let mut weights = (0.0, 0.0);
        for (p, strip) in strips.iter().enumerate() {
            for (q, cell) in strip.cells.iter().enumerate() {
                if cell.weight > 0.0 {
                    add(&mut weights, cell.weight);
                }
                let Some(slopes) = cell.slopes else { continue };
                for (axis, n) in [p, q].into_iter().enumerate() {
                    let halves: &Vec<f64> = &halves[axis];
                    add(&mut sums[axis][n], slopes[axis] / halves[n]);
                    add(&mut total[axis], slopes[axis] / halves[n]);
                }
            }
        }
        let mean = |(sum, count): (f64, f64)| (count > 0.0 && sum > 0.0).then(|| sum / count);
        Lengths {
            lengths: sums.map(|sums| sums.into_iter().map(mean).collect()),
            mean: total.map(|sum| mean(sum).unwrap_or(1.0)),
            halves,
            weight: mean(weights).unwrap_or(1.0),
            open: cells.samples.open,
        }
    }

    /// The half lengths of cell (p, q): its own, or the mean ones of its strips.
    fn half(&self, p: usize, q: usize, cell: &Census) -> [f64; 2] {
        let usual = |axis: usize, n: usize| {
            self.halves[axis][n] * self.lengths[axis][n].unwrap_or(self.mean[axis])
        };
        let usual = [usual(0, p), usual(1, q)];
        let own = cell.slopes.unwrap_or(usual);
        // The own lengths of collapsed or creased cells are not reliable.
        [0, 1].map(|k| own[k].clamp(1e-2 * usual[k], 1e2 * usual[k]))
    }
}

fn add((sum, count): &mut (f64, f64), x: f64) {
    *sum += x;
    *count += 1.0;
}
