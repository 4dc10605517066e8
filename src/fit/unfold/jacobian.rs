//! Places all over a surface at which it is looked whether it turns over.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::fit::cells::Cells;
use crate::fit::tangent_distance::TangentDistance;
use crate::geometry::{Uv, Vector};
use crate::spline::KnotVector;

/// Places looked at in a cell along u and along v.
pub const ACROSS: usize = 6;

/// Where a place spreads by less than this share of what is usual, finer places around it
/// are looked at, this many to a step: a fold may be narrower than places are apart.
const SUSPECT: f64 = 0.5;
const FINER: usize = 4;

/// The finer places of a cell along u and along v.
const FINEST: usize = (ACROSS - 1) * FINER + 1;

/// The surface is to spread at a place by this share of what is usual around it,
/// on the side that the samples face.
pub const MIN_SPREAD: f64 = 0.1;

/// It counts as turned over where it spreads by less than this share.
const INVERTED: f64 = 0.01;

/// Sweeps over the cells without samples.
const SWEEPS: usize = 40;

/// The values and slopes of the four functions at a place of one axis.
pub type Functions = [[f64; 4]; 2];

/// The four rows of the net that reach into a cell, as points and their changes with v.
type Rows = [[Vector; 2]; 4];

/// A place around which the surface spreads too little, moved to where it spreads least.
pub struct JacobianSample {
    /// Its cell.
    pub cell: [usize; 2],
    /// The functions in u and in v.
    pub functions: [Functions; 2],
    /// Where the samples face, of length 1.
    pub facing: Vector,
    /// Derivatives in u and in v, over the usual product of their lengths.
    pub slopes: [Vector; 2],
    /// What they span towards `facing`, of the usual.
    pub spread: f64,
}

impl JacobianSample {
    /// Whether the surface is turned over, or all but is.
    pub fn is_inverted(&self) -> bool {
        self.spread < INVERTED
    }
}

/// The places of a net.
pub struct JacobianSamples<'a> {
    cells: &'a Cells<'a>,
    holds: &'a [TangentDistance],
    /// The finer places along u and along v, each with the functions there.
    axes: [Vec<(f64, Functions)>; 2],
    /// The mean normal of a cell's samples; in a cell without any, one that changes
    /// smoothly from those around.
    facings: Vec<Vector>,
    /// The usual product of the derivatives' lengths around a cell, in mm².
    usual: Vec<f64>,
}

/// How many places a surface over some knots has.
pub fn count(knots: [&KnotVector; 2]) -> usize {
    knots.map(|knots| ACROSS * (knots.breaks().len() - 1)).iter().product()
}

impl<'a> JacobianSamples<'a> {
    /// The places of a net over `cells`, whose samples are held by `holds`.
    pub fn new(cells: &'a Cells<'a>, holds: &'a [TangentDistance], net: &[Vector]) -> Self {
        let axes = cells.knots.map(along);
        let mut places = JacobianSamples {
            cells,
            holds,
            axes,
            facings: facings(cells, holds),
            usual: Vec::new(),
        };
        places.usual = places.usual(net);
        places
    }

    /// Places that spread too little in the cells that are `chosen`.
    pub fn spots(
        &self,
        net: &[Vector],
        chosen: impl Fn(usize, usize) -> bool + Sync,
    ) -> Vec<JacobianSample> {
        let [across, down] = self.cells.counts();
        let rows = (0..across).into_par_iter().map(|p| {
            let cells = (0..down).filter(|&q| chosen(p, q));
            cells.flat_map(|q| self.in_cell(net, [p, q])).collect::<Vec<JacobianSample>>()
        });
        rows.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    fn in_cell(&self, net: &[Vector], [p, q]: [usize; 2]) -> Vec<JacobianSample> {
        let number = p * self.cells.counts()[1] + q;
        let usual = self.usual[number];
        let slopes = self.slopes(net, [p, q]);
        let home = self.cells.indices(p, q);
        let between = home.is_empty().then(|| self.facings[number].try_normalize(1e-9));
        let mut spots = Vec::new();
        for (n, [along, across]) in slopes.into_iter().enumerate() {
            let place = [n / ACROSS * FINER, n % ACROSS * FINER];
            let normal = along.cross(&across);
            let nearest = || {
                let [u, v] = self.place([p, q], place).map(|(at, _)| *at);
                self.nearest(home, Uv::new(u, v))
            };
            let Some(facing) = between.unwrap_or_else(nearest) else { continue };
            if facing.dot(&normal) < SUSPECT * usual {
                let spot = self.least_around(net, [p, q], place, facing);
                spots.extend(spot.filter(|spot| spot.spread < MIN_SPREAD));
            }
        }
        spots
    }

    /// Where the surface spreads least among the finer places that are nearer to `place` than
    /// to others.
    fn least_around(
        &self,
        net: &[Vector],
        cell: [usize; 2],
        place: [usize; 2],
        facing: Vector,
    ) -> Option<JacobianSample> {
        let usual = self.usual[cell[0] * self.cells.counts()[1] + cell[1]];
        let [us, vs] = place.map(|k| k.saturating_sub(FINER / 2)..=(k + FINER / 2).min(FINEST - 1));
        let rows: Vec<Rows> = vs.clone().map(|b| self.rows(net, cell, b)).collect();
        let spots = us.flat_map(|a| vs.clone().zip(&rows).map(move |(b, rows)| ([a, b], rows)));
        let spots = spots.map(|(at, rows)| {
            let functions = self.place(cell, at).map(|(_, functions)| *functions);
            let slopes = slopes(rows, &functions[0]).map(|slope| slope / usual);
            let spread = facing.dot(&slopes[0].cross(&slopes[1])) * usual;
            JacobianSample { cell, functions, facing, slopes, spread }
        });
        let least = |a: JacobianSample, b: JacobianSample| if b.spread < a.spread { b } else { a };
        spots.reduce(least)
    }

    /// A finer place of a cell along u and along v.
    fn place(&self, [p, q]: [usize; 2], [a, b]: [usize; 2]) -> [&(f64, Functions); 2] {
        [&self.axes[0][p * FINEST + a], &self.axes[1][q * FINEST + b]]
    }

    /// Where the sample faces that is nearest to `at` in the domain.
    fn nearest(&self, samples: &[u32], at: Uv) -> Option<Vector> {
        let distance = |i: usize| (self.cells.samples.uv[i] - at).norm_squared();
        let by_distance = |a: &usize, b: &usize| {
            distance(*a).partial_cmp(&distance(*b)).unwrap_or(Ordering::Equal)
        };
        let nearest = samples.iter().map(|&i| i as usize).min_by(by_distance);
        nearest.map(|i| self.holds[i].normal)
    }

    /// The derivatives in u and v at the places of a cell.
    fn slopes(&self, net: &[Vector], cell: [usize; 2]) -> [[Vector; 2]; ACROSS * ACROSS] {
        let mut all = [[Vector::zeros(); 2]; ACROSS * ACROSS];
        for b in 0..ACROSS {
            let rows = self.rows(net, cell, b * FINER);
            for a in 0..ACROSS {
                all[a * ACROSS + b] = slopes(&rows, &self.axes[0][cell[0] * FINEST + a * FINER].1);
            }
        }
        all
    }

    /// A cell's rows of the net at its finer place `b` along v.
    fn rows(&self, net: &[Vector], [p, q]: [usize; 2], b: usize) -> Rows {
        let width = self.cells.counts()[1] + 3;
        let (_, functions) = &self.axes[1][q * FINEST + b];
        std::array::from_fn(|i| {
            let row = &net[(p + i) * width + q..][..4];
            functions.map(|of| row.iter().zip(of).map(|(c, b)| c * b).sum())
        })
    }

    fn usual(&self, net: &[Vector]) -> Vec<f64> {
        let [across, down] = self.cells.counts();
        let own: Vec<Vec<f64>> = (0..across)
            .into_par_iter()
            .map(|p| (0..down).map(|q| mean_product(&self.slopes(net, [p, q]))).collect())
            .collect();
        let around = |p: usize, q: usize| {
            let rows = &own[p.saturating_sub(1)..(p + 2).min(across)];
            let of = q.saturating_sub(1)..(q + 2).min(down);
            rows.iter().flat_map(|row| &row[of.clone()]).sum::<f64>()
                / (rows.len() * of.len()) as f64
        };
        let cells = (0..across).flat_map(|p| (0..down).map(move |q| (p, q)));
        cells.map(|(p, q)| around(p, q).max(f64::MIN_POSITIVE)).collect()
    }
}

/// The derivatives in u and v where rows meet functions of u.
fn slopes(rows: &Rows, [value, slope]: &Functions) -> [Vector; 2] {
    let mut slopes = [Vector::zeros(); 2];
    for (i, [along, across]) in rows.iter().enumerate() {
        slopes[0] += along * slope[i];
        slopes[1] += across * value[i];
    }
    slopes
}

fn mean_product(slopes: &[[Vector; 2]]) -> f64 {
    slopes.iter().map(|[u, v]| u.norm() * v.norm()).sum::<f64>() / slopes.len() as f64
}

/// The mean normals of all cells' samples, and between them the solution of
/// Laplace's equation, or near it.
fn facings(cells: &Cells, holds: &[TangentDistance]) -> Vec<Vector> {
    let [across, down] = cells.counts();
    let at = |c: usize| cells.indices(c / down, c % down);
    let mean = |c: usize| -> Vector {
        let sum: Vector = at(c).iter().map(|&i| holds[i as usize].normal).sum();
        sum.try_normalize(1e-9).unwrap_or_default()
    };
    let count = across * down;
    let mut facings: Vec<Vector> = (0..count).map(mean).collect();
    let empty: Vec<usize> = (0..count).filter(|&c| at(c).is_empty()).collect();
    for sweep in 0..SWEEPS {
        for k in 0..empty.len() {
            // There and back, so that each sweep carries all the way.
            let c = empty[if sweep % 2 == 0 { k } else { empty.len() - 1 - k }];
            let (p, q) = (c / down, c % down);
            let around = [
                (p > 0).then(|| c - down),
                (p + 1 < across).then(|| c + down),
                (q > 0).then(|| c - 1),
                (q + 1 < down).then(|| c + 1),
            ];
            let around = around.into_iter().flatten().map(|c| facings[c]);
            // Cells that nothing was carried to yet do not count.
            let known: Vec<Vector> = around.filter(|f| *f != Vector::zeros()).collect();
            facings[c] = known.iter().sum::<Vector>() / known.len().max(1) as f64;
        }
    }
    facings
}

/// The finer places of an axis.
fn along(knots: &KnotVector) -> Vec<(f64, Functions)> {
    let ends = &knots.knots()[3..=knots.functions()];
    let spans = ends.windows(2).enumerate();
    let places = spans.flat_map(|(n, ends)| {
        // The ends, too: a side of the domain may fold where its cell does not.
        let (low, step) = (ends[0], (ends[1] - ends[0]) / (FINEST - 1) as f64);
        (0..FINEST).map(move |k| (n + 3, low + step * k as f64))
    });
    let at = |(span, t): (usize, f64)| {
        let [value, slope, _] = knots.basis_in(span, t).derivative;
        (t, [value, slope].map(|of| [of[0], of[1], of[2], of[3]]))
    };
    places.map(at).collect()
}
