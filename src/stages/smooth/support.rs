//! The support h and the noise, estimated from the scan.
//!
//! A small h leaves noise; a large h flattens the shape. At a sample of places the surface is
//! estimated with every support. A wide support is biased by the amount by which it differs from
//! narrower ones beyond what their noise explains (Goldenshluger and Lepski, "Bandwidth selection
//! in kernel density estimation", Annals of Statistics 2011). The support with the smallest sum of
//! squared bias and variance, averaged over neighbouring places, is chosen. It varies over the scan
//! no faster than the distance between the places allows.

use rayon::prelude::*;

use super::clusters::{Neighbourhood, ScratchPool};
use super::levels::SupportLevel;
use super::noise_detection::{self, ResidualPair};
use super::root_mean_square;
use crate::geometry::{FEW, NONE, VertexId};
use crate::mesh::Mesh;

/// The number of vertices for each sampled place.
const VERTICES_PER_PLACE: usize = 200;

/// The smallest and the largest number of sampled places. How often noise and curvature change does
/// not depend on the density of the scan.
const PLACE_COUNT: [usize; 2] = [2_000, 10_000];

/// The residuals at the second level give the noise, because its fits have enough points. If their
/// variance exceeds that at the first level by this factor, they show the shape, and the first
/// level gives the noise.
const SHAPE_RATIO: f64 = 2.0;

/// The factor by which the differences that noise explains are enlarged, because they fluctuate.
const NOISE_MARGIN: f64 = 1.3;

/// Wider supports are not tried after one that differs from the one before it by more than this
/// number of standard deviations.
const CLEAR_DEVIATIONS: f64 = 8.0;

/// The supports and the noise of a scan.
pub struct SupportField {
    /// The level of each vertex. A fraction means a blend of two adjacent levels.
    pub place: Vec<f32>,
    /// The standard deviation in mm of the residuals around each vertex. They are noise, or shape
    /// that the polynomials miss.
    pub residual: Vec<f32>,
    /// The share of noise at each vertex: 1 where the residuals are noise, 0 where they cannot be
    /// distinguished from shape, and values between where such regions meet.
    pub noise_share: Vec<f32>,
}

impl SupportField {
    /// The standard deviation of the noise over the whole scan, in mm.
    pub fn noise(&self) -> f64 {
        root_mean_square((0..self.noise_share.len()).map(|v| self.noise_at(v)))
    }

    /// The standard deviation of the noise around a vertex, in mm.
    pub fn noise_at(&self, v: usize) -> f64 {
        f64::from(self.noise_share[v]) * f64::from(self.residual[v])
    }
}

/// The estimates at one place, one for each support that was tried: the height of the surface, and
/// its variance if the points have variance 1.
struct SupportTrial {
    heights: Vec<(f64, f64)>,
    /// The mean squared residuals at the two levels that show the noise.
    scatter: [f64; 2],
    /// The residuals at the first level of the place and of neighbouring vertices.
    pairs: Vec<ResidualPair>,
}

/// Chooses the support of every vertex, and reports progress to `progress`.
pub fn choose<E>(
    mesh: &Mesh,
    levels: &[SupportLevel],
    progress: &mut dyn FnMut(f64) -> Result<(), E>,
) -> Result<SupportField, E> {
    let sampling = sampling(mesh.points.len(), levels);
    let places = first_vertices(sampling);
    let scratch_pool = ScratchPool::default();
    let look = |&v: &u32| scratch_pool.with(|scratch| trial(mesh, levels, VertexId(v), scratch));
    let mut trials: Vec<SupportTrial> = Vec::with_capacity(places.len());
    for part in places.chunks(places.len().div_ceil(FEW).max(1)) {
        trials.par_extend(part.par_iter().map(look));
        progress(trials.len() as f64 / places.len() as f64)?;
    }
    let windows: Vec<Vec<u32>> = (0..places.len()).map(|i| window(sampling, i)).collect();
    let noise: Vec<f64> = windows.iter().map(|w| noise(&trials, w)).collect();
    let best = windows.iter().zip(&noise).map(|(w, &variance)| best(&trials, w, variance));
    let best: Vec<f64> = best.collect();
    let mean = |values: &[f64], w: &[u32]| {
        w.iter().map(|&i| values[i as usize]).sum::<f64>() / w.len() as f64
    };
    let best: Vec<f64> = windows.iter().map(|w| mean(&best, w)).collect();
    let spread = |values: &[f64]| -> Vec<f32> {
        (0..mesh.points.len())
            .into_par_iter()
            .map(|v| blended(sampling, values, VertexId::from(v), mesh) as f32)
            .collect()
    };
    let deviation: Vec<f64> = noise.iter().map(|variance| variance.sqrt()).collect();
    let pairs: Vec<&[ResidualPair]> = trials.iter().map(|trial| trial.pairs.as_slice()).collect();
    let noise_share = noise_detection::noise_share(&pairs, |i| wider(&windows, i));
    Ok(SupportField {
        place: spread(&best),
        residual: spread(&deviation),
        noise_share: spread(&noise_share),
    })
}

/// The level that has about as many clusters as places are wanted.
fn sampling(vertices: usize, levels: &[SupportLevel]) -> &SupportLevel {
    let wanted = (vertices / VERTICES_PER_PLACE).clamp(PLACE_COUNT[0], PLACE_COUNT[1]);
    let enough = levels.iter().rev().find(|level| level.clusters.samples.len() >= wanted);
    enough.unwrap_or(&levels[0])
}

/// The first vertex of each cluster.
fn first_vertices(level: &SupportLevel) -> Vec<u32> {
    let mut first = vec![NONE; level.clusters.samples.len()];
    for (v, &c) in level.cluster.iter().enumerate() {
        first[c as usize] = first[c as usize].min(v as u32);
    }
    first
}

/// The neighbours of place `i`, their neighbours, and the place itself.
fn window(level: &SupportLevel, i: usize) -> Vec<u32> {
    let mut window: Vec<u32> = level.clusters.near(i).to_vec();
    window.extend(level.clusters.near(i).iter().flat_map(|&j| level.clusters.near(j as usize)));
    window.push(i as u32);
    window.sort_unstable();
    window.dedup();
    window
}

/// The places of the windows of all places in the window of place `i`.
fn wider(windows: &[Vec<u32>], i: usize) -> Vec<u32> {
    let mut wide: Vec<u32> =
        windows[i].iter().flat_map(|&j| windows[j as usize].iter().copied()).collect();
    wide.sort_unstable();
    wide.dedup();
    wide
}

fn trial(
    mesh: &Mesh,
    levels: &[SupportLevel],
    v: VertexId,
    scratch: &mut Neighbourhood,
) -> SupportTrial {
    let (p, normal) = (mesh.point(v), levels[0].clusters.normals[v.index()]);
    let pairs = noise_detection::pairs(mesh, &levels[0], v, scratch);
    let mut trial = SupportTrial { heights: Vec::new(), scatter: [f64::NAN; 2], pairs };
    for (k, level) in levels.iter().enumerate() {
        let cluster = level.cluster[v.index()] as usize;
        let fitted = match trial.scatter.get_mut(k) {
            Some(place) => level.fit_with_scatter(cluster, scratch).map(|(fit, scatter)| {
                *place = scatter.variance;
                fit
            }),
            None => level.fit(cluster, scratch),
        };
        let Some(fit) = fitted else {
            // There are too few points; wider supports may have enough.
            trial.heights.push((0.0, f64::INFINITY));
            continue;
        };
        let height = (fit.at(p).0 - p).dot(&normal);
        let last = trial.heights.last().copied();
        trial.heights.push((height, fit.variance));
        let explained = |variance: f64| CLEAR_DEVIATIONS * (trial.scatter[1] * variance).sqrt();
        if k > 1 && last.is_some_and(|(h, v)| (height - h).abs() > explained(v)) {
            break;
        }
    }
    trial
}

/// The variance of the noise over a window.
fn noise(trials: &[SupportTrial], window: &[u32]) -> f64 {
    let median = |k: usize| {
        let all = window.iter().map(|&i| trials[i as usize].scatter[k]);
        let all: Vec<f64> = all.filter(|scatter| scatter.is_finite()).collect();
        (!all.is_empty()).then(|| super::median(all))
    };
    match [median(0), median(1)] {
        [Some(first), Some(second)] if second > SHAPE_RATIO * first => first,
        [first, second] => second.or(first).unwrap_or(0.0),
    }
}

/// The level with the smallest risk over a window, refined between levels.
fn best(trials: &[SupportTrial], window: &[u32], variance: f64) -> f64 {
    let deepest = window.iter().map(|&i| trials[i as usize].heights.len()).min().unwrap_or(0);
    let mean = |f: &dyn Fn(&SupportTrial) -> f64| {
        window.iter().map(|&i| f(&trials[i as usize])).sum::<f64>() / window.len() as f64
    };
    let noise: Vec<f64> = (0..deepest).map(|k| variance * mean(&|t| t.heights[k].1)).collect();
    let bias = |k: usize| {
        let beyond = |i: usize| {
            let square = mean(&|t| (t.heights[k].0 - t.heights[i].0).powi(2));
            square - NOISE_MARGIN * (noise[i] - noise[k]).max(0.0)
        };
        (0..k).filter(|&i| noise[i].is_finite()).map(beyond).fold(0.0, f64::max)
    };
    let risks: Vec<f64> = (0..deepest).map(|k| noise[k] + bias(k)).collect();
    let finite = (0..deepest).filter(|&k| risks[k].is_finite());
    let least = finite.min_by(|&i, &j| risks[i].total_cmp(&risks[j])).unwrap_or(0);
    least as f64 + vertex_of_parabola(&risks, least)
}

/// The minimum, between −½ and ½, of the parabola through the logarithms of three risks around the
/// smallest one.
fn vertex_of_parabola(risks: &[f64], least: usize) -> f64 {
    let Some(before) = least.checked_sub(1).and_then(|k| risks.get(k)) else { return 0.0 };
    let Some(after) = risks.get(least + 1) else { return 0.0 };
    let [a, b, c] = [before, &risks[least], after].map(|r| r.max(f64::MIN_POSITIVE).ln());
    let curvature = a - 2.0 * b + c;
    if curvature > 1e-9 && curvature.is_finite() {
        (0.5 * (a - c) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// The value at a vertex, blended from the values at the places around it.
fn blended(sampling: &SupportLevel, values: &[f64], v: VertexId, mesh: &Mesh) -> f64 {
    let own = sampling.cluster[v.index()] as usize;
    let p = mesh.point(v);
    let (mut weight, mut sum) = (1e-12, 1e-12 * values[own]);
    let beside = sampling.clusters.near(own).iter().map(|&c| c as usize);
    for c in std::iter::once(own).chain(beside) {
        let w = sampling.weight(c, p);
        weight += w;
        sum += w * values[c];
    }
    sum / weight
}
