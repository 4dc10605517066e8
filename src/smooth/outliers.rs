//! Points that no surface explains: each far off the one that its neighbours
//! lie on, while these are not.

use rayon::prelude::*;

use super::levels::Level;
use super::median;
use super::support::Choice;
use super::surface::{NOWHERE, Surface};
use crate::error::Result;
use crate::geometry::{Vector, VertexId};
use crate::mesh::{Mesh, Rings};
use crate::progress;

/// So many standard deviations of the residuals around: in a normal distribution not
/// one point of a hundred million is as far off.
const DEVIATIONS: f64 = 6.0;

/// So many times as far off as the neighbours are: along a sharp edge, where the
/// fit has to fail, all are far off.
const ALONE: f64 = 4.0;

/// Nothing nearer to the surface than this share of the mean edge is an outlier:
/// a fit may miss a clean scan by more than its noise.
const LEAST: f64 = 0.1;

/// The lowest level that is steady enough to show an outlier.
const STEADY: usize = 2;

/// Points that stick out of their neighbours' mean by less than so many standard
/// deviations need no closer look.
const STICKS_OUT: f64 = 4.0;

/// Marks the outliers in `left_out`, by their distances from the surface of the
/// scan's median support: where it is narrow it may be so for an outlier's sake.
/// Says whether there are more than before.
pub fn add(
    mesh: &Mesh,
    rings: &Rings,
    levels: &[Level],
    choice: &Choice,
    left_out: &mut [bool],
) -> Result<bool> {
    let least = LEAST * mesh.mean_edge();
    let limit = |v: usize, deviations: f64| least.max(deviations * f64::from(choice.residual[v]));
    let normals = &levels[0].grain.normals;
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

/// How far a vertex is off its neighbours' mean, along its normal.
fn sticks_out(mesh: &Mesh, rings: &Rings, v: usize, normal: Vector) -> f64 {
    let p = mesh.points[v];
    let off = rings.neighbours(mesh, VertexId::from(v)).map(|w| (mesh.point(w) - p).dot(&normal));
    let (sum, count) = off.fold((0.0, 0), |(sum, count), d| (sum + d, count + 1));
    sum.abs() / f64::from(count.max(1))
}

/// The surface of the median support, near the suspects and their neighbours.
fn surface_around(
    mesh: &Mesh,
    rings: &Rings,
    levels: &[Level],
    choice: &Choice,
    suspects: &[usize],
) -> Result<Surface> {
    let place = median(choice.place.iter().map(|&p| f64::from(p).round()).collect()) as f32;
    let place = place.max(STEADY.min(levels.len() - 1) as f32);
    let mut places = vec![NOWHERE; mesh.points.len()];
    for &v in suspects {
        places[v] = place;
        rings.neighbours(mesh, VertexId::from(v)).for_each(|w| places[w.index()] = place);
    }
    Surface::new(levels[0].grain.clone(), levels.to_vec(), places, &mut progress::ignore)
}
