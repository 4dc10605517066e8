//! The edges of a component with labels that tell which loops do not separate it.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, VecDeque};

use crate::geometry::random::scattered;
use crate::geometry::{NONE, OrderedFloat, Point, VertexId};
use crate::mesh::{EdgeMap, Mesh, Neighbours, boundary};

/// The labelled edges of a component, and short chords across its boundary loops. A chord stands for a way
/// over a cap that closes the loop.
pub(super) struct LabelledEdges<'a> {
    mesh: &'a Mesh,
    /// The edges and chords at each vertex.
    pub at: Vec<Vec<LabelledEdge>>,
    /// The boundary loop of each vertex, or [`NONE`].
    pub rim: Vec<u32>,
}

/// An edge or a chord that begins at some vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct LabelledEdge {
    /// The other end.
    pub to: u32,
    pub label: u64,
    pub is_chord: bool,
}

/// A loop that does not separate a component.
pub(super) struct FoundLoop {
    pub length: f64,
    /// The exclusive or of its labels.
    pub label: u64,
    pub ring: Vec<VertexId>,
}

impl<'a> LabelledEdges<'a> {
    /// Labels the edges, and the chords that are not longer than `chord`. If there is no such length, edges at
    /// the boundary are left out, too. `None` if the component has no handles.
    pub(super) fn new(mesh: &'a Mesh, edges: &EdgeMap, chord: Option<f64>) -> Option<Self> {
        let sides = 3 * mesh.triangles.len();
        let stands = |side: usize| edges.across(side).map_or(side, |other| side.min(other));
        let ends = |side: usize| {
            let t = mesh.triangles[side / 3];
            [t[side % 3], t[(side % 3 + 1) % 3]]
        };
        let mut sides_at = vec![Vec::new(); mesh.points.len()];
        for side in (0..sides).filter(|&side| stands(side) == side) {
            let [a, b] = ends(side);
            sides_at[a.index()].push((b.0, side as u32));
            sides_at[b.index()].push((a.0, side as u32));
        }
        let in_tree = spanning_tree(&sides_at, mesh.triangles.first()?[0].index(), sides);
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
        let labelled = |&(to, side): &(u32, u32)| {
            let label = labels[side as usize];
            LabelledEdge { to, label, is_chord: false }
        };
        let at = sides_at.iter().map(|sides| sides.iter().map(labelled).collect()).collect();
        let mut all = LabelledEdges { mesh, at, rim: vec![NONE; mesh.points.len()] };
        for (number, rim) in rims.iter().enumerate() {
            rim.iter().for_each(|v| all.rim[v.index()] = number as u32);
            chord.into_iter().for_each(|longest| all.add_chords(rim, longest));
        }
        if chord.is_none() {
            all.leave_out_boundary();
        }
        Some(all)
    }

    fn leave_out_boundary(&mut self) {
        let rim = &self.rim;
        for (v, edges) in self.at.iter_mut().enumerate() {
            edges.retain(|edge| rim[v] == NONE && rim[edge.to as usize] == NONE);
        }
    }

    /// Adds the chords of a boundary loop that are not longer than `longest`. The way over the cap between
    /// two vertices has the label of the way along the loop.
    fn add_chords(&mut self, rim: &[VertexId], longest: f64) {
        let points: Vec<Point> = rim.iter().map(|&v| self.mesh.point(v)).collect();
        let near = Neighbours::new(&points);
        let mut from_first = vec![0u64];
        for pair in rim.windows(2) {
            let along = self.at[pair[0].index()].iter().find(|edge| edge.to == pair[1].0);
            let so_far = from_first[from_first.len() - 1];
            from_first.push(so_far ^ along.map_or(0, |edge| edge.label));
        }
        let mut found = Vec::new();
        for (i, &v) in rim.iter().enumerate() {
            near.within(points[i], longest, &mut found);
            let others = found.iter().map(|&j| j as usize).filter(|&j| j != i);
            self.at[v.index()].extend(others.map(|j| {
                let label = from_first[i] ^ from_first[j];
                LabelledEdge { to: rim[j].0, label, is_chord: true }
            }));
        }
    }

    /// The shortest loop through `first` whose labels do not cancel.
    pub(crate) fn loop_at(&self, first: u32, longest: f64) -> Option<FoundLoop> {
        let mut reached: HashMap<u32, Reached> = HashMap::new();
        let mut heap = BinaryHeap::new();
        let start = Reached { distance: 0.0, label: 0, parent: first, is_done: false };
        reached.insert(first, start);
        heap.push(Reverse((OrderedFloat(0.0), first)));
        let mut best: Option<(f64, u64, [u32; 2])> = None;
        while let Some(Reverse((OrderedFloat(distance), v))) = heap.pop() {
            let bound = best.map_or(longest, |best| best.0);
            if 2.0 * distance > bound {
                break;
            }
            let Some(here) = reached.get_mut(&v) else { break };
            if std::mem::replace(&mut here.is_done, true) {
                continue;
            }
            let here = *here;
            for &LabelledEdge { to: w, label, .. } in &self.at[v as usize] {
                let edge = (self.mesh.point(VertexId(w)) - self.mesh.point(VertexId(v))).norm();
                let label = here.label ^ label;
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
                        heap.push(Reverse((OrderedFloat(there), w)));
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
