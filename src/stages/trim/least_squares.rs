//! The cubic B-spline nearest to a polygon of the parameter plane.

use faer::sparse::{SparseColMat, Triplet};
use nalgebra::Vector2;

use super::polygon::Polygon;
use crate::solve::cholesky::Cholesky;
use crate::spline::{Curve, KnotVector};

/// The least number of samples of a knot span.
const MIN_SAMPLES: usize = 6;

/// The knots of a curve over [0, 1].
#[derive(Debug, Clone)]
pub(super) struct Knots {
    /// Distinct knots in [0, 1), ascending from 0.
    pub breaks: Vec<f64>,
    /// The knots at which the curve has a corner. If a closed curve has any, 0 is one of them.
    pub corners: Vec<f64>,
}

impl Knots {
    /// The ends of span `i`.
    pub(super) fn span(&self, i: usize) -> (f64, f64) {
        (self.breaks[i], self.breaks.get(i + 1).copied().unwrap_or(1.0))
    }

    /// The knot vector of a closed curve as an ordinary spline over [0, 1]. Corners are triple
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

    /// The knot vector of a curve with ends.
    fn clamped(&self) -> KnotVector {
        KnotVector::clamped(3, &[&self.breaks[..], &[1.0]].concat(), 1)
    }
}

/// The curve over `knots` that minimizes the integral of the squared distance from a polygon over the parameter.
/// An open curve has the ends of the polygon. A closed one must have at least four knots. `None` if the equations
/// are singular.
pub(super) fn nearest_curve(polygon: &Polygon<'_>, knots: &Knots) -> Option<Curve<2>> {
    let vector = if polygon.is_closed { knots.unrolled() } else { knots.clamped() };
    let functions = vector.functions();
    // The last three control points of a closed curve are its first three. Those at the ends of an open one are known.
    let unknown = functions - if polygon.is_closed { 3 } else { 2 };
    let row = |i: usize| match polygon.is_closed {
        true => Some(i % unknown),
        false => i.checked_sub(1).filter(|&i| i < unknown),
    };
    let ends = [polygon.uv[0].coords, polygon.uv[polygon.uv.len() - 1].coords];
    let mut entries = Vec::new();
    let mut right = faer::Mat::<f64>::zeros(unknown, 2);
    for span in vector.breaks().windows(2) {
        let count = MIN_SAMPLES.max(3 * (polygon.before(span[1]) - polygon.before(span[0])));
        let step = (span[1] - span[0]) / count as f64;
        let mut gram = [[0.0; 4]; 4];
        let start = vector.basis(0.5 * (span[0] + span[1])).first;
        for k in 0..count {
            let t = span[0] + (k as f64 + 0.5) * step;
            let (mut at, b) = (polygon.at(t).coords, vector.basis(t).derivative[0]);
            for (i, &b) in b[..=3].iter().enumerate().filter(|(i, _)| row(start + i).is_none()) {
                at -= b * ends[usize::from(start + i > 0)];
            }
            for i in 0..4 {
                (0..4).for_each(|j| gram[i][j] += step * b[i] * b[j]);
                if let Some(i_row) = row(start + i) {
                    right[(i_row, 0)] += step * b[i] * at.x;
                    right[(i_row, 1)] += step * b[i] * at.y;
                }
            }
        }
        for (i, values) in gram.iter().enumerate() {
            for (j, &value) in values.iter().enumerate() {
                if let (Some(i), Some(j)) = (row(start + i), row(start + j)) {
                    entries.extend((i >= j).then_some(Triplet::new(i, j, value)));
                }
            }
        }
    }
    let matrix =
        SparseColMat::<usize, f64>::try_new_from_triplets(unknown, unknown, &entries).ok()?;
    Cholesky::new(matrix.as_ref()).ok()?.solve(&mut right);
    let [low, high] = polygon.range;
    let control = |i: usize| match row(i) {
        Some(i) => Vector2::new(right[(i, 0)], right[(i, 1)]).map(|x| x.clamp(low, high)),
        None => ends[usize::from(i > 0)],
    };
    let control: Vec<Vector2<f64>> = (0..functions).map(control).collect();
    let finite = control.iter().all(|p| p.x.is_finite() && p.y.is_finite());
    finite.then(|| Curve::new(vector, control))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Uv, Vector};
    use crate::spline::Surface;

    /// The unit square as a surface.
    fn square() -> Surface {
        let k = KnotVector::uniform(1, 2);
        let net = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]];
        Surface::new(k.clone(), k, net.map(|[x, y]| Vector::new(x, y, 0.0)).to_vec())
    }

    /// A polygon of `n` corners on the unit square.
    fn polygon(
        surface: &Surface,
        n: usize,
        is_closed: bool,
        at: impl Fn(f64) -> (f64, f64),
    ) -> Polygon<'_> {
        let edges = n - usize::from(!is_closed);
        let corner = |i: usize| {
            let (u, v) = at(i as f64 / edges as f64);
            (Uv::new(u, v), 0.0)
        };
        let corners: Vec<_> = (0..n).map(corner).collect();
        Polygon::new(surface, &corners, is_closed, [0.0, 1.0]).unwrap().0
    }

    #[test]
    fn a_circle_is_closed_and_smooth() {
        let angle = |t: f64| std::f64::consts::TAU * t;
        let at = |t| (0.5 + 0.2 * angle(t).cos(), 0.5 - 0.2 * angle(t).sin());
        let surface = square();
        let circle = polygon(&surface, 60, true, at);
        let breaks = (0..8).map(|i| f64::from(i) / 8.0).collect();
        let curve = nearest_curve(&circle, &Knots { breaks, corners: vec![] }).unwrap();
        for (t, p) in circle.parameters.iter().zip(&circle.uv) {
            assert!((curve.point(*t) - p.coords).norm() < 1e-3);
        }
        let [ends, slopes, _] =
            std::array::from_fn(|k| [0.0, 1.0].map(|t| curve.derivatives(t)[k]));
        assert!((ends[0] - ends[1]).norm() < 1e-14);
        assert!((slopes[0] - slopes[1]).norm() < 1e-12);
    }

    #[test]
    fn an_open_curve_has_the_ends_of_its_polygon() {
        let at = |t: f64| (0.1 + 0.8 * t, 0.2 + 0.5 * t * t * t);
        let surface = square();
        let line = polygon(&surface, 50, false, at);
        let knots = Knots { breaks: vec![0.0, 0.25, 0.5, 0.75], corners: vec![] };
        let curve = nearest_curve(&line, &knots).unwrap();
        for t in [0.0, 1.0] {
            assert_eq!(curve.point(t), Vector2::new(at(t).0, at(t).1));
        }
        for (t, p) in line.parameters.iter().zip(&line.uv) {
            assert!((curve.point(*t) - p.coords).norm() < 1e-3);
        }
    }

    #[test]
    fn a_square_has_its_corners() {
        let corners = [(0.2, 0.2), (0.2, 0.8), (0.8, 0.8), (0.8, 0.2)];
        let surface = square();
        let square = polygon(&surface, 40, true, |t| {
            let (i, s) = ((4.0 * t) as usize % 4, (4.0 * t).fract());
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            (a.0 + s * (b.0 - a.0), a.1 + s * (b.1 - a.1))
        });
        let quarters = vec![0.0, 0.25, 0.5, 0.75];
        let curve = nearest_curve(&square, &Knots { breaks: quarters.clone(), corners: quarters });
        let curve = curve.unwrap();
        for (i, (u, v)) in corners.into_iter().enumerate() {
            assert!((curve.point(0.25 * i as f64) - Vector2::new(u, v)).norm() < 1e-12);
        }
    }
}
