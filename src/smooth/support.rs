//! The support h, and the noise, from the scan itself.
//!
//! Small h leaves noise, large h flattens. At a sample of places the surface is
//! estimated with every support. A wider one is biased by as much as it differs
//! from narrower ones beyond what their noise explains (Goldenshluger and
//! Lepski, "Bandwidth selection in kernel density estimation", Annals of
//! Statistics 2011); bias and noise together, averaged over places side by side,
//! are least at the support that is taken. It changes over the scan as slowly as
//! the samples stand apart.

use rayon::prelude::*;

use super::clusters::{Gathering, Rooms};
use super::levels::Level;
use super::root_mean_square;
use super::telling::{self, Pair};
use crate::geometry::VertexId;
use crate::mesh::Mesh;

/// Places that are looked at: one for so many vertices,
const VERTICES: usize = 200;

/// and no fewer, nor many more, than this: how often noise and curvature change does
/// not depend on how densely they are scanned.
const PLACES: [usize; 2] = [2_000, 10_000];

/// The residuals at the second level give the noise, since it has a good number
/// of points. Where they are this many times those at the first one, it is the
/// shape that they show, and the first one has to do.
const SHAPE: f64 = 2.0;

/// What noise explains is overrated by this much, since it fluctuates.
const CAUTION: f64 = 1.3;

/// A wider support that differs from the one before it by more than this many
/// standard deviations need not be followed by still wider ones.
const CLEAR: f64 = 8.0;

/// What was found.
pub struct Choice {
    /// For each vertex the level to take; between two, both.
    pub place: Vec<f32>,
    /// For each vertex the standard deviation of the residuals around, in mm: of the
    /// noise, or of what polynomials miss of the shape.
    pub residual: Vec<f32>,
    /// For each vertex 1 where the residuals around are noise, 0 where they are not told
    /// from shape, and between where these places meet.
    pub told: Vec<f32>,
}

impl Choice {
    /// The standard deviation of the noise over the whole scan, in mm.
    pub fn noise(&self) -> f64 {
        root_mean_square((0..self.told.len()).map(|v| self.noise_at(v)))
    }

    /// The standard deviation of the noise around a vertex, in mm.
    pub fn noise_at(&self, v: usize) -> f64 {
        f64::from(self.told[v]) * f64::from(self.residual[v])
    }
}

/// The estimates at one place, with each support as far as they were tried: the
/// surface's height, and its variance where the points' is 1.
struct Trial {
    heights: Vec<(f64, f64)>,
    /// Mean squares of the residuals at the two levels that show the noise.
    scatter: [f64; 2],
    /// Residuals at the first level, of the place and of vertices beside it.
    pairs: Vec<Pair>,
}

/// Parts of the places that are looked at before it is told how far that has come.
const PARTS: usize = 4;

/// Chooses the support for every vertex. `progress` is told how far that has come.
pub fn choose<E>(
    mesh: &Mesh,
    levels: &[Level],
    progress: &mut dyn FnMut(f64) -> Result<(), E>,
) -> Result<Choice, E> {
    let sampling = sampling(mesh.points.len(), levels);
    let places = first_vertices(sampling);
    let rooms = Rooms::default();
    let look = |&v: &u32| rooms.with(|room| trial(mesh, levels, VertexId(v), room));
    let mut trials: Vec<Trial> = Vec::with_capacity(places.len());
    for part in places.chunks(places.len().div_ceil(PARTS).max(1)) {
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
    let pairs: Vec<&[Pair]> = trials.iter().map(|trial| trial.pairs.as_slice()).collect();
    let told = telling::told(&pairs, |i| wider(&windows, i));
    Ok(Choice { place: spread(&best), residual: spread(&deviation), told: spread(&told) })
}

/// The level whose clusters are about as many as places are wanted.
fn sampling(vertices: usize, levels: &[Level]) -> &Level {
    let wanted = (vertices / VERTICES).clamp(PLACES[0], PLACES[1]);
    let enough = levels.iter().rev().find(|level| level.grain.samples.len() >= wanted);
    enough.unwrap_or(&levels[0])
}

/// The first vertex of each cluster.
fn first_vertices(level: &Level) -> Vec<u32> {
    let mut first = vec![u32::MAX; level.grain.samples.len()];
    for (v, &c) in level.cluster.iter().enumerate() {
        first[c as usize] = first[c as usize].min(v as u32);
    }
    first
}

/// The places beside the `i`-th, and beside these.
fn window(level: &Level, i: usize) -> Vec<u32> {
    let mut window: Vec<u32> = level.grain.near(i).to_vec();
    window.extend(level.grain.near(i).iter().flat_map(|&j| level.grain.near(j as usize)));
    window.push(i as u32);
    window.sort_unstable();
    window.dedup();
    window
}

/// The places of all windows around those of the `i`-th one.
fn wider(windows: &[Vec<u32>], i: usize) -> Vec<u32> {
    let mut wide: Vec<u32> =
        windows[i].iter().flat_map(|&j| windows[j as usize].iter().copied()).collect();
    wide.sort_unstable();
    wide.dedup();
    wide
}

fn trial(mesh: &Mesh, levels: &[Level], v: VertexId, room: &mut Gathering) -> Trial {
    let (p, normal) = (mesh.point(v), levels[0].grain.normals[v.index()]);
    let pairs = telling::pairs(mesh, &levels[0], v, room);
    let mut trial = Trial { heights: Vec::new(), scatter: [f64::NAN; 2], pairs };
    for (k, level) in levels.iter().enumerate() {
        let cluster = level.cluster[v.index()] as usize;
        let fitted = match trial.scatter.get_mut(k) {
            Some(place) => level.fit_with_scatter(cluster, room).map(|(fit, scatter)| {
                *place = scatter.variance;
                fit
            }),
            None => level.fit(cluster, room),
        };
        let Some(fit) = fitted else {
            // Too few points; wider ones may have enough.
            trial.heights.push((0.0, f64::INFINITY));
            continue;
        };
        let height = (fit.at(p).0 - p).dot(&normal);
        let last = trial.heights.last().copied();
        trial.heights.push((height, fit.variance));
        let explained = |variance: f64| CLEAR * (trial.scatter[1] * variance).sqrt();
        if k > 1 && last.is_some_and(|(h, v)| (height - h).abs() > explained(v)) {
            break;
        }
    }
    trial
}

/// The variance of the noise over a window.
fn noise(trials: &[Trial], window: &[u32]) -> f64 {
    let median = |k: usize| {
        let all = window.iter().map(|&i| trials[i as usize].scatter[k]);
        let all: Vec<f64> = all.filter(|scatter| scatter.is_finite()).collect();
        (!all.is_empty()).then(|| super::median(all))
    };
    match [median(0), median(1)] {
        [Some(first), Some(second)] if second > SHAPE * first => first,
        [first, second] => second.or(first).unwrap_or(0.0),
    }
}

/// The level of least risk over a window, refined between levels.
fn best(trials: &[Trial], window: &[u32], variance: f64) -> f64 {
    let deepest = window.iter().map(|&i| trials[i as usize].heights.len()).min().unwrap_or(0);
    let mean = |f: &dyn Fn(&Trial) -> f64| {
        window.iter().map(|&i| f(&trials[i as usize])).sum::<f64>() / window.len() as f64
    };
    let noise: Vec<f64> = (0..deepest).map(|k| variance * mean(&|t| t.heights[k].1)).collect();
    let bias = |k: usize| {
        let beyond = |i: usize| {
            let square = mean(&|t| (t.heights[k].0 - t.heights[i].0).powi(2));
            square - CAUTION * (noise[i] - noise[k]).max(0.0)
        };
        (0..k).filter(|&i| noise[i].is_finite()).map(beyond).fold(0.0, f64::max)
    };
    let risks: Vec<f64> = (0..deepest).map(|k| noise[k] + bias(k)).collect();
    let finite = (0..deepest).filter(|&k| risks[k].is_finite());
    let least = finite.min_by(|&i, &j| risks[i].total_cmp(&risks[j])).unwrap_or(0);
    least as f64 + vertex_of_parabola(&risks, least)
}

/// Where, between −½ and ½, the parabola through the logarithms of three risks
/// around the least is lowest.
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

/// A value of the places, between them by nearness.
fn blended(sampling: &Level, values: &[f64], v: VertexId, mesh: &Mesh) -> f64 {
    let own = sampling.cluster[v.index()] as usize;
    let p = mesh.point(v);
    let (mut weight, mut sum) = (1e-12, 1e-12 * values[own]);
    let beside = sampling.grain.near(own).iter().map(|&c| c as usize);
    for c in std::iter::once(own).chain(beside) {
        let w = sampling.weight(c, p);
        weight += w;
        sum += w * values[c];
    }
    sum / weight
}
