//! What the normal equations need to know of one strip of knot cells, those
//! between two neighbouring knots in u: sums over its samples that are already
//! B-splines in v and still powers in u.

use super::cells::Cells;
use super::moments::Moments;
use super::spans::{PAIRS, Span};

/// The sums of one strip; entry j of the lists belongs to control points (·, j).
pub struct Strip {
    /// `gram[j][k][d]` = Σ w sᵏ B_j(v) B_{j+d}(v).
    pub gram: Vec<[[f64; 4]; 7]>,
    /// `right[j][axis][k]` = Σ w sᵏ B_j(v) p.
    pub right: Vec<[[f64; 4]; 3]>,
    /// Σ w p².
    pub squares: f64,
    /// What each cell's samples look like.
    pub cells: Vec<Census>,
}

/// A cell's samples at a glance.
#[derive(Debug, Clone, Copy)]
pub struct Census {
    /// Σ w.
    pub weight: f64,
    /// How many there are; fewer where they leave parts of the cell empty.
    pub covering: f64,
    /// The share of its parts that have no sample.
    pub bare: f64,
    /// Mean change of p, in mm, with s and with t, where there are samples
    /// enough to tell.
    pub slopes: Option<[f64; 2]>,
}

impl Strip {
    /// The sums of strip `p`.
    pub fn new(cells: &Cells, p: usize) -> Self {
        let down = cells.counts()[1];
        let mut strip = Strip {
            gram: vec![[[0.0; 4]; 7]; down + 3],
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

    fn add(&mut self, q: usize, moments: &Moments, span: &Span) {
        for (product, (b, d)) in span.products.iter().zip(PAIRS) {
            let mut sums = [0.0; 8];
            for (row, c) in moments.gram.iter().zip(product) {
                sums.iter_mut().zip(row).for_each(|(sum, m)| *sum += c * m);
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

/// A cell is looked at in this many parts along u and v.
const PARTS: f64 = 4.0;

impl Census {
    fn new(moments: &Moments, cells: &Cells, p: usize, q: usize) -> Self {
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
            weight: moments.gram[0][0],
            covering: cells.count(p, q) as f64 * share.powi(3),
            bare: 1.0 - share,
            slopes: slopes(moments),
        }
    }
}

/// Length of the gradient of p along s and t, by least squares on a plane.
fn slopes(m: &Moments) -> Option<[f64; 2]> {
    let [w, s, t] = [m.gram[0][0], m.gram[0][1], m.gram[1][0]];
    let [ss, st, tt] = [m.gram[0][2], m.gram[1][1], m.gram[2][0]];
    // Spread about the mean; a third of the weight is that of a full cell.
    let (ss, st, tt) = (ss - s * s / w, st - s * t / w, tt - t * t / w);
    let det = ss * tt - st * st;
    if !(w > 0.0 && det > (0.03 * w) * (0.03 * w)) {
        return None;
    }
    let mut squares = [0.0; 2];
    for axis in &m.right {
        let (sp, tp) = (axis[0][1] - s * axis[0][0] / w, axis[1][0] - t * axis[0][0] / w);
        squares[0] += ((tt * sp - st * tp) / det).powi(2);
        squares[1] += ((ss * tp - st * sp) / det).powi(2);
    }
    Some(squares.map(f64::sqrt))
}
