//! Splitting of chords. A chord is an inner edge between two boundary vertices. If both ends were
//! on one side of the rectangle, the chord and everything beyond it would be mapped onto this side.
//! Each chord therefore gets a vertex in its middle.

use foldhash::{HashMap, HashMapExt};
use rayon::prelude::*;

use crate::mesh::{EdgeMidpoints, Mesh, Patch};

/// Splits the chords. Returns their number.
pub(crate) fn split_chords(patch: &mut Patch) -> usize {
    let sides = between_outer(patch);
    let chords = chords(patch, &sides);
    if chords.is_empty() {
        return 0;
    }
    let straight = |mesh: &Mesh, a, b| nalgebra::center(&mesh.point(a), &mesh.point(b));
    let midpoints = EdgeMidpoints::new(&mut patch.mesh, chords, straight);
    patch.divide(&midpoints, sides.into_iter().map(|side| side / 3));
    midpoints.len()
}

/// The sides of triangles between two vertices of the outer boundary, in ascending order.
fn between_outer(patch: &Patch) -> Vec<usize> {
    let mut outer = vec![false; patch.mesh.points.len()];
    patch.outer.iter().for_each(|v| outer[v.index()] = true);
    let sides = (0..3 * patch.mesh.triangles.len()).into_par_iter();
    sides
        .filter(|&side| {
            let (a, b) = patch.mesh.side(side);
            outer[a.index()] && outer[b.index()]
        })
        .collect()
}

/// Those of `sides` that do not lie on the boundary.
fn chords(patch: &Patch, sides: &[usize]) -> Vec<usize> {
    let edge = |side: usize| {
        let (a, b) = patch.mesh.side(side);
        (a.min(b), a.max(b))
    };
    let mut seen = HashMap::with_capacity(sides.len());
    for &side in sides {
        *seen.entry(edge(side)).or_insert(0) += 1;
    }
    sides.iter().copied().filter(|&side| seen[&edge(side)] > 1).collect()
}
