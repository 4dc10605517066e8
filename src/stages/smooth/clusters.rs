//! A hierarchy of clusters of a scan's vertices. The finest level is the vertices themselves;
//! clusters of coarser levels grow along the edges of the mesh.
//!
//! A fit with a wide support uses clusters in place of points. Each cluster has a number of points,
//! a mean and a covariance (see [`Sample`]). Such a fit costs as much as one with a narrow support
//! and is as exact as one to the points. Neighbourhoods follow the mesh, so none reaches through a
//! wall or across a gap to another sheet.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::geometry::{BLOCK, NONE, ROUNDING, Vector, VertexId};
use crate::mesh::mls::{REACH, Sample, smoothed_normals};
use crate::mesh::{Mesh, VertexRings};

/// One level of the hierarchy.
#[derive(Default)]
pub(crate) struct ClusterLevel {
    /// The clusters.
    pub samples: Vec<Sample>,
    /// The mean unit normals of the clusters.
    pub normals: Arc<Vec<Vector>>,
    /// The adjacency of the clusters: the neighbours of cluster i are at `starts[i]..starts[i + 1]`
    /// of `near`. Two clusters are neighbours if they share an edge of the mesh.
    starts: Vec<u32>,
    near: Vec<u32>,
}

/// Working memory for the gathering of one neighbourhood.
#[derive(Default)]
pub(crate) struct Neighbourhood {
    stamp: u32,
    seen: Vec<u32>,
    found: Vec<u32>,
    /// The samples of the neighbourhood.
    pub around: Vec<Sample>,
}

/// A pool of working memory, kept between gatherings because each piece is as large as the level.
#[derive(Default)]
pub(crate) struct ScratchPool(Mutex<Vec<Neighbourhood>>);

impl ScratchPool {
    /// Runs `work` with working memory that no other thread uses meanwhile.
    pub(crate) fn with<T>(&self, work: impl FnOnce(&mut Neighbourhood) -> T) -> T {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = free().pop();
        let mut scratch = taken.unwrap_or_default();
        let done = work(&mut scratch);
        free().push(scratch);
        done
    }
}

/// A cluster is a remainder if it has less than this share of the mean number of points of its
/// neighbours. A remainder takes its normal from its neighbours.
const REMAINDER_SHARE: f64 = 0.25;

impl ClusterLevel {
    /// The level of the vertices themselves. Vertices marked in `left_out` have no weight.
    pub(crate) fn finest(mesh: &Mesh, rings: &VertexRings, left_out: &[bool]) -> Self {
        let mut samples: Vec<Sample> = mesh.points.iter().map(|&p| p.into()).collect();
        for (sample, _) in samples.iter_mut().zip(left_out).filter(|(_, out)| **out) {
            sample.weight = 0.0;
        }
        let around = |v: usize, near: &mut Vec<u32>| {
            near.extend(rings.neighbours(mesh, VertexId::from(v)).map(|w| w.0));
        };
        let (starts, near) = adjacency(mesh.points.len(), around);
        let normals = Arc::new(smoothed_normals(mesh, rings));
        ClusterLevel { samples, normals, starts, near }
    }

    /// Joins the clusters of this level that lie within `radius` of a seed. Returns the coarser
    /// level, and for each cluster of this level the number of its coarser cluster.
    pub(crate) fn coarser(&self, radius: f64) -> (ClusterLevel, Vec<u32>) {
        let mut cluster = vec![NONE; self.samples.len()];
        let mut members: Vec<u32> = Vec::with_capacity(self.samples.len());
        let mut ends = Vec::new();
        for seed in 0..self.samples.len() {
            if cluster[seed] == NONE {
                self.grow(seed, radius, ends.len() as u32, &mut cluster, &mut members);
                ends.push(members.len());
            }
        }
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let of: Vec<&[u32]> = starts.zip(&ends).map(|(a, &b)| &members[a..b]).collect();
        let samples =
            of.par_iter().map(|m| Sample::merged(m.iter().map(|&i| self.samples[i as usize])));
        let sum = |m: &&[u32]| -> Vector {
            m.iter().map(|&i| self.samples[i as usize].weight * self.normals[i as usize]).sum()
        };
        let sums: Vec<Vector> = of.par_iter().map(sum).collect();
        let around = |c: usize, near: &mut Vec<u32>| {
            near.extend(
                of[c].iter().flat_map(|&i| self.near(i as usize)).map(|&j| cluster[j as usize]),
            );
        };
        let (starts, near) = adjacency(of.len(), around);
        let mut clusters =
            ClusterLevel { samples: samples.collect(), normals: Arc::default(), starts, near };
        // A few points left between clusters may have normals that are mostly noise.
        let normal = |c: usize| {
            let beside = || clusters.near(c).iter().map(|&b| b as usize);
            let mean = beside().map(|b| clusters.samples[b].weight).sum::<f64>()
                / clusters.near(c).len().max(1) as f64;
            let is_remainder = clusters.samples[c].weight < REMAINDER_SHARE * mean;
            let sum = if is_remainder { beside().map(|b| sums[b]).sum() } else { sums[c] };
            sum.try_normalize(ROUNDING).unwrap_or(self.normals[of[c][0] as usize])
        };
        let normals: Vec<Vector> = (0..of.len()).into_par_iter().map(normal).collect();
        clusters.normals = Arc::new(normals);
        (clusters, cluster)
    }

    fn grow(
        &self,
        seed: usize,
        radius: f64,
        number: u32,
        cluster: &mut [u32],
        members: &mut Vec<u32>,
    ) {
        let mut done = members.len();
        members.push(seed as u32);
        cluster[seed] = number;
        while let Some(&i) = members.get(done) {
            done += 1;
            for &j in self.near(i as usize) {
                let j = j as usize;
                let close = (self.samples[j].at - self.samples[seed].at).norm() <= radius;
                if cluster[j] == NONE && close && self.normals[j].dot(&self.normals[seed]) > 0.0 {
                    cluster[j] = number;
                    members.push(j as u32);
                }
            }
        }
    }

    /// The neighbours of cluster `i`.
    pub(crate) fn near(&self, i: usize) -> &[u32] {
        &self.near[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Gathers the samples within reach of cluster `c` that are connected to it through other such
    /// samples. Samples whose normal faces the opposite way lie on another sheet and block the way.
    pub(crate) fn gather(&self, c: usize, h: f64, scratch: &mut Neighbourhood) {
        let (at, normal) = (self.samples[c].at, self.normals[c]);
        let reach = (REACH * h).powi(2);
        // Stamps left by levels of other sizes are older than every stamp to come.
        if scratch.seen.len() < self.samples.len() {
            scratch.seen.resize(self.samples.len(), 0);
        }
        scratch.stamp += 1;
        scratch.found.clear();
        scratch.found.push(c as u32);
        scratch.seen[c] = scratch.stamp;
        let mut done = 0;
        while let Some(&i) = scratch.found.get(done) {
            done += 1;
            for &j in self.near(i as usize) {
                let k = j as usize;
                if scratch.seen[k] != scratch.stamp {
                    scratch.seen[k] = scratch.stamp;
                    let close = (self.samples[k].at - at).norm_squared() <= reach;
                    if close && self.normals[k].dot(&normal) > 0.0 {
                        scratch.found.push(j);
                    }
                }
            }
        }
        scratch.around.clear();
        let counts = |sample: &Sample| sample.weight > 0.0;
        let found = scratch.found.iter().map(|&i| self.samples[i as usize]);
        scratch.around.extend(found.filter(counts));
    }
}

/// The adjacency lists of `count` items. `around` lists the neighbours of an item; repetitions and
/// the item itself are removed.
fn adjacency(count: usize, around: impl Fn(usize, &mut Vec<u32>) + Sync) -> (Vec<u32>, Vec<u32>) {
    let block = |first: usize| {
        let (mut ends, mut near, mut some) = (Vec::new(), Vec::new(), Vec::new());
        for i in first..count.min(first + BLOCK) {
            some.clear();
            around(i, &mut some);
            some.sort_unstable();
            some.dedup();
            near.extend(some.iter().filter(|&&j| j as usize != i));
            ends.push(near.len() as u32);
        }
        (ends, near)
    };
    let firsts = (0..count.div_ceil(BLOCK)).into_par_iter().map(|k| k * BLOCK);
    let blocks: Vec<(Vec<u32>, Vec<u32>)> = firsts.map(block).collect();
    let mut starts = Vec::with_capacity(count + 1);
    let mut near = Vec::with_capacity(blocks.iter().map(|block| block.1.len()).sum());
    starts.push(0);
    for (ends, more) in blocks {
        let before = near.len() as u32;
        starts.extend(ends.into_iter().map(|end| before + end));
        near.extend(more);
    }
    (starts, near)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn a_cluster_of_one_noisy_point_faces_as_those_beside_it() {
        let n = 12;
        let point = |v: usize| Point::new((v % n) as f64, (v / n) as f64, 0.0);
        let around = |v: usize, near: &mut Vec<u32>| {
            let beside = |w: &usize| (point(*w) - point(v)).norm() < 1.5;
            near.extend((0..n * n).filter(beside).map(|w| w as u32));
        };
        let (starts, near) = adjacency(n * n, around);
        let mut normals = vec![Vector::z(); n * n];
        normals[5 * n + 6] = Vector::new(0.6, 0.0, -0.8);
        let samples = (0..n * n).map(|v| point(v).into()).collect();
        let (coarse, of) =
            ClusterLevel { samples, normals: Arc::new(normals), starts, near }.coarser(2.5);
        let own = of[5 * n + 6] as usize;
        assert_eq!(coarse.samples[own].weight, 1.0);
        assert!(coarse.normals[own].z > 0.5, "{}", coarse.normals[own]);
    }
}
