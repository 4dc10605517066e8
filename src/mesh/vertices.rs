//! Which point of a face's mesh each vertex of the scan became.

use std::hash::BuildHasher;

use foldhash::fast::FixedState;
use hashbrown::HashTable;

use super::Build;
use crate::geometry::{NONE, Point};

/// For each vertex of the scan the point that it became.
#[derive(Debug, Clone, Default)]
pub(crate) struct VertexMap {
    /// Positions of the points, or [`NONE`].
    points: Vec<u32>,
}

impl VertexMap {
    /// `points` are some of the mesh, each at a place of its own. They have the mesh's own
    /// coordinates, by which they are found.
    pub(super) fn new(build: &Build, points: &[Point]) -> Self {
        let hash = |p: &Point| FixedState::default().hash_one([p.x, p.y, p.z].map(f64::to_bits));
        let mut found: HashTable<u32> = HashTable::with_capacity(points.len());
        for (i, p) in (0..).zip(points) {
            found.insert_unique(hash(p), i, |&i| hash(&points[i as usize]));
        }
        let places = build.place.iter().max().map_or(0, |&last| last as usize + 1);
        let mut at_place = vec![NONE; places];
        for (p, &place) in build.mesh.points.iter().zip(&build.place) {
            if let Some(&i) = found.find(hash(p), |&i| points[i as usize] == *p) {
                at_place[place as usize] = i;
            }
        }
        let point = |&place: &u32| at_place.get(place as usize).copied().unwrap_or(NONE);
        VertexMap { points: build.vertices.iter().map(point).collect() }
    }

    /// For each vertex the position of its point, or [`NONE`].
    pub(super) fn of_numbers(points: Vec<u32>) -> Self {
        VertexMap { points }
    }

    /// The position of the point that a vertex of the scan became, if it became one.
    pub(crate) fn point_of(&self, vertex: usize) -> Option<usize> {
        self.points.get(vertex).filter(|&&point| point != NONE).map(|&point| point as usize)
    }
}
