//! A fairing term for what the samples leave open: thin-plate energy
//! ∫ |S_xx|² + 2 |S_xy|² + |S_yy|² dx dy, where x and y run along u and v and
//! are lengths in mm, measured cell by cell.
//!
//! A cell without samples around it feels it almost as strongly as samples would
//! hold it; with their number in the cell and the eight around it the weight falls
//! off so steeply that where these are covered nothing of it is left but what keeps
//! the equations regular, and the surface calm where it goes on beyond the samples.

use rayon::prelude::*;

use super::cells::Cells;
use super::strips::{Census, Strip};
use super::weight::Weight;
use crate::spline::spans::{Cubic, PAIRS, Span, products};

/// Weight of the term in a cell without samples, of that of a mean cell's.
const EMPTY: f64 = 1e-2;

/// What is left of that, where the surface goes on beyond the samples, in a cell in
/// parts bare of them, for the share squared of these: where samples end within a
/// cell, its control points hang on the few places that its functions have there.
const BARE: f64 = 1e-3;

/// Samples, spread over the cell, from which on the term fades.
const FEW: f64 = 4.0;

/// Integrals over a strip: `of[order][j][d]` is that of the weight times the
/// derivatives of order `order` of B_j and B_{j+d} in v, and belongs to the
/// derivatives of order 2 − `order` in u.
pub struct Fairing {
    pub of: [Vec<[f64; 4]>; 3],
}

/// The term of every strip.
pub fn strips<W: Weight>(strips: &[Strip<W>], cells: &Cells) -> Vec<Fairing> {
    let metric = Lengths::new(strips, cells);
    let energies: Vec<[[f64; 10]; 3]> = cells.spans[1].all.iter().map(energies).collect();
    (0..strips.len()).into_par_iter().map(|p| strip(p, strips, &metric, &energies)).collect()
}

fn strip<W: Weight>(
    p: usize,
    strips: &[Strip<W>],
    metric: &Lengths,
    energies: &[[[f64; 10]; 3]],
) -> Fairing {
    let strip = &strips[p];
    let around = &strips[p.saturating_sub(1)..(p + 2).min(strips.len())];
    let across: Vec<f64> = (0..strip.cells.len())
        .map(|q| around.iter().map(|strip| strip.cells[q].covering).sum())
        .collect();
    let bare = if metric.open { BARE } else { 0.0 };
    let mut of = [0; 3].map(|_| vec![[0.0; 4]; strip.cells.len() + 3]);
    for (q, (cell, energy)) in strip.cells.iter().zip(energies).enumerate() {
        let [x, y] = metric.half(p, q, cell);
        let covering: f64 = across[q.saturating_sub(1)..(q + 2).min(across.len())].iter().sum();
        let fade = (FEW / (FEW + covering)).powi(6).max(bare * cell.bare.powi(2));
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

/// Integrals of the products of [`PAIRS`], of their derivatives in s and of
/// their second ones, over a span with s from −1 to 1.
pub fn energies(span: &Span) -> [[f64; 10]; 3] {
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

/// How long, in mm, half a cell is along u and along v.
struct Lengths {
    /// In mm a unit of u and of v: means over the strips of cells along v and
    /// along u, and the mean of all.
    lengths: [Vec<Option<f64>>; 2],
    mean: [f64; 2],
    halves: [Vec<f64>; 2],
    /// Σ w of a mean cell.
    weight: f64,
    /// Whether the samples end inside the domain.
    open: bool,
}

impl Lengths {
    fn new<W: Weight>(strips: &[Strip<W>], cells: &Cells) -> Self {
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

    /// The half lengths of cell (p, q): its own, or those usual around it.
    fn half(&self, p: usize, q: usize, cell: &Census) -> [f64; 2] {
        let usual = |axis: usize, n: usize| {
            self.halves[axis][n] * self.lengths[axis][n].unwrap_or(self.mean[axis])
        };
        let usual = [usual(0, p), usual(1, q)];
        let own = cell.slopes.unwrap_or(usual);
        // Crushed or creased cells have no length to go by.
        [0, 1].map(|k| own[k].clamp(1e-2 * usual[k], 1e2 * usual[k]))
    }
}

fn add((sum, count): &mut (f64, f64), x: f64) {
    *sum += x;
    *count += 1.0;
}
