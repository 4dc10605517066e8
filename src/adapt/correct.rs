//! Parameter correction (Hoschek 1988): every sample gets the parameter of its
//! foot point on the surface fitted to it, so that the next fit need not follow
//! how the parameters run, only how the surface does.

use std::cmp::Ordering;

use rayon::prelude::*;

use crate::geometry::{Uv, VertexId, orient2d};

/// After as many attempts the old map stays.
const ATTEMPTS: usize = 12;

/// Twice a triangle's area at some parameters.
pub fn area(at: impl Fn(usize) -> Uv, triangle: [VertexId; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| at(v.index()));
    orient2d(a, b, c)
}

/// The parameters of vertices and, after them, of a skirt's.
pub fn with_scaffold<'a>(uv: &'a [Uv], scaffold: &'a [Uv]) -> impl Fn(usize) -> Uv + 'a {
    move |v| uv.get(v).copied().unwrap_or_else(|| scaffold[v - uv.len()])
}

/// The parameters `uv`, `moved` to their feet. Vertices of triangles that would keep less
/// than the share `least` of their [`area`] in the map as it was `made` stay where they
/// were. Those that `scaffold` is the places of come after them, and stay.
pub fn corrected(
    triangles: &[[VertexId; 3]],
    made: &[f64],
    least: f64,
    uv: Vec<Uv>,
    mut moved: Vec<Uv>,
    scaffold: &[Uv],
) -> Vec<Uv> {
    // Feet that are no numbers crush them, too.
    let crushed = |at: &[Uv], t: usize| {
        let area = area(with_scaffold(at, scaffold), triangles[t]);
        area.partial_cmp(&(least * made[t])).is_none_or(Ordering::is_lt)
    };
    // Only triangles with a vertex that has just been put back can turn now.
    let all = || (0..triangles.len()).into_par_iter();
    let mut suspects: Vec<usize> = all().filter(|&t| crushed(&moved, t)).collect();
    for _ in 0..ATTEMPTS {
        if suspects.is_empty() {
            return moved;
        }
        let mut back = vec![false; uv.len()];
        let corners = suspects.iter().flat_map(|&t| triangles[t]).map(VertexId::index);
        for v in corners.filter(|v| *v < uv.len()) {
            back[v] = true;
            moved[v] = uv[v];
        }
        let is_back = |v: &VertexId| back.get(v.index()).is_some_and(|&back| back);
        let touched = |t: &usize| triangles[*t].iter().any(is_back);
        suspects = all().filter(touched).filter(|&t| crushed(&moved, t)).collect();
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
        let made: Vec<f64> = mesh.triangles.iter().map(|&t| area(|v| uv[v], t)).collect();
        let moved = |u: f64, v: f64| {
            let mut feet = uv.clone();
            feet[4] = Uv::new(u, v);
            corrected(&mesh.triangles, &made, 0.2, uv.clone(), feet, &[])[4]
        };
        assert_eq!(moved(0.3, 0.6), Uv::new(0.3, 0.6));
        assert_eq!(moved(0.3, 1.2), uv[4]);
        assert_eq!(moved(f64::NAN, 0.5), uv[4]);
    }
}
