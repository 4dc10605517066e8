//! A disk stored as the one-rings of its vertices, with half-edge collapses and vertex splits.

use foldhash::{HashMap, HashSet};
use rayon::prelude::*;
use smallvec::SmallVec;

use super::edge_map::MOST_THREADS;
use super::{Mesh, VertexRings};
use crate::geometry::{NONE, VertexId};

/// The one-ring of a vertex, or a part of it. Almost all rings are short enough to be stored in
/// place. Behind pointers they would be scattered over the memory, because collapses happen all
/// over the mesh, and every access would wait for the memory.
pub(crate) type OneRing = SmallVec<[u32; 12]>;

/// The neighbours of every vertex in counter-clockwise order (its one-ring, the link of the
/// vertex). The ring of a boundary vertex starts at the next boundary vertex and ends at the
/// previous one. Two consecutive neighbours form a triangle with the vertex.
#[derive(Debug, Clone)]
pub(crate) struct OneRings {
    rings: Vec<OneRing>,
    boundary: Vec<bool>,
}

/// A half-edge collapse: a vertex is removed, and a fan from one of its neighbours, the apex,
/// replaces its triangles.
#[derive(Debug, Clone)]
pub(crate) struct HalfEdgeCollapse {
    /// The removed vertex.
    pub vertex: u32,
    /// Its ring. For an inner vertex it starts with the apex; for a boundary vertex it starts or
    /// ends with the apex.
    pub ring: OneRing,
    /// Whether the apex is the last entry.
    pub last: bool,
}

impl HalfEdgeCollapse {
    /// The apex of the fan, and the other vertices of the ring in counter-clockwise order.
    pub(crate) fn fan(&self) -> (u32, &[u32]) {
        match &self.ring[..] {
            [path @ .., apex] if self.last => (*apex, path),
            [apex, path @ ..] => (*apex, path),
            [] => (self.vertex, &[]),
        }
    }
}

impl OneRings {
    /// The one-rings of a disk with the given boundary.
    pub(crate) fn new(mesh: &Mesh, outer: &[VertexId]) -> Self {
        let corners = VertexRings::new(mesh);
        let mut boundary = vec![false; mesh.points.len()];
        outer.iter().for_each(|v| boundary[v.index()] = true);
        let ring = |v: usize| {
            let v = VertexId::from(v);
            let side = |t: &u32| {
                let t = mesh.triangles[*t as usize];
                let k = t.iter().position(|&w| w == v).unwrap_or(0);
                (t[(k + 1) % 3].0, t[(k + 2) % 3].0)
            };
            chained(corners.triangles(v).iter().map(side).collect())
        };
        OneRings { rings: (0..boundary.len()).into_par_iter().map(ring).collect(), boundary }
    }

    /// The one-rings of the vertices `left`, renumbered in their order. The second value gives the
    /// new number of each vertex, or [`NONE`] for vertices that are not left.
    pub(crate) fn renumbered(&self, left: &[u32]) -> (Self, Vec<u32>) {
        let mut number = vec![NONE; self.len()];
        left.iter().zip(0..).for_each(|(&v, new)| number[v as usize] = new);
        let ring = |v: &u32| self.ring(*v).iter().map(|&w| number[w as usize]).collect();
        let rings = OneRings {
            rings: left.par_iter().map(ring).collect(),
            boundary: left.iter().map(|&v| self.on_boundary(v)).collect(),
        };
        (rings, number)
    }

    /// The number of vertices, including collapsed ones.
    pub(crate) fn len(&self) -> usize {
        self.rings.len()
    }

    /// The one-ring of a vertex; empty for a collapsed one.
    pub(crate) fn ring(&self, v: u32) -> &[u32] {
        &self.rings[v as usize]
    }

    /// Whether a vertex is on the boundary.
    pub(crate) fn on_boundary(&self, v: u32) -> bool {
        self.boundary[v as usize]
    }

    /// The other two corners of each triangle around a vertex.
    pub(crate) fn sides(&self, v: u32) -> impl Iterator<Item = (u32, u32)> + '_ {
        let ring = self.ring(v);
        let closing = if self.on_boundary(v) { None } else { ring.last().zip(ring.first()) };
        let pairs = ring.windows(2).map(|w| (w[0], w[1]));
        pairs.chain(closing.map(|(&a, &b)| (a, b)))
    }

    /// The collapse of `v` into its `k`-th neighbour. `None` if it would add an edge that already
    /// exists, or join two boundary vertices through the inside.
    pub(crate) fn collapse(&self, v: u32, k: usize) -> Option<HalfEdgeCollapse> {
        let mut ring = OneRing::from_slice(self.ring(v));
        let apex = ring[k];
        let last = self.on_boundary(v) && k + 1 == ring.len();
        match self.on_boundary(v) {
            true if ring.len() < 3 || !(k == 0 || last) => return None,
            true => (),
            false => ring.rotate_left(k),
        }
        let collapse = HalfEdgeCollapse { vertex: v, ring, last };
        let (_, path) = collapse.fan();
        // The ends of the path are already neighbours of the apex in the triangles of v.
        let closing = self.on_boundary(v);
        let new = if last { &path[..path.len() - 1] } else { &path[1..] };
        let new = if closing { new } else { &new[..new.len() - 1] };
        let over = if last { 0 } else { new.len().wrapping_sub(1) };
        let free = |(i, w): (usize, &u32)| {
            let along = closing && i == over;
            !self.ring(apex).contains(w)
                && (along || !(self.on_boundary(apex) && self.on_boundary(*w)))
        };
        new.iter().enumerate().all(free).then_some(collapse)
    }

    /// Makes collapses in the given order.
    pub(crate) fn apply(&mut self, collapses: &[HalfEdgeCollapse]) {
        self.in_parts(|part| collapses.iter().for_each(|collapse| part.apply(collapse)));
    }

    /// Undoes collapses by vertex splits, the last one first. All later collapses must already be
    /// undone.
    pub(crate) fn split(&mut self, collapses: &[HalfEdgeCollapse]) {
        self.in_parts(|part| collapses.iter().rev().for_each(|collapse| part.split(collapse)));
    }

    fn in_parts(&mut self, change: impl Fn(&mut RingSlice) + Sync) {
        // Each part reads all collapses.
        let parts = rayon::current_num_threads().min(MOST_THREADS);
        let share = self.rings.len().div_ceil(parts).max(1);
        let boundary = &self.boundary;
        self.rings.par_chunks_mut(share).enumerate().for_each(|(k, rings)| {
            change(&mut RingSlice { first: k * share, rings, boundary });
        });
    }
}

/// The rings of vertices with consecutive numbers.
struct RingSlice<'a> {
    first: usize,
    rings: &'a mut [OneRing],
    /// The boundary marks of all vertices.
    boundary: &'a [bool],
}

impl RingSlice<'_> {
    fn ring(&mut self, v: u32) -> Option<&mut OneRing> {
        self.rings.get_mut((v as usize).wrapping_sub(self.first))
    }

    /// Makes the changes of a collapse to these rings.
    fn apply(&mut self, collapse: &HalfEdgeCollapse) {
        let v = collapse.vertex;
        let (apex, path) = collapse.fan();
        let n = path.len();
        let inner = !self.boundary[v as usize];
        if let Some(ring) = self.ring(apex) {
            let at = position(ring, v);
            // The end of the path that is already a neighbour of the apex stays in the ring.
            let new = match (inner, collapse.last) {
                (true, _) => &path[1..n - 1],
                (false, false) => &path[1..],
                (false, true) => &path[..n - 1],
            };
            ring.remove(at);
            ring.insert_from_slice(at, new);
        }
        for (i, &w) in path.iter().enumerate() {
            let Some(ring) = self.ring(w) else { continue };
            let at = position(ring, v);
            let joined = (i == 0 && !collapse.last) || (i + 1 == n && (inner || collapse.last));
            if joined {
                ring.remove(at);
            } else {
                ring[at] = apex;
            }
        }
        if let Some(ring) = self.ring(v) {
            *ring = OneRing::new();
        }
    }

    /// Undoes the changes of a collapse to these rings.
    fn split(&mut self, collapse: &HalfEdgeCollapse) {
        let v = collapse.vertex;
        let (apex, path) = collapse.fan();
        let n = path.len();
        let inner = !self.boundary[v as usize];
        let at_boundary = self.boundary[apex as usize];
        if let Some(ring) = self.ring(apex) {
            match (inner, collapse.last) {
                (true, _) => {
                    let first = position(ring, path[0]);
                    if !at_boundary {
                        ring.rotate_left(first);
                    }
                    let first = position(ring, path[0]);
                    ring.drain(first + 1..first + n - 1);
                    ring.insert(first + 1, v);
                }
                (false, false) => {
                    let first = position(ring, path[0]);
                    ring.truncate(first + 1);
                    ring.push(v);
                }
                (false, true) => {
                    ring.drain(..n - 1);
                    ring.insert(0, v);
                }
            }
        }
        for (i, &w) in path.iter().enumerate() {
            let Some(ring) = self.ring(w) else { continue };
            let at = position(ring, apex);
            if i == 0 && !collapse.last {
                ring.insert(at, v);
            } else if i + 1 == n && (inner || collapse.last) {
                ring.insert(at + 1, v);
            } else {
                ring[at] = v;
            }
        }
        if let Some(ring) = self.ring(v) {
            ring.clone_from(&collapse.ring);
        }
    }
}

fn position(ring: &[u32], v: u32) -> usize {
    ring.iter().position(|&w| w == v).unwrap_or(0)
}

/// A ring with more sides is chained through a table. Searches in it take the square of their number.
const MOST_SEARCHED: usize = 100;

/// Chains the sides opposite to a vertex into its ring, as [`chained`] does, by a table of their ends.
fn chained_by_table(sides: &[(u32, u32)]) -> OneRing {
    let next: HashMap<u32, u32> = sides.iter().copied().collect();
    let ends: HashSet<u32> = sides.iter().map(|side| side.1).collect();
    let first = sides.iter().find(|side| !ends.contains(&side.0)).unwrap_or(&sides[0]).0;
    let mut ring = OneRing::new();
    let mut at = Some(first);
    while let Some(v) = at.filter(|_| ring.len() <= sides.len()) {
        ring.push(v);
        at = next.get(&v).copied().filter(|&v| v != first);
    }
    ring
}

/// Chains the sides opposite to a vertex into its ring.
fn chained(mut sides: SmallVec<[(u32, u32); 12]>) -> OneRing {
    if sides.len() > MOST_SEARCHED {
        return chained_by_table(&sides);
    }
    let first = sides.iter().position(|s| sides.iter().all(|t| t.1 != s.0)).unwrap_or(0);
    if sides.is_empty() {
        return OneRing::new();
    }
    sides.swap(0, first);
    for i in 1..sides.len() {
        if let Some(next) = (i..sides.len()).find(|&j| sides[j].0 == sides[i - 1].1) {
            sides.swap(i, next);
        }
    }
    let mut ring: OneRing = sides.iter().map(|s| s.0).collect();
    let last = sides[sides.len() - 1].1;
    if last != ring[0] {
        ring.push(last);
    }
    ring
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::mesh::Patch;

    /// A grid of n × n vertices.
    pub(crate) fn grid(n: u32) -> Patch {
        let points = (0..n * n).map(|i| Point::new(f64::from(i / n), f64::from(i % n), 0.0));
        let quads = (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| i * n + j));
        let halves = quads.flat_map(|a| [[a, a + n, a + n + 1], [a, a + n + 1, a + 1]]);
        let triangles: Vec<_> = halves.map(|t| t.map(VertexId)).collect();
        let side = |k: u32| {
            (0..n - 1)
                .map(move |i| [i * n, (n - 1) * n + i, n * n - 1 - i * n, n - 1 - i][k as usize])
        };
        let outer = (0..4).flat_map(side).map(VertexId).collect();
        Patch { outer, ..Patch::closed(Mesh { points: points.collect(), triangles }) }
    }

    #[test]
    fn long_rings_are_the_same_by_a_table() {
        let closed: SmallVec<[(u32, u32); 12]> =
            (0..9).map(|k| (5 * k % 9, 5 * (k + 1) % 9)).collect();
        for count in [9, 8] {
            let mut sides: SmallVec<[(u32, u32); 12]> = closed[..count].into();
            sides.reverse();
            assert_eq!(chained_by_table(&sides), chained(sides.clone()), "{count}");
        }
    }

    impl OneRings {
        /// `n` vertices, each of which is a neighbour of all others.
        pub(crate) fn joined(n: u32) -> OneRings {
            let ring = |v: u32| (0..n).filter(|&w| w != v).collect();
            OneRings { rings: (0..n).map(ring).collect(), boundary: vec![false; n as usize] }
        }
    }

    /// Checks that neighbourhood is symmetric and that consecutive neighbours of a vertex are
    /// neighbours.
    fn check(rings: &OneRings) {
        for v in 0..rings.len() as u32 {
            assert!(rings.ring(v).iter().all(|&w| rings.ring(w).contains(&v)), "{v}");
            assert!(rings.sides(v).all(|(a, b)| rings.sides(a).any(|side| side == (b, v))), "{v}");
        }
    }

    /// The rings, rotated so that the smallest entry comes first.
    fn turned(rings: &OneRings) -> Vec<Vec<u32>> {
        let turn = |v: u32| {
            let mut ring = rings.ring(v).to_vec();
            let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
            if !rings.on_boundary(v) {
                ring.rotate_left(least);
            }
            ring
        };
        (0..rings.len() as u32).map(turn).collect()
    }

    #[test]
    fn what_is_taken_out_can_be_put_back() {
        let patch = grid(7);
        let mut rings = OneRings::new(&patch.mesh, &patch.outer);
        let before = turned(&rings);
        let corners = [0, 6, 42, 48];
        let mut collapses = Vec::new();
        // Inner vertices are collapsed towards every neighbour, boundary vertices in both
        // directions.
        for round in 0..4 {
            for v in (0..49).map(|v| v * 11 % 49).filter(|v| !corners.contains(v)) {
                let ways = rings.ring(v).len();
                let collapse =
                    (0..ways).find_map(|k| rings.collapse(v, (k + round + v as usize) % ways));
                if let Some(collapse) = collapse {
                    rings.apply(std::slice::from_ref(&collapse));
                    check(&rings);
                    collapses.push(collapse);
                }
            }
        }
        assert!(collapses.len() >= 40, "{}", collapses.len());
        let (first, rest) = collapses.split_at(collapses.len() / 2);
        for collapse in rest.iter().rev() {
            rings.split(std::slice::from_ref(collapse));
            check(&rings);
        }
        rings.split(first);
        assert_eq!(turned(&rings), before);
    }
}
