//! A closed mesh of quads that is divided into square blocks.

use std::collections::HashMap;

use crate::geometry::{Point, Vector, VertexId};

/// A closed, oriented, edge-manifold mesh of quads. It consists of blocks of `side` × `side` quads,
/// and a vertex with other than four quads is a corner of blocks.
#[derive(Debug, Clone, Default)]
pub struct QuadMesh {
    /// Positions.
    pub points: Vec<Point>,
    /// Unit normals of the scan at the points. They point outwards.
    pub normals: Vec<Vector>,
    /// Corners of the quads, counter-clockwise seen from outside. The quads of a block follow each
    /// other in rows. Quad (i, j) of block b has the number `side² · b + side · j + i`. Its corners
    /// are at (i, j), (i + 1, j), (i + 1, j + 1) and (i, j + 1) of the block.
    pub quads: Vec<[VertexId; 4]>,
    /// The number of quads along each side of a block.
    pub side: usize,
}

impl QuadMesh {
    /// The number of blocks.
    pub fn blocks(&self) -> usize {
        self.quads.len() / (self.side * self.side)
    }

    /// The vertex at (i, j) of a block, with i and j from 0 to `side`.
    pub fn vertex(&self, block: usize, i: usize, j: usize) -> VertexId {
        let n = self.side;
        let quad = self.quads[n * n * block + n * j.min(n - 1) + i.min(n - 1)];
        quad[match (i == n, j == n) {
            (false, false) => 0,
            (true, false) => 1,
            (true, true) => 2,
            (false, true) => 3,
        }]
    }

    /// The number of quads at each vertex.
    pub fn valences(&self) -> Vec<usize> {
        let mut valences = vec![0; self.points.len()];
        self.quads.iter().flatten().for_each(|v| valences[v.index()] += 1);
        valences
    }

    /// The Euler number V − E + F.
    pub fn euler(&self) -> i64 {
        self.points.len() as i64 - self.quads.len() as i64
    }

    /// Checks what the type promises. Returns the first broken promise.
    pub fn fault(&self) -> Option<&'static str> {
        let n = self.side;
        if n == 0 || self.quads.is_empty() || !self.quads.len().is_multiple_of(n * n) {
            return Some("the quads do not make up whole blocks");
        }
        let mut sides = HashMap::new();
        for (number, quad) in self.quads.iter().enumerate() {
            for k in 0..4 {
                let ends = (quad[k], quad[(k + 1) % 4]);
                if ends.0 == ends.1 || sides.insert(ends, number).is_some() {
                    return Some("two quads have the same side in the same direction");
                }
            }
        }
        if sides.keys().any(|&(a, b)| !sides.contains_key(&(b, a))) {
            return Some("a side has a quad on one side only");
        }
        let inner = |b: usize, i: usize, j: usize| {
            let q = self.quads[n * n * b + n * j + i];
            q == [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.vertex(b, i, j))
        };
        if !(0..self.quads.len()).all(|q| inner(q / (n * n), q % n, q / n % n)) {
            return Some("the quads of a block are not in the order of its rows");
        }
        self.irregular_fault()
    }

    /// Checks that irregular vertices are corners of blocks, and that each vertex has one fan.
    fn irregular_fault(&self) -> Option<&'static str> {
        let n = self.side;
        let valences = self.valences();
        let mut is_corner = vec![false; self.points.len()];
        for b in 0..self.blocks() {
            for (i, j) in [(0, 0), (n, 0), (n, n), (0, n)] {
                is_corner[self.vertex(b, i, j).index()] = true;
            }
        }
        if (0..valences.len()).any(|v| valences[v] < 3) {
            return Some("a vertex has fewer than three quads");
        }
        if (0..valences.len()).any(|v| valences[v] != 4 && !is_corner[v]) {
            return Some("an irregular vertex is not a corner of a block");
        }
        let next: HashMap<_, _> = self
            .quads
            .iter()
            .flat_map(|q| (0..4).map(|k| ((q[k], q[(k + 1) % 4]), q[(k + 3) % 4])))
            .collect();
        let mut seen = vec![0; self.points.len()];
        for &(v, first) in next.keys() {
            if seen[v.index()] > 0 {
                continue;
            }
            let mut w = first;
            loop {
                seen[v.index()] += 1;
                w = next[&(v, w)];
                if w == first || seen[v.index()] > valences[v.index()] {
                    break;
                }
            }
        }
        (seen != valences).then_some("a vertex has several fans of quads")
    }
}
