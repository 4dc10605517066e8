//! How exactly a rim is known: the scatter of its vertices about a fair curve.
//!
//! The vertices of a rim and the normals of the surface there go in, and the distance comes out within which
//! nearly all of the vertices are from a fair curve. Only the scatter along the surface and across the rim counts:
//! that across the surface is not one of the rim.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{Point, Vector};
use crate::statistics::{SIGNIFICANT, absolute_at, quantile};

/// The number of vertices on each side of a vertex through which a parabola is laid. Seven vertices leave four
/// degrees of freedom, and a fair curve is a parabola over so few.
const BESIDE: usize = 3;

/// The scatter is that of this share of the vertices. Corners of a rim have fewer vertices beside them than the
/// rest, and teeth have more.
const SHARE: f64 = 0.75;

/// The distance from a fair curve within which nearly all vertices of a rim are. `None` if the rim has too few
/// vertices to tell.
pub(crate) fn scatter(points: &[Point], normals: &[Vector]) -> Option<f64> {
    if points.len() <= 2 * BESIDE {
        return None;
    }
    let residuals = (0..points.len()).map(|i| residual(points, normals[i], i));
    let mut residuals: Vec<f64> = residuals.collect::<Option<_>>()?;
    Some(SIGNIFICANT * quantile(&mut residuals, SHARE)? / absolute_at(SHARE))
}

/// The distance of vertex `i` from the parabola through it and its neighbours, as large as it would be without
/// the share that the vertex itself has in the parabola. `None` if there is no parabola.
fn residual(points: &[Point], normal: Vector, i: usize) -> Option<f64> {
    let n = points.len();
    let beside = |k: usize| points[(i + n + k - BESIDE) % n] - points[i];
    let along = beside(2 * BESIDE) - beside(0);
    let across = normal.cross(&along).try_normalize(0.0)?;
    let along = along.try_normalize(0.0)?;
    let (mut gram, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for k in 0..=2 * BESIDE {
        let s = beside(k).dot(&along);
        let row = Vector3::new(1.0, s, s * s);
        gram += row * row.transpose();
        right += beside(k).dot(&across) * row;
    }
    let inverse = gram.try_inverse()?;
    let left = 1.0 - inverse[(0, 0)];
    (left > 0.0).then(|| (inverse * right)[0].abs() / left.sqrt())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// The scatter of a circle of 100 vertices about a millimetre apart, whose vertices are moved outwards and up.
    fn of_circle(moved: impl Fn(usize) -> [f64; 2]) -> f64 {
        let at = |i: usize| {
            let ([out, up], angle) = (moved(i), TAU * i as f64 / 100.0);
            let r = 16.0 + out;
            Point::new(r * angle.cos(), r * angle.sin(), up)
        };
        let points: Vec<Point> = (0..100).map(at).collect();
        scatter(&points, &[Vector::z(); 100]).unwrap()
    }

    #[test]
    fn a_circle_has_none_and_noise_across_the_surface_is_none() {
        let noise = |i: usize| 0.05 * f64::from((i * i % 17) as u32) / 17.0;
        // A circle leaves its parabola by s⁴ / 8r³, at the ends of seven vertices by 0.0025 mm.
        let curved = SIGNIFICANT * 0.0025;
        assert!(of_circle(|_| [0.0, 0.0]) < curved);
        assert!(of_circle(|i| [0.0, noise(i)]) < curved);
        assert!(of_circle(|i| [noise(i), 0.0]) > 0.03);
    }

    #[test]
    fn teeth_scatter_and_a_few_corners_do_not() {
        let tooth = |i: usize| if i.is_multiple_of(2) { 0.3 } else { -0.3 };
        assert!(of_circle(|i| [tooth(i), 0.0]) > 0.5);
        assert!(of_circle(|i| [if i % 50 == 0 { 1.0 } else { 0.0 }, 0.0]) < 0.05);
        assert!(scatter(&[Point::origin(); 6], &[Vector::z(); 6]).is_none());
    }
}
