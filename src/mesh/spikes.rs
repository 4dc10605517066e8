//! Removal of spikes: single vertices that a scanner placed far off the surface.

use std::collections::BTreeSet;

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};
use rayon::prelude::*;

use super::build::{Build, count};
use super::{EdgeMap, Mesh, VertexRings, polygons};
use crate::geometry::{Point, Vector, VertexId, bounds};

/// A vertex is a spike if its distance from each neighbour exceeds this multiple of the extent of
/// all its neighbours. A real needle is not a spike, because vertices along its side are neighbours
/// of its tip.
const REACH: f64 = 3.0;

/// The limit at a boundary. It is larger because two triangles on a short side often stick out
/// there.
const REACH_AT_BOUNDARY: f64 = 4.0;

/// Removes spikes. The hole that a spike leaves is closed by the polygon of its neighbours, unless
/// it lies at a boundary. Returns whether there were any spikes.
pub(super) fn drop(build: &mut Build) -> bool {
    let rings = VertexRings::new(&build.mesh);
    let vertices = (0..build.mesh.points.len()).into_par_iter().map(VertexId::from);
    let spikes: BTreeSet<VertexId> = vertices
        .filter(|&v| may_be_spike(&build.mesh, &rings, v) && is_spike(&build.mesh, &rings, v))
        .collect();
    if spikes.is_empty() {
        return false;
    }
    let mut left = spikes.clone();
    let mut dropped = HashSet::new();
    let mut caps = Vec::new();
    while let Some(first) = left.pop_first() {
        let around = fans(&build.mesh, &rings, first, &mut left);
        if let Some(polygon) = outline(&build.mesh, &around, &spikes) {
            polygons::cut_up(&build.mesh.points, &polygon, &mut caps);
        }
        dropped.extend(around.into_iter().map(|t| t as usize));
    }
    build.drop_triangles(&dropped);
    build.mesh.triangles.append(&mut caps);
    build.edges = EdgeMap::new(&build.mesh);
    count(&mut build.repairs, "spikes_dropped", spikes.len());
    true
}

/// The triangles of a spike and of all spikes connected to it. These spikes are removed from
/// `left`.
fn fans(
    mesh: &Mesh,
    rings: &VertexRings,
    first: VertexId,
    left: &mut BTreeSet<VertexId>,
) -> BTreeSet<u32> {
    let mut around = BTreeSet::new();
    let mut front = vec![first];
    while let Some(v) = front.pop() {
        around.extend(rings.triangles(v));
        front.extend(rings.neighbours(mesh, v).filter(|w| left.remove(w)));
    }
    around
}

/// The loop of sides that face the spikes, if there is exactly one loop and it is closed.
fn outline(mesh: &Mesh, around: &BTreeSet<u32>, spikes: &BTreeSet<VertexId>) -> Option<Vec<u32>> {
    let mut next = HashMap::new();
    for &t in around {
        let corners = mesh.triangles[t as usize];
        for k in 0..3 {
            let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            if spikes.contains(&corners[k]) && !spikes.contains(&a) && !spikes.contains(&b) {
                next.insert(a, b);
            }
        }
    }
    let start = *next.keys().min()?;
    let mut ring = Vec::new();
    let mut at = start;
    while let Some(after) = next.remove(&at) {
        ring.push(at.0);
        at = after;
    }
    (at == start && next.is_empty()).then_some(ring)
}

/// Whether some neighbours of `v` are much nearer to each other than to `v`. This quick test holds
/// for every spike and for few other vertices.
fn may_be_spike(mesh: &Mesh, rings: &VertexRings, v: VertexId) -> bool {
    let (mut nearest, mut shortest) = (f64::MAX, f64::MAX);
    let p = mesh.point(v);
    for &t in rings.triangles(v) {
        let [a, b, c] = mesh.triangles[t as usize];
        let (q, r) = if a == v {
            (b, c)
        } else if b == v {
            (c, a)
        } else {
            (a, b)
        };
        let (q, r) = (mesh.point(q), mesh.point(r));
        nearest = nearest.min((q - p).norm_squared()).min((r - p).norm_squared());
        shortest = shortest.min((r - q).norm_squared());
    }
    nearest > REACH * REACH * shortest
}

/// Whether `v` is far from its neighbours, and each neighbour has triangles without `v`. Away from
/// boundaries the neighbour farthest from the others is ignored, because it may be a spike itself.
fn is_spike(mesh: &Mesh, rings: &VertexRings, v: VertexId) -> bool {
    let mut foot: Vec<VertexId> = rings.neighbours(mesh, v).collect();
    foot.sort_unstable();
    foot.dedup();
    let stands_on = |&w: &VertexId| {
        rings.triangles(w).iter().any(|&t| !mesh.triangles[t as usize].contains(&v))
    };
    if foot.len() < 3 || !foot.iter().all(stands_on) {
        return false;
    }
    let from = |&w: &VertexId| (mesh.point(w) - mesh.point(v)).norm();
    let reach =
        |foot: &[VertexId]| foot.iter().map(from).fold(f64::MAX, f64::min) / extent(mesh, foot);
    if foot.len() > rings.triangles(v).len() {
        return reach(&foot) > REACH_AT_BOUNDARY;
    }
    reach(&foot) > REACH || foot.len() > 3 && reach(&without_farthest(mesh, foot)) > REACH
}

/// The diagonal of the bounding box of some vertices.
fn extent(mesh: &Mesh, vertices: &[VertexId]) -> f64 {
    let [low, high] = bounds(vertices.iter().map(|&v| mesh.point(v)));
    (high - low).norm()
}

/// The vertices without the one that is farthest from their centre.
fn without_farthest(mesh: &Mesh, mut vertices: Vec<VertexId>) -> Vec<VertexId> {
    let sum: Vector = vertices.iter().map(|&v| mesh.point(v).coords).sum();
    let centre = Point::from(sum / vertices.len() as f64);
    let from = |v: &VertexId| (mesh.point(*v) - centre).norm_squared();
    let farthest =
        (0..vertices.len()).max_by(|&i, &j| from(&vertices[i]).total_cmp(&from(&vertices[j])));
    vertices.swap_remove(farthest.unwrap_or(0));
    vertices
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 7 × 7 points, one of them at another height.
    fn grid(x: u32, y: u32, height: f64) -> Build {
        let mut mesh = Mesh::default();
        for i in 0..49 {
            let z = if i == 7 * y + x { height } else { 0.0 };
            mesh.points.push(Point::new(f64::from(i % 7), f64::from(i / 7), z));
        }
        for i in (0..42).filter(|i| i % 7 < 6) {
            mesh.triangles.push([i, i + 1, i + 8].map(VertexId));
            mesh.triangles.push([i, i + 8, i + 7].map(VertexId));
        }
        let place = (0..49).collect();
        Build::new(mesh, place, 1.0)
    }

    #[test]
    fn a_spike_goes_and_leaves_no_hole() {
        let mut build = grid(3, 3, 50.0);
        assert!(drop(&mut build));
        build.make_manifold();
        assert_eq!(build.repairs["spikes_dropped"], 1);
        assert_eq!(build.edges.open_sides().count(), 24);
        let area: f64 =
            build.mesh.triangles.iter().map(|&t| build.mesh.area_vector(t).z / 2.0).sum();
        assert!((area - 36.0).abs() < 1e-9, "{area}");
    }

    #[test]
    fn a_spike_at_the_edge_goes_with_its_triangles() {
        let mut build = grid(0, 3, 50.0);
        assert!(drop(&mut build));
        assert_eq!(build.mesh.triangles.len(), 72 - 3);
    }

    #[test]
    fn two_spikes_side_by_side_go() {
        let mut build = grid(3, 3, 50.0);
        build.mesh.points[7 * 3 + 2].z = 60.0;
        while drop(&mut build) {
            build.make_manifold();
        }
        assert_eq!(build.repairs["spikes_dropped"], 2);
        assert_eq!(build.edges.open_sides().count(), 24);
        let high = build.mesh.triangles.iter().flatten().map(|&v| build.mesh.point(v).z);
        assert_eq!(high.fold(0.0, f64::max), 0.0);
    }

    #[test]
    fn a_bump_stays() {
        assert!(!drop(&mut grid(3, 3, 4.0)));
    }
}
