//! Linear maps in which every inner vertex is a weighted mean of its neighbours: mean value
//! coordinates (Floater, "Mean value coordinates", 2003) and even weights (Tutte, "How to draw a
//! graph", 1963).

use faer::sparse::{SparseColMat, Triplet};

use super::lu::Lu;
use crate::error::{self, Result, Unsolved};
use crate::geometry::{NEGLIGIBLE, NONE, Point, Uv};
use crate::mesh::one_rings::OneRings;

/// The mean value weights of the neighbours `ring` around the point `p`: (tan(α/2) + tan(β/2)) / ‖q
/// − p‖, where α and β are the angles at p on the two sides of the edge to q. All weights are
/// positive, so the map is a convex combination.
pub(crate) fn shares(p: Point, ring: &[u32], points: &[Point]) -> Vec<(u32, f64)> {
    let n = ring.len();
    let away: Vec<_> = ring.iter().map(|&w| points[w as usize] - p).collect();
    let longest = away.iter().map(|d| d.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let length = |i: usize| away[i % n].norm().max(NEGLIGIBLE * longest);
    // tan(α/2) = sin α / (1 + cos α). It is bounded above for needles whose angle is nearly a half
    // turn, and below where the angle vanishes.
    let tangent = |i: usize| {
        let (d, e) = (away[i % n], away[(i + 1) % n]);
        let product = length(i) * length(i + 1);
        (d.cross(&e).norm() / (product + d.dot(&e)).max(NEGLIGIBLE * product)).max(NEGLIGIBLE)
    };
    let share = |i: usize| (tangent(i) + tangent(i + n - 1)) / length(i);
    ring.iter().enumerate().map(|(i, &w)| (w, share(i))).collect()
}

/// Moves each of the `inner` vertices to the mean of its neighbours with mean value weights. All
/// others stay in place.
pub(crate) fn mean_value(
    points: &[Point],
    rings: &OneRings,
    inner: &[u32],
    at: &mut [Uv],
) -> Result<()> {
    solve(rings, inner, at, |v| shares(points[v as usize], rings.ring(v), points))
}

/// Moves each of the `inner` vertices to the mean of its neighbours with even weights (Tutte). This
/// does not depend on the shapes of the triangles.
pub(crate) fn even(rings: &OneRings, inner: &[u32], at: &mut [Uv]) -> Result<()> {
    solve(rings, inner, at, |v| rings.ring(v).iter().map(|&w| (w, 1.0)).collect())
}

/// Solves by a sparse LU factorization, because mean value weights are not symmetric.
fn solve(
    rings: &OneRings,
    inner: &[u32],
    at: &mut [Uv],
    shares: impl Fn(u32) -> Vec<(u32, f64)>,
) -> Result<()> {
    let failed = error::unsolved("parameterization");
    let n = inner.len();
    if n == 0 {
        return Ok(());
    }
    let mut unknown = vec![NONE; rings.len()];
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
                NONE => {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::one_rings::tests::grid;

    #[test]
    fn a_flat_sheet_keeps_its_places() {
        let patch = grid(20);
        let rings = OneRings::new(&patch.mesh, &patch.outer);
        let flat: Vec<Uv> = patch.mesh.points.iter().map(|p| Uv::new(p.x, p.y)).collect();
        let inner: Vec<u32> = (0..flat.len() as u32).filter(|&v| !rings.on_boundary(v)).collect();
        let mut at = flat.clone();
        inner.iter().for_each(|&v| at[v as usize] = Uv::origin());
        mean_value(&patch.mesh.points, &rings, &inner, &mut at).unwrap();
        assert!(at.iter().zip(&flat).all(|(p, q)| (p - q).norm() < 1e-9));
    }
}
