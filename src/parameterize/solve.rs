//! The linear system: every inner vertex is the weighted mean of its
//! neighbours.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};

use super::weights::Weights;
use crate::error::{Error, Result};
use crate::geometry::Uv;
use crate::mesh::Patch;

/// Solves for the inner vertices, given the outer loop's parameter points.
/// Sparse LU, since mean value weights are not symmetric.
pub fn convex_combination(patch: &Patch, weights: &Weights, rim: &[Uv]) -> Result<Vec<Uv>> {
    const INNER: Uv = Uv::new(f64::NAN, f64::NAN);
    let mut uv = vec![INNER; patch.mesh.points.len()];
    for (v, &at) in patch.outer.iter().zip(rim) {
        uv[v.index()] = at;
    }
    let mut unknown = vec![u32::MAX; uv.len()];
    let inner: Vec<usize> = (0..uv.len()).filter(|&v| uv[v].x.is_nan()).collect();
    for (i, &v) in inner.iter().enumerate() {
        unknown[v] = i as u32;
    }
    if inner.is_empty() {
        return Ok(uv);
    }
    let totals = totals(patch, weights);
    let mut triplets = Vec::with_capacity(7 * inner.len());
    triplets.extend((0..inner.len() as u32).map(|i| Triplet::new(i, i, 1.0)));
    let mut right = faer::Mat::<f64>::zeros(inner.len(), 2);
    for (t, pairs) in patch.mesh.triangles.iter().zip(&weights.pairs) {
        for k in 0..3 {
            let row = unknown[t[k].index()];
            if row == u32::MAX {
                continue;
            }
            for (j, w) in pairs[k].iter().enumerate() {
                let other = t[(k + 1 + j) % 3].index();
                let share = w / totals[t[k].index()];
                if unknown[other] == u32::MAX {
                    right[(row as usize, 0)] += share * uv[other].x;
                    right[(row as usize, 1)] += share * uv[other].y;
                } else {
                    triplets.push(Triplet::new(row, unknown[other], -share));
                }
            }
        }
    }
    let n = inner.len();
    let singular = |_| Error::Singular("parameterization");
    let matrix = SparseColMat::<u32, f64>::try_new_from_triplets(n, n, &triplets)
        .map_err(|_| Error::Singular("parameterization"))?;
    drop(triplets);
    let solution = matrix.sp_lu().map_err(singular)?.solve(&right);
    for (i, &v) in inner.iter().enumerate() {
        uv[v] = Uv::new(solution[(i, 0)], solution[(i, 1)]);
    }
    if uv.iter().any(|p| !(p.x.is_finite() && p.y.is_finite())) {
        return Err(Error::Singular("parameterization"));
    }
    Ok(uv)
}

fn totals(patch: &Patch, weights: &Weights) -> Vec<f64> {
    let mut totals = vec![0.0; patch.mesh.points.len()];
    for (t, pairs) in patch.mesh.triangles.iter().zip(&weights.pairs) {
        for k in 0..3 {
            totals[t[k].index()] += pairs[k][0] + pairs[k][1];
        }
    }
    totals
}
