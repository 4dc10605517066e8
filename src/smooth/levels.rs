//! The supports that are tried, each with the grain that serves it.

use std::sync::Arc;

use rayon::prelude::*;

use super::clusters::{Gathering, Grain};
use crate::geometry::Point;
use crate::mesh::mls::{Plane, Polynomial, REACH, Scatter, reference_plane};
use crate::mesh::{Mesh, Rings};

/// The shortest support, in mean edge lengths: below it a quadratic has too few
/// points.
const SHORTEST: f64 = 1.25;

/// Each support is this many times the one before it.
const RATIO: f64 = 1.5;

/// The longest support, as a share of the scan's diagonal.
const LONGEST: f64 = 0.1;

/// Clusters have this radius, in supports.
const RADIUS: f64 = 0.3;

/// With no more vertices than this within that radius of each other, clusters would be
/// little fewer than they. Counted, not told from the lengths of edges, which noise as
/// large as the point spacing doubles.
const CROWD: f64 = 4.4;

/// The vertices around about so many are counted.
const COUNTED: usize = 1000;

/// A support and its grain.
#[derive(Clone)]
pub struct Level {
    /// The support h, in mm.
    pub h: f64,
    /// The clusters that fits take for points.
    pub grain: Arc<Grain>,
    /// The cluster of each vertex.
    pub cluster: Arc<Vec<u32>>,
}

/// The levels for a mesh, from the shortest support to the longest.
pub fn levels(mesh: &Mesh, rings: &Rings, left_out: &[bool]) -> Vec<Level> {
    let shortest = SHORTEST * mesh.mean_edge();
    let longest = (LONGEST * mesh.diagonal()).max(shortest);
    let mut levels = vec![Level::finest(mesh, rings, left_out, shortest)];
    while let Some(last) = levels.last().filter(|last| last.h * RATIO <= longest) {
        levels.push(last.next(last.h * RATIO));
    }
    levels
}

impl Level {
    /// The vertices as they are, for support `h`.
    fn finest(mesh: &Mesh, rings: &Rings, left_out: &[bool], h: f64) -> Level {
        let cluster = (0..mesh.points.len() as u32).collect();
        Level {
            h,
            grain: Arc::new(Grain::finest(mesh, rings, left_out)),
            cluster: Arc::new(cluster),
        }
    }

    /// The level for support `h`, of the same grain where a coarser one would be hardly
    /// any other.
    pub fn next(&self, h: f64) -> Level {
        let is_finest = self.grain.samples.len() == self.cluster.len();
        if is_finest && self.crowd(RADIUS * h) < CROWD {
            return Level { h, grain: self.grain.clone(), cluster: self.cluster.clone() };
        }
        let (grain, of) = self.grain.coarser(RADIUS * h);
        let cluster = self.cluster.par_iter().map(|&c| of[c as usize]).collect();
        Level { h, grain: Arc::new(grain), cluster: Arc::new(cluster) }
    }

    /// How many samples are within a radius of one, in the mean.
    fn crowd(&self, radius: f64) -> f64 {
        let (mut room, count) = (Gathering::default(), self.grain.samples.len());
        let looked_at = (0..count).step_by(count.div_ceil(COUNTED).max(1));
        let of_each = looked_at.map(|c| {
            self.grain.gather(c, radius / REACH, &mut room);
            room.around.len() as f64
        });
        let (sum, looked_at) = of_each.fold((0.0, 0.0), |(sum, n), found| (sum + found, n + 1.0));
        sum / looked_at
    }

    /// The polynomial around the place of cluster `c`.
    pub fn fit(&self, c: usize, room: &mut Gathering) -> Option<Polynomial> {
        Polynomial::fit(&self.plane(c, room)?, &room.around, self.h)
    }

    /// The same, and what it shows of the noise.
    pub fn fit_with_scatter(
        &self,
        c: usize,
        room: &mut Gathering,
    ) -> Option<(Polynomial, Scatter)> {
        Polynomial::fit_with_scatter(&self.plane(c, room)?, &room.around, self.h)
    }

    /// The reference plane of cluster `c`; its neighbourhood is left in `room`.
    fn plane(&self, c: usize, room: &mut Gathering) -> Option<Plane> {
        self.grain.gather(c, self.h, room);
        let (at, normal) = (self.grain.samples[c].at, self.grain.normals[c]);
        reference_plane(at, normal, &room.around, self.h)
    }

    /// The weight of cluster `c`'s polynomial at `p`.
    pub fn weight(&self, c: usize, p: Point) -> f64 {
        let radius = RADIUS * self.h;
        (-(self.grain.samples[c].at - p).norm_squared() / (radius * radius)).exp()
    }
}
