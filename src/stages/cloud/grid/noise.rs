//! The noise of a scan with a grid. A raster and its edges go in; the standard deviation along the
//! normal comes out.
//!
//! The raster is divided into patches of 5 × 5 cells. Over each complete patch without a jump the
//! coordinates are fitted by quadratic polynomials of row and column. What the fit leaves, taken
//! along its normal, has n − 6 degrees of freedom, so the estimate of the variance is unbiased. The
//! median of all patches ignores those in which the shape is finer than the patch. Scanners with
//! coarse steps of depth deliver patches that are exactly flat; these are left out.

use rayon::prelude::*;

use super::jumps::GridEdges;
use super::raster::{GridCell, GridStep, Raster};
use crate::geometry::{Point, Vector};
use crate::statistics::{MeanSquare, median};

/// The cells along a side of a patch. Three leave too few degrees of freedom, seven bend more than
/// a quadratic polynomial.
const SIDE: usize = 5;

/// The cells of a patch.
const CELLS: f64 = (SIDE * SIDE) as f64;

/// Patches must hold at least this share of the points. Fewer are not typical of the scan.
const LEAST_COVERED: f64 = 0.01;

/// A patch whose residuals are below this share of the spacing says nothing: the scanner did not
/// resolve its noise there. Rounding to f32 leaves 1e-4, scanners' noise is more than 1e-2.
const FLAT: f64 = 1e-3;

/// The noise along the normal in the unit of the cloud, or `None` if patches cover too little of
/// the points. It is measured on patches that are not flat, if these cover enough.
pub(super) fn measure(raster: &Raster, edges: &GridEdges, spacing: f64) -> Option<f64> {
    let points = raster.cells().filter(|&cell| raster.index(cell).is_some()).count();
    let rows = (0..raster.rows() / SIDE).into_par_iter();
    let of_row = |row| {
        let columns = 0..raster.columns() / SIDE;
        columns.filter_map(move |column| variance(raster, edges, (SIDE * row, SIDE * column)))
    };
    let mut all: Vec<f64> = rows.flat_map_iter(of_row).collect();
    let is_enough = |variances: &[f64]| {
        !variances.is_empty() && variances.len() as f64 * CELLS >= LEAST_COVERED * points as f64
    };
    let rough = all.iter().copied().filter(|variance| *variance > (FLAT * spacing).powi(2));
    let mut rough: Vec<f64> = rough.collect();
    let variances = if is_enough(&rough) { &mut rough } else { &mut all };
    let variance = median(variances).filter(|_| is_enough(variances))?;
    Some((variance / MeanSquare(FREEDOM).at(0.0)).sqrt())
}

/// The degrees of freedom of a patch: six coefficients are fitted.
const FREEDOM: f64 = CELLS - 6.0;

/// The polynomials up to the second degree that are orthogonal on the 5 × 5 cells, by v and u from
/// −2 to 2, each with its sum of squares.
fn basis(v: f64, u: f64) -> [(f64, f64); 6] {
    [(1.0, 25.0), (u, 50.0), (v, 50.0), (u * u - 2.0, 70.0), (u * v, 100.0), (v * v - 2.0, 70.0)]
}

/// The variance along the normal in the patch whose first cell is given.
fn variance(raster: &Raster, edges: &GridEdges, first: GridCell) -> Option<f64> {
    let points = patch(raster, edges, first)?;
    let mut fit = [Vector::zeros(); 6];
    for &(v, u, p) in &points {
        for (sum, (value, squares)) in fit.iter_mut().zip(basis(v, u)) {
            *sum += (p - points[0].2) * (value / squares);
        }
    }
    let mut sum = 0.0;
    for &(v, u, p) in &points {
        let fitted: Vector = fit.iter().zip(basis(v, u)).map(|(c, (value, _))| c * value).sum();
        let along_u = fit[1] + 2.0 * u * fit[3] + v * fit[4];
        let along_v = fit[2] + u * fit[4] + 2.0 * v * fit[5];
        let normal = along_u.cross(&along_v).try_normalize(0.0)?;
        sum += (p - points[0].2 - fitted).dot(&normal).powi(2);
    }
    Some(sum / FREEDOM)
}

/// The points of a patch with their places in it, if it is complete and has no jump.
fn patch(raster: &Raster, edges: &GridEdges, first: GridCell) -> Option<Vec<(f64, f64, Point)>> {
    let places = (0..SIDE).flat_map(|v| (0..SIDE).map(move |u| (v, u)));
    let middle = (SIDE / 2) as f64;
    let point = |(v, u): (usize, usize)| {
        let cell = (first.0 + v, first.1 + u);
        let across = u + 1 == SIDE || edges.is_joined(cell, GridStep::Column);
        let down = v + 1 == SIDE || edges.is_joined(cell, GridStep::Row);
        let point = raster.point(cell).filter(|_| across && down)?;
        Some((v as f64 - middle, u as f64 - middle, point))
    };
    places.map(point).collect()
}
