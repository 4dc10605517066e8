//! The nearest neighbours of every point.

use rayon::prelude::*;

use super::CHUNK;
use super::layers::{AROUND, AreJoined, LayerSearch, Layers};
use super::project::SurfacePoint;
use crate::geometry::Point;
use crate::mesh::Neighbours;

/// For each point its k nearest other points, nearest first.
pub(super) struct NearestLists {
    flat: Vec<u32>,
    k: usize,
}

impl NearestLists {
    /// Lists the `k` nearest of `points` in the layer of each. There must be more than `k`.
    pub(super) fn new(points: &[Point], layers: &Layers<'_>, k: usize) -> Self {
        Self::filled(points.len(), k, |search: &mut LayerSearch, own, list| {
            layers.list(own, k, search);
            list.copy_from_slice(&search.list);
        })
    }

    /// Lists the `k` nearest of `points`, with `are_joined` only those that it joins. There are fewer where few are
    /// joined, and the rest of a list is the point itself.
    pub(super) fn of_joined(
        points: &[Point],
        k: usize,
        are_joined: Option<&AreJoined<'_>>,
    ) -> Self {
        let near = Neighbours::new(points);
        let looked_at = if are_joined.is_some() { AROUND * k } else { k };
        Self::filled(points.len(), k, |found: &mut Vec<(u32, f64)>, own, list| {
            near.nearest_n(points[own], looked_at + 1, found);
            let others = found.iter().map(|&(other, _)| other).filter(|&o| o as usize != own);
            let kept = others.filter(|&other| are_joined.is_none_or(|joined| joined(own, other)));
            let filled = kept.chain(std::iter::repeat(own as u32));
            list.iter_mut().zip(filled).for_each(|(place, other)| *place = other);
        })
    }

    fn filled<S: Default>(
        count: usize,
        k: usize,
        fill: impl Fn(&mut S, usize, &mut [u32]) + Sync,
    ) -> Self {
        let mut flat = vec![0; count * k];
        flat.par_chunks_mut(CHUNK * k).enumerate().for_each(|(chunk, lists)| {
            let mut search = S::default();
            for (own, list) in (chunk * CHUNK..).zip(lists.chunks_exact_mut(k)) {
                fill(&mut search, own, list);
            }
        });
        NearestLists { flat, k }
    }

    /// The number of neighbours of each point.
    pub(super) fn count(&self) -> usize {
        self.k
    }

    /// Replaces `found` by the `k` points whose projected places are nearest to that of point `i`,
    /// with the squares of their distances, and returns the largest distance. They are looked for
    /// among the neighbours of neighbours. Point `i` is one of them.
    pub(crate) fn nearest_of_two_rings(
        &self,
        i: usize,
        surface: &[SurfacePoint],
        left_out: &[bool],
        found: &mut Vec<(f64, u32)>,
    ) -> f64 {
        let ring = self.of(i).iter();
        let two_rings = ring.flat_map(|&j| self.of(j as usize)).chain(self.of(i)).copied();
        let squared = |j: u32| (surface[j as usize].place - surface[i].place).norm_squared();
        found.clear();
        found.extend(two_rings.filter(|&j| !left_out[j as usize]).map(|j| (squared(j), j)));
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.dedup();
        found.truncate(self.k);
        found.last().map_or(0.0, |&(squared, _)| squared.sqrt())
    }

    /// The neighbours of point `i`.
    pub(super) fn of(&self, i: usize) -> &[u32] {
        &self.flat[i * self.k..(i + 1) * self.k]
    }
}
