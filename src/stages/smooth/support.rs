//! The support h, estimated from the scan.
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
use crate::error::Result;
use crate::geometry::{FEW, NONE, ROUNDING, VertexId};
use crate::mesh::Mesh;
use crate::noise::NoiseField;
use crate::progress::Progress;
use crate::statistics::outlying;

/// The number of sampled places at least. How often noise and curvature change does not depend on the density of the
/// scan.
const PLACE_COUNT: usize = 2_000;

/// The factor by which the differences that noise explains are enlarged, because they fluctuate.
const NOISE_MARGIN: f64 = 1.3;

/// The estimates at one place, one for each support that was tried: the height of the surface, and
/// its variance.
type SupportTrial = Vec<(f64, f64)>;

/// Chooses the level of every vertex, and reports progress to `progress`. A fraction means a blend
/// of two adjacent levels.
pub(crate) fn choose(
    mesh: &Mesh,
    levels: &[SupportLevel],
    noise: &NoiseField,
    progress: &mut Progress,
) -> Result<Vec<f32>> {
    let sampling = sampling(levels);
    let places = first_vertices(sampling);
    let scratch_pool = ScratchPool::default();
    let clear = outlying(places.len());
    let look = |&v: &u32| {
        scratch_pool.with(|scratch| trial(mesh, levels, (VertexId(v), noise, clear), scratch))
    };
    let mut trials: Vec<SupportTrial> = Vec::with_capacity(places.len());
    for part in places.chunks(places.len().div_ceil(FEW).max(1)) {
        trials.par_extend(part.par_iter().map(look));
        progress(trials.len() as f64 / places.len() as f64)?;
    }
    let windows: Vec<Vec<u32>> = (0..places.len()).map(|i| window(sampling, i)).collect();
    let best: Vec<f64> = windows.iter().map(|w| best(&trials, w)).collect();
    let mean = |w: &Vec<u32>| w.iter().map(|&i| best[i as usize]).sum::<f64>() / w.len() as f64;
    let best: Vec<f64> = windows.iter().map(mean).collect();
    let at = |v: usize| blended(sampling, &best, VertexId::from(v), mesh) as f32;
    Ok((0..mesh.points.len()).into_par_iter().map(at).collect())
}

/// The level that has about as many clusters as places are wanted.
fn sampling(levels: &[SupportLevel]) -> &SupportLevel {
    let enough = levels.iter().rev().find(|level| level.clusters.samples.len() >= PLACE_COUNT);
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

/// The estimates at a vertex. Wider supports are not tried after one that differs from the one
/// before it by more than `clear` standard deviations.
fn trial(
    mesh: &Mesh,
    levels: &[SupportLevel],
    (v, noise, clear): (VertexId, &NoiseField, f64),
    scratch: &mut Neighbourhood,
) -> SupportTrial {
    let (p, normal) = (mesh.point(v), levels[0].clusters.normals[v.index()]);
    let mut trial: SupportTrial = Vec::new();
    for level in levels {
        let Some(fit) = level.fit(level.cluster[v.index()] as usize, scratch) else {
            // There are too few points; wider supports may have enough.
            trial.push((0.0, f64::INFINITY));
            continue;
        };
        let height = (fit.at(p).0 - p).dot(&normal);
        let last = trial.last().copied();
        let points = scratch.around.iter().map(|sample| sample.at);
        trial.push((height, noise.variance_of_fit(v, fit.variance, points)));
        if last.is_some_and(|(h, variance)| (height - h).abs() > clear * variance.sqrt()) {
            break;
        }
    }
    trial
}

/// The level with the smallest risk over a window, refined between levels.
fn best(trials: &[SupportTrial], window: &[u32]) -> f64 {
    let deepest = window.iter().map(|&i| trials[i as usize].len()).min().unwrap_or(0);
    let mean = |f: &dyn Fn(&SupportTrial) -> f64| {
        window.iter().map(|&i| f(&trials[i as usize])).sum::<f64>() / window.len() as f64
    };
    let noise: Vec<f64> = (0..deepest).map(|k| mean(&|t| t[k].1)).collect();
    let bias = |k: usize| {
        let beyond = |i: usize| {
            let square = mean(&|t| (t[k].0 - t[i].0).powi(2));
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
    if curvature > ROUNDING && curvature.is_finite() {
        (0.5 * (a - c) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

/// The value at a vertex, blended from the values at the places around it.
fn blended(sampling: &SupportLevel, values: &[f64], v: VertexId, mesh: &Mesh) -> f64 {
    let own = sampling.cluster[v.index()] as usize;
    let p = mesh.point(v);
    let (mut weight, mut sum) = (ROUNDING, ROUNDING * values[own]);
    let beside = sampling.clusters.near(own).iter().map(|&c| c as usize);
    for c in std::iter::once(own).chain(beside) {
        let w = sampling.weight(c, p);
        weight += w;
        sum += w * values[c];
    }
    sum / weight
}
