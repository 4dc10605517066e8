//! Repair of triangles that rounding has inverted.
//!
//! No step on the way to a map inverts a triangle. Slivers may still be inverted in the last bit
//! when the rectangle is scaled to a square.

use super::solve;
use crate::geometry::{Uv, orient2d};
use crate::mesh::one_rings::OneRings;

/// The triangles that do not run counter-clockwise, by an exact predicate.
pub(crate) fn inverted(triangles: impl Iterator<Item = [u32; 3]>, at: &[Uv]) -> Vec<[u32; 3]> {
    let flipped = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| at[v as usize]);
        orient2d(a, b, c) <= 0.0
    };
    triangles.filter(flipped).collect()
}

/// Remaps the surroundings of inverted triangles with even weights. The surroundings grow until no
/// triangle is inverted; with all inner vertices this is Tutte's map, which does not fold. Returns
/// the number of inverted triangles, and those that could not be repaired.
pub(crate) fn mend(
    rings: &OneRings,
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
    at: &mut [Uv],
) -> (usize, Vec<[u32; 3]>) {
    let mut folded = inverted(triangles.clone(), at);
    let count = folded.len();
    let (mut reach, mut last) = (1, 0);
    while !folded.is_empty() {
        let region = within(rings, &folded, reach);
        let before: Vec<Uv> = region.iter().map(|&v| at[v as usize]).collect();
        let solved = solve::even(rings, &region, at).is_ok();
        let left = inverted(triangles.clone(), at);
        if solved && left.len() < folded.len() {
            (folded, reach, last) = (left, 1, 0);
            continue;
        }
        region.iter().zip(before).for_each(|(&v, place)| at[v as usize] = place);
        if region.len() == last {
            break;
        }
        (reach, last) = (2 * reach, region.len());
    }
    (count, folded)
}

/// The inner vertices within `reach` edges of the folded triangles.
fn within(rings: &OneRings, folded: &[[u32; 3]], reach: usize) -> Vec<u32> {
    let mut seen = vec![false; rings.len()];
    let mut region = Vec::new();
    let mut front: Vec<u32> = folded.iter().flatten().copied().collect();
    for _ in 0..=reach {
        front.retain(|&v| !std::mem::replace(&mut seen[v as usize], true));
        if front.is_empty() {
            break;
        }
        region.extend(front.iter().copied().filter(|&v| !rings.on_boundary(v)));
        front = front.iter().flat_map(|&v| rings.ring(v)).copied().collect();
    }
    region.sort_unstable();
    region
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::one_rings::tests::grid;

    const N: u32 = 12;

    /// A grid on the unit square with some vertices moved far away.
    fn thrown(vertices: impl Iterator<Item = u32>) -> (OneRings, Vec<[u32; 3]>, Vec<Uv>) {
        let patch = grid(N);
        let rings = OneRings::new(&patch.mesh, &patch.outer);
        let triangles: Vec<_> = patch.mesh.triangles.iter().map(|t| t.map(|v| v.0)).collect();
        let side = f64::from(N - 1);
        let mut at: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y) / side).collect();
        vertices
            .filter(|&v| !rings.on_boundary(v))
            .for_each(|v| at[v as usize] = Uv::new(0.9, 0.2));
        (rings, triangles, at)
    }

    fn check(vertices: impl Iterator<Item = u32>) {
        let (rings, triangles, mut at) = thrown(vertices);
        let count = inverted(triangles.iter().copied(), &at).len();
        assert!(count > 0);
        assert_eq!(mend(&rings, triangles.iter().copied(), &mut at), (count, vec![]));
        assert!(inverted(triangles.iter().copied(), &at).is_empty());
    }

    #[test]
    fn single_vertices_are_put_back() {
        check([3 * N + 4].into_iter());
        check([3 * N + 4, 7 * N + 7, 7 * N + 8].into_iter());
    }

    #[test]
    fn a_map_that_is_lost_is_made_anew() {
        check(0..N * N);
    }

    #[test]
    fn a_boundary_that_goes_back_is_told() {
        let (rings, triangles, mut at) = thrown(std::iter::empty());
        at.swap(2, 3);
        let before = at.clone();
        assert!(!mend(&rings, triangles.iter().copied(), &mut at).1.is_empty());
        assert_eq!(at, before);
    }
}
