//! The support h, and the noise, from the scan itself.
//!
//! Small h leaves noise, large h flattens. Leave-one-out cross-validation
//! weighs the two: a point's distance from the surface that its neighbours
//! alone define is, for a projection that is linear in the heights with
//! leverage a, (distance moved) / (1 − a). The h that predicts left-out points
//! best over a sample of the scan wins. With residuals r, leverages a and
//! variance factors s the noise is σ² = mean r² / mean(1 − 2 a + s).

use rayon::prelude::*;

use super::Support;
use crate::mesh::Mesh;
use crate::mesh::mls::{Cloud, Scratch};

/// Points that take part in the cross-validation, at the most.
const SAMPLE: usize = 3000;

/// The supports tried, in mean edge lengths.
const TRIED: [f64; 9] = [1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.3, 8.0];

/// Share of the largest residuals that are set aside as outliers.
const OUTLIERS: f64 = 0.01;

/// A support and the noise that the scan shows under it, in mm.
pub struct Choice {
    pub h: f64,
    pub noise: f64,
}

struct Trial {
    h: f64,
    left_out: f64,
    noise: f64,
}

/// The support asked for, or the one found, with the scan's noise.
pub fn choose(mesh: &Mesh, cloud: &Cloud, asked: Support) -> Choice {
    let spacing = mesh.mean_edge();
    let best = TRIED
        .iter()
        .filter_map(|k| trial(mesh, cloud, k * spacing))
        .min_by(|x, y| x.left_out.total_cmp(&y.left_out));
    let noise = best.as_ref().map_or(0.0, |b| b.noise);
    let h = match asked {
        Support::Fixed(h) => h,
        Support::Auto => best.map_or(TRIED[0] * spacing, |b| b.h),
        Support::Off => 0.0,
    };
    Choice { h, noise }
}

fn trial(mesh: &Mesh, cloud: &Cloud, h: f64) -> Option<Trial> {
    let stride = mesh.points.len().div_ceil(SAMPLE).max(1);
    let sample: Vec<usize> = (0..mesh.points.len()).step_by(stride).collect();
    let residual = |scratch: &mut Scratch, &i: &usize| {
        let p = mesh.points[i];
        let foot = cloud.project(p, cloud.normal(i), h, scratch)?;
        let freedom = 1.0 - 2.0 * foot.leverage + foot.variance;
        let left_out = (p - foot.point).norm() / (1.0 - foot.leverage).max(1e-3);
        (foot.leverage < 0.95).then_some((left_out, (p - foot.point).norm(), freedom))
    };
    let mut found: Vec<(f64, f64, f64)> =
        sample.par_iter().map_init(Scratch::default, residual).flatten().collect();
    if found.len() * 2 < sample.len() {
        return None;
    }
    found.sort_by(|x, y| x.0.total_cmp(&y.0));
    found.truncate((found.len() as f64 * (1.0 - OUTLIERS)).ceil() as usize);
    let n = found.len() as f64;
    let left_out = found.iter().map(|f| f.0 * f.0).sum::<f64>() / n;
    let squares: f64 = found.iter().map(|f| f.1 * f.1).sum();
    let freedom: f64 = found.iter().map(|f| f.2).sum();
    Some(Trial { h, left_out, noise: (squares / freedom.max(1e-9)).sqrt() })
}
