//! The reference line of an MLS curve, and the quadratic over it (section 3.1).

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::geometry::{MOST_ROUNDS, NEGLIGIBLE, Point, ROUNDING, Vector, plane_axes};
use crate::solve::shares;

/// A line through the points around a place.
pub(crate) struct ReferenceLine {
    /// A point of the line.
    pub origin: Point,
    /// The unit direction of the line.
    pub along: Vector,
}

/// Value, half gradient and Gauss–Newton matrices of the energy of the line. The unknowns are the
/// shift of q and the tilt of u in each of the two directions across the line.
struct LineEnergy {
    value: f64,
    gradient: [Vector2<f64>; 2],
    matrix: Matrix2<f64>,
}

fn energy(r: Point, q: Point, u: Vector, around: &[Point], h: f64) -> LineEnergy {
    let (e1, e2) = plane_axes(u);
    let inverse = 1.0 / (h * h);
    let shift = q - r;
    let mut e =
        LineEnergy { value: 0.0, gradient: [Vector2::zeros(); 2], matrix: Matrix2::zeros() };
    let mut pull_along = 0.0;
    for p in around {
        let d = p - q;
        let s = d.dot(&u);
        let across = Vector2::new(d.dot(&e1), d.dot(&e2));
        let far = across.norm_squared();
        let weight = (-d.norm_squared() * inverse).exp();
        e.value += weight * far;
        // The terms with `inverse` come from the weights, which move with q.
        let moving = weight * far * inverse;
        pull_along += moving * s;
        for k in 0..2 {
            e.gradient[k].x += (moving - weight) * across[k];
            e.gradient[k].y -= weight * s * across[k];
        }
        e.matrix += weight * Matrix2::new(1.0, s, s, s * s);
    }
    // q stays on the plane through r across u. Tilting u by δ therefore moves q by −⟨q − r, δ⟩ u.
    for (k, axis) in [e1, e2].iter().enumerate() {
        e.gradient[k].y -= shift.dot(axis) * pull_along;
    }
    e
}

/// Finds the line that minimises the energy, by Gauss–Newton steps with the exact gradient. Each
/// step is shortened until the energy decreases.
pub(crate) fn reference_line(r: Point, around: &[Point], h: f64) -> Option<ReferenceLine> {
    if around.len() < 4 {
        return None;
    }
    let mut u = principal_direction(r, around, h);
    let mut q = r;
    let mut at = energy(r, q, u, around, h);
    for _ in 0..MOST_ROUNDS {
        let damped = at.matrix + Matrix2::identity() * (ROUNDING * at.matrix.trace());
        let factor = damped.cholesky()?;
        let steps = at.gradient.map(|g| -factor.solve(&g));
        let (e1, e2) = plane_axes(u);
        let accepted = shares().find_map(|share| {
            let tilt = share * (steps[0].y * e1 + steps[1].y * e2);
            let u2 = (u + tilt).normalize();
            let moved = q - r + share * (steps[0].x * e1 + steps[1].x * e2);
            let limited = moved.cap_magnitude(h);
            let q2 = r + (limited - limited.dot(&u2) * u2);
            let next = energy(r, q2, u2, around, h);
            (next.value <= at.value).then_some((q2, u2, next))
        });
        let Some((q2, u2, next)) = accepted else { break };
        let still = (q2 - q).norm() < NEGLIGIBLE * h && (u2 - u).norm() < NEGLIGIBLE;
        (q, u, at) = (q2, u2, next);
        if still {
            break;
        }
    }
    Some(ReferenceLine { origin: q, along: u })
}

fn principal_direction(r: Point, around: &[Point], h: f64) -> Vector {
    let weight = |p: &Point| (-(p - r).norm_squared() / (h * h)).exp();
    let total: f64 = around.iter().map(weight).sum();
    let mean = around.iter().fold(Vector::zeros(), |sum, p| sum + weight(p) * (p - r)) / total;
    let mut spread = Matrix3::zeros();
    for p in around {
        let d = p - r - mean;
        spread += weight(p) * d * d.transpose();
    }
    let eigen = spread.symmetric_eigen();
    let largest = eigen.eigenvalues.imax();
    eigen.eigenvectors.column(largest).into_owned()
}

/// The value at u = 0 of the weighted quadratics v(u) and w(u), and the leverage of a point at the
/// origin.
pub(crate) fn quadratic(line: &ReferenceLine, around: &[Point], h: f64) -> Option<(Point, f64)> {
    let (e1, e2) = plane_axes(line.along);
    let mut gram = Matrix3::zeros();
    let mut right = [Vector3::zeros(); 2];
    for p in around {
        let d = (p - line.origin) / h;
        let u = d.dot(&line.along);
        let basis = Vector3::new(1.0, u, u * u);
        let weight = (-d.norm_squared()).exp();
        gram += weight * basis * basis.transpose();
        right[0] += weight * d.dot(&e1) * basis;
        right[1] += weight * d.dot(&e2) * basis;
    }
    gram += Matrix3::identity() * (ROUNDING * gram.trace());
    let factor = gram.cholesky()?;
    let across = right.map(|b| factor.solve(&b).x * h);
    let leverage = factor.solve(&Vector3::x()).x;
    Some((line.origin + across[0] * e1 + across[1] * e2, leverage))
}
