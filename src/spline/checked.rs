//! Splines made of numbers from elsewhere: the same as the constructors of their own
//! files, which take for granted what is looked at here.

use nalgebra::SVector;

use super::{Curve, KnotVector, Surface};
use crate::error::{Error, Result};
use crate::geometry::Vector;

impl KnotVector {
    /// A knot vector from its degree, 1 to 5, and its knots.
    ///
    /// # Errors
    /// [`Error::Input`]: knots that decrease, are not finite, fewer than
    /// 2 (degree + 1), or no span for the basis.
    pub fn try_new(degree: usize, knots: Vec<f64>) -> Result<Self> {
        let enough = (1..=5).contains(&degree) && knots.len() >= 2 * (degree + 1);
        let ascend = knots.windows(2).all(|w| w[0] <= w[1]) && knots.iter().all(|t| t.is_finite());
        if !enough || !ascend || knots[degree] >= knots[knots.len() - degree - 1] {
            return Err(Error::Input("not the knots of a B-spline of degree 1 to 5"));
        }
        Ok(KnotVector::new(degree, knots))
    }

    /// The clamped knot vector of degree 3 over [0, 1] with `control_points` functions
    /// and spans of equal length.
    ///
    /// # Errors
    /// [`Error::Input`]: fewer than four control points.
    pub fn cubic(control_points: usize) -> Result<Self> {
        match control_points {
            0..4 => Err(Error::Input("a cubic B-spline has at least four control points")),
            n => Ok(KnotVector::uniform(3, n)),
        }
    }
}

impl<const D: usize> Curve<D> {
    /// A curve from its knots and control points.
    ///
    /// # Errors
    /// [`Error::Input`]: not one control point a basis function.
    pub fn try_new(knots: KnotVector, control: Vec<SVector<f64, D>>) -> Result<Self> {
        if knots.functions() != control.len() {
            return Err(Error::Input("a curve has not one control point a basis function"));
        }
        Ok(Curve::new(knots, control))
    }
}

impl Surface {
    /// A surface from its knots and net, of which v runs first.
    ///
    /// # Errors
    /// [`Error::Input`]: a net of another size than u.functions() × v.functions().
    pub fn try_new(u: KnotVector, v: KnotVector, net: Vec<Vector>) -> Result<Self> {
        if u.functions() * v.functions() != net.len() {
            return Err(Error::Input("a surface has not one control point a pair of functions"));
        }
        Ok(Surface::new(u, v, net))
    }
}
