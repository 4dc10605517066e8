//! Detection of outliers: points that are far from the surface through their neighbours while these
//! neighbours are not.

use rayon::prelude::*;

use super::levels::SupportLevel;
use super::median;
use super::support::SupportField;
use super::surface::{MlsSurface, NOWHERE};
use crate::error::Result;
use crate::geometry::{ALONE, Vector, VertexId};
use crate::mesh::{Mesh, VertexRings};
use crate::progress;

/// An outlier is farther from the surface than this multiple of the standard deviation of the
/// residuals around it. Fewer than one in a hundred million normally distributed residuals is as
/// large.
const DEVIATIONS: f64 = 6.0;

/// A point nearer to the surface than this share of the mean edge length is not an outlier. On a
/// scan without noise, fit errors may exceed the noise.
const MIN_DISTANCE: f64 = 0.1;

/// The lowest level on which fits are stable enough for the detection.
const STABLE_LEVEL: usize = 2;

/// Points are examined only if they are farther from the mean of their neighbours than this
/// multiple of the standard deviation.
const STICKS_OUT: f64 = 4.0;

/// Marks outliers in `left_out`, by their distances from the surface with the median support of the
/// scan. A locally narrow support may itself be the effect of an outlier. Returns whether new
/// outliers were found.
pub fn add(
    mesh: &Mesh,
    rings: &VertexRings,
    levels: &[SupportLevel],
    choice: &SupportField,
    left_out: &mut [bool],
) -> Result<bool> {
    let least = MIN_DISTANCE * mesh.mean_edge();
    let limit = |v: usize, deviations: f64| least.max(deviations * f64::from(choice.residual[v]));
    let normals = &levels[0].clusters.normals;
    let suspects: Vec<usize> = (0..mesh.points.len())
        .into_par_iter()
        .filter(|&v| !left_out[v] && sticks_out(mesh, rings, v, normals[v]) > limit(v, STICKS_OUT))
        .collect();
    let surface = surface_around(mesh, rings, levels, choice, &suspects)?;
    let off = |v: usize| {
        let foot = surface.project(VertexId::from(v), mesh.points[v]);
        foot.map_or(0.0, |foot| (mesh.points[v] - foot.point).dot(&foot.normal).abs())
    };
    let is_outlier = |&v: &usize| {
        let far = off(v);
        if far <= limit(v, DEVIATIONS) {
            return false;
        }
        let around = rings.neighbours(mesh, VertexId::from(v)).map(|w| w.index());
        let (sum, count) = around
            .filter(|&w| !left_out[w])
            .fold((0.0, 0), |(sum, count), w| (sum + off(w), count + 1));
        far * f64::from(count) > ALONE * sum
    };
    let found: Vec<usize> = suspects.into_par_iter().filter(is_outlier).collect();
    found.iter().for_each(|&v| left_out[v] = true);
    Ok(!found.is_empty())
}

/// The distance of a vertex from the mean of its neighbours, along its normal.
fn sticks_out(mesh: &Mesh, rings: &VertexRings, v: usize, normal: Vector) -> f64 {
    let p = mesh.points[v];
    let off = rings.neighbours(mesh, VertexId::from(v)).map(|w| (mesh.point(w) - p).dot(&normal));
    let (sum, count) = off.fold((0.0, 0), |(sum, count), d| (sum + d, count + 1));
    sum.abs() / f64::from(count.max(1))
}

/// The surface with the median support, near the suspects and their neighbours.
fn surface_around(
    mesh: &Mesh,
    rings: &VertexRings,
    levels: &[SupportLevel],
    choice: &SupportField,
    suspects: &[usize],
) -> Result<MlsSurface> {
    let place = median(choice.place.iter().map(|&p| f64::from(p).round()).collect()) as f32;
    let place = place.max(STABLE_LEVEL.min(levels.len() - 1) as f32);
    let mut places = vec![NOWHERE; mesh.points.len()];
    for &v in suspects {
        places[v] = place;
        rings.neighbours(mesh, VertexId::from(v)).for_each(|w| places[w.index()] = place);
    }
    MlsSurface::new(levels[0].clusters.clone(), levels.to_vec(), places, &mut progress::ignore)
}
