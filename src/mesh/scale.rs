//! The pipeline's unit of length. The coordinates of the scan are multiplied by a power of two that
//! gives every scan about the same size.
//!
//! Such a factor is exact. Neither the unit of the file nor a factor of a power of two between two
//! files therefore changes any digit of the result.

use formats::Soup;

use super::weld::is_usable;

/// The largest extent of a scaled scan is at least two to this power and less than twice as much.
/// This is about the extent in mm of the scans on which the stages were tuned.
const SIZE: i32 = 6;

/// The power of two that gives the scan its standard size. Only points that polygons use and that
/// [`is_usable`] accepts are measured; `mm` is the length of their unit in mm.
pub(super) fn to_size(soup: &Soup, mm: f64) -> f64 {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let corners = soup.polygons.iter().flatten().map(|&corner| &soup.points[corner as usize]);
    for p in corners.filter(|p| is_usable(p, mm)) {
        for k in 0..3 {
            bounds[0][k] = bounds[0][k].min(p[k]);
            bounds[1][k] = bounds[1][k].max(p[k]);
        }
    }
    let extent = (0..3).map(|k| bounds[1][k] - bounds[0][k]).fold(0.0, f64::max);
    // Two to a power beyond this, or its inverse, is not a normal floating-point number.
    let most = -f64::MIN_EXP;
    if extent > 0.0 { 2f64.powi((SIZE - exponent(extent)).clamp(-most, most)) } else { 1.0 }
}

/// The exponent of the largest power of two that is at most `x`, for `x` above 0. It is read from
/// the bits, because a logarithm may be rounded up to the next integer.
fn exponent(x: f64) -> i32 {
    (x.to_bits() >> (f64::MANTISSA_DIGITS - 1)) as i32 - (f64::MAX_EXP - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scan_gets_the_same_size() {
        for (extent, factor) in
            [(64.0, 1.0), (127.9, 1.0), (128.0, 0.5), (1.0, 64.0), (1.5e-3, 65536.0)]
        {
            let mut soup =
                Soup { points: vec![[5.0, 0.0, 0.0], [5.0, extent, 0.0]], ..Soup::default() };
            soup.points.extend([[f64::NAN; 3], [1e70, 0.0, 0.0], [9e9, 0.0, 0.0]]);
            // A place that no polygon uses is ignored.
            soup.polygons.push([0, 1, 2, 3]);
            assert_eq!(to_size(&soup, 1.0), factor, "{extent}");
        }
        assert_eq!(to_size(&Soup::default(), 1.0), 1.0);
    }

    #[test]
    fn a_factor_is_finite_for_whatever_size() {
        for extent in [5e-324, 1e-300, 1e300, f64::MAX] {
            let mut soup = Soup { points: vec![[0.0; 3], [extent; 3]], ..Soup::default() };
            soup.polygons.push([0, 1, 0]);
            let factor = to_size(&soup, f64::MIN_POSITIVE);
            assert!(factor.is_normal() && factor.recip().is_normal(), "{extent}: {factor}");
        }
    }
}
