//! The noise of a scan. A mesh goes in; the standard deviation of its vertices along the normal
//! comes out, for the whole scan and at each vertex, with the correlation between neighbours and the
//! outliers.
//!
//! The residuals of quadrics through small patches are noise, mixed by the fits ([`patch`]). Unmixing
//! gives the variance and the correlations without bias ([`estimate`]). Patches that hold an edge or
//! an outlier have larger residuals than noise explains, and do not count. Where the noise of a part
//! differs from that of the whole, the part's own holds ([`local`]). A mesh that a modelling program
//! made has no noise but the rounding of its file ([`rounding`]).

mod estimate;
mod local;
mod outliers;
mod patch;
mod rounding;
mod terraces;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, VertexRings};
use crate::statistics::{MeanSquare, outlying};
use estimate::Estimate;
use local::LocalNoise;
use patch::{NoisePatch, Scratch};
use rounding::{Flatness, Rounding, flatness};
pub(crate) use terraces::Terraces;

/// The most patches that are fitted. The standard deviation of the estimate is then below 1 %.
const MOST_PATCHES: usize = 4000;

/// The noise of a scan.
#[derive(Debug)]
pub(crate) struct NoiseField {
    /// The standard deviation along the normal over the whole scan, in the unit of the mesh. It is
    /// that of the rounding if no other noise is visible.
    pub deviation: f64,
    /// Whether there is noise beyond the rounding.
    pub is_visible: bool,
    /// The correlations of the noise of vertices that are one edge and two edges apart.
    pub correlation: [f64; 2],
    /// The steps of heights that are given in steps.
    pub terraces: Option<Terraces>,
    /// The standard deviation at each vertex; empty if it is the same everywhere.
    at: Vec<f32>,
}

impl NoiseField {
    /// Measures the noise of a mesh.
    pub(crate) fn new(mesh: &Mesh, rings: &VertexRings) -> Self {
        let rounding = Rounding::of(&mesh.points);
        let rounded = rounding.deviation(&mesh.points);
        let none = |deviation| NoiseField {
            deviation,
            is_visible: false,
            correlation: [0.0; 2],
            terraces: None,
            at: Vec::new(),
        };
        if let Some(terraces) = Terraces::likely(mesh) {
            let patches = patches(mesh, rings);
            if terraces.is_rough(&patches) {
                return Self::of_terraces(terraces, &patches, &mesh.points);
            }
        }
        let flatness = flatness(mesh, rings, rounding);
        if flatness == Flatness::Clean && rounding.is_sure() {
            return none(rounded);
        }
        let patches = patches(mesh, rings);
        let Some(estimate) = Estimate::new(&patches, mesh.points.len()) else {
            return none(rounded);
        };
        let deviation = estimate.deviation();
        // Residuals are noise if noise makes up the larger part of their mean square.
        let is_noise = estimate.remaining >= 0.5 && deviation > rounded;
        if flatness == Flatness::Clean || !is_noise {
            return none(deviation.min(rounded));
        }
        let local = LocalNoise::new(mesh, &patches, &estimate);
        let at = local.map_or(Vec::new(), |local| {
            let at = |p| (deviation * local.factor(p)) as f32;
            mesh.points.par_iter().map(|&p| at(p)).collect()
        });
        let correlation = estimate.correlation();
        NoiseField { deviation, is_visible: true, correlation, terraces: None, at }
    }

    /// The noise of heights in steps: at least that of the steps. Where the sensor's own noise is larger, the steps do
    /// not show, and it is the estimate.
    fn of_terraces(terraces: Terraces, patches: &[NoisePatch], points: &[Point]) -> Self {
        let estimate = Estimate::new(patches, points.len());
        let larger = estimate.filter(|found| found.deviation() > terraces.deviation());
        let at = terraces.deviations(points).filter(|_| larger.is_none());
        NoiseField {
            deviation: larger.as_ref().map_or(terraces.deviation(), Estimate::deviation),
            is_visible: true,
            correlation: larger.map_or([0.0; 2], |found| found.correlation()),
            terraces: Some(terraces),
            at: at.unwrap_or_default(),
        }
    }

    /// The standard deviation at a vertex.
    pub(crate) fn at(&self, v: VertexId) -> f64 {
        self.at.get(v.index()).map_or(self.deviation, |&deviation| deviation.into())
    }

    /// The variance of a fit to points around a vertex, of which independent points of variance 1 leave
    /// `left`. Correlated points leave more, but no more than one of them has.
    pub(crate) fn variance_of_fit(
        &self,
        v: VertexId,
        left: f64,
        points: impl Iterator<Item = Point>,
    ) -> f64 {
        let [one, two] = self.correlation;
        let common = 1.0 + AROUND[0] * one + AROUND[1] * two;
        let own = self.at(v).powi(2) * if left <= 1.0 { (common * left).min(1.0) } else { left };
        self.terraces.map_or(own, |terraces| own.max(terraces.variance(points)))
    }

    /// The vertices where the noise does not explain how far a surface is from them and their neighbours. `squares` has
    /// the squared distance of each vertex as a share of its variance.
    pub(crate) fn unexplained<N: Iterator<Item = usize>>(
        &self,
        squares: &[f64],
        neighbours: impl Fn(usize) -> N + Sync,
    ) -> Vec<bool> {
        let limit = outlying(squares.len());
        let is_unexplained = |v: usize| {
            let around = neighbours(v).map(|w| squares[w]);
            let (sum, count) = around.fold((squares[v], 1.0), |(sum, n), s| (sum + s, n + 1.0));
            sum / count > self.mean_square_around(count).at(limit)
        };
        (0..squares.len()).into_par_iter().map(is_unexplained).collect()
    }

    /// The distribution of the mean square of `count` points: one and its neighbours.
    fn mean_square_around(&self, count: f64) -> MeanSquare {
        let [one, two] = self.correlation;
        let beside = count - 1.0;
        // The spokes and the rim, and the other pairs of the rim.
        let pairs = [2.0 * beside, (0.5 * beside * (beside - 3.0)).max(0.0)];
        MeanSquare(count * count / (count + 2.0 * (pairs[0] * one * one + pairs[1] * two * two)))
    }
}

/// How many vertices are one edge and two edges from a vertex of an even mesh.
const AROUND: [f64; 2] = [6.0, 12.0];

/// Patches that are spread evenly over the vertices.
fn patches(mesh: &Mesh, rings: &VertexRings) -> Vec<NoisePatch> {
    let normals = mesh.vertex_normals();
    let step = mesh.points.len().div_ceil(MOST_PATCHES).max(1);
    let count = mesh.points.len().div_ceil(step);
    let fit = |scratch: &mut Scratch, k: usize| {
        NoisePatch::new(mesh, rings, &normals, VertexId::from(k * step), scratch)
    };
    (0..count).into_par_iter().map_init(Scratch::default, fit).flatten().collect()
}
