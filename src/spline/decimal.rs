//! Rounding of coordinates to decimals.
//!
//! A file holds every coordinate with enough digits to read back the same number. The results of
//! a fit need 17 digits. Rounded to a billionth of a millimetre, which is a hundredth of the
//! smallest distance that importers distinguish, they need about two thirds of these digits.

use super::{Curve, Surface};
use crate::geometry::ROUNDING;

impl Surface {
    /// The surface with rounded control points. `diagonal` is the diagonal of the scan; a scan of
    /// 100 mm is rounded to a billionth of a millimetre, and others in proportion, by powers of
    /// ten.
    #[must_use]
    pub fn rounded(mut self, diagonal: f64) -> Self {
        let steps = steps(diagonal);
        self.net.iter_mut().for_each(|p| *p = p.map(|x| round(x, steps)));
        self
    }
}

fn steps(diagonal: f64) -> f64 {
    let digits = if diagonal > 0.0 { 11.0 - diagonal.log10().floor() } else { 9.0 };
    power(digits.clamp(9.0, 22.0))
}

/// The allowed distance of an edge from its surface, as a multiple of the step to which its control
/// points are rounded.
const FINE: f64 = 100.0;

/// Rounds the control points of an edge. `accuracy` is the allowed distance from its surface in mm.
pub(crate) fn lengths(edge: &mut Curve<3>, accuracy: f64) {
    curve(edge, power((FINE / accuracy).log10().ceil().clamp(0.0, 22.0)));
}

/// Rounds a curve in the parameter plane. The edge in space must be traced after it. A trillionth of the
/// side of a surface is shorter than the rounding step of its control points.
pub(crate) fn parameters(arc: &mut Curve<2>) {
    curve(arc, 1.0 / ROUNDING);
}

/// 10 to the power of `digits`.
fn power(digits: f64) -> f64 {
    10f64.powi(digits as i32)
}

fn curve<const D: usize>(curve: &mut Curve<D>, steps: f64) {
    curve.control.iter_mut().for_each(|p| *p = p.map(|x| round(x, steps)));
}

/// The floating-point number nearest to the decimal nearest to `x`.
fn round(x: f64, steps: f64) -> f64 {
    let scaled = x * steps;
    // Larger numbers have no digits after this decimal place.
    if scaled.abs() < 1e15 { scaled.round() / steps } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_numbers_are_short() {
        assert_eq!(round(-50.045_756_446_894_74, steps(130.0)).to_string(), "-50.045756447");
        assert_eq!(round(1.0 / 3.0, steps(1.5)).to_string(), "0.33333333333");
        assert_eq!(round(5000.0 / 3.0, steps(5e4)).to_string(), "1666.666666667");
        assert_eq!(round(1e9 / 3.0, steps(1e9)), 1e9 / 3.0);
    }
}
