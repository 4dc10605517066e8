//! How exactly points tell the parameters of a surface.

use nalgebra::{Matrix3, SMatrix, SVector};

use super::{Covariance, MOST_PARAMETERS, Motions, Primitive};
use crate::geometry::{Point, Vector};

/// The standard deviations of the parameters of a surface, as its own points tell them. Those that its kind does not have are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Of the place: of a plane along its normal, of a sphere and a torus that of the centre, and of others that of the axis amid the points.
    /// The direction in which it is largest counts.
    pub place: f64,
    /// Of the normal or the axis, in radians.
    pub direction: Option<f64>,
    /// Of the radius. Of a torus it is that of the tube, and of a cone that amid the points.
    pub radius: Option<f64>,
    /// Of the radius of the circle of a torus.
    pub major: Option<f64>,
    /// Of the angle between the axis of a cone and its generators, in radians.
    pub angle: Option<f64>,
}

/// The share of a standard deviation that derivatives are taken over.
const STEP: f64 = 1e-2;

/// A place, a direction, the radius, the major radius and the angle.
const VALUES: usize = 9;

impl Uncertainty {
    /// The standard deviations that follow from those of the motions. `None` if nothing is known of these.
    pub(crate) fn of(motions: &Motions, covariance: &Covariance) -> Option<Self> {
        let pivot = motions.pivot();
        let surface = motions.surface();
        let mut slopes = SMatrix::<f64, VALUES, MOST_PARAMETERS>::zeros();
        let mut is_known = false;
        for k in 0..surface.kind().parameters() {
            let step = STEP * covariance[(k, k)].max(0.0).sqrt();
            if step <= 0.0 {
                continue;
            }
            is_known = true;
            let at = |by: f64| {
                let mut motion = super::MotionRow::zeros();
                motion[k] = by;
                motions.moved(&motion).map(|moved| values(&moved, &surface, pivot))
            };
            let slope = (at(step)? - at(-step)?) / (2.0 * step);
            slopes.set_column(k, &slope);
        }
        let all = slopes * covariance * slopes.transpose();
        let widest = |from: usize| {
            let part: Matrix3<f64> = all.fixed_view::<3, 3>(from, from).into();
            part.symmetric_eigenvalues().max().max(0.0).sqrt()
        };
        let of = |k: usize| all[(k, k)].max(0.0).sqrt();
        let is_torus = matches!(surface, Primitive::Torus { .. });
        let is_cone = matches!(surface, Primitive::Cone { .. });
        let has_axis = !matches!(surface, Primitive::Sphere { .. });
        let is_round = !matches!(surface, Primitive::Plane { .. });
        is_known.then(|| Uncertainty {
            place: widest(0),
            direction: has_axis.then(|| widest(3)),
            radius: is_round.then(|| of(6)),
            major: is_torus.then(|| of(7)),
            angle: is_cone.then(|| of(8)),
        })
    }

    /// The same if systematic errors of such a size may move places and radii, too.
    pub(crate) fn with_bias(self, bias: f64) -> Self {
        self.with_lengths(|x| x.hypot(bias))
    }

    /// The same in a unit of which the old one has so many.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        self.with_lengths(|x| factor * x)
    }

    fn with_lengths(self, of: impl Fn(f64) -> f64) -> Self {
        let (radius, major) = (self.radius.map(&of), self.major.map(&of));
        Uncertainty { place: of(self.place), radius, major, ..self }
    }
}

/// The parameters of a surface next to a point. `was` is the surface from which it was moved.
fn values(of: &Primitive, was: &Primitive, pivot: Point) -> SVector<f64, VALUES> {
    let at_pivot = |origin: Point, axis: Vector| origin + (pivot - origin).dot(&axis) * axis;
    let (place, direction, rest) = match *of {
        Primitive::Plane { normal, .. } => {
            let own = was.distance(pivot).1;
            (Point::from(-of.distance(pivot).0 * own), normal, [0.0; 3])
        }
        Primitive::Cylinder { origin, axis, radius } => {
            (at_pivot(origin, axis), axis, [radius, 0.0, 0.0])
        }
        Primitive::Cone { origin, axis, radius, angle } => {
            let there = radius + (pivot - origin).dot(&axis) * angle.tan();
            (at_pivot(origin, axis), axis, [there, 0.0, angle])
        }
        Primitive::Sphere { centre, radius } => (centre, Vector::zeros(), [radius, 0.0, 0.0]),
        Primitive::Torus { centre, axis, major, minor } => (centre, axis, [minor, major, 0.0]),
    };
    let mut all = SVector::<f64, VALUES>::zeros();
    all.fixed_rows_mut::<3>(0).copy_from(&place.coords);
    all.fixed_rows_mut::<3>(3).copy_from(&direction);
    all.fixed_rows_mut::<3>(6).copy_from(&Vector::from(rest));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{FitOptions, FitSample, fit};

    /// The spread of fitted cylinders is what each of them says of itself.
    #[test]
    fn fits_scatter_as_they_say() {
        let truth = Primitive::Cylinder { origin: Point::origin(), axis: Vector::z(), radius: 5.0 };
        let error = 0.02;
        let mut state = 7u64;
        let mut normal = || {
            // Twelve uniform numbers less six have the variance 1.
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let (mut radii, mut places, mut turns) = (Vec::new(), Vec::new(), Vec::new());
        let mut said = None;
        for _ in 0..200 {
            let samples: Vec<FitSample> = (0..120)
                .map(|k| {
                    let (u, h) = (0.2 * f64::from(k % 12), f64::from(k / 12));
                    let r = 5.0 + error * normal();
                    FitSample { at: Point::new(r * u.cos(), r * u.sin(), h), error }
                })
                .collect();
            let found = fit(truth, &samples, &FitOptions::default()).expect("a fit");
            said = Uncertainty::of(&found.motions, &found.covariance);
            let Primitive::Cylinder { origin, axis, radius } = found.surface else { continue };
            radii.push(radius - 5.0);
            let middle = origin + (4.5 - origin.z) / axis.z * axis;
            places.push(middle.coords.xy().norm());
            turns.push(axis.cross(&Vector::z()).norm());
        }
        let rms = |of: &[f64]| (of.iter().map(|x| x * x).sum::<f64>() / of.len() as f64).sqrt();
        let said = said.expect("standard deviations");
        let ratio = rms(&radii) / said.radius.expect("a radius");
        assert!((0.85..1.15).contains(&ratio), "{ratio}");
        // The place and the axis are uncertain in two directions, of which the worse one is said.
        let ratio = rms(&places) / said.place;
        assert!((0.85..1.45).contains(&ratio), "{ratio}");
        let ratio = rms(&turns) / said.direction.expect("an axis");
        assert!((0.85..1.45).contains(&ratio), "{ratio}");
        assert!(said.major.is_none() && said.angle.is_none());
    }
}
