//! Topological noise: handles and tunnels of a few triangles.
//!
//! A component goes in. Its short loops that do not separate it are cut, and the two rims of each cut
//! are closed. Each cut takes one handle away. After these, loops may run across the gaps of the component:
//! one that crosses a narrow bridge of triangles comes back over the gap. The triangles along such a
//! loop are left out, so that the gap becomes larger.
//!
//! A loop does not separate a surface if it crosses some other loop an odd number of times. A tree
//! over the vertices and a tree over the triangles that crosses none of its edges leave two edges
//! for each handle, and each of these closes a loop of triangles (Eppstein, "Dynamic generators of
//! topologically embedded graphs", 2003). Each such loop has a random number, and the label of an
//! edge is the exclusive or of the numbers of all loops that cross it. Then the labels along a loop
//! of edges cancel if the loop separates the surface, and hardly ever otherwise. Around each vertex
//! at a labelled edge the shortest loop whose labels do not cancel is searched (Dijkstra's method).
//! Several loops are cut at once if they share no vertex and the labels of no group of them cancel.

mod close;
mod labelled;

use std::cmp::Reverse;
use std::collections::HashSet;

use rayon::prelude::*;

use super::build::Build;
use super::components::pieces;
use super::{EdgeMap, Mesh, Topology};
use crate::geometry::{NONE, Point, Vector, VertexId};
use crate::statistics::median;
use labelled::{FoundLoop, LabelledEdges};

/// A handle is cut, unless a length is named, if its loop is not longer than this multiple of the median
/// edge. The false handles of a scanned face have up to 3 edges around them, the holes of a casting with
/// few triangles 4.8 or more.
const EDGES: f64 = 4.0;

/// It is not cut if its loop is longer than this share of the diagonal, because the triangles of CAD parts
/// are long, and their real holes have few median edges around them. The false handles of a scanned face
/// have up to 0.025, real holes with few edges 0.074 or more.
const SHARE: f64 = 0.07;

/// In the mesh of a cloud it is cut if its loop is not longer than this multiple of the median edge. Points that
/// are a radius or more apart do not tell a tube from noise: a triangulation is right where they are at
/// most half as far apart as the medial axis is away (Amenta and Bern, "Surface reconstruction by Voronoi
/// filtering", 1999), which is this number around a tube. With half as many, two of five real clouds keep
/// false handles. With twice as many these five stay the same, but tubes with 25 points around are cut.
const CLOUD_EDGES: f64 = 4.0 * std::f64::consts::PI;

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

/// The lengths up to which loops are cut, one after the other, if none is named.
pub(super) fn lengths(mesh: &Mesh, of_cloud: bool) -> Vec<f64> {
    let edge = median_edge(mesh);
    if of_cloud {
        vec![EDGES * edge, CLOUD_EDGES * edge]
    } else {
        vec![(EDGES * edge).min(SHARE * mesh.diagonal())]
    }
}

fn median_edge(mesh: &Mesh) -> f64 {
    let edges = mesh.triangles.iter().map(|t| (mesh.point(t[1]) - mesh.point(t[0])).norm());
    median(&mut edges.collect::<Vec<f64>>()).unwrap_or(0.0)
}

/// Cuts the handles of a two-sided component whose loops are not longer than `longest`.
pub(super) fn cut(build: &mut Build, longest: f64) -> Vec<Handle> {
    let mut handles = Vec::new();
    while Topology::new(&build.mesh, &build.edges, true).genus() > 0.0 {
        let inner = short_loops(&build.mesh, &build.edges, longest, None);
        if !inner.is_empty() {
            handles.extend(inner.iter().map(|ring| Handle::of(&build.mesh, ring)));
            close::cut_and_close(build, &inner);
            continue;
        }
        // The rest of a loop is at least as long as a chord of it.
        let bridges = short_loops(&build.mesh, &build.edges, longest, Some(0.5 * longest));
        let around = bridges.iter().map(|ring| Handle::of(&build.mesh, ring)).collect::<Vec<_>>();
        if bridges.is_empty() || !leave_out(build, &bridges) {
            break;
        }
        handles.extend(around);
    }
    handles
}

/// Leaves out the triangles along loops, and what hangs on the rest by single vertices only. Returns whether
/// any triangle would be left. If none would, all stay.
fn leave_out(build: &mut Build, rings: &[Vec<VertexId>]) -> bool {
    let on_rings: HashSet<VertexId> = rings.iter().flatten().copied().collect();
    let is_kept = |t: &[VertexId; 3]| t.iter().all(|v| !on_rings.contains(v));
    if !build.mesh.triangles.iter().any(is_kept) {
        return false;
    }
    build.mesh.triangles.retain(is_kept);
    build.edges = EdgeMap::new(&build.mesh);
    build.make_manifold();
    let largest = pieces(build).into_iter().next().unwrap_or_default();
    *build = build.part(&largest);
    true
}

/// The handles of a mesh, shortest loops first. Where loops of several handles cross, only the shorter ones
/// are listed.
pub(crate) fn handles(mesh: &Mesh) -> Vec<Handle> {
    let rings = short_loops(mesh, &EdgeMap::new(mesh), f64::INFINITY, None);
    rings.iter().map(|ring| Handle::of(mesh, ring)).collect()
}

fn mean(points: &[Point]) -> Vector {
    points.iter().map(|p| p.coords).sum::<Vector>() / points.len() as f64
}

/// The shortest loops that together do not separate the component and are not longer than `longest`. They
/// share no vertices. If the length of a `chord` is named, they may cross gaps by chords that are not longer.
/// Without one, they do not meet the boundary.
fn short_loops(
    mesh: &Mesh,
    edges: &EdgeMap,
    longest: f64,
    chord: Option<f64>,
) -> Vec<Vec<VertexId>> {
    let Some(labelled) = LabelledEdges::new(mesh, edges, chord) else { return Vec::new() };
    let seeds = (0..mesh.points.len()).filter(|&v| labelled.at[v].iter().any(|at| at.label != 0));
    let seeds: Vec<usize> = seeds.collect();
    let found = seeds.into_par_iter().filter_map(|v| labelled.loop_at(v as u32, longest));
    let mut found: Vec<FoundLoop> = found.collect();
    // The sort is stable, so among equal loops the one of the lowest vertex comes first.
    found.sort_by(|a, b| a.length.total_cmp(&b.length));
    let mut taken = HashSet::new();
    let mut taken_rims = HashSet::new();
    let mut labels = IndependentLabels::default();
    let mut rings = Vec::new();
    for FoundLoop { label, ring, .. } in found {
        let rims: HashSet<u32> =
            ring.iter().map(|v| labelled.rim[v.index()]).filter(|&rim| rim != NONE).collect();
        // Two loops over one gap may cross there. Then they are one handle.
        let is_free = rims.is_disjoint(&taken_rims) && ring.iter().all(|v| !taken.contains(v));
        if is_free && labels.add(label) {
            // Neighbours are taken, too, so that no edge joins two loops.
            let around = ring.iter().flat_map(|v| &labelled.at[v.index()]);
            taken.extend(around.filter(|at| !at.is_chord).map(|at| VertexId(at.to)));
            taken.extend(&ring);
            rings.push(ring);
            taken_rims.extend(rims);
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

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(cut(&mut build, 6.0).is_empty(), "the tube is 6.2 mm around");
        let handles = cut(&mut build, 6.3);
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
        assert!(cut(&mut build, 100.0).is_empty());
    }

    #[test]
    fn a_bridge_over_a_gap_is_left_out() {
        // A torus with a gap around its tube, but for a bridge of two triangles.
        let mut build = torus(40, 12);
        build.mesh.triangles.drain(24 * 35 + 2..24 * 36);
        build.edges = EdgeMap::new(&build.mesh);
        let before = Topology::new(&build.mesh, &build.edges, true);
        assert_eq!((before.genus(), before.loops), (1.0, 1));
        let handles = cut(&mut build, 2.5);
        assert_eq!(handles.len(), 1, "{handles:?}");
        let topology = Topology::new(&build.mesh, &build.edges, true);
        assert_eq!((topology.genus(), topology.loops), (0.0, 2));
        assert!(build.mesh.triangles.len() > 24 * 38);
    }

    #[test]
    fn a_torus_with_a_window_is_cut_too() {
        let mut build = torus(40, 12);
        build.mesh.triangles.truncate(24 * 40 - 9);
        build.edges = EdgeMap::new(&build.mesh);
        assert_eq!(cut(&mut build, 7.0).len(), 1);
        let topology = Topology::new(&build.mesh, &build.edges, true);
        assert_eq!((topology.genus(), topology.loops), (0.0, 1));
    }
}
