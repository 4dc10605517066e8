//! Outliers: points that are far from the surface through their neighbours while these are not.

use rayon::prelude::*;

use super::NoiseField;
use super::patch::{Heights, Scratch};
use crate::geometry::{ALONE, Vector, VertexId};
use crate::mesh::{Mesh, VertexRings};
use crate::statistics::{SIGNIFICANT, absolute_at, median, outlying};

impl NoiseField {
    /// Which vertices are outliers. None is if the scan has no visible noise, because nothing then
    /// tells them from shape.
    pub(crate) fn outliers(&self, mesh: &Mesh, rings: &VertexRings) -> Vec<bool> {
        let mut outliers = vec![false; mesh.points.len()];
        if !self.is_visible {
            return outliers;
        }
        let normals = mesh.vertex_normals();
        let limit = outlying(mesh.points.len());
        let is_suspect = |&v: &usize| {
            sticks_out(mesh, rings, v, normals[v]) > SIGNIFICANT * self.at(VertexId::from(v))
        };
        let suspects: Vec<usize> =
            (0..mesh.points.len()).into_par_iter().filter(is_suspect).collect();
        let is_outlier = |scratch: &mut Scratch, v: usize| {
            let v = VertexId::from(v);
            let heights = Heights::without_middle(mesh, rings, &normals, v, scratch)?;
            is_outlier(&heights, self.at(v), limit).then_some(v)
        };
        let found: Vec<VertexId> =
            suspects.into_par_iter().map_init(Scratch::default, is_outlier).flatten().collect();
        found.iter().for_each(|v| outliers[v.index()] = true);
        outliers
    }
}

/// The distance of a vertex from the mean of its neighbours, along its normal.
fn sticks_out(mesh: &Mesh, rings: &VertexRings, v: usize, normal: Vector) -> f64 {
    let p = mesh.points[v];
    let off = rings.neighbours(mesh, VertexId::from(v)).map(|w| (mesh.point(w) - p).dot(&normal));
    let (sum, count) = off.fold((0.0, 0), |(sum, count), d| (sum + d, count + 1));
    sum.abs() / f64::from(count.max(1))
}

/// Whether the middle vertex of a patch is farther from the surface through the others than
/// `limit` standard deviations, while its neighbours are not far. Where these scatter more than the
/// noise they show shape, and count for the standard deviation.
fn is_outlier(heights: &Heights, noise: f64, limit: f64) -> bool {
    let mut others: Vec<f64> = heights.others.iter().map(|e| e.abs()).collect();
    let beside = others[..heights.neighbours].iter().sum::<f64>() / heights.neighbours as f64;
    let Some(middle) = median(&mut others) else { return false };
    let deviation = noise.max(middle / absolute_at(0.5)) * heights.variance.sqrt();
    let far = heights.middle.abs();
    far > limit * deviation && far > ALONE * beside
}
