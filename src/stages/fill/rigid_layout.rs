//! As-rigid-as-possible layout of a surface in the plane (Liu, Zhang, Xu, Gotsman &
//! Gortler 2008, "A local/global approach to mesh parameterization"), from Tutte's embedding.
//! It is the chart of a fill that is no height field over any plane.

use std::collections::HashMap;

use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::{Matrix2, Rotation2, Vector2};
use rayon::prelude::*;

use crate::geometry::{Point, Uv};
use crate::mesh::remesh::flips::cotangent;
use crate::solve::cholesky::Cholesky;

/// The steps of the method. Each rotates every triangle and then moves all vertices. The layout is
/// only a chart for the spline: half and twice as many change the rms by less than 0.1 %.
const STEPS: usize = 30;

/// Lays out a connected surface with a boundary in the plane, beginning with `start` if it is
/// given. Lengths change little; triangles can be inverted where the surface is far from
/// developable. Points without triangles can end up anywhere. `None` if the surface has no
/// boundary, or numbers that are too large or not finite.
pub(crate) fn lay_out(
    points: &[Point],
    triangles: &[[usize; 3]],
    start: Option<Vec<Uv>>,
) -> Option<Vec<Uv>> {
    let mut uv = start.or_else(|| embed(points, triangles))?;
    let flat: Vec<[Vector2<f64>; 3]> =
        triangles.iter().map(|t| flatten(t.map(|v| points[v]))).collect();
    let weights: Vec<[f64; 3]> =
        triangles.iter().map(|t| cotangents(t.map(|v| points[v]))).collect();
    let factor = laplacian(points.len(), triangles, &weights)?;
    for _ in 0..STEPS {
        let mut right = Mat::<f64>::zeros(points.len(), 2);
        let rotated = triangles.par_iter().zip(&flat).zip(&weights).map(|((t, x), w)| {
            let turn = rotation(t.map(|v| uv[v]), x, w);
            [0, 1, 2].map(|k| w[k] * (turn * (x[k] - x[(k + 1) % 3])))
        });
        let rotated: Vec<[Vector2<f64>; 3]> = rotated.collect();
        for (t, sides) in triangles.iter().zip(rotated) {
            for (k, side) in sides.into_iter().enumerate() {
                let (i, j) = (t[k], t[(k + 1) % 3]);
                for axis in 0..2 {
                    right[(i, axis)] += side[axis];
                    right[(j, axis)] -= side[axis];
                }
            }
        }
        factor.solve(&mut right);
        uv = (0..points.len()).map(|i| Uv::new(right[(i, 0)], right[(i, 1)])).collect();
    }
    uv.iter().all(|p| p.x.is_finite() && p.y.is_finite()).then_some(uv)
}

/// A triangle in its own plane, its first corner at the origin.
fn flatten([a, b, c]: [Point; 3]) -> [Vector2<f64>; 3] {
    let (side, other) = (b - a, c - a);
    let length = side.norm().max(f64::MIN_POSITIVE);
    let along = other.dot(&side) / length;
    let height = side.cross(&other).norm() / length;
    [Vector2::zeros(), Vector2::new(length, 0.0), Vector2::new(along, height)]
}

/// Half the cotangents of the angles opposite to the sides 0 1, 1 2 and 2 0. They are clamped,
/// so that slivers neither outweigh all others nor lose all their weight.
fn cotangents(corners: [Point; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let apex = corners[(k + 2) % 3];
        0.5 * cotangent(apex, corners[k], corners[(k + 1) % 3]).clamp(0.05, 20.0)
    })
}

/// The rotation that brings a flattened triangle nearest to its image in the layout.
fn rotation(image: [Uv; 3], flat: &[Vector2<f64>; 3], weights: &[f64; 3]) -> Rotation2<f64> {
    let (mut cosine, mut sine) = (0.0, 0.0);
    for k in 0..3 {
        let (u, x) = (image[k] - image[(k + 1) % 3], flat[k] - flat[(k + 1) % 3]);
        cosine += weights[k] * x.dot(&u);
        sine += weights[k] * x.perp(&u);
    }
    let length = cosine.hypot(sine);
    // An image that is one point has no rotation.
    let (c, s) = if length > 0.0 { (cosine / length, sine / length) } else { (1.0, 0.0) };
    Rotation2::from_matrix_unchecked(Matrix2::new(c, -s, s, c))
}

/// The Cholesky factor of Σ w (uᵢ − uⱼ)². A small diagonal holds all vertices.
fn laplacian(n: usize, triangles: &[[usize; 3]], weights: &[[f64; 3]]) -> Option<Cholesky<usize>> {
    let mut entries: Vec<_> = (0..n).map(|i| Triplet::new(i, i, 1e-9)).collect();
    for (t, w) in triangles.iter().zip(weights) {
        for k in 0..3 {
            let (i, j) = (t[k], t[(k + 1) % 3]);
            entries.extend([Triplet::new(i, i, w[k]), Triplet::new(j, j, w[k])]);
            entries.push(Triplet::new(i.max(j), i.min(j), -w[k]));
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &entries).ok()?;
    Cholesky::new(matrix.as_ref()).ok()
}

/// Tutte's embedding: the longest boundary is on a circle with the area of the surface, and
/// every other vertex is the mean of its neighbours.
fn embed(points: &[Point], triangles: &[[usize; 3]]) -> Option<Vec<Uv>> {
    let boundary = longest_boundary(points, triangles)?;
    let area: f64 = triangles
        .iter()
        .map(|t| 0.5 * (points[t[1]] - points[t[0]]).cross(&(points[t[2]] - points[t[0]])).norm())
        .sum();
    let radius = (area / std::f64::consts::PI).sqrt();
    let side = |i: usize| (points[boundary[(i + 1) % boundary.len()]] - points[boundary[i]]).norm();
    let total: f64 = (0..boundary.len()).map(side).sum();
    let mut uv = vec![None; points.len()];
    let mut walked = 0.0;
    for (i, &v) in boundary.iter().enumerate() {
        let angle = std::f64::consts::TAU * walked / total;
        uv[v] = Some(Uv::new(radius * angle.cos(), radius * angle.sin()));
        walked += side(i);
    }
    let number: HashMap<usize, usize> =
        (0..points.len()).filter(|&v| uv[v].is_none()).enumerate().map(|(k, v)| (v, k)).collect();
    let n = number.len();
    let mut entries: Vec<_> = (0..n).map(|i| Triplet::new(i, i, 1e-9)).collect();
    let mut right = Mat::<f64>::zeros(n, 2);
    for (i, j) in triangles.iter().flat_map(|t| (0..6).map(|k| (t[k % 3], t[(k + 1 + k / 3) % 3])))
    {
        let Some(&row) = number.get(&i) else { continue };
        entries.push(Triplet::new(row, row, 1.0));
        match uv[j] {
            Some(q) => (0..2).for_each(|axis| right[(row, axis)] += q[axis]),
            None => entries.push(Triplet::new(row, number[&j], -1.0)),
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &entries).ok()?;
    Cholesky::new(matrix.as_ref()).ok()?.solve(&mut right);
    let inner = |v: usize| number.get(&v).map(|&k| Uv::new(right[(k, 0)], right[(k, 1)]));
    (0..points.len()).map(|v| uv[v].or_else(|| inner(v))).collect()
}

fn longest_boundary(points: &[Point], triangles: &[[usize; 3]]) -> Option<Vec<usize>> {
    let sides = || triangles.iter().flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
    let all: std::collections::HashSet<_> = sides().collect();
    let open: Vec<_> = sides().filter(|&(a, b)| !all.contains(&(b, a))).collect();
    let mut next: HashMap<usize, usize> = open.iter().copied().collect();
    let mut longest: Option<(f64, Vec<usize>)> = None;
    for (start, _) in open {
        let (mut ring, mut length, mut v) = (Vec::new(), 0.0, start);
        while let Some(w) = next.remove(&v) {
            length += (points[w] - points[v]).norm();
            ring.push(v);
            v = w;
        }
        // A boundary that comes to a vertex twice gives several rings.
        if v == start && ring.len() > 2 && longest.as_ref().is_none_or(|l| length > l.0) {
            longest = Some((length, ring));
        }
    }
    Some(longest?.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rolled_sheet_is_unrolled() {
        let (n, m) = (40, 12);
        let at = |i: usize, j: usize| {
            let angle = 5.0 * i as f64 / (n - 1) as f64;
            Point::new(10.0 * angle.sin(), j as f64, 10.0 * angle.cos())
        };
        let points: Vec<Point> = (0..n * m).map(|k| at(k / m, k % m)).collect();
        let cells = (0..n - 1).flat_map(|i| (0..m - 1).map(move |j| i * m + j));
        let triangles: Vec<[usize; 3]> =
            cells.flat_map(|k| [[k, k + m, k + m + 1], [k, k + m + 1, k + 1]]).collect();
        let uv = lay_out(&points, &triangles, None).unwrap();
        for t in &triangles {
            for k in 0..3 {
                let (i, j) = (t[k], t[(k + 1) % 3]);
                let ratio = (uv[i] - uv[j]).norm() / (points[i] - points[j]).norm();
                assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
            }
        }
        assert!(((uv[0] - uv[(n - 1) * m]).norm() - 50.0).abs() < 1.0);
    }
}
