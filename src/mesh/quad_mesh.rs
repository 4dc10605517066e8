//! A closed mesh of quads that is divided into square blocks.

use std::collections::HashMap;

use crate::geometry::{Point, Uv, Vector, VertexId};

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

    /// The mesh with all lengths multiplied by a factor.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.points.iter_mut().for_each(|p| *p *= factor);
        self
    }

    /// The normal at a place on the unit square of a quad, between those of its corners. Its length is
    /// not 1.
    pub fn normal(&self, quad: usize, at: Uv) -> Vector {
        let [a, b, c, d] = self.quads[quad].map(|v| self.normals[v.index()]);
        a.lerp(&b, at.x).lerp(&d.lerp(&c, at.x), at.y)
    }

    /// The same at a place of a block, with coordinates from 0 to `side`.
    pub fn block_normal(&self, block: usize, at: Uv) -> Vector {
        let n = self.side;
        let cell = |x: f64| (x.max(0.0) as usize).min(n - 1);
        let (i, j) = (cell(at.x), cell(at.y));
        self.normal(n * n * block + n * j + i, Uv::new(at.x - i as f64, at.y - j as f64))
    }

    /// The vertex at corner `k` of a block, counter-clockwise from (0, 0).
    pub fn corner(&self, block: usize, k: usize) -> VertexId {
        let n = self.side;
        let (i, j) = [(0, 0), (n, 0), (n, n), (0, n)][k];
        self.vertex(block, i, j)
    }

    /// The mesh with each quad divided into four. `vertices` are the new places of the vertices, and
    /// `middle` makes the vertex on side k of a quad. The vertices in the middles of sides follow
    /// the old ones, and those in the middles of quads come last. The new points in the quads are
    /// the means of the old corners, and the normals are not kept.
    pub(crate) fn divided(
        &self,
        vertices: Vec<Point>,
        middle: impl Fn(usize, usize) -> Point,
    ) -> Self {
        let mut points = vertices;
        let mut middles = HashMap::new();
        let mut of_quads = Vec::with_capacity(self.quads.len());
        for (number, quad) in self.quads.iter().enumerate() {
            of_quads.push([0, 1, 2, 3].map(|k| {
                let (a, b) = (quad[k], quad[(k + 1) % 4]);
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push(middle(number, k));
                    VertexId::from(points.len() - 1)
                })
            }));
        }
        let first = points.len();
        points.extend(self.quads.iter().map(|quad| {
            let sum: Vector = quad.iter().map(|v| self.points[v.index()].coords).sum();
            Point::from(0.25 * sum)
        }));
        let n = self.side;
        let small = |k: usize| {
            let (b, place) = (k / (4 * n * n), k % (4 * n * n));
            let (i, j) = (place % (2 * n), place / (2 * n));
            let q = n * n * b + n * (j / 2) + i / 2;
            let (corners, sides) = (self.quads[q], of_quads[q]);
            let centre = VertexId::from(first + q);
            match (i % 2, j % 2) {
                (0, 0) => [corners[0], sides[0], centre, sides[3]],
                (1, 0) => [sides[0], corners[1], sides[1], centre],
                (1, 1) => [centre, sides[1], corners[2], sides[2]],
                _ => [sides[3], centre, sides[2], corners[3]],
            }
        };
        let quads = (0..4 * self.quads.len()).map(small).collect();
        QuadMesh { points, normals: Vec::new(), quads, side: 2 * n }
    }

    /// The marked vertices, and all others of the quads around them.
    pub fn with_neighbours(&self, marked: &[bool]) -> Vec<bool> {
        let mut near = marked.to_vec();
        let beside = self.quads.iter().filter(|quad| quad.iter().any(|v| marked[v.index()]));
        beside.flatten().for_each(|v| near[v.index()] = true);
        near
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
        let valences = self.valences();
        let mut is_corner = vec![false; self.points.len()];
        for b in 0..self.blocks() {
            (0..4).for_each(|k| is_corner[self.corner(b, k).index()] = true);
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
