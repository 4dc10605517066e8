//! The text of real numbers in exchange files.
//!
//! STEP and IGES get the fewest digits that read back as the same `f64`. With fewer digits, the
//! distance of a trim curve from its surface would exceed what the Boolean operations of importers
//! accept. Both formats require a decimal point in every real number.

use std::fmt;

/// A real number in the notation of ISO 10303-21, clause 6.4.2: `1.`, `0.25`, `1.5E-07`.
pub(crate) struct StepReal(pub f64);

/// A double-precision real number in the notation of IGES 5.3, clause 2.2.2.2: `1.`, `0.25`,
/// `1.5D-07`.
pub(crate) struct IgesReal(pub f64);

impl fmt::Display for StepReal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        real(self.0, 'E', f)
    }
}

impl fmt::Display for IgesReal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        real(self.0, 'D', f)
    }
}

fn real(x: f64, letter: char, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    debug_assert!(x.is_finite(), "`Brep::check` lets finite numbers through only");
    let magnitude = x.abs();
    if magnitude == 0.0 {
        f.write_str("0.") // no sign: -0 means nothing in a CAD file
    } else if !(1e-4..1e15).contains(&magnitude) {
        scientific(x, letter, f)
    } else if x.fract() == 0.0 {
        write!(f, "{x}.")
    } else {
        write!(f, "{x}")
    }
}

fn scientific(x: f64, letter: char, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let text = format!("{x:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let point = if mantissa.contains('.') { "" } else { "." };
    let (sign, digits) = match exponent.strip_prefix('-') {
        Some(digits) => ('-', digits),
        None => ('+', exponent),
    };
    write!(f, "{mantissa}{point}{letter}{sign}{digits:0>2}")
}

/// The distinct knots of a knot vector and the multiplicity of each.
///
/// Knots are compared exactly, because a net of a thousand rows may have knots closer than 1e-6.
pub(crate) fn distinct_knots(knots: &[f64]) -> (Vec<f64>, Vec<usize>) {
    let mut distinct = Vec::with_capacity(knots.len());
    let mut counts: Vec<usize> = Vec::with_capacity(knots.len());
    for &knot in knots {
        match counts.last_mut() {
            Some(count) if distinct.last() == Some(&knot) => *count += 1,
            _ => {
                distinct.push(knot);
                counts.push(1);
            }
        }
    }
    (distinct, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_carry_a_point_and_read_back() {
        for (x, text) in [
            (0.0, "0."),
            (-0.0, "0."),
            (1.0, "1."),
            (-12.0, "-12."),
            (0.1, "0.1"),
            (1e-5, "1.E-05"),
            (-2.5e-7, "-2.5E-07"),
            (1e15, "1.E+15"),
            (1.25e300, "1.25E+300"),
            (1.0 / 3.0, "0.3333333333333333"),
        ] {
            assert_eq!(StepReal(x).to_string(), text);
            assert_eq!(text.parse::<f64>().unwrap(), x);
            assert_eq!(IgesReal(x).to_string(), text.replace('E', "D"));
        }
    }

    #[test]
    fn close_knots_stay_apart() {
        let (knots, counts) = distinct_knots(&[0.0, 0.0, 1e-9, 1.0, 1.0]);
        assert_eq!(knots, [0.0, 1e-9, 1.0]);
        assert_eq!(counts, [2, 1, 2]);
    }
}
