//! The control points that fit a scan at given foot points: a linear least-squares problem with
//! sparse normal equations.

use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::feet::Feet;
use super::{FitTarget, Net};
use crate::cholesky::Cholesky;
use crate::error::{Error, Result};
use crate::geometry::{Point, Vector};
use crate::spline::subdivision::limit_weights;

/// The weight of fairing, beside the mean weight of the points of a control point. Larger weights
/// flatten the shape, and smaller ones let the net fold where it has few points.
const FAIRING: f64 = 1e-3;

/// The weight of anchors, beside the mean weight of the points of a control point. Larger weights keep
/// the surface from the points, and without anchors quads slide along the surface until they fold.
const ANCHOR: f64 = 0.03;

/// The lower triangle of the part of the normal matrix that belongs to one quad, and the right side.
struct QuadSums {
    matrix: DMatrix<f64>,
    right: Vec<Vector>,
}

/// Solves for the control points. The surface is held near the anchors, and where the `firmness` of a
/// vertex exceeds one, its control point is, too. A net whose control points are the vertices of a
/// layout without folds hardly folds, and one whose surface goes through them may.
pub(super) fn control_points(
    net: &Net,
    target: &FitTarget,
    feet: &Feet,
    firmness: &[f64],
    anchors: &[Point],
) -> Result<Vec<Point>> {
    let count = net.mesh.points.len();
    let members = members(net, feet);
    let sums = members.par_iter().enumerate().map_init(Vec::new, |scratch, (quad, points)| {
        quad_sums(net, target, feet, quad, points, scratch)
    });
    let sums: Vec<QuadSums> = sums.collect();
    let mut right = Mat::<f64>::zeros(count, 3);
    let mut entries = Vec::new();
    for (quad, of_quad) in sums.iter().enumerate() {
        let control = net.surface.control(quad);
        for (i, &a) in control.iter().enumerate() {
            let a = a as usize;
            (0..3).for_each(|k| right[(a, k)] += of_quad.right[i][k]);
            // A control point occurs twice in a quad near a vertex with three quads.
            for (j, &b) in control.iter().enumerate() {
                let b = b as usize;
                let value = of_quad.matrix[(i.max(j), i.min(j))];
                if a >= b && value != 0.0 {
                    entries.push(Triplet::new(a, b, value));
                }
            }
        }
    }
    let total: f64 = members.iter().flatten().map(|&i| target.weights[i as usize]).sum();
    let mean = total.max(1.0) / count as f64;
    for (v, anchor) in anchors.iter().enumerate() {
        let row = limit_row(net, v);
        let weight = ANCHOR * mean;
        for &(a, x) in &row {
            (0..3).for_each(|k| right[(a, k)] += weight * x * anchor[k]);
        }
        add_square(&row, weight, &mut entries);
        let hold = weight * (firmness[v] - 1.0);
        if hold > 0.0 {
            (0..3).for_each(|k| right[(v, k)] += hold * anchor[k]);
            entries.push(Triplet::new(v, v, hold));
        }
    }
    for v in 0..count {
        add_square(&umbrella(net, v), FAIRING * mean, &mut entries);
    }
    let singular = |_| Error::Singular("net");
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(count, count, &entries);
    let matrix = matrix.map_err(|_| Error::Memory("net"))?;
    Cholesky::new(matrix.as_ref()).map_err(singular)?.solve(&mut right);
    let point = |v: usize| Point::new(right[(v, 0)], right[(v, 1)], right[(v, 2)]);
    Ok((0..count).map(point).collect())
}

/// The points whose foot points lie on each quad.
fn members(net: &Net, feet: &Feet) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); net.mesh.quads.len()];
    for (i, foot) in feet.feet.iter().enumerate() {
        if let Some(foot) = foot {
            members[foot.place.quad].push(i as u32);
        }
    }
    members
}

fn quad_sums(
    net: &Net,
    target: &FitTarget,
    feet: &Feet,
    quad: usize,
    points: &[u32],
    scratch: &mut Vec<[f64; 3]>,
) -> QuadSums {
    let size = net.surface.control(quad).len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut right = vec![Vector::zeros(); size];
    for &i in points {
        let i = i as usize;
        let Some(foot) = feet.feet[i] else { continue };
        net.surface.basis(foot.place, scratch);
        let w = target.weights[i];
        for (a, x) in scratch.iter().enumerate() {
            right[a] += w * x[0] * target.points[i].coords;
            for (b, y) in scratch[..=a].iter().enumerate() {
                matrix[(a, b)] += w * x[0] * y[0];
            }
        }
    }
    QuadSums { matrix, right }
}

/// Adds the square of a row of the least-squares problem to the lower triangle.
fn add_square(row: &[(usize, f64)], weight: f64, entries: &mut Vec<Triplet<usize, usize, f64>>) {
    for &(a, x) in row {
        let lower = row.iter().filter(|&&(b, _)| a >= b);
        entries.extend(lower.map(|&(b, y)| Triplet::new(a, b, weight * x * y)));
    }
}

/// The umbrella operator at a vertex: its control point minus the mean of its neighbours.
fn umbrella(net: &Net, v: usize) -> Vec<(usize, f64)> {
    let (quad, k) = net.surface.corner(v.into());
    let ring = net.surface.ring(quad, k);
    let n = (ring.len() / 2) as f64;
    let spokes = ring.iter().skip(1).step_by(2).map(|&w| (w as usize, -1.0 / n));
    std::iter::once((v, 1.0)).chain(spokes).collect()
}

/// The point of the limit surface at a vertex.
fn limit_row(net: &Net, v: usize) -> Vec<(usize, f64)> {
    let (quad, k) = net.surface.corner(v.into());
    let ring = net.surface.ring(quad, k);
    let weights = limit_weights(ring.len());
    ring.iter().map(|&w| w as usize).zip(weights).collect()
}
