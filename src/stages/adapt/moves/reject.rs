//! Outlier rejection: points that no surface explains, nor their neighbours. Smoothing takes a
//! scanner's outliers back; if it is off, a fit must not follow them.
//!
//! What is around a point tells an outlier from the shape: along an edge that the net
//! cannot follow, the neighbours are off, too.

use crate::geometry::{ALONE, Point, Vector, VertexId};
use crate::stages::adapt::problem::Problem;
use crate::statistics::outlying;

/// How often outliers are looked for without those found before among the neighbours. Twice
/// finds both of a pair.
const ROUNDS: usize = 2;

/// Which vertices are outliers, by their distances from a surface, the farthest first.
pub(crate) fn outliers(problem: &Problem, distances: &[f64]) -> Vec<usize> {
    let (limit, most) = limits(problem);
    if most == 0 {
        return Vec::new();
    }
    let triangles = &problem.map.patch.mesh.triangles;
    let may = |v: usize| v < problem.measured() && !problem.is_corner(v);
    let mut outliers = found(distances, limit, triangles, may);
    outliers.truncate(most);
    outliers
}

/// The same before there is a surface: by the vertices' distances from the means of their
/// neighbours.
pub(crate) fn outliers_before_a_fit(problem: &Problem) -> Vec<usize> {
    if limits(problem).1 == 0 {
        return Vec::new();
    }
    let mesh = &problem.map.patch.mesh;
    outliers(problem, &from_neighbours(&mesh.points, &mesh.triangles))
}

/// From which distance on, in mm, a vertex may be an outlier, and how many may be. None may be
/// that smoothing has taken back or that the user wants the face to follow.
fn limits(problem: &Problem) -> (f64, usize) {
    let goal = problem.goal;
    match (problem.options.noise > 0.0, goal.named) {
        (false, _) => (f64::INFINITY, 0),
        (true, true) => (goal.tolerance, problem.spared()),
        (true, false) => (outlying(problem.measured()) * goal.noise(), problem.measured()),
    }
}

/// Which of the vertices that `may` be outliers are farther off than `limit` while their
/// neighbours are not, the farthest first: from their distances and the triangles.
fn found(
    distances: &[f64],
    limit: f64,
    triangles: &[[VertexId; 3]],
    may: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let far: Vec<bool> = (0..distances.len()).map(|v| distances[v] > limit && may(v)).collect();
    let mut suspects: Vec<usize> = (0..far.len()).filter(|&v| far[v]).collect();
    if suspects.is_empty() {
        return suspects;
    }
    let mut out = vec![false; far.len()];
    for _ in 0..ROUNDS {
        let mut around = vec![(0.0, 0.0); far.len()];
        for t in triangles.iter().map(|t| t.map(VertexId::index)) {
            for (k, v) in t.into_iter().enumerate().filter(|(_, v)| far[*v]) {
                for w in [t[(k + 1) % 3], t[(k + 2) % 3]].into_iter().filter(|w| !out[*w]) {
                    around[v].0 += distances[w];
                    around[v].1 += 1.0;
                }
            }
        }
        for &v in &suspects {
            out[v] = distances[v] * around[v].1 > ALONE * around[v].0;
        }
    }
    suspects.retain(|&v| out[v]);
    suspects.sort_by(|&a, &b| distances[b].total_cmp(&distances[a]));
    suspects
}

/// How far each vertex is from the mean of its neighbours.
fn from_neighbours(points: &[Point], triangles: &[[VertexId; 3]]) -> Vec<f64> {
    let mut sums = vec![(Vector::zeros(), 0.0); points.len()];
    for t in triangles.iter().map(|t| t.map(VertexId::index)) {
        let [a, b, c] = t.map(|v| points[v].coords);
        for (v, others) in t.into_iter().zip([b + c, c + a, a + b]) {
            sums[v].0 += others;
            sums[v].1 += 2.0;
        }
    }
    let off = |(p, (sum, count)): (&Point, (Vector, f64))| match count > 0.0 {
        true => (p.coords - sum / count).norm(),
        false => 0.0,
    };
    points.iter().zip(sums).map(off).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 9 × 9 vertices, some of them off.
    fn outliers_of(off: &[(usize, usize)]) -> Vec<usize> {
        let vertex = |k: usize| VertexId::from(k);
        let cell = |k: usize| (k / 8) * 9 + k % 8;
        let halves = |a: usize| [[a, a + 9, a + 10], [a, a + 10, a + 1]].map(|t| t.map(vertex));
        let triangles: Vec<_> = (0..64).map(cell).flat_map(halves).collect();
        let mut distances = vec![0.02; 81];
        off.iter().for_each(|&(i, j)| distances[9 * i + j] = 1.0);
        found(&distances, 0.1, &triangles, |v| v != 80)
    }

    #[test]
    fn single_points_and_pairs_are_outliers_edges_and_patches_are_not() {
        assert!(outliers_of(&[(8, 8)]).is_empty());
        assert_eq!(outliers_of(&[(4, 4)]), [40]);
        assert_eq!(outliers_of(&[(4, 4), (4, 5)]), [40, 41]);
        let edge: Vec<_> = (0..9).map(|j| (4, j)).collect();
        assert!(outliers_of(&edge).is_empty());
        let patch: Vec<_> = (0..9).map(|k| (3 + k / 3, 3 + k % 3)).collect();
        assert!(outliers_of(&patch).is_empty());
    }
}
