//! The B-spline surface of a smooth piece of a clean mesh whose kind is not known: fill → parameterize → knots and fit.

use super::Options;
use crate::deviation::Deviation;
use crate::error::Result;
use crate::mesh::{Disk, Mesh, Outline};
use crate::spline::{SplineSheet, foot_point};
use crate::stages::adapt::Goal;
use crate::stages::{adapt, fill, parameterize};
use crate::statistics::SIGNIFICANT;

/// The surface follows the vertices to this share of what the flat triangles leave open: the shape between two vertices
/// is not known better.
const SHARE: f64 = 0.1;

/// Fits a surface to some triangles of a mesh in mm. `rounding` is the bound of the errors of its vertices in mm.
///
/// # Errors
/// The triangles are no disk with holes, or a stage fails.
pub(super) fn sheet(mesh: &Mesh, triangles: &[u32], rounding: f64) -> Result<SplineSheet> {
    let (piece, _) = mesh.part(triangles.iter().map(|&t| t as usize));
    let chord_error = piece.mean_chord_error();
    let tolerance = (SHARE * chord_error).max(SIGNIFICANT * rounding);
    let disk = Disk::of(piece)?;
    let points = disk.mesh.points.clone();
    let (patch, _) = fill::fill_with(
        disk,
        &points,
        &fill::Options::default(),
        &mut crate::progress::ignore,
    )?;
    let how = parameterize::Options { outline: Some(Outline::Free), ..Default::default() };
    let (mut map, _) = parameterize::parameterize(patch, &how)?;
    let goal = Goal { tolerance, named: true, outliers: 0.0 };
    let (surface, _) = adapt::fit(&mut map, &Options::default().adapt(0.0), &goal)?;
    let starts = map.scan_uv();
    let off = points.iter().zip(starts.iter()).map(|(&p, &at)| foot_point(&surface, p, at).1);
    let within = Deviation::of(&points, off.collect()).max;
    Ok(SplineSheet::new(surface, within, chord_error.max(within)))
}
