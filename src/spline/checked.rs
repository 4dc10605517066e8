//! Constructors that check their arguments and return errors. The constructors in the files of the
//! types themselves panic on unsuitable arguments.

use nalgebra::SVector;

use super::{Curve, KnotVector, Surface};
use crate::error::{Error, Result};
use crate::geometry::Vector;

impl KnotVector {
    /// A knot vector from its degree, 1 to 5, and its knots.
    ///
    /// # Errors
    /// [`Error::Input`] if there are fewer than 2 (degree + 1) knots, if the knots decrease or are
    /// not finite, or if no span is left on which the basis is complete.
    pub fn try_new(degree: usize, knots: Vec<f64>) -> Result<Self> {
        let enough = (1..=5).contains(&degree) && knots.len() >= 2 * (degree + 1);
        let ascend = knots.windows(2).all(|w| w[0] <= w[1]) && knots.iter().all(|t| t.is_finite());
        if !enough || !ascend || knots[degree] >= knots[knots.len() - degree - 1] {
            return Err(Error::Input("not the knots of a B-spline of degree 1 to 5"));
        }
        Ok(KnotVector::new(degree, knots))
    }

    /// The clamped cubic knot vector over [0, 1] with `control_points` basis functions and spans of
    /// equal length.
    ///
    /// # Errors
    /// [`Error::Input`] if there are fewer than four control points.
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
    /// [`Error::Input`] if the numbers of control points and basis functions differ.
    pub fn try_new(knots: KnotVector, control: Vec<SVector<f64, D>>) -> Result<Self> {
        if knots.functions() != control.len() {
            return Err(Error::Input("a curve needs one control point for each basis function"));
        }
        Ok(Curve::new(knots, control))
    }
}

impl Surface {
    /// A surface from its knots and its control net, in which the index along v runs faster.
    ///
    /// # Errors
    /// [`Error::Input`] if the net does not have u.functions() × v.functions() control points.
    pub fn try_new(u: KnotVector, v: KnotVector, net: Vec<Vector>) -> Result<Self> {
        if u.functions() * v.functions() != net.len() {
            return Err(Error::Input(
                "a surface needs one control point for each pair of basis functions",
            ));
        }
        Ok(Surface::new(u, v, net))
    }
}
