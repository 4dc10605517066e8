//! Closed uniform cubic B-splines in the parameter plane.

use nalgebra::{DMatrix, SVector, Vector2};

use crate::geometry::{Point, Uv};
use crate::spline::{Curve, KnotVector, Surface};

/// Samples a control point at the least.
const SAMPLES: usize = 3;

/// A periodic uniform cubic B-spline over [0, 1].
#[derive(Debug, Clone)]
pub struct ClosedCubic {
    control: Vec<Vector2<f64>>,
    /// The parameters of the points it was fitted to.
    parameters: Vec<f64>,
}

impl ClosedCubic {
    /// The least-squares curve with `n` control points through the closed
    /// polygon `uv`, with parameters by the chord length of `points`. The
    /// polygon's edges are sampled as often as `n` control points need. A weak
    /// pull towards even third differences settles what samples leave open.
    pub fn fit(surface: &Surface, points: &[Point], uv: &[Uv], n: usize) -> Option<Self> {
        let parameters = chord_parameters(points)?;
        let metric = mean_metric(surface, uv);
        let mut gram = DMatrix::<f64>::zeros(n, n);
        let mut right = DMatrix::<f64>::zeros(n, 2);
        let m = uv.len();
        let pieces = (SAMPLES * n).div_ceil(m).max(1);
        for i in 0..m {
            let end = if i + 1 < m { parameters[i + 1] } else { 1.0 };
            for piece in 0..pieces {
                let s = piece as f64 / pieces as f64;
                let at = uv[i] + s * (uv[(i + 1) % m] - uv[i]);
                let (first, b) = basis(n, parameters[i] + s * (end - parameters[i]));
                for k in 0..4 {
                    for l in 0..4 {
                        gram[((first + k) % n, (first + l) % n)] += b[k] * b[l];
                    }
                    right[((first + k) % n, 0)] += b[k] * at.x * metric.x;
                    right[((first + k) % n, 1)] += b[k] * at.y * metric.y;
                }
            }
        }
        add_evenness(&mut gram, n, 1e-6 * (pieces * m) as f64 / n as f64);
        let solved = gram.cholesky()?.solve(&right);
        let control = (0..n)
            .map(|i| Vector2::new(solved[(i, 0)] / metric.x, solved[(i, 1)] / metric.y))
            .collect();
        Some(ClosedCubic { control, parameters })
    }

    /// The curve unrolled: an ordinary B-spline whose range is [0, 1].
    pub fn unrolled(&self) -> Curve<2> {
        let n = self.control.len();
        let knots = (0..n + 7).map(|i| (i as f64 - 3.0) / n as f64).collect();
        let control = (0..n + 3).map(|i| self.control[i % n]).collect();
        Curve::new(KnotVector::new(3, knots), control)
    }

    /// Two halves as clamped curves: an edge needs two different ends.
    pub fn arcs(&self) -> Vec<Curve<2>> {
        let whole = self.unrolled();
        vec![whole.part(0.0, 0.5), whole.part(0.5, 1.0)]
    }

    /// The farthest, in mm, that the traced curve is from the points at their
    /// own parameters.
    pub fn distance(&self, surface: &Surface, points: &[Point]) -> f64 {
        let curve = self.unrolled();
        let off = |(p, &t): (&Point, &f64)| {
            let at = surface.clamp(Uv::from(curve.point(t)));
            (surface.point(at) - p).norm()
        };
        points.iter().zip(&self.parameters).map(off).fold(0.0, f64::max)
    }
}

/// Parameters in [0, 1) by chord length around the loop.
fn chord_parameters(points: &[Point]) -> Option<Vec<f64>> {
    let m = points.len();
    let mut walked = 0.0;
    let mut parameters = Vec::with_capacity(m);
    for i in 0..m {
        parameters.push(walked);
        walked += (points[(i + 1) % m] - points[i]).norm();
    }
    (walked > 0.0 && walked.is_finite())
        .then(|| parameters.into_iter().map(|t| t / walked).collect())
}

/// Mean lengths, in mm, of a unit of u and of v along the rim.
fn mean_metric(surface: &Surface, uv: &[Uv]) -> Vector2<f64> {
    let sum = uv.iter().fold(Vector2::zeros(), |sum, &at| {
        let jet = surface.jet(at);
        sum + Vector2::new(jet.su.norm(), jet.sv.norm())
    });
    let mean: Vector2<f64> = sum / uv.len() as f64;
    mean.map(|x| if x > 0.0 { x } else { 1.0 })
}

/// The first of the four control points that matter at `t`, and their weights.
fn basis(n: usize, t: f64) -> (usize, SVector<f64, 4>) {
    let x = t.rem_euclid(1.0) * n as f64;
    let first = (x as usize).min(n - 1);
    let s = x - first as f64;
    let r = 1.0 - s;
    let b = [
        r * r * r,
        3.0 * s * s * s - 6.0 * s * s + 4.0,
        3.0 * r * r * r - 6.0 * r * r + 4.0,
        s * s * s,
    ];
    (first, SVector::from(b) / 6.0)
}

fn add_evenness(gram: &mut DMatrix<f64>, n: usize, weight: f64) {
    const THIRD: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];
    for i in 0..n {
        for k in 0..4 {
            for l in 0..4 {
                gram[((i + k) % n, (i + l) % n)] += weight * THIRD[k] * THIRD[l];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    fn plate() -> Surface {
        let k = KnotVector::uniform(3, 6);
        let net =
            (0..36).map(|n| Vector::new(200.0 * k.greville(n / 6), 50.0 * k.greville(n % 6), 0.0));
        Surface::new(k.clone(), k.clone(), net.collect())
    }

    #[test]
    fn a_round_rim_is_followed_and_split_in_two() {
        let plate = plate();
        let uv: Vec<Uv> = (0..60)
            .map(|i| std::f64::consts::TAU * f64::from(i) / 60.0)
            .map(|a| Uv::new(0.5 + 0.05 * a.cos(), 0.5 - 0.2 * a.sin()))
            .collect();
        let points: Vec<Point> = uv.iter().map(|&at| plate.point(at)).collect();
        let curve = ClosedCubic::fit(&plate, &points, &uv, 12).unwrap();
        assert!(curve.distance(&plate, &points) < 0.02);
        let arcs = curve.arcs();
        assert!((arcs[0].point(0.5) - arcs[1].point(0.5)).norm() < 1e-14);
        assert!((arcs[0].point(0.0) - arcs[1].point(1.0)).norm() < 1e-14);
    }

    #[test]
    fn three_vertices_make_a_loop() {
        let plate = plate();
        let uv = [Uv::new(0.5, 0.5), Uv::new(0.5, 0.54), Uv::new(0.51, 0.5)];
        let points: Vec<Point> = uv.iter().map(|&at| plate.point(at)).collect();
        let curve = ClosedCubic::fit(&plate, &points, &uv, 6).unwrap();
        assert!(curve.distance(&plate, &points) < 0.8);
    }
}
