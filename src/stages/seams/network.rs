//! Chains of mesh edges between two patches, and the loops of each patch.

use super::Work;
use super::arches::Arch;
use super::fallback::SeamFault;
use crate::geometry::{Point, Vector, VertexId};
use crate::primitives::Primitive;
use crate::primitives::contact::touch;

/// Mesh edges between the same two patches. The left one is on the left of the direction, seen from outside.
#[derive(Debug, Clone)]
pub(super) struct Chain {
    pub left: usize,
    pub right: usize,
    /// The mesh vertices. Of a closed chain the first and the last are the same.
    pub mesh_vertices: Vec<u32>,
    /// Points on both surfaces, ends included.
    pub points: Vec<Point>,
    /// The vertices at the ends. A closed chain has none until its start is chosen.
    pub ends: Option<[usize; 2]>,
    /// Whether the surfaces touch instead of crossing.
    pub touches: bool,
    /// The edge between a facet and a curved face, as a whole, and the plane that it lies in.
    pub arch: Option<Arch>,
    pub upright: Option<Primitive>,
    /// The directions at its ends, if they are known.
    pub tangents: [Option<Vector>; 2],
    /// The largest error of its mesh vertices.
    pub error: f64,
}

impl Chain {
    /// Whether the first and the last point are the same.
    pub(super) fn is_closed(&self) -> bool {
        self.ends.is_none_or(|[a, b]| a == b)
    }
}

/// One use of a chain in a loop: its number and whether it runs forward.
pub(super) type ChainUse = (usize, bool);

/// The chains and loops of all patches.
#[derive(Debug, Default)]
pub(super) struct ChainNetwork {
    pub chains: Vec<Chain>,
    /// For each patch its loops, with the patch on the left.
    pub loops: Vec<Vec<Vec<ChainUse>>>,
    /// The vertices of the solid.
    pub vertices: Vec<Point>,
    /// The mesh vertex that each of the first vertices is.
    pub junctions: Vec<u32>,
}

impl ChainNetwork {
    /// The place of a mesh vertex at which chains end.
    pub(super) fn junction_place(&self, v: VertexId) -> Option<Point> {
        let number = self.junctions.binary_search(&v.0).ok()?;
        Some(self.vertices[number])
    }
}

impl Work<'_> {
    fn is_border(&self, side: usize) -> bool {
        self.across(side) != self.of_triangle[side / 3]
    }

    /// The patch on the other side of a side of a triangle.
    fn across(&self, side: usize) -> usize {
        let twin = self.edges.across(side);
        twin.map_or_else(|| self.stretch_across(side), |twin| self.of_triangle[twin / 3])
    }

    /// The next border side of the same patch.
    fn next_border(&self, side: usize) -> Option<usize> {
        let after = |side: usize| 3 * (side / 3) + (side + 1) % 3;
        let mut next = after(side);
        // No vertex has more sides than the mesh.
        for _ in 0..3 * self.mesh.triangles.len() {
            if self.is_border(next) {
                return Some(next);
            }
            next = after(self.edges.across(next)?);
        }
        None
    }

    /// Finds chains and loops.
    pub(super) fn network(&self) -> Result<ChainNetwork, SeamFault> {
        let count = 3 * self.mesh.triangles.len();
        let is_junction = self.junctions();
        let start = |side: usize| self.mesh.side(side).0.index();
        let end = |side: usize| self.mesh.side(side).1.index();
        let mut network = ChainNetwork::default();
        let mut number = vec![usize::MAX; self.mesh.points.len()];
        for v in (0..is_junction.len()).filter(|&v| is_junction[v]) {
            number[v] = network.vertices.len();
            network.vertices.push(self.mesh.points[v]);
            network.junctions.push(v as u32);
        }
        let mut is_done = vec![false; count];
        // The chain that begins with a side, in one of its directions.
        let mut begins: Vec<Option<ChainUse>> = vec![None; count];
        let mut lasts: Vec<[usize; 2]> = Vec::new();
        let borders: Vec<usize> = (0..count).filter(|&side| self.is_border(side)).collect();
        let at_junctions = borders.iter().filter(|&&side| is_junction[start(side)]);
        for &first in at_junctions.chain(&borders) {
            if is_done[first] {
                continue;
            }
            let mut sides = vec![first];
            let mut last = first;
            while !is_junction[end(last)] && end(last) != start(first) {
                let lost =
                    || SeamFault::new(&[self.of_triangle[first / 3]], "a border without an end");
                last = self.next_border(last).ok_or_else(lost)?;
                sides.push(last);
            }
            let twin = |side: usize| self.edges.across(side).unwrap_or(side);
            for &side in &sides {
                is_done[side] = true;
                is_done[twin(side)] = true;
            }
            let of = network.chains.len();
            // At a rim there is nothing that runs back.
            begins[twin(last)] = Some((of, false));
            begins[first] = Some((of, true));
            lasts.push([last, twin(first)]);
            let mut mesh_vertices: Vec<u32> = sides.iter().map(|&s| start(s) as u32).collect();
            mesh_vertices.push(end(last) as u32);
            let ends = is_junction[start(first)].then(|| [number[start(first)], number[end(last)]]);
            let error = |v: &u32| self.errors[*v as usize];
            network.chains.push(Chain {
                left: self.of_triangle[first / 3],
                right: self.across(first),
                points: mesh_vertices.iter().map(|&v| self.mesh.points[v as usize]).collect(),
                error: mesh_vertices.iter().map(error).fold(0.0, f64::max),
                mesh_vertices,
                ends,
                touches: false,
                arch: None,
                upright: None,
                tangents: [None; 2],
            });
        }
        self.chain_loops(&mut network, &begins, &lasts)?;
        Ok(network)
    }

    fn chain_loops(
        &self,
        network: &mut ChainNetwork,
        begins: &[Option<ChainUse>],
        lasts: &[[usize; 2]],
    ) -> Result<(), SeamFault> {
        network.loops = vec![Vec::new(); self.patches.len()];
        let mut is_used = vec![[false; 2]; network.chains.len()];
        for chain in 0..network.chains.len() {
            for forward in [true, false] {
                let mut ring = Vec::new();
                let mut at = (chain, forward);
                let of = &network.chains[chain];
                let patch = if forward { of.left } else { of.right };
                if patch >= self.patches.len() {
                    continue;
                }
                while !is_used[at.0][usize::from(at.1)] {
                    is_used[at.0][usize::from(at.1)] = true;
                    ring.push(at);
                    let last = lasts[at.0][usize::from(!at.1)];
                    let next = self.next_border(last).and_then(|side| begins[side]);
                    at = next.ok_or_else(|| SeamFault::new(&[patch], "a loop that breaks off"))?;
                }
                if !ring.is_empty() {
                    let rings = self.simple_rings(network, patch, ring);
                    network.loops[patch].extend(rings);
                }
            }
        }
        Ok(())
    }

    /// Where chains end: not two borders meet, a facet has a corner, or surfaces that cross have one normal.
    fn junctions(&self) -> Vec<bool> {
        let mut borders = vec![0_u32; self.mesh.points.len()];
        let mut pair = vec![[usize::MAX; 2]; self.mesh.points.len()];
        // The ends of the two border edges at each vertex.
        let mut beside = vec![[usize::MAX; 2]; self.mesh.points.len()];
        let mut is_junction = vec![false; self.mesh.points.len()];
        for side in 0..3 * self.mesh.triangles.len() {
            let own = self.of_triangle[side / 3];
            let v = self.mesh.side(side).0.index();
            is_junction[v] |= match self.patches[own].free_form() {
                Some(form) => form.is_corner(v),
                None => self.patches[own].is_facet,
            };
            if self.is_border(side) {
                let other = self.across(side);
                let key = [own.min(other), own.max(other)];
                let end = self.mesh.side(side).1.index();
                beside[v][usize::from(own < other)] = end;
                // A side of a rim has no twin that begins at its end.
                let ends = std::iter::once(v).chain((other >= self.patches.len()).then_some(end));
                for v in ends {
                    borders[v] += 1;
                    is_junction[v] |= pair[v] != [usize::MAX; 2] && pair[v] != key;
                    pair[v] = key;
                }
            }
        }
        let is_end =
            |v: usize| is_junction[v] || borders[v] != 2 || self.is_contact(pair[v], v, beside[v]);
        (0..borders.len()).map(|v| borders[v] > 0 && is_end(v)).collect()
    }

    /// Whether two surfaces touch at a vertex of their border, and cross at the vertices beside it. The border has a corner there, as two branches
    /// of their seam meet.
    fn is_contact(&self, pair: [usize; 2], v: usize, beside: [usize; 2]) -> bool {
        let [Some(a), Some(b)] = pair.map(|i| self.patches.get(i)) else { return false };
        let touches = |v: usize| {
            let at = self.mesh.points.get(v);
            at.is_some_and(|&p| touch(&a.surface, &b.surface, &[p], self.errors[v]))
        };
        !a.is_facet && !b.is_facet && touches(v) && !beside.into_iter().any(touches)
    }
}
