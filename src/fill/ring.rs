//! The front's edges: closed rings of nodes, in the direction of the rim, with
//! a grid over space to find the near ones.
//!
//! A vertex may stand in several nodes, one for each gap around it that is
//! still open.

use foldhash::{HashMap, HashMapExt};

use super::blocks::meet;
use crate::geometry::{Point, VertexId};

/// A place on a ring: a vertex, and the edge that leaves it.
#[derive(Debug, Clone, Copy)]
struct Node {
    vertex: VertexId,
    at: Point,
    before: usize,
    after: usize,
    alive: bool,
}

/// The grid's cells, in mean edges.
const CELL: f64 = 3.0;

/// Closed rings of nodes.
#[derive(Debug)]
pub struct Rings {
    nodes: Vec<Node>,
    alive: usize,
    /// The nodes that were left at the last renewal, and those since.
    recent: Vec<usize>,
    /// Nodes, and the boxes of their edges, by the cells that these pass.
    grid: HashMap<u64, Vec<(usize, [Point; 2])>>,
    cell: f64,
}

impl Rings {
    /// Rings over `loops`.
    pub fn new(loops: &[Vec<(VertexId, Point)>]) -> Self {
        let (nodes, recent, grid) = (Vec::new(), Vec::new(), HashMap::new());
        let mut rings = Rings { nodes, alive: 0, recent, grid, cell: 1.0 };
        for ring in loops {
            let (first, n) = (rings.nodes.len(), ring.len());
            for (i, &(vertex, at)) in ring.iter().enumerate() {
                let (before, after) = (first + (i + n - 1) % n, first + (i + 1) % n);
                rings.nodes.push(Node { vertex, at, before, after, alive: true });
            }
            rings.alive += n;
            rings.recent.extend(first..first + n);
        }
        rings.renew();
        rings
    }

    /// Forgets the nodes that are no more, and fits the grid to the edges that
    /// are left.
    pub fn renew(&mut self) {
        self.recent = self.all().collect();
        let lengths = self.recent.iter().map(|&node| {
            let (p, q) = self.edge(node);
            (q - p).norm()
        });
        let cell = CELL * lengths.sum::<f64>() / self.alive.max(1) as f64;
        if cell > 0.0 {
            self.cell = cell;
        }
        self.grid.clear();
        for i in 0..self.recent.len() {
            self.enter(self.recent[i]);
        }
    }

    /// The number of nodes left.
    pub fn len(&self) -> usize {
        self.alive
    }

    /// The nodes left.
    pub fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.recent.iter().copied().filter(|&node| self.nodes[node].alive)
    }

    pub fn is_alive(&self, node: usize) -> bool {
        self.nodes[node].alive
    }

    pub fn vertex(&self, node: usize) -> VertexId {
        self.nodes[node].vertex
    }

    pub fn at(&self, node: usize) -> Point {
        self.nodes[node].at
    }

    pub fn after(&self, node: usize) -> usize {
        self.nodes[node].after
    }

    pub fn before(&self, node: usize) -> usize {
        self.nodes[node].before
    }

    /// The ends of the edge that leaves a node.
    pub fn edge(&self, node: usize) -> (Point, Point) {
        (self.at(node), self.at(self.after(node)))
    }

    /// The ring of a node, from it on.
    pub fn ring(&self, node: usize) -> Vec<usize> {
        let mut ring = vec![node];
        while self.after(ring[ring.len() - 1]) != node {
            ring.push(self.after(ring[ring.len() - 1]));
        }
        ring
    }

    /// Whether the ring of a node is a triangle.
    pub fn is_triangle(&self, node: usize) -> bool {
        self.after(self.after(self.after(node))) == node
    }

    /// Takes a node out and joins its neighbours.
    pub fn cut(&mut self, node: usize) {
        let Node { before, after, .. } = self.nodes[node];
        self.link(before, after);
        self.remove(node);
        self.enter(before);
    }

    /// Takes a ring's nodes out.
    pub fn drop_ring(&mut self, node: usize) {
        for node in self.ring(node) {
            self.remove(node);
        }
    }

    /// Puts a new vertex in the edge that leaves `node`; returns its node.
    pub fn insert(&mut self, node: usize, vertex: VertexId, at: Point) -> usize {
        let after = self.after(node);
        let new = self.push(vertex, at);
        self.link(node, new);
        self.link(new, after);
        self.enter(node);
        self.enter(new);
        new
    }

    /// Replaces the edge that leaves `node` by two, to and from the vertex of
    /// `apex`, which thereby stands in one node more: one ring becomes two, or
    /// two rings one.
    pub fn pinch(&mut self, node: usize, apex: usize) {
        let (after, before) = (self.after(node), self.before(apex));
        let new = self.push(self.vertex(apex), self.at(apex));
        self.link(node, apex);
        self.link(before, new);
        self.link(new, after);
        [node, before, new].into_iter().for_each(|node| self.enter(node));
    }

    /// Cuts the surface's gap open along a path from `from` to `to`, which are
    /// on two rings; `path` holds the inner vertices. The rings become one,
    /// with the path in it twice.
    pub fn bridge(&mut self, from: usize, to: usize, path: &[(VertexId, Point)]) {
        // … from  path  to … round … to'  path back  from' …
        let (after_from, before_to) = (self.after(from), self.before(to));
        let back_to = self.push(self.vertex(to), self.at(to));
        let back_from = self.push(self.vertex(from), self.at(from));
        let mut chain =
            |start: usize, end: usize, path: &mut dyn Iterator<Item = &(VertexId, Point)>| {
                let mut last = start;
                for &(vertex, at) in path {
                    let node = self.push(vertex, at);
                    self.link(last, node);
                    self.enter(last);
                    last = node;
                }
                self.link(last, end);
                self.enter(last);
            };
        chain(from, to, &mut path.iter());
        chain(back_to, back_from, &mut path.iter().rev());
        self.link(before_to, back_to);
        self.link(back_from, after_from);
        self.enter(before_to);
        self.enter(back_from);
    }

    /// The nodes whose edges may come within `radius` of `centre`, ascending.
    pub fn near(&self, centre: Point, radius: f64) -> Vec<usize> {
        // Of its cells much is farther away.
        let place = [-radius, radius].map(|r| centre.map(|x| x + r));
        // Edges may pass a cell between the places where they were entered.
        let reach = radius + 0.25 * self.cell;
        let [low, high] = [-reach, reach].map(|r| self.key(centre.map(|x| x + r)));
        let wide = (0..3).map(|k| f64::from(high[k] - low[k]) + 1.0).product::<f64>();
        if wide > self.alive as f64 {
            return self.all().filter(|&node| meet(&self.extent(node), &place)).collect();
        }
        let mut found = Vec::with_capacity(32);
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let here = self.grid.get(&packed([x, y, z])).into_iter().flatten();
                    let near = here.filter(|entry| meet(&entry.1, &place)).map(|entry| entry.0);
                    found.extend(near.filter(|&node| self.nodes[node].alive));
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        // Entries stay where an edge has been.
        found.retain(|&node| meet(&self.extent(node), &place));
        found
    }

    /// The box of the edge that leaves a node.
    fn extent(&self, node: usize) -> [Point; 2] {
        let (p, q) = self.edge(node);
        [p.inf(&q), p.sup(&q)]
    }

    fn push(&mut self, vertex: VertexId, at: Point) -> usize {
        let own = self.nodes.len();
        self.nodes.push(Node { vertex, at, before: own, after: own, alive: true });
        self.recent.push(own);
        self.alive += 1;
        own
    }

    fn remove(&mut self, node: usize) {
        self.nodes[node].alive = false;
        self.alive -= 1;
    }

    fn link(&mut self, before: usize, after: usize) {
        self.nodes[before].after = after;
        self.nodes[after].before = before;
    }

    fn key(&self, p: Point) -> [i32; 3] {
        [0, 1, 2].map(|k| (p[k] / self.cell).floor() as i32)
    }

    /// Enters a node's edge in the cells that it passes. Entries of edges that
    /// are no more stay; they are told by the nodes.
    fn enter(&mut self, node: usize) {
        let (p, q) = self.edge(node);
        let steps = (2.0 * (q - p).norm() / self.cell).ceil().max(1.0) as usize;
        let (mut last, extent) = (None, self.extent(node));
        for step in 0..=steps {
            let key = packed(self.key(p + (q - p) * (step as f64 / steps as f64)));
            if last != Some(key) {
                self.grid.entry(key).or_default().push((node, extent));
                last = Some(key);
            }
        }
    }
}

/// A cell's key; far cells may share it.
fn packed(cell: [i32; 3]) -> u64 {
    cell.into_iter().fold(0, |key, x| key << 21 | (x as u64 & 0x1f_ffff))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(first: u32, n: u32) -> Vec<(VertexId, Point)> {
        let at = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
            Point::new(f64::from(first) + angle.cos(), angle.sin(), 0.0)
        };
        (0..n).map(|i| (VertexId(first + i), at(i))).collect()
    }

    fn vertices(rings: &Rings, node: usize) -> Vec<u32> {
        rings.ring(node).iter().map(|&n| rings.vertex(n).0).collect()
    }

    #[test]
    fn a_pinch_splits_a_ring_and_joins_two() {
        let mut rings = Rings::new(&[polygon(0, 6)]);
        rings.pinch(0, 3);
        assert_eq!(vertices(&rings, 0), [0, 3, 4, 5]);
        assert_eq!(vertices(&rings, 1), [1, 2, 3]);
        assert!(rings.is_triangle(1));
        let mut rings = Rings::new(&[polygon(0, 3), polygon(10, 3)]);
        rings.pinch(0, 4);
        assert_eq!(vertices(&rings, 0), [0, 11, 12, 10, 11, 1, 2]);
    }

    #[test]
    fn a_bridge_makes_one_ring_of_two() {
        let mut rings = Rings::new(&[polygon(0, 3), polygon(10, 3)]);
        rings.bridge(0, 3, &[(VertexId(20), Point::origin())]);
        assert_eq!(vertices(&rings, 0), [0, 20, 10, 11, 12, 10, 20, 0, 1, 2]);
        assert_eq!(rings.len(), 10);
    }

    #[test]
    fn near_edges_are_found() {
        let mut rings = Rings::new(&[polygon(0, 200)]);
        assert!(rings.near(Point::new(1.0, 0.0, 0.0), 0.1).contains(&0));
        assert!(rings.near(Point::origin(), 0.2).is_empty());
        rings.cut(0);
        assert!(!rings.near(Point::new(1.0, 0.0, 0.0), 0.1).contains(&0));
        assert!(rings.near(Point::new(1.0, 0.0, 0.0), 0.1).contains(&199));
    }
}
