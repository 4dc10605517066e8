//! Colours in the notations of formats: as sRGB, or in proportion to the light.

/// The colour of three sRGB values between 0 and 1. `None` if one of them is no number.
pub(crate) fn srgb(channels: [f64; 3]) -> Option<[u8; 3]> {
    let is_number = channels.iter().all(|x| x.is_finite());
    is_number.then(|| channels.map(|x| (x.clamp(0.0, 1.0) * f64::from(u8::MAX)).round() as u8))
}

/// The colour of three values in proportion to the light (IEC 61966-2-1, the transfer function of sRGB).
pub(crate) fn srgb_of_linear(channels: [f64; 3]) -> Option<[u8; 3]> {
    /// Below this light, the function is a line.
    const DARK: f64 = 0.003_130_8;
    srgb(channels.map(|x| match x {
        dark if dark <= DARK => 12.92 * dark,
        light => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }))
}

/// The colour of `#RRGGBB` or `#RRGGBBAA`, as 3MF writes it.
pub(crate) fn of_hexadecimal(text: &str) -> Option<[u8; 3]> {
    let digits = text.trim().strip_prefix('#')?;
    let is_colour = matches!(digits.len(), 6 | 8) && digits.bytes().all(|b| b.is_ascii_hexdigit());
    let channel = |at: usize| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok();
    is_colour.then(|| Some([channel(0)?, channel(2)?, channel(4)?])).flatten()
}

#[cfg(test)]
mod tests {
    use super::{of_hexadecimal, srgb, srgb_of_linear};

    #[test]
    fn colours_of_all_notations() {
        assert_eq!(srgb([0.0, 0.51, 2.0]), Some([0, 130, 255]));
        assert_eq!(srgb([0.0, f64::NAN, 1.0]), None);
        // Half of the light is 188.
        assert_eq!(srgb_of_linear([0.5, 0.002, 1.0]), Some([188, 7, 255]));
        assert_eq!(of_hexadecimal("#173DCCFF"), Some([0x17, 0x3d, 0xcc]));
        assert_eq!(of_hexadecimal(" #1C6385 "), Some([0x1c, 0x63, 0x85]));
        for bad in ["", "173DCC", "#173DC", "#+13DCC", "#173DCC\u{e9}"] {
            assert_eq!(of_hexadecimal(bad), None, "{bad}");
        }
    }
}
