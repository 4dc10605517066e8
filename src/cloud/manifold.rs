//! From elected triangles to an oriented mesh with one fan at each vertex, without small holes and
//! without dust.

use foldhash::{HashSet, HashSetExt};
use smallvec::SmallVec;

use super::project::SurfacePoint;
use super::votes::circumradius;
use crate::geometry::{Point, VertexId, unit_normal};
use crate::mesh::{EdgeMap, Mesh, VertexRings, boundary};
use crate::sets::Sets;

/// Loops of at most this many edges are closed. They are where single points are missing: in a
/// sheet without a fault, a vertex has six neighbours.
const SMALL_LOOP: usize = 6;

/// A component with less than this share of all triangles is dust.
const DUST: f64 = 0.01;

/// Makes the mesh.
pub(super) fn from_triangles(vertices: &[SurfacePoint], triangles: &[[u32; 3]]) -> (Mesh, usize) {
    let points: Vec<Point> = vertices.iter().map(|v| v.place).collect();
    let triangles = triangles.iter().map(|t| t.map(VertexId)).collect();
    let mut mesh = Mesh { points, triangles };
    while keep_one_fan(&mut mesh) {}
    orient(&mut mesh);
    close_small_loops(&mut mesh);
    let dust = drop_dust(&mut mesh);
    (mesh, dust)
}

/// Gives every vertex of an oriented mesh one fan, and closes small loops.
pub(super) fn mend(mesh: &mut Mesh) {
    while keep_one_fan(mesh) {}
    close_small_loops(mesh);
}

/// Where a vertex has several fans of triangles, the largest stays. Returns whether there was one.
fn keep_one_fan(mesh: &mut Mesh) -> bool {
    let rings = VertexRings::new(mesh);
    let mut dropped = HashSet::new();
    for v in (0..mesh.points.len()).map(VertexId::from) {
        let around = rings.triangles(v);
        let mut fans = Sets::new(around.len());
        for (a, &t) in around.iter().enumerate() {
            for (b, &u) in around.iter().enumerate().skip(a + 1) {
                let (t, u) = (mesh.triangles[t as usize], mesh.triangles[u as usize]);
                if t.iter().any(|w| *w != v && u.contains(w)) {
                    fans.join(a, b);
                }
            }
        }
        let fans = fans.members();
        if fans.len() > 1 {
            let most = fans.iter().map(Vec::len).max();
            let largest = fans.iter().position(|f| Some(f.len()) == most);
            let others = fans.iter().enumerate().filter(|(f, _)| Some(*f) != largest);
            dropped.extend(others.flat_map(|(_, f)| f).map(|&a| around[a as usize] as usize));
        }
    }
    let mut t = 0..;
    mesh.triangles.retain(|_| t.next().is_some_and(|t| !dropped.contains(&t)));
    !dropped.is_empty()
}

/// Turns triangles so that neighbours agree with the first one of their component.
fn orient(mesh: &mut Mesh) {
    let edges = EdgeMap::new(mesh);
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut waiting = Vec::new();
    for first in 0..mesh.triangles.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        waiting.push(first);
        while let Some(t) = waiting.pop() {
            for side in 3 * t..3 * t + 3 {
                let Some(other) = edges.across(side) else { continue };
                if turned[other / 3].is_none() {
                    let same_way = mesh.side(side).0 == mesh.side(other).0;
                    turned[other / 3] = turned[t].map(|turn| turn ^ same_way);
                    waiting.push(other / 3);
                }
            }
        }
    }
    for (t, turned) in mesh.triangles.iter_mut().zip(turned) {
        if turned == Some(true) {
            t.swap(1, 2);
        }
    }
}

/// Closes small loops with ears of the least circumradius.
fn close_small_loops(mesh: &mut Mesh) {
    let edges = EdgeMap::new(mesh);
    let loops = boundary::boundary_loops(mesh, &edges);
    let rings = VertexRings::new(mesh);
    for ring in loops.into_iter().filter(|ring| ring.len() <= SMALL_LOOP) {
        if let Some(patch) = closed(mesh, &rings, ring) {
            mesh.triangles.extend(patch);
        }
    }
}

/// The triangles that close a loop. `None` if one would be folded over its neighbours, or if two
/// vertices of the loop are joined outside of it.
fn closed(
    mesh: &Mesh,
    rings: &VertexRings,
    mut ring: Vec<VertexId>,
) -> Option<SmallVec<[[VertexId; 3]; 4]>> {
    // The patch is to the right of the loop.
    ring.reverse();
    let normal = |v: VertexId| {
        let around = rings.triangles(v).iter().map(|&t| mesh.triangles[t as usize]);
        around.map(|t| mesh.area_vector(t)).sum::<crate::geometry::Vector>()
    };
    let mut patch = SmallVec::new();
    while ring.len() >= 3 {
        let count = ring.len();
        let ear = |k: usize| [ring[(k + count - 1) % count], ring[k], ring[(k + 1) % count]];
        let joined =
            |[a, _, c]: [VertexId; 3]| count > 3 && rings.neighbours(mesh, a).any(|v| v == c);
        let folded = |t: [VertexId; 3]| {
            let own = unit_normal(mesh.corners(t));
            own.is_none_or(|n| t.iter().any(|&v| n.dot(&normal(v)) <= 0.0))
        };
        let ears = (0..count).filter(|&k| !joined(ear(k)) && !folded(ear(k)));
        let radius = |k: &usize| circumradius(mesh.corners(ear(*k)));
        let best = { ears }.min_by(|a, b| radius(a).total_cmp(&radius(b)))?;
        patch.push(ear(best));
        ring.remove(best);
    }
    Some(patch)
}

/// Drops small components. Returns the number of their triangles.
fn drop_dust(mesh: &mut Mesh) -> usize {
    let mut sets = Sets::new(mesh.points.len());
    for t in &mesh.triangles {
        sets.join(t[0].index(), t[1].index());
        sets.join(t[1].index(), t[2].index());
    }
    let mut size = vec![0usize; mesh.points.len()];
    mesh.triangles.iter().for_each(|t| size[sets.find(t[0].index())] += 1);
    let before = mesh.triangles.len();
    let least = DUST * before as f64;
    mesh.triangles.retain(|t| size[sets.find(t[0].index())] as f64 >= least);
    before - mesh.triangles.len()
}
