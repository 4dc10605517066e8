//! The closing of small loops, where a point or two are missing in the surface.

use foldhash::{HashSet, HashSetExt};

use super::manifold::retain;
use super::votes::circumradius;
use crate::geometry::{Vector, VertexId, unit_normal};
use crate::mesh::boundary::{Loop, boundary_loops};
use crate::mesh::{EdgeMap, Mesh, VertexRings};

/// Loops of at most this many edges are closed. They are two and a half spacings wide, which is as
/// wide as chance makes a gap between points. Real holes are not that small.
const SMALL_LOOP: usize = 8;

/// A place that was opened again has at most this many edges.
const REOPENED_LOOP: usize = 4 * SMALL_LOOP;

/// Closes small loops with ears of the least circumradius. Where that would fold the surface, the
/// triangles around the loop are folded already. They are removed, and the vertices
/// of all removed triangles are returned.
pub(super) fn small_loops(mesh: &mut Mesh) -> HashSet<VertexId> {
    let rings = VertexRings::new(mesh);
    let mut removed = HashSet::new();
    for ring in boundary_loops(mesh, &EdgeMap::new(mesh)) {
        if ring.len() > SMALL_LOOP {
            continue;
        }
        match patch(mesh, &rings, ring.clone()) {
            Some(patch) => mesh.triangles.extend(patch),
            None => removed.extend(ring.iter().flat_map(|&v| rings.triangles(v))),
        }
    }
    let of_removed = removed.iter().flat_map(|&&t| mesh.triangles[t as usize]);
    let corners = of_removed.collect();
    let numbers: HashSet<usize> = removed.into_iter().map(|&t| t as usize).collect();
    if !numbers.is_empty() {
        retain(mesh, |t| !numbers.contains(&t));
    }
    corners
}

/// Closes the loops that only run through `reopened` vertices.
pub(super) fn reopened_loops(mesh: &mut Mesh, reopened: &HashSet<VertexId>) {
    let rings = VertexRings::new(mesh);
    for ring in boundary_loops(mesh, &EdgeMap::new(mesh)) {
        if ring.len() <= REOPENED_LOOP && ring.iter().all(|v| reopened.contains(v)) {
            mesh.triangles.extend(patch(mesh, &rings, ring).into_iter().flatten());
        }
    }
}

/// The triangles that close a loop. `None` if one would be folded over its neighbours, or if two
/// vertices of the loop are joined outside of it.
fn patch(mesh: &Mesh, rings: &VertexRings, mut ring: Loop) -> Option<Vec<[VertexId; 3]>> {
    // The surface is to the left of the loop, and the patch is to its right.
    ring.reverse();
    let normal = |v: VertexId| {
        let around = rings.triangles(v).iter().map(|&t| mesh.triangles[t as usize]);
        around.map(|t| mesh.area_vector(t)).sum::<Vector>()
    };
    let mut normals: Vec<Vector> = ring.iter().map(|&v| normal(v)).collect();
    let mut patch = Vec::new();
    while ring.len() >= 3 {
        let count = ring.len();
        let around = |k: usize| [(k + count - 1) % count, k, (k + 1) % count];
        let ear = |k: usize| around(k).map(|at| ring[at]);
        let is_joined =
            |[a, _, c]: [VertexId; 3]| count > 3 && rings.neighbours(mesh, a).any(|v| v == c);
        let is_folded = |k: usize| {
            let own = unit_normal(mesh.corners(ear(k)));
            own.is_none_or(|n| around(k).iter().any(|&at| n.dot(&normals[at]) <= 0.0))
        };
        let ears = (0..count).filter(|&k| !is_joined(ear(k)) && !is_folded(k));
        let radius = |k: &usize| circumradius(mesh.corners(ear(*k)));
        let best = { ears }.min_by(|a, b| radius(a).total_cmp(&radius(b)))?;
        patch.push(ear(best));
        ring.remove(best);
        normals.remove(best);
    }
    Some(patch)
}
