//! Points that no surface explains: each far off the one that its neighbours
//! lie on, while these are not.

use super::levels::Level;
use super::median;
use super::support::Choice;
use super::surface::Surface;
use crate::geometry::VertexId;
use crate::mesh::{Mesh, Rings};

/// So many standard deviations of the noise around: in a normal distribution not
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

/// Marks the outliers in `left_out`, by their distances from the surface of the
/// scan's median support: where it is narrow it may be so for an outlier's sake.
/// Says whether there are more than before.
pub fn add(
    mesh: &Mesh,
    rings: &Rings,
    levels: &[Level],
    choice: &Choice,
    left_out: &mut [bool],
) -> bool {
    let place = median(choice.place.iter().map(|&p| f64::from(p).round()).collect()) as f32;
    let place = place.max(STEADY.min(levels.len() - 1) as f32);
    let least = LEAST * mesh.mean_edge();
    let places = vec![place; mesh.points.len()];
    let surface = Surface::new(levels[0].grain.clone(), levels.to_vec(), places);
    let (feet, normals) = surface.feet(mesh);
    let off = |v: usize| (mesh.points[v] - feet[v]).dot(&normals[v]).abs();
    let is_outlier = |v: usize| {
        let far = off(v);
        if far <= least.max(DEVIATIONS * f64::from(choice.noise[v])) {
            return false;
        }
        let around = rings.neighbours(mesh, VertexId::from(v)).map(|w| w.index());
        let (sum, count) = around
            .filter(|&w| !left_out[w])
            .fold((0.0, 0), |(sum, count), w| (sum + off(w), count + 1));
        far * f64::from(count) > ALONE * sum
    };
    let found: Vec<usize> =
        (0..mesh.points.len()).filter(|&v| !left_out[v] && is_outlier(v)).collect();
    found.iter().for_each(|&v| left_out[v] = true);
    !found.is_empty()
}
