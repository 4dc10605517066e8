//! Mean value coordinates (Floater, "Mean value coordinates", 2003): every
//! inner vertex is the weighted mean of its neighbours.

use faer::sparse::{SparseColMat, Triplet};

use super::lu::Lu;
use super::stars::Stars;
use crate::error::{self, Result, Unsolved};
use crate::geometry::{Point, Uv};

/// The weights of the neighbours `ring`, all around the point `p`:
/// (tan(α/2) + tan(β/2)) / ‖q − p‖ with the angles at p on both sides of the
/// edge to q. All are positive, so the map is a convex combination.
pub fn shares(p: Point, ring: &[u32], points: &[Point]) -> Vec<(u32, f64)> {
    let n = ring.len();
    let away: Vec<_> = ring.iter().map(|&w| points[w as usize] - p).collect();
    let longest = away.iter().map(|d| d.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let length = |i: usize| away[i % n].norm().max(SHORTEST * longest);
    // tan(α/2) = sin α / (1 + cos α), bounded where a needle's angle comes near
    // a half turn, and from below where it vanishes.
    let tangent = |i: usize| {
        let (d, e) = (away[i % n], away[(i + 1) % n]);
        let product = length(i) * length(i + 1);
        (d.cross(&e).norm() / (product + d.dot(&e)).max(1e-8 * product)).max(1e-8)
    };
    let share = |i: usize| (tangent(i) + tangent(i + n - 1)) / length(i);
    ring.iter().enumerate().map(|(i, &w)| (w, share(i))).collect()
}

/// Edges count as if they were this share of the star's longest at least.
const SHORTEST: f64 = 1e-6;

/// Moves the `inner` vertices to where each is its neighbours' mean by mean value
/// weights, with all others held.
pub fn mean_value(points: &[Point], stars: &Stars, inner: &[u32], at: &mut [Uv]) -> Result<()> {
    solve(stars, inner, at, |v| shares(points[v as usize], stars.ring(v), points))
}

/// The same by even weights (Tutte), which no shape of a triangle can spoil.
pub fn even(stars: &Stars, inner: &[u32], at: &mut [Uv]) -> Result<()> {
    solve(stars, inner, at, |v| stars.ring(v).iter().map(|&w| (w, 1.0)).collect())
}

/// Sparse LU, since mean value weights are not symmetric.
fn solve(
    stars: &Stars,
    inner: &[u32],
    at: &mut [Uv],
    shares: impl Fn(u32) -> Vec<(u32, f64)>,
) -> Result<()> {
    let failed = error::unsolved("parameterization");
    let n = inner.len();
    if n == 0 {
        return Ok(());
    }
    let mut unknown = vec![u32::MAX; stars.len()];
    inner.iter().enumerate().for_each(|(i, &v)| unknown[v as usize] = i as u32);
    let mut triplets = Vec::with_capacity(7 * n);
    let mut right = faer::Mat::<f64>::zeros(n, 2);
    for (i, &v) in inner.iter().enumerate() {
        let shares = shares(v);
        let total: f64 = shares.iter().map(|s| s.1).sum();
        triplets.push(Triplet::new(i as u32, i as u32, 1.0));
        for (w, share) in shares {
            let share = share / total;
            match unknown[w as usize] {
                u32::MAX => {
                    right[(i, 0)] += share * at[w as usize].x;
                    right[(i, 1)] += share * at[w as usize].y;
                }
                column => triplets.push(Triplet::new(i as u32, column, -share)),
            }
        }
    }
    let matrix = SparseColMat::<u32, f64>::try_new_from_triplets(n, n, &triplets);
    let matrix = matrix.map_err(|why| failed(why.into()))?;
    drop(triplets);
    Lu::new(matrix.as_ref()).map_err(|why| failed(why.into()))?.solve(&mut right);
    for (i, &v) in inner.iter().enumerate() {
        at[v as usize] = Uv::new(right[(i, 0)], right[(i, 1)]);
    }
    let finite = |p: &Uv| p.x.is_finite() && p.y.is_finite();
    let all = inner.iter().all(|&v| finite(&at[v as usize]));
    if all { Ok(()) } else { Err(failed(Unsolved::Singular)) }
}
