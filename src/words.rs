//! Numbers formatted for people.

/// Formats a length in mm with four significant digits. Scans range from the size of a mountain to,
/// with a wrong unit, the size of a grain.
pub fn mm(length: f64) -> String {
    let digits = if length > 0.0 { 3 - length.log10().floor() as i32 } else { 0 };
    format!("{length:.*} mm", digits.clamp(0, 12) as usize)
}

/// A number of bytes in units of 1000, with one digit behind the point: "65.5 MB".
pub fn bytes(count: u64) -> String {
    const UNITS: [&str; 6] = ["kB", "MB", "GB", "TB", "PB", "EB"];
    if count < 1000 {
        return format!("{count} B");
    }
    // A value that rounds to 1000.0 stays in its unit.
    let power = count.ilog10() / 3;
    let unit = UNITS.get(power as usize - 1).copied().unwrap_or("EB");
    format!("{:.1} {unit}", count as f64 / 1000f64.powi(power as i32))
}

/// A number with a narrow space between thousands, as reports show it. Lines do not break there. The
/// terminal shows plain digits, which can be copied into a command.
pub fn grouped(number: &str) -> String {
    let whole = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
    let mut text = String::new();
    for (k, c) in number.char_indices() {
        if k > 0 && k < whole && (whole - k).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(c);
    }
    text
}

/// The extent of a box in x, y and z: "100.3 × 80.24 × 17.41 mm". Its corners are mm.
pub fn extent([low, high]: [[f64; 3]; 2]) -> String {
    let lengths = [0, 1, 2].map(|axis| plain_mm(high[axis] - low[axis]));
    format!("{} mm", lengths.join(" × "))
}

/// A length in mm without its unit, which stands beside.
pub fn plain_mm(length: f64) -> String {
    grouped(mm(length).trim_end_matches(" mm"))
}

/// A count of things by their name: "1 hole", "2 holes".
pub fn plural(count: usize, name: &str) -> String {
    format!("{count} {name}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::{bytes, extent, grouped, mm, plural};

    #[test]
    fn bytes_have_the_largest_unit_below_them() {
        assert_eq!(bytes(0), "0 B");
        assert_eq!(bytes(999), "999 B");
        assert_eq!(bytes(1000), "1.0 kB");
        assert_eq!(bytes(65_456_999), "65.5 MB");
        assert_eq!(bytes(u64::MAX), "18.4 EB");
    }

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!([0, 1, 2].map(|n| plural(n, "hole")), ["0 holes", "1 hole", "2 holes"]);
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(grouped("1234567"), "1\u{202f}234\u{202f}567");
        assert_eq!(grouped("53469 mm"), "53\u{202f}469 mm");
        assert_eq!(["999", "0.123456", ""].map(grouped), ["999", "0.123456", ""]);
    }

    #[test]
    fn a_box_has_one_unit() {
        let bounds = [[-1.0, 0.0, 5.0], [1.5, 12_345.6, 5.0]];
        assert_eq!(extent(bounds), "2.500 × 12\u{202f}346 × 0 mm");
    }

    #[test]
    fn lengths_have_four_digits() {
        assert_eq!(mm(0.059712), "0.05971 mm");
        assert_eq!(mm(22.532185), "22.53 mm");
        assert_eq!(mm(53468.6), "53469 mm");
        assert_eq!(mm(0.0), "0 mm");
        assert_eq!(mm(1.2345e-5), "0.00001234 mm");
    }
}
