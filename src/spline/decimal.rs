//! Coordinates with no more digits than mean something.
//!
//! A file has every coordinate with as many digits as read back the same number,
//! and what a fit computes takes 17. Rounded to a billionth of a millimetre,
//! a hundredth of what importers tell from nothing, it takes two thirds of them.

use super::{Curve, Surface};

impl Surface {
    /// The surface of a scan with that diagonal, its control points rounded to as many digits
    /// as a billionth of a millimetre has in a scan of 100 mm.
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

/// An edge may be off its surface by so many times what its control points are rounded to.
const FINE: f64 = 100.0;

/// Rounds the control points of an edge, which may be off its surface by `accuracy` in mm.
pub(crate) fn lengths(edge: &mut Curve<3>, accuracy: f64) {
    curve(edge, power((FINE / accuracy).log10().ceil().clamp(0.0, 22.0)));
}

/// The digits of a parameter in [0, 1]: a trillionth of a surface's side is less than the
/// digits of its control points tell.
const PARAMETER_DIGITS: f64 = 12.0;

/// Rounds a curve in the parameter plane. Its edge in space is traced afterwards.
pub(crate) fn parameters(arc: &mut Curve<2>) {
    curve(arc, power(PARAMETER_DIGITS));
}

/// 10 to the power of some digits.
fn power(digits: f64) -> f64 {
    10f64.powi(digits as i32)
}

fn curve<const D: usize>(curve: &mut Curve<D>, steps: f64) {
    curve.control.iter_mut().for_each(|p| *p = p.map(|x| round(x, steps)));
}

/// The double next to the decimal next to `x`.
fn round(x: f64, steps: f64) -> f64 {
    let scaled = x * steps;
    // Larger ones have no digits there.
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
