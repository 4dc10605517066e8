//! Tensor-product B-spline surfaces.

use super::{Basis, KnotVector};
use crate::geometry::{Point, Uv, Vector};

/// A tensor-product B-spline surface over the range of its two knot vectors.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Knot vector in u.
    pub u: KnotVector,
    /// Knot vector in v.
    pub v: KnotVector,
    /// The control net: point (i, j) at `i * v.functions() + j`, in mm.
    pub net: Vec<Vector>,
}

/// Point and derivatives of a surface at one parameter point.
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    /// The point.
    pub s: Point,
    /// First derivative in u, in mm a unit of u.
    pub su: Vector,
    /// First derivative in v.
    pub sv: Vector,
    /// Second derivative in u.
    pub suu: Vector,
    /// Mixed derivative.
    pub suv: Vector,
    /// Second derivative in v.
    pub svv: Vector,
}

impl Surface {
    /// A surface; the net must have u.functions() × v.functions() points.
    pub fn new(u: KnotVector, v: KnotVector, net: Vec<Vector>) -> Self {
        assert_eq!(u.functions() * v.functions(), net.len(), "control net");
        Surface { u, v, net }
    }

    /// How many control points the net has in u and in v.
    pub fn shape(&self) -> [usize; 2] {
        [self.u.functions(), self.v.functions()]
    }

    /// The control point (i, j).
    pub fn control(&self, i: usize, j: usize) -> Vector {
        self.net[i * self.v.functions() + j]
    }

    /// The point at `at`.
    pub fn point(&self, at: Uv) -> Point {
        let (bu, bv) = (self.u.basis(at.x), self.v.basis(at.y));
        Point::from(self.sum(&bu, &bv, 0, 0))
    }

    /// Point, first and second derivatives at `at`.
    pub fn jet(&self, at: Uv) -> Jet {
        let (bu, bv) = (self.u.basis(at.x), self.v.basis(at.y));
        let sum = |k, l| self.sum(&bu, &bv, k, l);
        Jet {
            s: Point::from(sum(0, 0)),
            su: sum(1, 0),
            sv: sum(0, 1),
            suu: sum(2, 0),
            suv: sum(1, 1),
            svv: sum(0, 2),
        }
    }

    fn sum(&self, bu: &Basis, bv: &Basis, k: usize, l: usize) -> Vector {
        let mut total = Vector::zeros();
        for i in 0..=self.u.degree() {
            let start = (bu.first + i) * self.v.functions() + bv.first;
            let row = &self.net[start..=start + self.v.degree()];
            let inner =
                row.iter().zip(&bv.derivative[l]).fold(Vector::zeros(), |sum, (p, &c)| sum + p * c);
            total += bu.derivative[k][i] * inner;
        }
        total
    }

    /// The nearest parameter point inside the domain.
    pub fn clamp(&self, at: Uv) -> Uv {
        Patch::clamp(self, at)
    }
}

/// What foot points and deviations need of a surface.
pub trait Patch: Sync {
    /// Point, first and second derivatives at `at`.
    fn jet(&self, at: Uv) -> Jet;

    /// The ranges of u and of v; they may be endless.
    fn ranges(&self) -> [(f64, f64); 2];

    /// The point at `at`.
    fn point(&self, at: Uv) -> Point {
        self.jet(at).s
    }

    /// The nearest parameter point inside the domain.
    fn clamp(&self, at: Uv) -> Uv {
        let [(u0, u1), (v0, v1)] = self.ranges();
        Uv::new(at.x.clamp(u0, u1), at.y.clamp(v0, v1))
    }
}

impl Patch for Surface {
    fn jet(&self, at: Uv) -> Jet {
        self.jet(at)
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        [self.u.range(), self.v.range()]
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
    }
}
