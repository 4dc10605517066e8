//! A scan at several grains: its vertices, and coarser and coarser clusters of
//! them that grow along the mesh's edges.
//!
//! A fit with a wide support takes clusters for points, each with its number of
//! points, their mean and their covariance: it costs as much as one with a
//! narrow support, and is as exact (see [`Sample`]). Neighbourhoods follow the
//! mesh, so that none reaches through a wall or over a gap to another sheet.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::geometry::{Vector, VertexId};
use crate::mesh::mls::{REACH, Sample, steady_normals};
use crate::mesh::{Mesh, Rings};

/// One grain.
pub struct Grain {
    /// The clusters.
    pub samples: Vec<Sample>,
    /// Their mean unit normals.
    pub normals: Vec<Vector>,
    /// Which clusters share an edge: those of cluster i stand at
    /// `starts[i]..starts[i + 1]`.
    starts: Vec<u32>,
    near: Vec<u32>,
}

/// Room for the gathering of one neighbourhood.
#[derive(Default)]
pub struct Gathering {
    stamp: u32,
    seen: Vec<u32>,
    found: Vec<u32>,
    /// The samples around.
    pub around: Vec<Sample>,
    /// Their numbers.
    pub numbers: Vec<u32>,
}

/// Rooms, kept between gatherings: each is as large as the grain.
#[derive(Default)]
pub struct Rooms(Mutex<Vec<Gathering>>);

impl Rooms {
    /// Does something in a room that nobody else uses meanwhile.
    pub fn with<T>(&self, work: impl FnOnce(&mut Gathering) -> T) -> T {
        let free = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = free().pop();
        let mut room = taken.unwrap_or_default();
        let done = work(&mut room);
        free().push(room);
        done
    }
}

const FREE: u32 = u32::MAX;

/// A cluster with less than this share of the points that those beside it have
/// faces as they do.
const LEFT_OVER: f64 = 0.25;

impl Grain {
    /// The vertices themselves. Those that `left_out` lists count for nothing.
    pub fn finest(mesh: &Mesh, rings: &Rings, left_out: &[bool]) -> Self {
        let mut samples: Vec<Sample> = mesh.points.iter().map(|&p| p.into()).collect();
        for (sample, _) in samples.iter_mut().zip(left_out).filter(|(_, out)| **out) {
            sample.weight = 0.0;
        }
        let around = |v: usize, near: &mut Vec<u32>| {
            near.extend(rings.neighbours(mesh, VertexId::from(v)).map(|w| w.0));
        };
        let (starts, near) = adjacency(mesh.points.len(), around);
        Grain { samples, normals: steady_normals(mesh, rings), starts, near }
    }

    /// Clusters of those of this grain that lie within `radius` of the first
    /// of them, and for each of this grain the number of its cluster.
    pub fn coarser(&self, radius: f64) -> (Grain, Vec<u32>) {
        let mut cluster = vec![FREE; self.samples.len()];
        let mut members: Vec<u32> = Vec::with_capacity(self.samples.len());
        let mut ends = Vec::new();
        for seed in 0..self.samples.len() {
            if cluster[seed] == FREE {
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
        let mut grain = Grain { samples: samples.collect(), normals: Vec::new(), starts, near };
        // The normals of a few points left over between clusters may be noise.
        let normal = |c: usize| {
            let beside = || grain.near(c).iter().map(|&b| b as usize);
            let mean = beside().map(|b| grain.samples[b].weight).sum::<f64>()
                / grain.near(c).len().max(1) as f64;
            let is_left_over = grain.samples[c].weight < LEFT_OVER * mean;
            let sum = if is_left_over { beside().map(|b| sums[b]).sum() } else { sums[c] };
            sum.try_normalize(1e-12).unwrap_or(self.normals[of[c][0] as usize])
        };
        grain.normals = (0..of.len()).into_par_iter().map(normal).collect();
        (grain, cluster)
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
                if cluster[j] == FREE && close && self.normals[j].dot(&self.normals[seed]) > 0.0 {
                    cluster[j] = number;
                    members.push(j as u32);
                }
            }
        }
    }

    /// The clusters that share an edge with the `i`-th.
    pub fn near(&self, i: usize) -> &[u32] {
        &self.near[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// Gathers the samples within reach of cluster `c`'s place that are reached
    /// from it over others of them. Those whose normal looks the other way lie
    /// on another sheet and bar the way.
    pub fn gather(&self, c: usize, h: f64, room: &mut Gathering) {
        let (at, normal) = (self.samples[c].at, self.normals[c]);
        let reach = (REACH * h).powi(2);
        // What grains of other sizes left there is older than any stamp to come.
        if room.seen.len() < self.samples.len() {
            room.seen.resize(self.samples.len(), 0);
        }
        room.stamp += 1;
        room.found.clear();
        room.found.push(c as u32);
        room.seen[c] = room.stamp;
        let mut done = 0;
        while let Some(&i) = room.found.get(done) {
            done += 1;
            for &j in self.near(i as usize) {
                let k = j as usize;
                if room.seen[k] != room.stamp {
                    room.seen[k] = room.stamp;
                    let close = (self.samples[k].at - at).norm_squared() <= reach;
                    if close && self.normals[k].dot(&normal) > 0.0 {
                        room.found.push(j);
                    }
                }
            }
        }
        room.numbers.clear();
        let counts = |i: &u32| self.samples[*i as usize].weight > 0.0;
        room.numbers.extend(room.found.iter().filter(|i| counts(i)));
        room.around.clear();
        room.around.extend(room.numbers.iter().map(|&i| self.samples[i as usize]));
    }
}

/// For each of `count` things those that `around` lists, but itself, each once.
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

/// Things whose neighbours one thread lists at a time.
const BLOCK: usize = 1 << 13;

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
        let (coarse, of) = Grain { samples, normals, starts, near }.coarser(2.5);
        let own = of[5 * n + 6] as usize;
        assert_eq!(coarse.samples[own].weight, 1.0);
        assert!(coarse.normals[own].z > 0.5, "{}", coarse.normals[own]);
    }
}
