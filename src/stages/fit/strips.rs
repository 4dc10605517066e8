//! Sums over the samples of one strip of knot cells, for the normal equations.
//!
//! A strip is the cells between two neighbouring knots in u. The output is sums over its samples of
//! products of B-splines in v and powers in u.

use nalgebra::Matrix3;

use super::knot_cells::{CellSample, KnotCells};
use super::moments::Moments;
use super::weight::Weight;
use crate::geometry::Vector;
use crate::spline::spans::{PAIRS, Span};

/// The sums of one strip. Entry j of the lists belongs to control points (·, j).
pub(crate) struct StripSums<W> {
    /// `gram[j][k][d]` = Σ w sᵏ B_j(v) B_{j+d}(v).
    pub gram: Vec<[[W; 4]; 7]>,
    /// `right[j][axis][k]` = Σ w sᵏ B_j(v) p.
    pub right: Vec<[[f64; 4]; 3]>,
    /// Σ w p².
    pub squares: f64,
    /// Statistics of each cell's samples.
    pub cells: Vec<Census>,
}

/// Statistics of a cell's samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Census {
    /// Σ w.
    pub weight: f64,
    /// The number of samples, reduced if they leave parts of the cell empty.
    pub covering: f64,
    /// The share of the cell's parts that have no sample.
    pub unsupported: f64,
    /// The mean change of p with s and with t, in mm, if there are enough samples.
    pub slopes: Option<[f64; 2]>,
}

impl<W: Weight> StripSums<W> {
    /// The sums of strip `p`.
    pub(super) fn new(cells: &KnotCells, p: usize) -> Self {
        let down = cells.counts()[1];
        let mut strip = StripSums {
            gram: vec![[[W::even(0.0); 4]; 7]; down + 3],
            right: vec![[[0.0; 4]; 3]; down + 3],
            squares: 0.0,
            cells: Vec::with_capacity(down),
        };
        for q in 0..down {
            let moments = Moments::of(cells, p, q);
            strip.cells.push(Census::new(&moments, cells, p, q));
            if cells.count(p, q) > 0 {
                strip.add(q, &moments, &cells.spans[1].all[q]);
            }
        }
        strip
    }

    fn add(&mut self, q: usize, moments: &Moments<W>, span: &Span) {
        for (product, (b, d)) in span.products.iter().zip(PAIRS) {
            let mut sums = [W::even(0.0); 8];
            for (row, c) in moments.gram.iter().zip(product) {
                sums.iter_mut().zip(row).for_each(|(sum, m)| *sum += *m * *c);
            }
            let to = &mut self.gram[q + b];
            to.iter_mut().zip(sums).for_each(|(to, sum)| to[d - b] += sum);
        }
        for (b, piece) in span.basis.iter().enumerate() {
            let to = &mut self.right[q + b];
            for (to, rows) in to.iter_mut().zip(&moments.right) {
                for (row, c) in rows.iter().zip(piece) {
                    to.iter_mut().zip(row).for_each(|(to, m)| *to += c * m);
                }
            }
        }
        self.squares += moments.squares;
    }
}

/// The number of parts along u and along v into which a cell is divided to see whether samples
/// cover it.
const PARTS: f64 = 4.0;

impl Census {
    fn new<W: Weight>(moments: &Moments<W>, cells: &KnotCells, p: usize, q: usize) -> Self {
        let mut seen = 0u16;
        for at in cells.places(p, q) {
            let part = |x: f64| ((x + 1.0) * 0.5 * PARTS).clamp(0.0, PARTS - 1.0) as u16;
            seen |= 1 << (4 * part(at.x) + part(at.y));
            if seen == u16::MAX {
                break;
            }
        }
        let share = f64::from(seen.count_ones()) / (PARTS * PARTS);
        Census {
            weight: moments.gram[0][0].mean(),
            covering: cells.count(p, q) as f64 * share.powi(3),
            unsupported: 1.0 - share,
            slopes: slopes(cells, p, q),
        }
    }
}

/// The number of samples that suffice to measure the lengths of a cell.
const SLOPE_SAMPLES: usize = 64;

/// The lengths of the derivatives of p in s and in t, from a least-squares fit of an affine map.
fn slopes(cells: &KnotCells, p: usize, q: usize) -> Option<[f64; 2]> {
    let step = cells.count(p, q).div_ceil(SLOPE_SAMPLES).max(1);
    let mut gram = Matrix3::zeros();
    let mut right = Matrix3::zeros();
    for CellSample { place, weight, point } in cells.samples::<f64>(p, q).step_by(step) {
        let plane = Vector::new(1.0, place.x, place.y);
        gram += weight * plane * plane.transpose();
        right += weight * plane * point.transpose();
    }
    // The variance about the mean. That of a full cell is a third of the weight.
    let w = gram[(0, 0)];
    let spread = |a: usize, b: usize| gram[(a, b)] - gram[(0, a)] * gram[(0, b)] / w;
    let (ss, st, tt) = (spread(1, 1), spread(1, 2), spread(2, 2));
    let det = ss * tt - st * st;
    if !(w > 0.0 && det > (0.03 * w) * (0.03 * w)) {
        return None;
    }
    let along = |a: usize| right.row(a) - right.row(0) * (gram[(0, a)] / w);
    let (sp, tp) = (along(1), along(2));
    Some([(sp * tt - tp * st).norm() / det, (tp * ss - sp * st).norm() / det])
}
