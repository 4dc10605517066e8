//! Numbers formatted for people.

/// Formats a length in mm with four significant digits. Scans range from the size of a mountain to,
/// with a wrong unit, the size of a grain.
pub fn mm(length: f64) -> String {
    let digits = if length > 0.0 { 3 - length.log10().floor() as i32 } else { 0 };
    format!("{length:.*} mm", digits.clamp(0, 12) as usize)
}

#[cfg(test)]
mod tests {
    use super::mm;

    #[test]
    fn lengths_have_four_digits() {
        assert_eq!(mm(0.059712), "0.05971 mm");
        assert_eq!(mm(22.532185), "22.53 mm");
        assert_eq!(mm(53468.6), "53469 mm");
        assert_eq!(mm(0.0), "0 mm");
        assert_eq!(mm(1.2345e-5), "0.00001234 mm");
    }
}
