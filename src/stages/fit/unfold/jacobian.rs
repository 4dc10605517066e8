//! Jacobian samples: points of a surface at which its orientation is tested.
//!
//! The input is a control net and samples with normals. The output is the points at which the
//! normalized Jacobian determinant, seen from the side that the samples face, is too small.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::geometry::{Uv, Vector};
use crate::spline::KnotVector;
use crate::stages::fit::knot_cells::KnotCells;
use crate::stages::fit::tangent_distance::TangentDistance;

/// The number of Jacobian samples in a cell along u and along v.
pub(crate) const ACROSS: usize = 6;

/// Finer samples are tested around a sample whose Jacobian determinant is below this share of the
/// usual one, because a fold may be narrower than the distance of samples.
const SUSPECT: f64 = 0.5;

/// The number of steps between finer samples in one step between samples.
const FINER: usize = 4;

/// The number of finer samples of a cell along u and along v.
const FINEST: usize = (ACROSS - 1) * FINER + 1;

/// The least wanted Jacobian determinant, seen from the side that the samples face, as a share of
/// the usual one nearby.
pub(crate) const MIN_SPREAD: f64 = 0.1;

/// A sample is inverted if its Jacobian determinant is below this share of the usual one.
const INVERTED: f64 = 0.01;

/// The number of relaxation sweeps over the cells without samples.
const SWEEPS: usize = 40;

/// The values and first derivatives of the four basis functions at a parameter of one axis.
pub(crate) type Functions = [[f64; 4]; 2];

/// The four rows of the net that influence a cell, evaluated at a parameter v: their points and
/// derivatives in v.
type Rows = [[Vector; 2]; 4];

/// A sample with a Jacobian determinant that is too small. It is the finer sample with the smallest
/// one nearby.
pub(crate) struct JacobianSample {
    /// The knot cell of the sample.
    pub cell: [usize; 2],
    /// The basis functions in u and in v.
    pub functions: [Functions; 2],
    /// The unit normal that the samples have there.
    pub facing: Vector,
    /// The derivatives in u and in v, divided by the usual product of their lengths.
    pub slopes: [Vector; 2],
    /// The normalized Jacobian determinant: the area that the derivatives span, seen from `facing`,
    /// as a share of the usual one.
    pub spread: f64,
}

impl JacobianSample {
    /// Whether the surface is inverted or almost inverted here.
    pub(crate) fn is_inverted(&self) -> bool {
        self.spread < INVERTED
    }
}

/// The Jacobian samples of a net.
pub(crate) struct JacobianSamples<'a> {
    cells: &'a KnotCells<'a>,
    holds: &'a [TangentDistance],
    /// The parameters of the finer samples along u and along v, with the basis functions there.
    axes: [Vec<(f64, Functions)>; 2],
    /// The mean normal of each cell's samples. In a cell without samples it is interpolated
    /// smoothly from the cells around it.
    facings: Vec<Vector>,
    /// The usual product of the lengths of the derivatives around each cell, in mm².
    usual: Vec<f64>,
}

/// The number of Jacobian samples of a surface over the given knots.
pub(crate) fn count(knots: [&KnotVector; 2]) -> usize {
    knots.map(|knots| ACROSS * (knots.breaks().len() - 1)).iter().product()
}

impl<'a> JacobianSamples<'a> {
    /// The Jacobian samples of a net over `cells`. `holds` has the normals of the samples.
    pub(super) fn new(
        cells: &'a KnotCells<'a>,
        holds: &'a [TangentDistance],
        net: &[Vector],
    ) -> Self {
        let axes = cells.knots.map(along);
        let mut samples = JacobianSamples {
            cells,
            holds,
            axes,
            facings: facings(cells, holds),
            usual: Vec::new(),
        };
        samples.usual = samples.usual(net);
        samples
    }

    /// The samples in the `chosen` cells whose Jacobian determinant is too small.
    pub(crate) fn flagged(
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
        let mut flagged = Vec::new();
        for (n, [along, across]) in slopes.into_iter().enumerate() {
            let place = [n / ACROSS * FINER, n % ACROSS * FINER];
            let normal = along.cross(&across);
            let nearest = || {
                let [u, v] = self.place([p, q], place).map(|(at, _)| *at);
                self.nearest(home, Uv::new(u, v))
            };
            let Some(facing) = between.unwrap_or_else(nearest) else { continue };
            if facing.dot(&normal) < SUSPECT * usual {
                let jacobian = self.least_around(net, [p, q], place, facing);
                flagged.extend(jacobian.filter(|jacobian| jacobian.spread < MIN_SPREAD));
            }
        }
        flagged
    }

    /// The sample with the smallest Jacobian determinant among the finer samples that are nearest
    /// to `place`.
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
        let candidates =
            us.flat_map(|a| vs.clone().zip(&rows).map(move |(b, rows)| ([a, b], rows)));
        let candidates = candidates.map(|(at, rows)| {
            let [(_, along), _] = self.place(cell, at);
            let slopes = slopes(rows, along).map(|slope| slope / usual);
            let spread = facing.dot(&slopes[0].cross(&slopes[1])) * usual;
            (spread, at, slopes)
        });
        let (spread, at, slopes) = candidates.reduce(|a, b| if b.0 < a.0 { b } else { a })?;
        let functions = self.place(cell, at).map(|(_, functions)| *functions);
        Some(JacobianSample { cell, functions, facing, slopes, spread })
    }

    /// The parameters of a finer sample of a cell in u and in v, with the basis functions there.
    fn place(&self, [p, q]: [usize; 2], [a, b]: [usize; 2]) -> [&(f64, Functions); 2] {
        [&self.axes[0][p * FINEST + a], &self.axes[1][q * FINEST + b]]
    }

    /// The normal of the sample that is nearest to `at` in the parameter plane.
    fn nearest(&self, samples: &[u32], at: Uv) -> Option<Vector> {
        let distance = |i: usize| (self.cells.samples.uv[i] - at).norm_squared();
        let by_distance = |a: &usize, b: &usize| {
            distance(*a).partial_cmp(&distance(*b)).unwrap_or(Ordering::Equal)
        };
        let nearest = samples.iter().map(|&i| i as usize).min_by(by_distance);
        nearest.map(|i| self.holds[i].normal)
    }

    /// The derivatives in u and v at the samples of a cell.
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

    /// The rows of the net that influence a cell, at its finer sample `b` along v.
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

/// The derivatives in u and v from evaluated rows and the basis functions in u.
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

/// The mean normals of the samples of each cell. In cells without samples, relaxation approximates
/// the solution of Laplace's equation.
fn facings(cells: &KnotCells, holds: &[TangentDistance]) -> Vec<Vector> {
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
            // The direction alternates, so that each sweep carries values across all cells.
            let c = empty[if sweep % 2 == 0 { k } else { empty.len() - 1 - k }];
            let (p, q) = (c / down, c % down);
            let around = [
                (p > 0).then(|| c - down),
                (p + 1 < across).then(|| c + down),
                (q > 0).then(|| c - 1),
                (q + 1 < down).then(|| c + 1),
            ];
            let around = around.into_iter().flatten().map(|c| facings[c]);
            // Cells that have no value yet do not count.
            let known: Vec<Vector> = around.filter(|f| *f != Vector::zeros()).collect();
            facings[c] = known.iter().sum::<Vector>() / known.len().max(1) as f64;
        }
    }
    facings
}

/// The parameters of the finer samples of an axis, with the basis functions there.
fn along(knots: &KnotVector) -> Vec<(f64, Functions)> {
    let ends = &knots.knots()[3..=knots.functions()];
    let spans = ends.windows(2).enumerate();
    let places = spans.flat_map(|(n, ends)| {
        // Include the ends, because a side of the domain may fold where its cell does not.
        let (low, step) = (ends[0], (ends[1] - ends[0]) / (FINEST - 1) as f64);
        (0..FINEST).map(move |k| (n + 3, low + step * k as f64))
    });
    let at = |(span, t): (usize, f64)| {
        let [value, slope, _] = knots.basis_in(span, t).derivative;
        (t, [value, slope].map(|of| [of[0], of[1], of[2], of[3]]))
    };
    places.map(at).collect()
}
