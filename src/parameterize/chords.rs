//! Chords, inner edges that join two boundary vertices, get a vertex in their
//! middle each: one whose ends are on one side of the rectangle would be mapped
//! onto that side, and everything beyond it too.

use foldhash::{HashMap, HashMapExt};
use rayon::prelude::*;

use crate::geometry::VertexId;
use crate::mesh::Patch;

type Edge = (VertexId, VertexId);

fn edge(a: VertexId, b: VertexId) -> Edge {
    (a.min(b), a.max(b))
}

/// Splits the chords; returns how many there were.
pub fn split_chords(patch: &mut Patch) -> usize {
    let sides = between_outer(patch);
    let middles = chords(patch, &sides);
    if middles.is_empty() {
        return 0;
    }
    let old = std::mem::take(&mut patch.mesh.triangles);
    let origins = std::mem::take(&mut patch.origin);
    let mut maybe = sides.into_iter().map(|side| side / 3).peekable();
    for (number, (t, origin)) in old.into_iter().zip(origins).enumerate() {
        let may_be_divided = maybe.peek() == Some(&number);
        while maybe.next_if_eq(&number).is_some() {}
        if may_be_divided {
            patch.mesh.triangles.extend(divided(t, &middles));
        } else {
            patch.mesh.triangles.push(t);
        }
        patch.origin.resize(patch.mesh.triangles.len(), origin);
    }
    middles.len()
}

/// The sides of triangles that join two outer vertices, ascending: side `3 t + k` runs
/// from corner `k` of triangle `t` to the next one.
fn between_outer(patch: &Patch) -> Vec<usize> {
    let mut outer = vec![false; patch.mesh.points.len()];
    patch.outer.iter().for_each(|v| outer[v.index()] = true);
    let sides = (0..3 * patch.mesh.triangles.len()).into_par_iter();
    sides
        .filter(|&side| {
            let (a, b) = ends(patch, side);
            outer[a.index()] && outer[b.index()]
        })
        .collect()
}

fn ends(patch: &Patch, side: usize) -> Edge {
    let t = patch.mesh.triangles[side / 3];
    (t[side % 3], t[(side % 3 + 1) % 3])
}

/// The chords among sides and their new vertices, which are added to the mesh.
fn chords(patch: &mut Patch, sides: &[usize]) -> HashMap<Edge, VertexId> {
    let mut seen = HashMap::with_capacity(sides.len());
    for &side in sides {
        let (a, b) = ends(patch, side);
        *seen.entry(edge(a, b)).or_insert(0) += 1;
    }
    let mut middles = HashMap::new();
    for &side in sides {
        let (a, b) = ends(patch, side);
        if seen[&edge(a, b)] < 2 {
            // A side of the boundary.
            continue;
        }
        middles.entry(edge(a, b)).or_insert_with(|| {
            let middle = nalgebra::center(&patch.mesh.point(a), &patch.mesh.point(b));
            patch.mesh.points.push(middle);
            VertexId::from(patch.mesh.points.len() - 1)
        });
    }
    middles
}

/// The triangles that a triangle becomes when some of its sides are halved.
fn divided(t: [VertexId; 3], middles: &HashMap<Edge, VertexId>) -> Vec<[VertexId; 3]> {
    let middle = |k: usize| middles.get(&edge(t[k % 3], t[(k + 1) % 3])).copied();
    let halved = (0..3).filter(|&k| middle(k).is_some()).count();
    // Begin at a side for which the cases below read alike: the only halved
    // one, or the first of two that follow each other.
    let start = (0..3).find(|&k| middle(k).is_some() && (halved != 2 || middle(k + 1).is_some()));
    let s = start.unwrap_or(0);
    let (a, b, c) = (t[s], t[(s + 1) % 3], t[(s + 2) % 3]);
    match (middle(s), middle(s + 1), middle(s + 2)) {
        (Some(ab), None, _) => vec![[a, ab, c], [ab, b, c]],
        (Some(ab), Some(bc), None) => vec![[ab, b, bc], [a, ab, bc], [a, bc, c]],
        (Some(ab), Some(bc), Some(ca)) => {
            vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        }
        (None, _, _) => vec![t],
    }
}
