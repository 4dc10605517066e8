//! What colour a distance has.

use super::colour::{Rgb, linear, mix, srgb};

/// Viridis, for distances: colours that the colour-blind tell apart too, their
/// lightness growing evenly.
pub const DISTANCE: [u32; 9] =
    [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];

/// For distances with a sign: blue below the face, red above it, and a grey that is
/// neither where the two meet (after Moreland's diverging maps).
pub(crate) const SIGNED: [u32; 9] =
    [0x1c3f94, 0x3b6fc4, 0x74a3e0, 0xb4cdee, 0xe6e4e1, 0xf0bfa4, 0xe08a67, 0xc4503f, 0x96162c];

/// The colour of a share of a scale, from 0 to 1.
pub fn colour(scale: &[u32; 9], share: f64) -> Rgb {
    let at = share.clamp(0.0, 1.0) * (scale.len() - 1) as f64;
    let k = (at as usize).min(scale.len() - 2);
    // Neighbours are so near each other that linear light does for mixing.
    mix(linear(srgb(scale[k])), linear(srgb(scale[k + 1])), (at - k as f64) as f32)
}

/// The factors of a power of ten at which a scale may end.
const ENDS: [f64; 10] = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];

/// The least number at which a scale may end that is not below `x`.
pub fn rounded_up(x: f64) -> f64 {
    if !(x > 1e-12 && x.is_finite()) {
        return 1e-12;
    }
    let exponent = x.log10().floor() as i32;
    // Divided by a power of ten, 3 gives the double that is written 0.3.
    let scaled = |factor: f64| match exponent {
        0.. => factor * 10f64.powi(exponent),
        _ => factor / 10f64.powi(-exponent),
    };
    ENDS.into_iter().map(scaled).find(|&end| end >= x * (1.0 - 1e-9)).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        for (x, end) in [(0.0213, 0.025), (0.95, 1.0), (23.4, 25.0), (0.3, 0.3), (6.1e-7, 8e-7)] {
            assert_eq!(rounded_up(x), end);
        }
        assert!(rounded_up(0.0) > 0.0 && rounded_up(f64::NAN) > 0.0);
    }
}
