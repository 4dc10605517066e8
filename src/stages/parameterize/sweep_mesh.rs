//! A compact copy of the present mesh for many relaxation sweeps.
//!
//! On the way from coarse to fine, the remaining vertices are scattered over the memory of the
//! whole mesh. The copy stores them contiguously. Each thread writes the positions that it computes
//! to where the other threads read them.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::relax::{self, Freedom, StretchEnergy};
use crate::geometry::{Point, Uv};
use crate::mesh::one_rings::OneRings;

/// The remaining vertices of a mesh, renumbered.
pub(crate) struct SweepMesh<'a> {
    rings: OneRings,
    points: Vec<Point>,
    weights: Vec<f64>,
    freedom: Vec<Freedom>,
    /// The weight of the convex energy term.
    convex_weight: f64,
    places: Vec<AtomicUv>,
    groups: Vec<Vec<u32>>,
    /// The numbers of the vertices in the whole mesh.
    remaining: &'a [u32],
}

/// A position that one thread writes while others read neighbouring ones.
struct AtomicUv([AtomicU64; 2]);

/// The number of vertices that one thread moves at a time. It does not depend on the number of
/// threads.
const CHUNK: usize = 64;

impl AtomicUv {
    fn new(at: Uv) -> Self {
        AtomicUv([at.x, at.y].map(|t| AtomicU64::new(t.to_bits())))
    }

    // Threads synchronize between groups and then see all earlier writes.
    fn get(&self) -> Uv {
        let [x, y] = self.0.each_ref().map(|t| f64::from_bits(t.load(Ordering::Relaxed)));
        Uv::new(x, y)
    }

    fn set(&self, at: Uv) {
        self.0[0].store(at.x.to_bits(), Ordering::Relaxed);
        self.0[1].store(at.y.to_bits(), Ordering::Relaxed);
    }
}

impl<'a> SweepMesh<'a> {
    /// Copies the vertices `remaining`. They must have no other neighbours.
    pub(super) fn new(
        energy: &StretchEnergy,
        rings: &OneRings,
        remaining: &'a [u32],
        at: &[Uv],
    ) -> Self {
        let (rings, _) = rings.renumbered(remaining);
        let groups = relax::groups(&rings, 0..remaining.len() as u32);
        SweepMesh {
            points: remaining.iter().map(|&v| energy.points[v as usize]).collect(),
            weights: remaining.iter().map(|&v| energy.weights[v as usize]).collect(),
            freedom: remaining.iter().map(|&v| energy.freedom[v as usize]).collect(),
            places: remaining.iter().map(|&v| AtomicUv::new(at[v as usize])).collect(),
            convex_weight: energy.convex_weight,
            rings,
            groups,
            remaining,
        }
    }

    /// Moves every vertex once. Returns the numbers, in the whole mesh, of the vertices that moved
    /// far relative to the size of their triangles.
    pub(crate) fn sweep(&self) -> Vec<u32> {
        let energy = StretchEnergy {
            points: &self.points,
            weights: &self.weights,
            freedom: &self.freedom,
            convex_weight: self.convex_weight,
        };
        let moved = |chunk: &[u32]| {
            let (mut corners, mut far) = (Vec::new(), Vec::new());
            for &v in chunk {
                // No other vertex of the group is a neighbour.
                let at = |w: u32| self.places[w as usize].get();
                let (to, is_far) = relax::moved(&energy, &self.rings, v, at, &mut corners);
                self.places[v as usize].set(to);
                if is_far {
                    far.push(self.remaining[v as usize]);
                }
            }
            far
        };
        let of =
            |group: &Vec<u32>| -> Vec<Vec<u32>> { group.par_chunks(CHUNK).map(moved).collect() };
        self.groups.iter().flat_map(of).flatten().collect()
    }

    /// Writes the positions into those of the whole mesh.
    pub(crate) fn put_back(&self, at: &mut [Uv]) {
        self.remaining
            .iter()
            .zip(&self.places)
            .for_each(|(&v, place)| at[v as usize] = place.get());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::one_rings::tests::grid;

    #[test]
    fn vertices_move_as_where_they_lie_among_the_others() {
        let n = 40;
        let patch = grid(n);
        let mut rings = OneRings::new(&patch.mesh, &patch.outer);
        let out: Vec<u32> =
            (0..n).map(|i| i * (n + 1)).filter(|v| !rings.on_boundary(*v)).collect();
        for &v in out.iter().step_by(2) {
            let collapse = rings.collapse(v, 0).unwrap();
            rings.apply(&[collapse]);
        }
        let remaining: Vec<u32> = (0..n * n).filter(|&v| !rings.ring(v).is_empty()).collect();
        let freedom: Vec<Freedom> = (0..n * n)
            .map(|v| if rings.on_boundary(v) { Freedom::None } else { Freedom::Full })
            .collect();
        let weights: Vec<f64> = (0..n * n).map(|v| 1.0 + f64::from(v % 7)).collect();
        let energy = StretchEnergy {
            points: &patch.mesh.points,
            weights: &weights,
            freedom: &freedom,
            convex_weight: 0.25,
        };
        let start: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y)).collect();
        let (mut whole, mut brought) = (start.clone(), start.clone());
        let groups = relax::groups(&rings, remaining.iter().copied());
        let sweeping = SweepMesh::new(&energy, &rings, &remaining, &start);
        for _ in 0..3 {
            let far = relax::sweep(&energy, &rings, &groups, &mut whole);
            assert_eq!(sweeping.sweep(), far);
        }
        sweeping.put_back(&mut brought);
        assert_eq!(whole, brought);
        assert!(whole != start && remaining.len() < start.len());
    }
}
