//! Parameter correction (Hoschek 1988): every sample gets the parameter of its
//! foot point on the surface fitted to it, so that the next fit need not follow
//! how the parameters run, only how the surface does.

use std::cmp::Ordering;

use crate::geometry::{Uv, VertexId, orient2d};

/// After as many attempts the old map stays.
const ATTEMPTS: usize = 12;

/// The parameters `uv`, `moved` to their feet. Vertices of triangles that would keep less
/// than the share `least` of the area in the map as it was made stay where they were.
pub fn corrected(
    triangles: &[[VertexId; 3]],
    made: &[Uv],
    least: f64,
    uv: Vec<Uv>,
    mut moved: Vec<Uv>,
) -> Vec<Uv> {
    let area = |at: &[Uv], t: usize| {
        let [a, b, c] = triangles[t].map(|v| at[v.index()]);
        orient2d(a, b, c)
    };
    let least: Vec<f64> = (0..triangles.len()).map(|t| least * area(made, t)).collect();
    // Feet that are no numbers crush them, too.
    let crushed =
        |at: &[Uv], t: usize| area(at, t).partial_cmp(&least[t]).is_none_or(Ordering::is_lt);
    // Only triangles with a vertex that has just been put back can turn now.
    let mut suspects: Vec<usize> = (0..triangles.len()).collect();
    for _ in 0..ATTEMPTS {
        suspects.retain(|&t| crushed(&moved, t));
        if suspects.is_empty() {
            return moved;
        }
        let mut back = vec![false; uv.len()];
        for v in suspects.iter().flat_map(|&t| triangles[t]) {
            back[v.index()] = true;
            moved[v.index()] = uv[v.index()];
        }
        let touched = |t: &usize| triangles[*t].iter().any(|v| back[v.index()]);
        suspects = (0..triangles.len()).filter(touched).collect();
    }
    uv
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::mesh::Mesh;

    /// Two triangles over the unit square, and a vertex in the middle of it.
    fn fan() -> (Mesh, Vec<Uv>) {
        let uv = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)];
        let uv: Vec<Uv> = uv.map(|(u, v)| Uv::new(u, v)).to_vec();
        let points = uv.iter().map(|p| Point::new(p.x, p.y, 0.0)).collect();
        let triangles = (0..4).map(|i| [i, (i + 1) % 4, 4].map(VertexId)).collect();
        (Mesh { points, triangles }, uv)
    }

    #[test]
    fn a_vertex_moves_to_its_foot_unless_triangles_turn_over() {
        let (mesh, uv) = fan();
        let moved = |u: f64, v: f64| {
            let mut feet = uv.clone();
            feet[4] = Uv::new(u, v);
            corrected(&mesh.triangles, &uv, 0.2, uv.clone(), feet)[4]
        };
        assert_eq!(moved(0.3, 0.6), Uv::new(0.3, 0.6));
        assert_eq!(moved(0.3, 1.2), uv[4]);
        assert_eq!(moved(f64::NAN, 0.5), uv[4]);
    }
}
