//! Coordinates with no more digits than mean something.
//!
//! A file has every coordinate with as many digits as read back the same number,
//! and what a fit computes takes 17. Rounded to a billionth of a millimetre,
//! a hundredth of what importers tell from nothing, it takes two thirds of them.

use crate::spline::{Curve, Surface};
use crate::trim::TrimLoop;

/// The grid to which coordinates are rounded: so many steps a mm, and so many a
/// unit of the parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Decimal {
    space: f64,
    parameters: f64,
}

impl Decimal {
    /// The grid for a scan of some size, in mm: of small ones it has the same
    /// number of digits as of one of 100 mm.
    pub(crate) fn for_size(diagonal: f64) -> Self {
        let digits = if diagonal > 0.0 { 11.0 - diagonal.log10().floor() } else { 9.0 };
        Decimal { space: 10f64.powi(digits.clamp(9.0, 22.0) as i32), parameters: 1e12 }
    }

    /// The surface with its control net on the grid.
    pub(crate) fn surface(self, mut surface: Surface) -> Surface {
        surface.net.iter_mut().for_each(|p| *p = p.map(|x| round(x, self.space)));
        surface
    }

    /// The loops likewise. Edges move by less than the accuracy that they have.
    pub(crate) fn loops(self, mut loops: Vec<TrimLoop>) -> Vec<TrimLoop> {
        for ring in &mut loops {
            ring.pcurves.iter_mut().for_each(|c| curve(c, self.parameters));
            ring.edges.iter_mut().for_each(|c| curve(c, self.space));
        }
        loops
    }
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
        let steps = |size: f64| Decimal::for_size(size).space;
        assert_eq!(round(-50.045_756_446_894_74, steps(130.0)).to_string(), "-50.045756447");
        assert_eq!(round(1.0 / 3.0, steps(1.5)).to_string(), "0.33333333333");
        assert_eq!(round(5000.0 / 3.0, steps(5e4)).to_string(), "1666.666666667");
        assert_eq!(round(1e9 / 3.0, steps(1e9)), 1e9 / 3.0);
    }
}
