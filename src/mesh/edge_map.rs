//! Adjacency: which triangles share an edge, and which share a vertex.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::Mesh;
use crate::geometry::{NONE, VertexId};

/// For each side of each triangle, the opposite side of the same edge.
///
/// Side `3 t + k` of the mesh runs from corner `k` of triangle `t` to corner `k + 1`. Two sides are
/// glued if they form one edge.
#[derive(Debug)]
pub struct EdgeMap {
    glued: Vec<u32>,
    overfull: Vec<Vec<u32>>,
}

impl EdgeMap {
    /// Glues every two sides that join the same two vertices in either direction, unless a third
    /// side joins them as well.
    pub fn new(mesh: &Mesh) -> Self {
        let ends = |side: u32| {
            let (t, k) = (side as usize / 3, side as usize % 3);
            let (a, b) = (mesh.triangles[t][k].0, mesh.triangles[t][(k + 1) % 3].0);
            (a.min(b), a.max(b))
        };
        let count = 3 * mesh.triangles.len();
        let by_lower = Buckets::new(mesh.points.len(), count, |side| ends(side).0);
        // Each side belongs to the edges of exactly one lower vertex, so no two threads write to
        // the same entry.
        let glued: Vec<AtomicU32> = (0..count).into_par_iter().map(|_| NONE.into()).collect();
        let glue = |(x, y): (u32, u32)| glued[x as usize].store(y, Ordering::Relaxed);
        let glue_at = |bucket: &mut Vec<(u32, u32)>, v: usize| {
            bucket.clear();
            bucket.extend(by_lower.of(v).iter().map(|&side| (ends(side).1, side)));
            bucket.sort_unstable();
            let mut overfull = Vec::new();
            for same in bucket.chunk_by(|x, y| x.0 == y.0) {
                match *same {
                    [_] => {}
                    [(_, x), (_, y)] => [(x, y), (y, x)].into_iter().for_each(glue),
                    _ => overfull.push(same.iter().map(|&(_, side)| side).collect()),
                }
            }
            overfull
        };
        let vertices = (0..mesh.points.len()).into_par_iter();
        let overfull = vertices.map_init(Vec::new, glue_at).flatten_iter().collect();
        EdgeMap { glued: glued.into_iter().map(AtomicU32::into_inner).collect(), overfull }
    }

    /// The edge map of the given triangles, of which no more than two share an edge.
    pub(super) fn part(&self, triangles: &[usize]) -> Self {
        let mut number = vec![NONE; self.glued.len() / 3];
        triangles.iter().enumerate().for_each(|(new, &t)| number[t] = new as u32);
        let renumbered = |side: usize| match self.glued[side] {
            NONE => NONE,
            other => match number[other as usize / 3] {
                NONE => NONE,
                number => 3 * number + other % 3,
            },
        };
        let glued = triangles.iter().flat_map(|t| [0, 1, 2].map(|k| renumbered(3 * t + k)));
        EdgeMap { glued: glued.collect(), overfull: Vec::new() }
    }

    /// The side that is glued to `side`, or `None` on the boundary.
    pub(crate) fn across(&self, side: usize) -> Option<usize> {
        let other = self.glued[side];
        (other != NONE).then_some(other as usize)
    }

    /// The boundary sides in ascending order.
    pub(crate) fn open_sides(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.glued.len()).filter(|&s| self.glued[s] == NONE)
    }

    /// Whether all pairs of glued sides run in opposite directions.
    pub(super) fn is_oriented(&self, mesh: &Mesh) -> bool {
        let from = |side: usize| mesh.triangles[side / 3][side % 3];
        let opposite = |s| self.across(s).is_none_or(|other| from(s) != from(other));
        (0..self.glued.len()).into_par_iter().all(opposite)
    }

    /// Whether the triangles around each vertex of an oriented mesh form a single fan.
    pub(super) fn has_single_fans(&self, mesh: &Mesh) -> bool {
        let none = |_| [AtomicU32::new(0), AtomicU32::new(0)];
        let of_vertices: Vec<[AtomicU32; 2]> =
            (0..mesh.points.len()).into_par_iter().map(none).collect();
        (0..self.glued.len()).into_par_iter().for_each(|corner| {
            let [count, first] = &of_vertices[mesh.triangles[corner / 3][corner % 3].index()];
            count.fetch_add(1, Ordering::Relaxed);
            // Any corner of the vertex serves as a start.
            first.store(corner as u32, Ordering::Relaxed);
        });
        of_vertices.into_par_iter().all(|[count, first]| match count.into_inner() {
            0 => true,
            count => self.fan(first.into_inner() as usize) == count,
        })
    }

    /// The number of corners at a vertex that are reached from one of them across glued sides.
    fn fan(&self, first: usize) -> u32 {
        let turned = |corner: usize, by: usize| corner / 3 * 3 + (corner % 3 + by) % 3;
        let mut count = 1;
        let mut corner = first;
        while let Some(other) = self.across(corner) {
            corner = turned(other, 1);
            if corner == first {
                return count;
            }
            count += 1;
        }
        corner = first;
        while let Some(other) = self.across(turned(corner, 2)) {
            corner = other;
            count += 1;
        }
        count
    }

    /// The sides of each edge that more than two triangles share. None of these sides is glued.
    pub(super) fn overfull(&self) -> &[Vec<u32>] {
        &self.overfull
    }

    /// Updates the map after corners 1 and 2 of triangle `t` were swapped, which flips its
    /// orientation.
    pub(super) fn turn_over(&mut self, t: usize) {
        self.glued.swap(3 * t, 3 * t + 2);
        for side in [3 * t, 3 * t + 2] {
            if let Some(other) = self.across(side) {
                self.glued[other] = side as u32;
            }
        }
        for side in self.overfull.iter_mut().flatten().filter(|s| **s as usize / 3 == t) {
            *side = 3 * t as u32 + 2 - *side % 3;
        }
    }
}

/// Numbers that are sorted into buckets. They ascend within each bucket.
#[derive(Debug)]
pub(crate) struct Buckets {
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// The most threads for a task in which each of them reads everything.
pub(super) const MOST_THREADS: usize = 8;

impl Buckets {
    /// Puts each number below `count` into the bucket `bucket(number)`; there are `buckets` of
    /// them.
    pub(crate) fn new(buckets: usize, count: usize, bucket: impl Fn(u32) -> u32 + Sync) -> Self {
        // Each thread reads all numbers and keeps those that belong to its share of the buckets.
        let threads = rayon::current_num_threads().min(MOST_THREADS);
        let share = buckets.div_ceil(threads).max(1);
        let mut starts = vec![0u32; buckets + 1];
        starts[1..].par_chunks_mut(share).enumerate().for_each(|(k, counts)| {
            for i in 0..count as u32 {
                if let Some(count) = counts.get_mut((bucket(i) as usize).wrapping_sub(k * share)) {
                    *count += 1;
                }
            }
        });
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut members = vec![0; count];
        let mut left = &mut members[..];
        let mut shares = Vec::new();
        for first in (0..buckets).step_by(share) {
            let next = &starts[first..(first + share).min(buckets)];
            let end = starts[first + next.len()];
            let (mine, others) = left.split_at_mut((end - next[0]) as usize);
            shares.push((first, next.to_vec(), mine));
            left = others;
        }
        shares.par_iter_mut().for_each(|(first, next, members)| {
            let start = next[0];
            for i in 0..count as u32 {
                if let Some(next) = next.get_mut((bucket(i) as usize).wrapping_sub(*first)) {
                    members[(*next - start) as usize] = i;
                    *next += 1;
                }
            }
        });
        Buckets { starts, members }
    }

    /// The numbers in a bucket.
    pub(crate) fn of(&self, bucket: usize) -> &[u32] {
        &self.members[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
    }
}

/// The one-ring of every vertex: its triangles, and through them its neighbours.
#[derive(Debug)]
pub(crate) struct VertexRings {
    corners: Buckets,
}

impl VertexRings {
    /// Lists the triangles of every vertex in ascending order.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let vertex = |corner: u32| mesh.triangles[corner as usize / 3][corner as usize % 3].0;
        let mut corners = Buckets::new(mesh.points.len(), 3 * mesh.triangles.len(), vertex);
        corners.members.iter_mut().for_each(|corner| *corner /= 3);
        VertexRings { corners }
    }

    /// The triangles around a vertex.
    pub(crate) fn triangles(&self, v: VertexId) -> &[u32] {
        self.corners.of(v.index())
    }

    /// The vertices that share a triangle with `v`. A vertex is repeated for each shared triangle.
    pub(crate) fn neighbours<'a>(
        &'a self,
        mesh: &'a Mesh,
        v: VertexId,
    ) -> impl Iterator<Item = VertexId> + 'a {
        let corners = self.triangles(v).iter().flat_map(|&t| mesh.triangles[t as usize]);
        corners.filter(move |&w| w != v)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_keep_the_order_with_any_number_of_threads() {
        let bucket = |i: u32| i.wrapping_mul(2_654_435_761) % 11;
        for threads in [1, 2, 3, 16] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            // Bucket 11 stays empty, and so do all three buckets when there are no numbers.
            let (all, none) =
                pool.install(|| (Buckets::new(12, 1000, bucket), Buckets::new(3, 0, bucket)));
            for b in 0..12 {
                let expected: Vec<u32> = (0..1000).filter(|&i| bucket(i) == b).collect();
                assert_eq!(all.of(b as usize), expected, "{threads} threads, bucket {b}");
            }
            assert!((0..3).all(|b| none.of(b).is_empty()));
        }
    }
}
