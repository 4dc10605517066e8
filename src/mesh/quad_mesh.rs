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
    pub(crate) fn normal(&self, quad: usize, at: Uv) -> Vector {
        let [a, b, c, d] = self.quads[quad].map(|v| self.normals[v.index()]);
        a.lerp(&b, at.x).lerp(&d.lerp(&c, at.x), at.y)
    }

    /// The same at a place of a block, with coordinates from 0 to `side`.
    pub(crate) fn block_normal(&self, block: usize, at: Uv) -> Vector {
        let (quad, at) = self.within(block, at);
        self.normal(quad, at)
    }

    /// The quad at a place of a block with coordinates from 0 to `side`, and the place on its unit square.
    pub(crate) fn within(&self, block: usize, at: Uv) -> (usize, Uv) {
        let n = self.side;
        let cell = |x: f64| (x.max(0.0) as usize).min(n - 1);
        let (i, j) = (cell(at.x), cell(at.y));
        (n * n * block + n * j + i, Uv::new(at.x - i as f64, at.y - j as f64))
    }

    /// The block of a quad, and the place of the quad's first corner in it.
    pub(crate) fn place(&self, quad: usize) -> (usize, Uv) {
        let n = self.side;
        let within = quad % (n * n);
        (quad / (n * n), Uv::new((within % n) as f64, (within / n) as f64))
    }

    /// The vertex at corner `k` of a block, counter-clockwise from (0, 0).
    pub(crate) fn corner(&self, block: usize, k: usize) -> VertexId {
        let n = self.side;
        let (i, j) = [(0, 0), (n, 0), (n, n), (0, n)][k];
        self.vertex(block, i, j)
    }

    /// Blocks of `side` × `side` quads with the same corners as those of this mesh: the quads, and for each
    /// vertex a block and its place there, with coordinates from 0 to the side of this mesh.
    pub(crate) fn with_side(&self, side: usize) -> (Vec<[VertexId; 4]>, Vec<(usize, Uv)>) {
        let mut places = Vec::new();
        let mut names = HashMap::new();
        let mut quads = Vec::with_capacity(side * side * self.blocks());
        let step = self.side as f64 / side as f64;
        for block in 0..self.blocks() {
            let mut vertex = |i: usize, j: usize| {
                let new = VertexId::from(places.len());
                let name = self.name(block, side, [i, j]);
                let number = *names.entry(name).or_insert(new);
                if number == new {
                    places.push((block, Uv::new(i as f64 * step, j as f64 * step)));
                }
                number
            };
            for (i, j) in (0..side * side).map(|k| (k % side, k / side)) {
                quads.push([
                    vertex(i, j),
                    vertex(i + 1, j),
                    vertex(i + 1, j + 1),
                    vertex(i, j + 1),
                ]);
            }
        }
        (quads, places)
    }

    /// A name for vertex (i, j) of a block with `side` × `side` quads that is the same in all blocks that
    /// have the vertex: two vertices of this mesh and a number.
    fn name(&self, block: usize, side: usize, [i, j]: [usize; 2]) -> [usize; 3] {
        let n = self.side;
        let corner = |at: usize| if at == 0 { Some(0) } else { (at == side).then_some(n) };
        match (corner(i), corner(j)) {
            (Some(i), Some(j)) => [self.vertex(block, i, j).index(), 0, 0],
            (None, None) => [block, side * j + i, usize::MAX],
            (fixed_i, fixed_j) => {
                let at = |t: usize| {
                    self.vertex(block, fixed_i.unwrap_or(t), fixed_j.unwrap_or(t)).index()
                };
                let step = if fixed_i.is_some() { j } else { i };
                // A side has two ends, and the first edge of one of them names it.
                let ends = [[at(0), at(1), step], [at(n), at(n - 1), side - step]];
                ends.into_iter().min().unwrap_or_default()
            }
        }
    }

    /// The marked vertices, and all others of the quads around them.
    pub(crate) fn with_neighbours(&self, marked: &[bool]) -> Vec<bool> {
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
    pub(crate) fn euler(&self) -> i64 {
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
