//! The reference plane of an MLS projection.

use nalgebra::{Matrix3, Vector3};

use super::Sample;
use crate::geometry::{MOST_ROUNDS, Point, ROUNDING, Vector, plane_axes};
use crate::solve::shares;

/// A plane through a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ReferencePlane {
    /// The foot point of r on the plane.
    pub origin: Point,
    /// The unit normal.
    pub normal: Vector,
}

/// Value, half gradient and Gauss–Newton matrix of the energy of the plane. The unknowns are t, the
/// tilt towards x and the tilt towards y.
pub(super) struct PlaneEnergy {
    pub(super) value: f64,
    gradient: Vector3<f64>,
    matrix: Matrix3<f64>,
}

pub(super) fn energy(r: Point, n: Vector, t: f64, around: &[Sample], h: f64) -> PlaneEnergy {
    let (x, y) = plane_axes(n);
    let inverse = 1.0 / (h * h);
    let mut e = PlaneEnergy { value: 0.0, gradient: Vector3::zeros(), matrix: Matrix3::zeros() };
    let mut sums = [0.0; 6];
    for p in around {
        let d = p.at - r;
        let height = d.dot(&n);
        let s = height - t;
        let weight = p.weight * (-(d.norm_squared() - 2.0 * t * height + t * t) * inverse).exp();
        let (a, b) = (d.dot(&x), d.dot(&y));
        // The second terms come from the weights, which move with the plane.
        let by_t = weight * (s - s * s * s * inverse);
        let by_tilt = weight * (s + s * s * t * inverse);
        e.value += weight * s * s;
        e.gradient += Vector3::new(-by_t, by_tilt * a, by_tilt * b);
        let (wa, wb) = (weight * a, weight * b);
        sums[0] += weight;
        sums[1] += wa;
        sums[2] += wb;
        sums[3] += wa * a;
        sums[4] += wa * b;
        sums[5] += wb * b;
    }
    let [one, a, b, aa, ab, bb] = sums;
    e.matrix = Matrix3::new(one, -a, -b, -a, aa, ab, -b, ab, bb);
    e
}

/// The iteration stops when a step moves the plane by less than this share of h and turns it by
/// less than this angle in radians.
const CONVERGED: f64 = 1e-3;

/// Finds the plane that minimises the energy, by Gauss–Newton steps with the exact gradient. The
/// iteration starts at (n, t) = (`normal`, 0). Each step is shortened until the energy decreases.
/// The energy also decreases towards infinity, where the weights vanish; t is therefore limited to
/// ±h. Returns `None` if there are fewer than three points or no start normal.
pub(crate) fn reference_plane(
    r: Point,
    normal: Vector,
    around: &[Sample],
    h: f64,
) -> Option<ReferencePlane> {
    if around.len() < 3 || normal.norm_squared() < 0.5 {
        return None;
    }
    let (mut n, mut t) = (normal, 0.0);
    let mut at = energy(r, n, t, around, h);
    for _ in 0..MOST_ROUNDS {
        let damped = at.matrix + Matrix3::identity() * (ROUNDING * at.matrix.trace());
        let step = -damped.cholesky()?.solve(&at.gradient);
        let (x, y) = plane_axes(n);
        if step.x.abs() < CONVERGED * h && step.yz().norm() < CONVERGED {
            // The step is so short that the energy need not be evaluated again.
            t = (t + step.x).clamp(-h, h);
            n = (n + step.y * x + step.z * y).normalize();
            break;
        }
        let accepted = shares().find_map(|share| {
            let t2 = (t + share * step.x).clamp(-h, h);
            let n2 = (n + share * (step.y * x + step.z * y)).normalize();
            let next = energy(r, n2, t2, around, h);
            (next.value <= at.value).then_some((n2, t2, next))
        });
        let Some(better) = accepted else { break };
        (n, t, at) = better;
    }
    Some(ReferencePlane { origin: r + t * n, normal: n })
}
