//! The supports that are tried. Each has the level of clusters that its fits use.

use std::sync::Arc;

use rayon::prelude::*;

use super::clusters::{ClusterLevel, Neighbourhood};
use crate::geometry::{Point, SAMPLE};
use crate::mesh::mls::{Polynomial, REACH, ReferencePlane, reference_plane};
use crate::mesh::{Mesh, VertexRings};
use crate::noise::NoiseField;

/// The smallest support, as a multiple of the mean edge length. With a smaller one a quadratic has
/// too few points.
const SHORTEST: f64 = 1.25;

/// The ratio of each support to the one before it.
const RATIO: f64 = 1.5;

/// The largest support, as a share of the diagonal of the scan.
const LONGEST: f64 = 0.1;

/// The same for heights in steps, so that it spans several of them where the surface is nearly level.
const LONGEST_IN_STEPS: f64 = 0.3;

/// The radius of clusters, as a share of the support.
const CLUSTER_RADIUS: f64 = 0.3;

/// Vertices are not clustered if on average fewer than this many lie within the radius of a
/// cluster, because clusters would hardly be fewer. The vertices are counted: noise as large as the
/// distance between points doubles the lengths of edges, so these are no measure.
const MIN_CLUSTER_SIZE: f64 = 4.4;

/// A support with its level of clusters.
#[derive(Clone)]
pub(crate) struct SupportLevel {
    /// The support h, in mm.
    pub h: f64,
    /// The clusters that fits use as points.
    pub clusters: Arc<ClusterLevel>,
    /// The cluster of each vertex.
    pub cluster: Arc<Vec<u32>>,
}

/// The supports for a mesh in ascending order, with their clusters.
pub(crate) fn levels(
    mesh: &Mesh,
    rings: &VertexRings,
    noise: &NoiseField,
    left_out: &[bool],
) -> Vec<SupportLevel> {
    let mut levels = vec![SupportLevel::finest(mesh, rings, left_out)];
    let share = if noise.terraces.is_some() { LONGEST_IN_STEPS } else { LONGEST };
    let longest = (share * mesh.diagonal()).max(levels[0].h);
    while let Some(last) = levels.last().filter(|last| last.h * RATIO <= longest) {
        levels.push(last.next(last.h * RATIO));
    }
    levels
}

/// The smallest support, in mm.
pub(crate) fn shortest(mesh: &Mesh) -> f64 {
    SHORTEST * mesh.mean_edge()
}

impl SupportLevel {
    /// The vertices themselves, for the smallest support.
    pub(crate) fn finest(mesh: &Mesh, rings: &VertexRings, left_out: &[bool]) -> SupportLevel {
        let cluster = (0..mesh.points.len() as u32).collect();
        SupportLevel {
            h: shortest(mesh),
            clusters: Arc::new(ClusterLevel::finest(mesh, rings, left_out)),
            cluster: Arc::new(cluster),
        }
    }

    /// The level for support `h`. It keeps the present clusters if coarser ones would hardly
    /// differ.
    pub(crate) fn next(&self, h: f64) -> SupportLevel {
        let is_finest = self.clusters.samples.len() == self.cluster.len();
        if is_finest && self.mean_neighbours(CLUSTER_RADIUS * h) < MIN_CLUSTER_SIZE {
            return SupportLevel {
                h,
                clusters: self.clusters.clone(),
                cluster: self.cluster.clone(),
            };
        }
        let (clusters, of) = self.clusters.coarser(CLUSTER_RADIUS * h);
        let cluster = self.cluster.par_iter().map(|&c| of[c as usize]).collect();
        SupportLevel { h, clusters: Arc::new(clusters), cluster: Arc::new(cluster) }
    }

    /// Forgets the clusters of a level that no vertex uses.
    pub(crate) fn forget(&mut self) {
        (self.clusters, self.cluster) = (Arc::default(), Arc::default());
    }

    /// The level of some of its vertices.
    pub(crate) fn of_vertices(&self, left: &[u32]) -> SupportLevel {
        let of = |v: &u32| self.cluster.get(*v as usize).copied();
        let cluster = left.iter().filter_map(of).collect();
        SupportLevel { h: self.h, clusters: self.clusters.clone(), cluster: Arc::new(cluster) }
    }

    /// The mean number of samples within a radius of a sample.
    fn mean_neighbours(&self, radius: f64) -> f64 {
        let (mut scratch, count) = (Neighbourhood::default(), self.clusters.samples.len());
        let looked_at = (0..count).step_by(count.div_ceil(SAMPLE).max(1));
        let of_each = looked_at.map(|c| {
            self.clusters.gather(c, radius / REACH, &mut scratch);
            scratch.around.len() as f64
        });
        let (sum, looked_at) = of_each.fold((0.0, 0.0), |(sum, n), found| (sum + found, n + 1.0));
        sum / looked_at
    }

    /// Fits the polynomial around the position of cluster `c`.
    pub(super) fn fit(&self, c: usize, scratch: &mut Neighbourhood) -> Option<Polynomial> {
        Polynomial::fit(&self.plane(c, scratch)?, &scratch.around, self.h)
    }

    /// The reference plane of cluster `c`. The samples of its neighbourhood remain in `scratch`.
    fn plane(&self, c: usize, scratch: &mut Neighbourhood) -> Option<ReferencePlane> {
        self.clusters.gather(c, self.h, scratch);
        let (at, normal) = (self.clusters.samples[c].at, self.clusters.normals[c]);
        reference_plane(at, normal, &scratch.around, self.h)
    }

    /// The weight of the polynomial of cluster `c` at `p`.
    pub(crate) fn weight(&self, c: usize, p: Point) -> f64 {
        let radius = CLUSTER_RADIUS * self.h;
        (-(self.clusters.samples[c].at - p).norm_squared() / (radius * radius)).exp()
    }
}
