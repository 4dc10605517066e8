//! Two layers of points: a quadric that is there twice, one above the other.

use nalgebra::{SMatrix, SVector};

use super::quadric::PrincipalPlane;
use crate::geometry::{FEW, Point, plane_axes, range};
use crate::statistics::SIGNIFICANT;

/// Layers are so many standard deviations of their points apart at least. Normal noise that is cut in two halves has
/// a distance of three.
const LEAST_DISTANCE: f64 = 2.0 * SIGNIFICANT;

/// A layer has at least this share of the points. Fewer are outliers.
const LEAST_SHARE: f64 = 0.2;

/// The terms of the fit: a quadric and the distance of the layers.
const TERMS: usize = 7;

/// Points in two layers.
pub(super) struct TwoLayers {
    /// Whether each point is in the upper layer.
    pub is_upper: Vec<bool>,
    /// The distance of the layers.
    pub distance: f64,
}

impl TwoLayers {
    /// Divides points around a place, if they are two layers with nothing between.
    pub(super) fn new(own: Point, radius: f64, points: &[Point]) -> Option<Self> {
        let plane = PrincipalPlane::fit(points.iter().map(|p| (1.0, p - own)));
        let (x, y) = plane_axes(plane.normal);
        let flat = |p: &Point| {
            let d = (p - own) / radius;
            let (u, v) = (d.dot(&x), d.dot(&y));
            ([u, v], d.dot(&plane.normal))
        };
        let rows: Vec<([f64; 2], f64)> = points.iter().map(flat).collect();
        let [low, high] = range(rows.iter().map(|row| row.1));
        let mut is_upper: Vec<bool> = rows.iter().map(|row| 2.0 * row.1 > low + high).collect();
        for _ in 0..FEW {
            let fit = LayeredQuadric::fit(&rows, &is_upper)?;
            let again: Vec<bool> = rows.iter().map(|row| fit.is_upper(row)).collect();
            if again == is_upper {
                return fit
                    .is_apart(&rows, &is_upper)
                    .then(|| TwoLayers { is_upper, distance: radius * fit.distance().abs() });
            }
            is_upper = again;
        }
        None
    }
}

/// A quadric, and the same quadric at a distance.
struct LayeredQuadric(SVector<f64, TERMS>);

impl LayeredQuadric {
    /// Fits both to points of which it is known where they are. `None` if too few are in one layer.
    fn fit(rows: &[([f64; 2], f64)], is_upper: &[bool]) -> Option<Self> {
        let upper = is_upper.iter().filter(|is| **is).count();
        if (upper.min(rows.len() - upper) as f64) < LEAST_SHARE * rows.len() as f64 {
            return None;
        }
        let mut gram = SMatrix::<f64, TERMS, TERMS>::zeros();
        let mut right = SVector::<f64, TERMS>::zeros();
        for (&(at, height), &is_upper) in rows.iter().zip(is_upper) {
            let terms = terms(at, is_upper);
            gram.ger(1.0, &terms, &terms, 1.0);
            right.axpy(height, &terms, 1.0);
        }
        Some(LayeredQuadric(gram.cholesky()?.solve(&right)))
    }

    fn distance(&self) -> f64 {
        self.0[TERMS - 1]
    }

    /// Whether a point is nearer to the layer that is called the upper one.
    fn is_upper(&self, &(at, height): &([f64; 2], f64)) -> bool {
        let off = |is_upper| (height - self.0.dot(&terms(at, is_upper))).abs();
        off(true) < off(false)
    }

    /// Whether there is nothing between the layers.
    fn is_apart(&self, rows: &[([f64; 2], f64)], is_upper: &[bool]) -> bool {
        let square = |(&(at, height), &is_upper): (&([f64; 2], f64), &bool)| {
            (height - self.0.dot(&terms(at, is_upper))).powi(2)
        };
        let sum: f64 = rows.iter().zip(is_upper).map(square).sum();
        let freedom = rows.len().saturating_sub(TERMS);
        freedom > 0 && self.distance().abs() > LEAST_DISTANCE * (sum / freedom as f64).sqrt()
    }
}

fn terms([x, y]: [f64; 2], is_upper: bool) -> SVector<f64, TERMS> {
    SVector::from([1.0, x, y, x * x, x * y, y * y, f64::from(u8::from(is_upper))])
}
