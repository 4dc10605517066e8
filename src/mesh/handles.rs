//! Topological noise: handles and tunnels of a few triangles.
//!
//! A component goes in. Its short loops that do not separate it are cut, and the two rims of each cut
//! are closed. Each cut takes one handle away.
//!
//! A loop does not separate a surface if it crosses some other loop an odd number of times. A tree
//! over the vertices and a tree over the triangles that crosses none of its edges leave two edges
//! for each handle, and each of these closes a loop of triangles (Eppstein, "Dynamic generators of
//! topologically embedded graphs", 2003). Each such loop has a random number, and the label of an
//! edge is the exclusive or of the numbers of all loops that cross it. Then the labels along a loop
//! of edges cancel if the loop separates the surface, and hardly ever otherwise. Around each vertex
//! at a labelled edge the shortest loop whose labels do not cancel is searched (Dijkstra's method).
//! Several loops are cut at once if they share no vertex and the labels of no group of them cancel.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet, VecDeque};

use rayon::prelude::*;

use super::boundary;
use super::build::Build;
use super::{EdgeMap, Mesh};
use crate::geometry::{Point, VertexId};
use crate::random::scattered;

/// A handle is cut, unless a length is named, if its loop is not longer than this multiple of the median
/// edge. The false handles of a scanned face have up to 3 edges around them, the holes of a casting with
/// few triangles 4.8 or more.
const EDGES: f64 = 4.0;

/// It is not cut if its loop is longer than this share of the diagonal, because the triangles of CAD parts
/// are long, and their real holes have few median edges around them. The false handles of a scanned face
/// have up to 0.025, real holes with few edges 0.074 or more.
const SHARE: f64 = 0.07;

/// A handle or a tunnel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Handle {
    /// The middle of the shortest loop that was found around it.
    pub at: Point,
    /// The length of this loop.
    pub length: f64,
}

impl Handle {
    fn of(mesh: &Mesh, ring: &[VertexId]) -> Self {
        let points: Vec<Point> = ring.iter().map(|&v| mesh.point(v)).collect();
        let next = points.iter().cycle().skip(1);
        let length = points.iter().zip(next).map(|(a, b)| (b - a).norm()).sum();
        Handle { at: Point::from(mean(&points)), length }
    }

    /// The same with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Handle { at: self.at * factor, length: self.length * factor }
    }
}

/// The longest loop that is cut if no length is named.
pub(super) fn longest(mesh: &Mesh) -> f64 {
    let edges = mesh.triangles.iter().map(|t| (mesh.point(t[1]) - mesh.point(t[0])).norm());
    let mut edges: Vec<f64> = edges.collect();
    let middle = edges.len() / 2;
    if edges.is_empty() {
        return 0.0;
    }
    let median = *edges.select_nth_unstable_by(middle, f64::total_cmp).1;
    (EDGES * median).min(SHARE * mesh.diagonal())
}

/// Cuts the handles of a two-sided component of the given genus whose loops are not longer than
/// `longest`.
pub(super) fn cut(build: &mut Build, longest: f64, genus: usize) -> Vec<Handle> {
    let mut handles = Vec::new();
    while handles.len() < genus {
        let rings = short_loops(&build.mesh, &build.edges, longest);
        if rings.is_empty() {
            break;
        }
        handles.extend(rings.iter().map(|ring| Handle::of(&build.mesh, ring)));
        open(build, &rings);
    }
    handles
}

/// The handles of a mesh, shortest loops first. Where loops of several handles cross, only the shorter ones
/// are listed.
pub fn handles(mesh: &Mesh) -> Vec<Handle> {
    let rings = short_loops(mesh, &EdgeMap::new(mesh), f64::INFINITY);
    rings.iter().map(|ring| Handle::of(mesh, ring)).collect()
}

fn mean(points: &[Point]) -> crate::geometry::Vector {
    points.iter().map(|p| p.coords).sum::<crate::geometry::Vector>() / points.len() as f64
}

/// The labelled edges of a component.
struct LabelledEdges<'a> {
    mesh: &'a Mesh,
    /// The edges at each vertex: the other end, and the side of a triangle that stands for the edge.
    at: Vec<Vec<(u32, u32)>>,
    /// The label of each side that stands for an edge.
    labels: Vec<u64>,
    is_boundary: Vec<bool>,
}

/// A loop that does not separate a component.
struct FoundLoop {
    length: f64,
    /// The exclusive or of its labels.
    label: u64,
    ring: Vec<VertexId>,
}

/// The shortest loops that together do not separate the component, do not meet its boundary and are not
/// longer than `longest`. They share no vertices.
fn short_loops(mesh: &Mesh, edges: &EdgeMap, longest: f64) -> Vec<Vec<VertexId>> {
    let Some(labelled) = LabelledEdges::new(mesh, edges) else { return Vec::new() };
    let of = |v: usize| labelled.at[v].iter().any(|&(_, side)| labelled.labels[side as usize] != 0);
    let seeds = (0..mesh.points.len()).filter(|&v| !labelled.is_boundary[v] && of(v));
    let seeds: Vec<usize> = seeds.collect();
    let found = seeds.into_par_iter().filter_map(|v| labelled.loop_at(v as u32, longest));
    let mut found: Vec<FoundLoop> = found.collect();
    // The sort is stable, so among equal loops the one of the lowest vertex comes first.
    found.sort_by(|a, b| a.length.total_cmp(&b.length));
    let mut taken = HashSet::new();
    let mut labels = IndependentLabels::default();
    let mut rings = Vec::new();
    for FoundLoop { label, ring, .. } in found {
        if ring.iter().all(|v| !taken.contains(v)) && labels.add(label) {
            // Neighbours are taken, too, so that no edge joins two loops.
            taken
                .extend(ring.iter().flat_map(|v| &labelled.at[v.index()]).map(|at| VertexId(at.0)));
            taken.extend(&ring);
            rings.push(ring);
        }
    }
    rings
}

/// Labels of which no group cancels, each reduced by the others (Gaussian elimination).
#[derive(Default)]
struct IndependentLabels(Vec<u64>);

impl IndependentLabels {
    /// Adds a label unless some of the others cancel it. Returns whether it was added.
    fn add(&mut self, label: u64) -> bool {
        let reduced = self.0.iter().fold(label, |label, other| label.min(label ^ other));
        if reduced != 0 {
            self.0.push(reduced);
            self.0.sort_unstable_by_key(|&label| Reverse(label));
        }
        reduced != 0
    }
}

impl<'a> LabelledEdges<'a> {
    /// `None` if the component has no handles.
    fn new(mesh: &'a Mesh, edges: &EdgeMap) -> Option<Self> {
        let sides = 3 * mesh.triangles.len();
        let stands = |side: usize| edges.across(side).map_or(side, |other| side.min(other));
        let ends = |side: usize| {
            let t = mesh.triangles[side / 3];
            [t[side % 3], t[(side % 3 + 1) % 3]]
        };
        let mut at = vec![Vec::new(); mesh.points.len()];
        let mut is_boundary = vec![false; mesh.points.len()];
        for side in (0..sides).filter(|&side| stands(side) == side) {
            let [a, b] = ends(side);
            at[a.index()].push((b.0, side as u32));
            at[b.index()].push((a.0, side as u32));
            if edges.across(side).is_none() {
                [a, b].into_iter().for_each(|v| is_boundary[v.index()] = true);
            }
        }
        let in_tree = spanning_tree(&at, mesh.triangles.first()?[0].index(), sides);
        // A cap closes each boundary loop.
        let mut faces: Vec<[u32; 2]> = (0..sides).map(|side| [side as u32 / 3; 2]).collect();
        let rims = boundary::boundary_loops(mesh, edges);
        let mut cap_of = HashMap::new();
        for (cap, rim) in rims.iter().enumerate() {
            cap_of.extend(rim.iter().map(|v| (*v, (mesh.triangles.len() + cap) as u32)));
        }
        for (side, beside) in faces.iter_mut().enumerate() {
            beside[1] = match edges.across(side) {
                Some(other) => other as u32 / 3,
                None => *cap_of.get(&ends(side)[0])?,
            };
        }
        let labels = labels(&faces, mesh.triangles.len() + rims.len(), |side| {
            stands(side) == side && !in_tree[side]
        })?;
        Some(LabelledEdges { mesh, at, labels, is_boundary })
    }

    /// The shortest loop through `first` whose labels do not cancel.
    fn loop_at(&self, first: u32, longest: f64) -> Option<FoundLoop> {
        let mut reached: HashMap<u32, Reached> = HashMap::new();
        let mut heap = BinaryHeap::new();
        let start = Reached { distance: 0.0, label: 0, parent: first, is_done: false };
        reached.insert(first, start);
        heap.push(Reverse((Distance(0.0), first)));
        let mut best: Option<(f64, u64, [u32; 2])> = None;
        while let Some(Reverse((Distance(distance), v))) = heap.pop() {
            let bound = best.map_or(longest, |best| best.0);
            if 2.0 * distance > bound {
                break;
            }
            let Some(here) = reached.get_mut(&v) else { break };
            if std::mem::replace(&mut here.is_done, true) {
                continue;
            }
            let here = *here;
            for &(w, side) in &self.at[v as usize] {
                if self.is_boundary[w as usize] {
                    continue;
                }
                let edge = (self.mesh.point(VertexId(w)) - self.mesh.point(VertexId(v))).norm();
                let label = here.label ^ self.labels[side as usize];
                let there = distance + edge;
                match reached.get(&w).copied() {
                    Some(other) if other.is_done => {
                        let length = there + other.distance;
                        if other.label != label && length <= best.map_or(longest, |best| best.0) {
                            best = Some((length, other.label ^ label, [v, w]));
                        }
                    }
                    Some(other) if other.distance <= there => {}
                    _ => {
                        let new = Reached { distance: there, label, parent: v, is_done: false };
                        reached.insert(w, new);
                        heap.push(Reverse((Distance(there), w)));
                    }
                }
            }
        }
        let (length, label, [a, b]) = best?;
        let way = |mut v: u32| {
            let mut way = vec![v];
            while v != first {
                v = reached[&v].parent;
                way.push(v);
            }
            way.reverse();
            way
        };
        let (a, b) = (way(a), way(b));
        // The ways begin together and part somewhere.
        let common = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
        let back = b[common..].iter().rev();
        let ring: Vec<VertexId> =
            a[common - 1..].iter().chain(back).map(|&v| VertexId(v)).collect();
        Some(FoundLoop { length, label, ring })
    }
}

/// A vertex that a search has reached.
#[derive(Debug, Clone, Copy)]
struct Reached {
    distance: f64,
    /// The exclusive or of the labels on the way.
    label: u64,
    parent: u32,
    is_done: bool,
}

/// A distance in the order of a heap.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Distance(f64);

impl Eq for Distance {}

impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Which sides stand for the edges of a tree over all vertices.
fn spanning_tree(at: &[Vec<(u32, u32)>], first: usize, sides: usize) -> Vec<bool> {
    let mut in_tree = vec![false; sides];
    let mut seen = vec![false; at.len()];
    seen[first] = true;
    let mut queue = VecDeque::from([first]);
    while let Some(v) = queue.pop_front() {
        for &(w, side) in &at[v] {
            if !std::mem::replace(&mut seen[w as usize], true) {
                in_tree[side as usize] = true;
                queue.push_back(w as usize);
            }
        }
    }
    in_tree
}

/// The labels of the sides. `faces` are those on both sides of each, and `is_free` says which sides
/// stand for edges that the tree of vertices does not have. `None` if no edge is left over.
fn labels(faces: &[[u32; 2]], count: usize, is_free: impl Fn(usize) -> bool) -> Option<Vec<u64>> {
    let free: Vec<usize> = (0..faces.len()).filter(|&side| is_free(side)).collect();
    let mut around = vec![Vec::new(); count];
    for &side in &free {
        let [a, b] = faces[side];
        around[a as usize].push((b, side));
        around[b as usize].push((a, side));
    }
    // The face before each face in the tree, and the side between them, in the order of the tree.
    let mut before: Vec<Option<(u32, usize)>> = vec![None; count];
    let mut order = vec![0usize];
    let mut seen = vec![false; count];
    seen[0] = true;
    let mut next = 0;
    while let Some(&face) = order.get(next) {
        next += 1;
        for &(other, side) in &around[face] {
            if !std::mem::replace(&mut seen[other as usize], true) {
                before[other as usize] = Some((face as u32, side));
                order.push(other as usize);
            }
        }
    }
    let mut in_tree = vec![false; faces.len()];
    before.iter().flatten().for_each(|&(_, side)| in_tree[side] = true);
    let mut labels = vec![0; faces.len()];
    let mut sums = vec![0u64; count];
    let mut random = 0u64;
    for &side in free.iter().filter(|&&side| !in_tree[side]) {
        random += 1;
        labels[side] = scattered(random);
        faces[side].into_iter().for_each(|face| sums[face as usize] ^= labels[side]);
    }
    if random == 0 {
        return None;
    }
    // The loop of a left-over edge crosses the sides above which exactly one of its faces is.
    for &face in order.iter().rev() {
        if let Some((parent, side)) = before[face] {
            labels[side] = sums[face];
            sums[parent as usize] ^= sums[face];
        }
    }
    Some(labels)
}

/// Cuts a component along loops without common vertices and closes both rims of each.
fn open(build: &mut Build, rings: &[Vec<VertexId>]) {
    let on_rings: HashSet<VertexId> = rings.iter().flatten().copied().collect();
    let mut side_of = HashMap::new();
    for side in 0..3 * build.mesh.triangles.len() {
        let t = build.mesh.triangles[side / 3];
        let ends = (t[side % 3], t[(side % 3 + 1) % 3]);
        if on_rings.contains(&ends.0) && on_rings.contains(&ends.1) {
            side_of.insert(ends, side);
        }
    }
    let moved: Vec<_> = rings.iter().map(|ring| right_corners(build, &side_of, ring)).collect();
    for (ring, corners) in rings.iter().zip(moved) {
        let copies: Vec<VertexId> =
            ring.iter().map(|&v| add_vertex(build, build.mesh.point(v))).collect();
        for (side, i) in corners {
            build.mesh.triangles[side / 3][side % 3] = copies[i];
        }
        let backwards: Vec<VertexId> = ring.iter().rev().copied().collect();
        let rims = [close(build, backwards), close(build, copies)];
        retract(&mut build.mesh, &rims);
    }
    build.edges = EdgeMap::new(&build.mesh);
}

/// The corners to the right of a loop, each with the position of its vertex in the loop.
fn right_corners(
    build: &Build,
    side_of: &HashMap<(VertexId, VertexId), usize>,
    ring: &[VertexId],
) -> Vec<(usize, usize)> {
    let n = ring.len();
    let mut corners = Vec::new();
    for i in 0..n {
        let (before, v, after) = (ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]);
        // Counter-clockwise from the triangle to the right of the side that arrives.
        let mut corner = side_of.get(&(v, before)).copied();
        while let Some(side) = corner {
            corners.push((side, i));
            let arrives = side / 3 * 3 + (side % 3 + 2) % 3;
            let from = build.mesh.triangles[side / 3][(side % 3 + 2) % 3];
            corner = if from == after { None } else { build.edges.across(arrives) };
        }
    }
    corners
}

/// The number of steps in which a stump is drawn back. It is then a hundredth as long, or shorter.
const RETRACTIONS: usize = 12;

/// Draws the stump of a handle back to where the handle began. The other rim, which moves less when it
/// is drawn to its neighbours, belongs to the surface and stays.
fn retract(mesh: &mut Mesh, rims: &[Vec<VertexId>; 2]) {
    let drawn = rims.each_ref().map(|rim| {
        let mut neighbours: HashMap<VertexId, Vec<VertexId>> = HashMap::new();
        for t in &mesh.triangles {
            for k in (0..3).filter(|&k| rim.contains(&t[k])) {
                neighbours.entry(t[k]).or_default().extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
            }
        }
        let mut at: HashMap<VertexId, Point> = HashMap::new();
        for _ in 0..RETRACTIONS {
            let place = |v: &VertexId| at.get(v).copied().unwrap_or_else(|| mesh.point(*v));
            let moved = |v: &VertexId| {
                let around: Vec<Point> = neighbours.get(v)?.iter().map(place).collect();
                Some((*v, Point::from(mean(&around))))
            };
            at = rim.iter().filter_map(moved).collect();
        }
        let off: f64 = at.iter().map(|(&v, p)| (p - mesh.point(v)).norm()).sum();
        (off, at)
    });
    let stump = usize::from(drawn[1].0 > drawn[0].0);
    for (v, &p) in &drawn[stump].1 {
        mesh.points[v.index()] = p;
    }
}

/// Adds a vertex at a place of its own.
fn add_vertex(build: &mut Build, p: Point) -> VertexId {
    let place = build.place.iter().max().map_or(0, |&last| last + 1);
    build.mesh.points.push(p);
    build.place.push(place);
    VertexId::from(build.mesh.points.len() - 1)
}

/// Closes a rim with a triangle, or with a fan around its middle. Returns the corners.
fn close(build: &mut Build, mut rim: Vec<VertexId>) -> Vec<VertexId> {
    if let [a, b, c] = rim[..] {
        build.mesh.triangles.push([a, b, c]);
        return rim;
    }
    let points: Vec<Point> = rim.iter().map(|&v| build.mesh.point(v)).collect();
    let middle = add_vertex(build, Point::from(mean(&points)));
    for (i, &v) in rim.iter().enumerate() {
        build.mesh.triangles.push([v, rim[(i + 1) % rim.len()], middle]);
    }
    rim.push(middle);
    rim
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;

    /// A torus of `n` × `m` vertices.
    fn torus(n: usize, m: usize) -> Build {
        let mut mesh = Mesh::default();
        for (i, j) in (0..n * m).map(|k| (k / m, k % m)) {
            let [u, v] = [(i, n), (j, m)].map(|(i, n)| std::f64::consts::TAU * i as f64 / n as f64);
            let reach = 4.0 + v.cos();
            mesh.points.push(Point::new(reach * u.cos(), reach * u.sin(), v.sin()));
            let name = |i: usize, j: usize| VertexId::from((i % n) * m + j % m);
            let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        let place = (0..mesh.points.len() as u32).collect();
        Build::new(mesh, place, 1.0)
    }

    #[test]
    fn a_torus_is_cut_around_its_tube() {
        let mut build = torus(40, 12);
        assert!(cut(&mut build, 6.0, 1).is_empty(), "the tube is 6.2 mm around");
        let handles = cut(&mut build, 6.3, 1);
        assert_eq!(handles.len(), 1);
        assert!((handles[0].length - 24.0 * (std::f64::consts::PI / 12.0).sin()).abs() < 1e-9);
        let distance = handles[0].at.coords.norm();
        assert!((distance - 4.0).abs() < 1e-9, "{distance}");
        let topology = Topology::new(&build.mesh, &build.edges, true);
        assert_eq!((topology.genus(), topology.loops), (0.0, 0));
        assert!(build.edges.is_oriented(&build.mesh));
    }

    #[test]
    fn a_tube_with_open_ends_has_no_handle() {
        let mut build = torus(40, 12);
        build.mesh.triangles.truncate(24 * 30);
        build.edges = EdgeMap::new(&build.mesh);
        assert!(cut(&mut build, 100.0, 9).is_empty());
    }

    #[test]
    fn a_torus_with_a_window_is_cut_too() {
        let mut build = torus(40, 12);
        build.mesh.triangles.truncate(24 * 40 - 9);
        build.edges = EdgeMap::new(&build.mesh);
        assert_eq!(cut(&mut build, 7.0, 9).len(), 1);
        let topology = Topology::new(&build.mesh, &build.edges, true);
        assert_eq!((topology.genus(), topology.loops), (0.0, 1));
    }
}
