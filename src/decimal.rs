//! Coordinates with no more digits than mean something.
//!
//! A file has every coordinate with as many digits as read back the same number,
//! and what a fit computes takes 17. Rounded to a billionth of a millimetre,
//! a hundredth of what importers tell from nothing, it takes two thirds of them.

use crate::spline::{Curve, Surface};
use crate::trim::{TrimLoop, edge_accuracy};

/// The grid to which coordinates are rounded: so many steps a mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Decimal {
    space: f64,
}

/// Rounded parameters move a point of the surface by less than this share of what
/// edges may be off: they stay as near as they are.
const PARAMETER_STEP: f64 = 0.1;

impl Decimal {
    /// The grid for a scan of some size, in mm: of small ones it has the same
    /// number of digits as of one of 100 mm.
    pub(crate) fn for_size(diagonal: f64) -> Self {
        let digits = if diagonal > 0.0 { 11.0 - diagonal.log10().floor() } else { 9.0 };
        Decimal { space: power(digits, 9.0, 22.0) }
    }

    /// The surface with its control net on the grid.
    pub(crate) fn surface(self, mut surface: Surface) -> Surface {
        surface.net.iter_mut().for_each(|p| *p = p.map(|x| round(x, self.space)));
        surface
    }

    /// The loops likewise, their parameters on a grid that is fine enough for the
    /// surface. Edges move by less than the accuracy that they have.
    pub(crate) fn loops(self, surface: &Surface, mut loops: Vec<TrimLoop>) -> Vec<TrimLoop> {
        let step = PARAMETER_STEP * edge_accuracy(surface);
        let parameters = power((surface.speed() / step).log10().ceil(), 12.0, 17.0);
        for ring in &mut loops {
            ring.pcurves.iter_mut().for_each(|c| curve(c, parameters));
        }
        self.edges(loops)
    }

    /// The loops with their edges on the grid.
    pub(crate) fn edges(self, mut loops: Vec<TrimLoop>) -> Vec<TrimLoop> {
        let edges = loops.iter_mut().flat_map(|ring| &mut ring.edges);
        edges.for_each(|c| curve(c, self.space));
        loops
    }
}

/// 10 to the power of some digits, that are not fewer or more than given.
fn power(digits: f64, least: f64, most: f64) -> f64 {
    10f64.powi(digits.clamp(least, most) as i32)
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
