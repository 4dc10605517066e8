//! Tensor-product B-spline surfaces.

use std::sync::Arc;

use super::{Basis, KnotVector, fast_evaluator};
use crate::geometry::{Point, Uv, Vector};

/// A tensor-product B-spline surface over the ranges of its two knot vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Knot vector in u.
    pub u: KnotVector,
    /// Knot vector in v.
    pub v: KnotVector,
    /// The control net, in mm. Point (i, j) is at `i * v.functions() + j`.
    pub net: Vec<Vector>,
}

/// The point and the derivatives of a surface at one parameter point.
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    /// The point.
    pub s: Point,
    /// The first derivative in u, in mm per unit of u.
    pub su: Vector,
    /// The first derivative in v.
    pub sv: Vector,
    /// The second derivative in u.
    pub suu: Vector,
    /// The mixed second derivative.
    pub suv: Vector,
    /// The second derivative in v.
    pub svv: Vector,
}

impl Jet {
    /// The mean curvature in 1/mm: positive where the surface bulges to the side of its normal, 0 at
    /// a place without a normal.
    pub fn mean_curvature(&self) -> f64 {
        let cross = self.su.cross(&self.sv);
        let Some(normal) = cross.try_normalize(0.0) else { return 0.0 };
        let (e, f, g) = (self.su.dot(&self.su), self.su.dot(&self.sv), self.sv.dot(&self.sv));
        let [l, m, n] = [self.suu, self.suv, self.svv].map(|second| second.dot(&normal));
        let mean = (2.0 * f * m - e * n - g * l) / (2.0 * cross.norm_squared());
        if mean.is_finite() { mean } else { 0.0 }
    }
}

impl Surface {
    /// The surface with all lengths multiplied by a factor.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.net.iter_mut().for_each(|p| *p *= factor);
        self
    }

    /// A surface from its knot vectors and control net.
    ///
    /// # Panics
    /// Panics if the net does not have u.functions() × v.functions() control points.
    /// [`Surface::try_new`] returns an error instead.
    pub fn new(u: KnotVector, v: KnotVector, net: Vec<Vector>) -> Self {
        assert_eq!(u.functions() * v.functions(), net.len(), "control net");
        Surface { u, v, net }
    }

    /// The numbers of control points in u and in v.
    pub fn shape(&self) -> [usize; 2] {
        [self.u.functions(), self.v.functions()]
    }

    /// The control point (i, j).
    pub fn control(&self, i: usize, j: usize) -> Vector {
        self.net[i * self.v.functions() + j]
    }

    /// The parameter points in the middles of `parts` × `parts` equal parts of each cell between knots.
    pub(crate) fn middles(&self, parts: usize) -> Vec<Uv> {
        let (us, vs) = (self.u.middles(parts), self.v.middles(parts));
        us.iter().flat_map(|&u| vs.iter().map(move |&v| Uv::new(u, v))).collect()
    }

    /// The point at the parameter point `at`.
    pub fn point(&self, at: Uv) -> Point {
        let (bu, bv) = (self.u.basis(at.x), self.v.basis(at.y));
        let rows =
            (0..=self.u.degree()).map(|i| self.row(bu.first + i, &bv)[0] * bu.derivative[0][i]);
        Point::from(rows.sum::<Vector>())
    }

    /// The point and the first and second derivatives at the parameter point `at`.
    pub fn jet(&self, at: Uv) -> Jet {
        let (bu, bv) = (self.u.basis(at.x), self.v.basis(at.y));
        let mut sums = [Vector::zeros(); 6];
        for i in 0..=self.u.degree() {
            let [s, sv, svv] = self.row(bu.first + i, &bv);
            let [b, bu, buu] = [0, 1, 2].map(|k| bu.derivative[k][i]);
            let terms = [s * b, s * bu, sv * b, s * buu, sv * bu, svv * b];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let [s, su, sv, suu, suv, svv] = sums;
        Jet { s: Point::from(s), su, sv, suu, suv, svv }
    }

    /// The value and the derivatives in v of row `i` of the net.
    fn row(&self, i: usize, bv: &Basis) -> [Vector; 3] {
        let start = i * self.v.functions() + bv.first;
        let mut sums = [Vector::zeros(); 3];
        for (j, p) in self.net[start..=start + self.v.degree()].iter().enumerate() {
            for (sum, b) in sums.iter_mut().zip(&bv.derivative) {
                *sum += p * b[j];
            }
        }
        sums
    }

    /// The parameter point of the domain nearest to `at`.
    pub(crate) fn clamp(&self, at: Uv) -> Uv {
        ParametricSurface::clamp(self, at)
    }

    /// A bound on the speed: the largest distance in mm that a point moves per unit of u or of v.
    /// It is the length of the longest control vector of the first derivatives.
    pub fn speed(&self) -> f64 {
        let [m, n] = self.shape();
        let step = |knots: &KnotVector, i: usize, from: Vector, to: Vector| {
            let length = knots.knots()[i + knots.degree()] - knots.knots()[i];
            (to - from).norm() * knots.degree() as f64 / length
        };
        let at = |i, j| self.control(i, j);
        let inner = (0..m).flat_map(|i| (0..n).map(move |j| (i, j)));
        let steps = inner.flat_map(|(i, j)| {
            let along_u = (i > 0).then(|| step(&self.u, i, at(i - 1, j), at(i, j)));
            let along_v = (j > 0).then(|| step(&self.v, j, at(i, j - 1), at(i, j)));
            along_u.into_iter().chain(along_v)
        });
        steps.fold(0.0, f64::max)
    }
}

/// The operations of a surface that foot points and deviations use.
pub trait ParametricSurface: Send + Sync {
    /// The point and the first and second derivatives at `at`.
    fn jet(&self, at: Uv) -> Jet;

    /// The ranges of u and of v. They may be infinite.
    fn ranges(&self) -> [(f64, f64); 2];

    /// The lines u = const and v = const between which the surface is smooth, including its ends.
    fn breaks(&self) -> [Vec<f64>; 2] {
        self.ranges().map(|(low, high)| vec![low, high])
    }

    /// The same surface in a form that is faster to evaluate, if there is one.
    fn fast_form(&self) -> Option<Arc<dyn ParametricSurface>> {
        None
    }

    /// The point at `at`.
    fn point(&self, at: Uv) -> Point {
        self.jet(at).s
    }

    /// The parameter point of the domain nearest to `at`.
    fn clamp(&self, at: Uv) -> Uv {
        let [(u0, u1), (v0, v1)] = self.ranges();
        Uv::new(at.x.clamp(u0, u1), at.y.clamp(v0, v1))
    }
}

impl ParametricSurface for Surface {
    fn jet(&self, at: Uv) -> Jet {
        self.jet(at)
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        [self.u.range(), self.v.range()]
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        [self.u.breaks(), self.v.breaks()]
    }

    fn fast_form(&self) -> Option<Arc<dyn ParametricSurface>> {
        let is_cubic = |knots: &KnotVector| {
            knots.degree() == 3 && knots.breaks().len() + 2 == knots.functions()
        };
        (is_cubic(&self.u) && is_cubic(&self.v)).then(|| fast_evaluator(self).into())
    }

    fn point(&self, at: Uv) -> Point {
        self.point(at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_over_greville_points_is_the_identity() {
        let u = KnotVector::clamped(3, &[0.0, 0.3, 1.0], 1);
        let v = KnotVector::uniform(3, 7);
        let mut net = Vec::new();
        for i in 0..u.functions() {
            for j in 0..v.functions() {
                net.push(Vector::new(u.greville(i), v.greville(j), u.greville(i) * v.greville(j)));
            }
        }
        let s = Surface::new(u, v, net);
        let jet = s.jet(Uv::new(0.37, 0.81));
        assert!((jet.s - Point::new(0.37, 0.81, 0.37 * 0.81)).norm() < 1e-12);
        assert!((jet.su - Vector::new(1.0, 0.0, 0.81)).norm() < 1e-12);
        assert!((jet.suv - Vector::z()).norm() < 1e-12);
        assert!(jet.suu.norm() < 1e-11 && jet.svv.norm() < 1e-11);
        // The mean curvature of z = x y, seen from above.
        let w = (1.0_f64 + 0.37_f64.powi(2) + 0.81_f64.powi(2)).sqrt();
        assert!((jet.mean_curvature() - 0.37 * 0.81 / w.powi(3)).abs() < 1e-12);
    }

    #[test]
    fn a_hill_has_a_positive_curvature_and_a_hollow_a_negative_one() {
        let bent = |bend: f64| Jet {
            s: Point::origin(),
            su: Vector::x(),
            sv: 2.0 * Vector::y(),
            suu: bend * Vector::z(),
            suv: Vector::zeros(),
            svv: 4.0 * bend * Vector::z(),
        };
        // Spheres of radius 4, which fall away from the normal or rise to it.
        assert!((bent(-0.25).mean_curvature() - 0.25).abs() < 1e-15);
        assert!((bent(0.25).mean_curvature() + 0.25).abs() < 1e-15);
    }

    #[test]
    fn the_speed_of_a_plane_is_its_sides_length() {
        let (u, v) = (KnotVector::uniform(3, 4), KnotVector::uniform(3, 9));
        let at = |n: usize| Vector::new(30.0 * u.greville(n / 9), 70.0 * v.greville(n % 9), 2.0);
        let net = (0..u.functions() * v.functions()).map(at).collect();
        let found = Surface::new(u.clone(), v.clone(), net).speed();
        assert!((found - 70.0).abs() < 1e-9, "{found}");
    }
}
