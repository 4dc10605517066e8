//! What colour a distance has.

use super::colour::{Rgb, linear, mix, srgb};

/// Viridis, for distances: colours that the colour-blind tell apart too, their
/// lightness growing evenly.
pub const DISTANCE: [u32; 9] =
    [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];

/// For distances with a sign: blue below the face, red above it, and a grey that is
/// neither where the two meet (after Moreland's diverging maps).
pub const SIGNED: [u32; 9] =
    [0x1c3f94, 0x3b6fc4, 0x74a3e0, 0xb4cdee, 0xe6e4e1, 0xf0bfa4, 0xe08a67, 0xc4503f, 0x96162c];

/// The colour of a share of a scale, from 0 to 1.
pub fn colour(scale: &[u32; 9], share: f64) -> Rgb {
    let at = share.clamp(0.0, 1.0) * (scale.len() - 1) as f64;
    let k = (at as usize).min(scale.len() - 2);
    // Neighbours are so near each other that linear light does for mixing.
    mix(linear(srgb(scale[k])), linear(srgb(scale[k + 1])), (at - k as f64) as f32)
}

/// The least of 1, 2, 2.5 and 5 times a power of ten that is not below `x`, and the
/// decimals that it and half of it need.
pub fn rounded_up(x: f64) -> (f64, usize) {
    if !(x > 1e-12 && x.is_finite()) {
        return (1e-12, 12);
    }
    let exponent = x.log10().floor() as i32;
    let unit = 10f64.powi(exponent);
    let step = [1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let factor = step.into_iter().find(|s| s * unit >= x * (1.0 - 1e-9)).unwrap_or(10.0);
    (factor * unit, (2 - exponent).clamp(0, 14) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_round_numbers() {
        assert_eq!(rounded_up(0.0213), (0.025, 4));
        assert_eq!(rounded_up(0.95), (1.0, 3));
        assert_eq!(rounded_up(23.4), (25.0, 1));
        assert_eq!(rounded_up(0.3).0, 0.3);
        assert!(rounded_up(0.0).0 > 0.0 && rounded_up(f64::NAN).0 > 0.0);
    }
}
