//! The edges of the front: closed loops of nodes in the direction of the rim, and a
//! hash grid over space that finds the edges near a point.
//!
//! A vertex has one node for each gap around it that is still open, so it can have
//! several.

use foldhash::{HashMap, HashMapExt};

use crate::geometry::{Point, VertexId};
use crate::mesh::crossings::overlap;
use crate::stages::fill::CELL;

/// A vertex on a loop, and the edge from it to the next node.
#[derive(Debug, Clone, Copy)]
struct Node {
    vertex: VertexId,
    at: Point,
    before: usize,
    after: usize,
    alive: bool,
}

/// The closed loops of the front.
#[derive(Debug)]
pub(crate) struct FrontLoops {
    nodes: Vec<Node>,
    alive: usize,
    /// The nodes that were alive at the last call of `renew`, and all newer ones.
    recent: Vec<usize>,
    /// The nodes whose edges pass each cell, with the bounding boxes of these edges.
    grid: HashMap<u64, Vec<(usize, [Point; 2])>>,
    cell: f64,
}

impl FrontLoops {
    /// The loops of a front that has not advanced yet.
    pub(super) fn new(rims: &[Vec<(VertexId, Point)>]) -> Self {
        let (nodes, recent, grid) = (Vec::new(), Vec::new(), HashMap::new());
        let mut loops = FrontLoops { nodes, alive: 0, recent, grid, cell: 1.0 };
        for rim in rims {
            let (first, n) = (loops.nodes.len(), rim.len());
            for (i, &(vertex, at)) in rim.iter().enumerate() {
                let (before, after) = (first + (i + n - 1) % n, first + (i + 1) % n);
                loops.nodes.push(Node { vertex, at, before, after, alive: true });
            }
            loops.alive += n;
            loops.recent.extend(first..first + n);
        }
        loops.renew();
        loops
    }

    /// Forgets removed nodes, and fits the grid to the edges that are left.
    pub(crate) fn renew(&mut self) {
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

    /// The number of nodes that are alive.
    pub(crate) fn len(&self) -> usize {
        self.alive
    }

    /// The nodes that are alive.
    pub(super) fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.recent.iter().copied().filter(|&node| self.nodes[node].alive)
    }

    pub(crate) fn is_alive(&self, node: usize) -> bool {
        self.nodes[node].alive
    }

    pub(super) fn vertex(&self, node: usize) -> VertexId {
        self.nodes[node].vertex
    }

    pub(crate) fn at(&self, node: usize) -> Point {
        self.nodes[node].at
    }

    pub(crate) fn after(&self, node: usize) -> usize {
        self.nodes[node].after
    }

    pub(crate) fn before(&self, node: usize) -> usize {
        self.nodes[node].before
    }

    /// The ends of the edge from a node to the next one.
    pub(crate) fn edge(&self, node: usize) -> (Point, Point) {
        (self.at(node), self.at(self.after(node)))
    }

    /// The nodes of one loop in order, beginning with `node`.
    pub(crate) fn loop_from(&self, node: usize) -> Vec<usize> {
        let mut nodes = vec![node];
        while self.after(nodes[nodes.len() - 1]) != node {
            nodes.push(self.after(nodes[nodes.len() - 1]));
        }
        nodes
    }

    /// Whether the loop of a node is a triangle.
    pub(crate) fn is_triangle(&self, node: usize) -> bool {
        self.after(self.after(self.after(node))) == node
    }

    /// Removes a node and joins its neighbours.
    pub(crate) fn remove_node(&mut self, node: usize) {
        let Node { before, after, .. } = self.nodes[node];
        self.link(before, after);
        self.remove(node);
        self.enter(before);
    }

    /// Removes all nodes of a loop.
    pub(crate) fn remove_loop(&mut self, node: usize) {
        for node in self.loop_from(node) {
            self.remove(node);
        }
    }

    /// Inserts a new vertex after `node` and returns its node.
    pub(super) fn insert(&mut self, node: usize, vertex: VertexId, at: Point) -> usize {
        let after = self.after(node);
        let new = self.push(vertex, at);
        self.link(node, new);
        self.link(new, after);
        self.enter(node);
        self.enter(new);
        new
    }

    /// Replaces the edge after `node` by two edges, to and from the vertex of `apex`. That
    /// vertex gets one more node. One loop becomes two, or two loops become one.
    pub(crate) fn pinch(&mut self, node: usize, apex: usize) {
        let (after, before) = (self.after(node), self.before(apex));
        let new = self.push(self.vertex(apex), self.at(apex));
        self.link(node, apex);
        self.link(before, new);
        self.link(new, after);
        [node, before, new].into_iter().for_each(|node| self.enter(node));
    }

    /// Joins two loops along a path from node `from` on one to node `to` on the other.
    /// `path` has the vertices between the two. The joint loop passes the path twice, once
    /// in each direction.
    pub(crate) fn bridge(&mut self, from: usize, to: usize, path: &[(VertexId, Point)]) {
        // from, path, to, the rest of that loop, to again, path backwards, from again.
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

    /// The nodes whose edges can come within `radius` of `centre`, in ascending order.
    pub(crate) fn near(&self, centre: Point, radius: f64) -> Vec<usize> {
        // The cells reach farther than this box.
        let place = [-radius, radius].map(|r| centre.map(|x| x + r));
        // `enter` samples an edge every half cell, so it can miss a cell by a quarter.
        let reach = radius + 0.25 * self.cell;
        let [low, high] = [-reach, reach].map(|r| self.key(centre.map(|x| x + r)));
        let wide = (0..3).map(|k| f64::from(high[k] - low[k]) + 1.0).product::<f64>();
        if wide > self.alive as f64 {
            return self.all().filter(|&node| overlap(&self.extent(node), &place)).collect();
        }
        let mut found = Vec::with_capacity(32);
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let here = self.grid.get(&packed([x, y, z])).into_iter().flatten();
                    let near = here.filter(|entry| overlap(&entry.1, &place)).map(|entry| entry.0);
                    found.extend(near.filter(|&node| self.nodes[node].alive));
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        // The grid still has entries of edges that have changed.
        found.retain(|&node| overlap(&self.extent(node), &place));
        found
    }

    /// The bounding box of the edge after a node.
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

    /// Enters the edge after a node in the cells that it passes. Old entries stay; `near`
    /// drops them.
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

/// The key of a cell. Two cells that are far apart can have the same key.
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

    fn vertices(loops: &FrontLoops, node: usize) -> Vec<u32> {
        loops.loop_from(node).iter().map(|&n| loops.vertex(n).0).collect()
    }

    #[test]
    fn a_pinch_splits_a_loop_and_joins_two() {
        let mut loops = FrontLoops::new(&[polygon(0, 6)]);
        loops.pinch(0, 3);
        assert_eq!(vertices(&loops, 0), [0, 3, 4, 5]);
        assert_eq!(vertices(&loops, 1), [1, 2, 3]);
        assert!(loops.is_triangle(1));
        let mut loops = FrontLoops::new(&[polygon(0, 3), polygon(10, 3)]);
        loops.pinch(0, 4);
        assert_eq!(vertices(&loops, 0), [0, 11, 12, 10, 11, 1, 2]);
    }

    #[test]
    fn a_bridge_makes_one_loop_of_two() {
        let mut loops = FrontLoops::new(&[polygon(0, 3), polygon(10, 3)]);
        loops.bridge(0, 3, &[(VertexId(20), Point::origin())]);
        assert_eq!(vertices(&loops, 0), [0, 20, 10, 11, 12, 10, 20, 0, 1, 2]);
        assert_eq!(loops.len(), 10);
    }

    #[test]
    fn near_edges_are_found() {
        let mut loops = FrontLoops::new(&[polygon(0, 200)]);
        assert!(loops.near(Point::new(1.0, 0.0, 0.0), 0.1).contains(&0));
        assert!(loops.near(Point::origin(), 0.2).is_empty());
        loops.remove_node(0);
        assert!(!loops.near(Point::new(1.0, 0.0, 0.0), 0.1).contains(&0));
        assert!(loops.near(Point::new(1.0, 0.0, 0.0), 0.1).contains(&199));
    }
}
