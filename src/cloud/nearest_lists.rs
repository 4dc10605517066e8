//! The nearest neighbours of every point.

use rayon::prelude::*;

use super::CHUNK;
use crate::geometry::Point;
use crate::mesh::Neighbours;

/// For each point its k nearest other points, nearest first.
pub(super) struct NearestLists {
    flat: Vec<u32>,
    k: usize,
}

impl NearestLists {
    /// Lists the `k` nearest of `points`, which `near` searches. There must be more than `k`.
    pub fn new(points: &[Point], near: &Neighbours, k: usize) -> Self {
        let mut flat = vec![0; points.len() * k];
        flat.par_chunks_mut(CHUNK * k).enumerate().for_each(|(chunk, lists)| {
            let mut found = Vec::new();
            for (own, list) in (chunk * CHUNK..).zip(lists.chunks_exact_mut(k)) {
                near.nearest_n(points[own], k + 1, &mut found);
                let others = found.iter().map(|&(other, _)| other).filter(|&o| o as usize != own);
                list.iter_mut().zip(others).for_each(|(place, other)| *place = other);
            }
        });
        NearestLists { flat, k }
    }

    /// The neighbours of point `i`.
    pub fn of(&self, i: usize) -> &[u32] {
        &self.flat[i * self.k..(i + 1) * self.k]
    }
}
