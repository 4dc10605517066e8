//! Least-squares fit of a closed cubic B-spline to a closed polygon of the parameter plane.
//!
//! The input is a weighted polygon and the knots. The output is the curve over [0, 1] and its
//! division into clamped arcs.

use faer::sparse::{SparseColMat, Triplet};
use nalgebra::Vector2;

use crate::geometry::Uv;
use crate::solve::cholesky::Cholesky;
use crate::spline::{Curve, KnotVector, MOST_SPANS, runs};

/// The least number of samples of a knot span.
const MIN_SAMPLES: usize = 6;

/// A closed polygon over [0, 1]. Corner i has the parameter `parameters[i]`. The first corner is
/// at 0 and again at 1.
#[derive(Debug, Clone)]
pub(crate) struct ClosedPolygon {
    /// Ascending parameters.
    pub parameters: Vec<f64>,
    /// The corners.
    pub uv: Vec<Uv>,
    /// The weight of each corner in a fit. Between corners the weight is interpolated linearly.
    pub weights: Vec<f64>,
}

impl ClosedPolygon {
    /// The number of corners before parameter `t`.
    pub(crate) fn before(&self, t: f64) -> usize {
        self.parameters.partition_point(|&p| p < t)
    }

    /// The point at `t` and its weight.
    fn at(&self, t: f64) -> (Uv, f64) {
        let n = self.uv.len();
        let i = self.parameters.partition_point(|&p| p <= t).clamp(1, n) - 1;
        let end = self.parameters.get(i + 1).copied().unwrap_or(1.0);
        let share = ((t - self.parameters[i]) / (end - self.parameters[i])).clamp(0.0, 1.0);
        let next = (i + 1) % n;
        let weight = self.weights[i] + share * (self.weights[next] - self.weights[i]);
        (self.uv[i] + share * (self.uv[next] - self.uv[i]), weight)
    }
}

/// The knots of a closed curve.
#[derive(Debug, Clone)]
pub(crate) struct ClosedKnots {
    /// Distinct knots in [0, 1), ascending from 0.
    pub breaks: Vec<f64>,
    /// The knots at which the curve has a corner. If there are any, 0 is one of them.
    pub corners: Vec<f64>,
}

impl ClosedKnots {
    /// The knot vector of the closed curve as an ordinary spline over [0, 1]. Corners are triple
    /// knots.
    fn unrolled(&self) -> KnotVector {
        let times = |t: &f64| if self.corners.contains(t) { 3 } else { 1 };
        let ring: Vec<f64> =
            self.breaks.iter().flat_map(|t| std::iter::repeat_n(*t, times(t))).collect();
        // The knots of one turn, three before and four after it.
        let n = ring.len() as isize;
        let knot = |i: isize| ring[i.rem_euclid(n) as usize] + i.div_euclid(n) as f64;
        KnotVector::new(3, (-3..n + 4).map(knot).collect())
    }
}

/// Fits a curve to a closed polygon by least squares: it minimizes the weighted integral of the
/// squared distance over the parameter. The result is an ordinary B-spline over [0, 1]. There must
/// be at least four knots. `None` if the equations are singular.
pub fn fit(polygon: &ClosedPolygon, knots: &ClosedKnots) -> Option<Curve<2>> {
    let vector = knots.unrolled();
    let n = vector.functions() - 3;
    let mut entries = Vec::new();
    let mut right = faer::Mat::<f64>::zeros(n, 2);
    for span in vector.breaks().windows(2) {
        let count = MIN_SAMPLES.max(3 * (polygon.before(span[1]) - polygon.before(span[0])));
        let step = (span[1] - span[0]) / count as f64;
        let mut gram = [[0.0; 4]; 4];
        let first = vector.basis(0.5 * (span[0] + span[1])).first;
        for k in 0..count {
            let t = span[0] + (k as f64 + 0.5) * step;
            let ((at, weight), b) = (polygon.at(t), vector.basis(t).derivative[0]);
            let step = weight * step;
            for i in 0..4 {
                (0..4).for_each(|j| gram[i][j] += step * b[i] * b[j]);
                right[((first + i) % n, 0)] += step * b[i] * at.x;
                right[((first + i) % n, 1)] += step * b[i] * at.y;
            }
        }
        for (i, row) in gram.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                let (i, j) = ((first + i) % n, (first + j) % n);
                entries.extend((i >= j).then_some(Triplet::new(i, j, value)));
            }
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(n, n, &entries).ok()?;
    Cholesky::new(matrix.as_ref()).ok()?.solve(&mut right);
    let control = |i: usize| Vector2::new(right[(i % n, 0)], right[(i % n, 1)]);
    let control: Vec<Vector2<f64>> = (0..n + 3).map(control).collect();
    let finite = control.iter().all(|p| p.x.is_finite() && p.y.is_finite());
    finite.then(|| Curve::new(vector, control))
}

/// Divides the closed curve into clamped arcs from corner to corner. Long arcs are divided again
/// at knots. There are at least two arcs, because an edge needs two different ends.
pub(crate) fn arcs(curve: &Curve<2>, knots: &ClosedKnots) -> Vec<Curve<2>> {
    let mut ends = if knots.corners.is_empty() { vec![0.0] } else { knots.corners.clone() };
    let least = if ends.len() < 2 { 2 } else { 1 };
    ends.push(1.0);
    let mut cuts = Vec::new();
    for w in ends.windows(2) {
        let inside = |t: &f64| w[0] < *t && *t < w[1];
        let mut breaks = vec![w[0]];
        breaks.extend(knots.breaks.iter().copied().filter(inside));
        breaks.push(w[1]);
        let mut ends = runs(&breaks, MOST_SPANS, least);
        ends.pop();
        cuts.extend(ends);
    }
    cuts.push(1.0);
    cuts.windows(2).map(|w| curve.part(w[0], w[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(n: usize, at: impl Fn(f64) -> (f64, f64)) -> ClosedPolygon {
        let parameters: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
        let uv = parameters.iter().map(|&t| at(t)).map(|(u, v)| Uv::new(u, v)).collect();
        ClosedPolygon { parameters, uv, weights: vec![1.0; n] }
    }

    #[test]
    fn a_round_loop_is_followed_and_cut_in_two() {
        let angle = |t: f64| std::f64::consts::TAU * t;
        let circle = polygon(60, |t| (0.5 + 0.2 * angle(t).cos(), 0.5 - 0.2 * angle(t).sin()));
        let breaks = (0..8).map(|i| f64::from(i) / 8.0).collect();
        let knots = ClosedKnots { breaks, corners: vec![] };
        let curve = fit(&circle, &knots).unwrap();
        for (t, p) in circle.parameters.iter().zip(&circle.uv) {
            assert!((curve.point(*t) - p.coords).norm() < 1e-3);
        }
        let arcs = arcs(&curve, &knots);
        assert!((arcs[0].point(0.5) - arcs[1].point(0.5)).norm() < 1e-14);
        assert!((arcs[0].point(0.0) - arcs[1].point(1.0)).norm() < 1e-14);
    }

    #[test]
    fn a_square_has_its_corners() {
        let corners = [(0.2, 0.2), (0.2, 0.8), (0.8, 0.8), (0.8, 0.2)];
        let square = polygon(40, |t| {
            let (i, s) = ((4.0 * t) as usize % 4, (4.0 * t).fract());
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1))
        });
        let quarters = vec![0.0, 0.25, 0.5, 0.75];
        let knots = ClosedKnots { breaks: quarters.clone(), corners: quarters };
        let sides = arcs(&fit(&square, &knots).unwrap(), &knots);
        assert_eq!(sides.len(), 4);
        for (side, (u, v)) in sides.iter().zip(corners) {
            let start = side.control.first().unwrap();
            assert!((start - Vector2::new(u, v)).norm() < 1e-12);
            assert_eq!(side.control.len(), 4);
        }
    }
}
