//! Parameter correction (Hoschek 1988): every sample gets the parameter of its
//! foot point on the surface fitted to it, so that the next fit need not follow
//! how the parameters run, only how the surface does.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::reject;
use crate::geometry::{Uv, VertexId, orient2d};
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::problem::Problem;
use crate::stages::adapt::state::State;

/// The share of its area that every triangle of the map keeps between fits. Corrections follow
/// each other, and where they wear the map thin, surfaces fold.
pub(crate) const FIRM_AREA: f64 = 0.2;

/// The same while folds are taken out or a surface is mended, which come last and need more
/// freedom: just enough that rounding inverts no triangle.
pub(crate) const LEAST_AREA: f64 = 1e-3;

/// Rounds in which vertices are put back before the old map stays altogether. A round puts back
/// the neighbours of those before, so that a dozen rounds reach a dozen edges far.
const ROUNDS: usize = 12;

/// The state of an attempt with the parameters of its foot points and without its outliers.
pub(crate) fn correct(problem: &Problem, of: &Attempt, least_area: f64) -> State {
    State {
        knots: of.state.knots.clone(),
        uv: of.corrected(problem, least_area),
        weights: of.state.weights.clone(),
        outliers: reject::outliers(problem, &of.foot_points.distances),
        inner: of.state.inner.clone(),
    }
}

/// Twice a triangle's area at some parameters.
pub(crate) fn area(at: impl Fn(usize) -> Uv, triangle: [VertexId; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| at(v.index()));
    orient2d(a, b, c)
}

/// The parameters of vertices, followed by those of the vertices of a scaffold.
pub(crate) fn with_scaffold<'a>(uv: &'a [Uv], scaffold: &'a [Uv]) -> impl Fn(usize) -> Uv + 'a {
    move |v| uv.get(v).copied().unwrap_or_else(|| scaffold[v - uv.len()])
}

/// The parameters `uv`, `moved` to their foot points. Vertices of triangles that would keep less
/// than the share `least` of their [`area`], which are `areas` on the map as it was made, stay
/// where they were. The vertices of the `scaffold` come after the others, and stay.
pub(crate) fn movable(
    triangles: &[[VertexId; 3]],
    areas: &[f64],
    least: f64,
    uv: Vec<Uv>,
    mut moved: Vec<Uv>,
    scaffold: &[Uv],
) -> Vec<Uv> {
    // A NaN foot point also counts as a compressed triangle.
    let compressed = |at: &[Uv], t: usize| {
        let area = area(with_scaffold(at, scaffold), triangles[t]);
        area.partial_cmp(&(least * areas[t])).is_none_or(Ordering::is_lt)
    };
    // Only triangles with a vertex that has just been put back can turn now.
    let all = || (0..triangles.len()).into_par_iter();
    let mut suspects: Vec<usize> = all().filter(|&t| compressed(&moved, t)).collect();
    for _ in 0..ROUNDS {
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
        suspects = all().filter(touched).filter(|&t| compressed(&moved, t)).collect();
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
    fn a_vertex_moves_to_its_foot_point_unless_triangles_are_inverted() {
        let (mesh, uv) = fan();
        let areas: Vec<f64> = mesh.triangles.iter().map(|&t| area(|v| uv[v], t)).collect();
        let moved = |u: f64, v: f64| {
            let mut wanted = uv.clone();
            wanted[4] = Uv::new(u, v);
            movable(&mesh.triangles, &areas, 0.2, uv.clone(), wanted, &[])[4]
        };
        assert_eq!(moved(0.3, 0.6), Uv::new(0.3, 0.6));
        assert_eq!(moved(0.3, 1.2), uv[4]);
        assert_eq!(moved(f64::NAN, 0.5), uv[4]);
    }
}
