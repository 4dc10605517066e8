//! Options that are numbers. The rules of the library say which values are valid.

use std::str::FromStr;

use clap::ValueEnum;
use formats::LengthUnit;
use scan2step::EdgeChoice;
use scan2step::rules::{self, Fault};
use scan2step::stages::smooth::Support;

use super::choices::Unit;

/// A number that a rule allows.
fn sound<T: FromStr + Copy>(
    text: &str,
    rule: impl FnOnce(T) -> Result<(), Fault>,
) -> Result<T, String> {
    let x = number(text)?;
    rule(x).map_err(|fault| fault.to_string())?;
    Ok(x)
}

fn number<T: FromStr>(text: &str) -> Result<T, String> {
    text.trim().parse().map_err(|_| match text.contains(',') {
        true => "not a number; write a decimal point, as 0.2".into(),
        false => "not a number".into(),
    })
}

/// A length above 0, in mm or with a unit.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    in_mm(text, rules::length)
}

/// A length of 0 or more, in mm or with a unit.
pub(crate) fn extent(text: &str) -> Result<f64, String> {
    in_mm(text, rules::extent)
}

/// A length as 0.05, 0.05mm, 20um or 0.002in, in mm.
fn in_mm(text: &str, rule: fn(f64) -> Result<(), Fault>) -> Result<f64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic());
    let unit = &text[digits.len()..];
    // A unit stands after a digit, so that "inf" and "nan" are numbers that no rule allows.
    let is_number = digits.trim_end().ends_with(|c: char| c.is_ascii_digit() || c == '.');
    let (digits, unit) = if is_number { (digits, unit) } else { (text, "") };
    let mm = match unit {
        "" => 1.0,
        unit => LengthUnit::from(Unit::from_str(unit, true).map_err(|_| {
            format!("'{unit}' is no unit of length: name um, mm, cm, m, in or ft, or none for mm")
        })?)
        .in_mm(),
    };
    let length = mm * number::<f64>(digits)?;
    rule(length).map_err(|fault| fault.to_string())?;
    Ok(length)
}

/// A percentage of points.
pub(crate) fn percentage(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    match rules::share(x / 100.0) {
        Ok(()) => Ok(x),
        Err(_) => Err("not a percentage from 0 to below 100".into()),
    }
}

/// A number of halvings of the domain.
pub(crate) fn depth(text: &str) -> Result<u32, String> {
    sound(text, rules::depth)
}

/// The bound on the control points of a net.
pub(crate) fn max_net(text: &str) -> Result<usize, String> {
    sound(text, rules::max_net)
}

/// A number of faces.
pub(crate) fn faces(text: &str) -> Result<usize, String> {
    sound(text, rules::faces)
}

/// The bound on the points of a cloud.
pub(crate) fn max_points(text: &str) -> Result<usize, String> {
    sound(text, rules::max_points)
}

/// The support of the smoothing.
pub(crate) fn support(text: &str) -> Result<Support, String> {
    match text {
        "auto" => Ok(Support::Auto),
        "off" => Ok(Support::Off),
        length => positive(length).map(Support::Fixed),
    }
}

/// Where exact faces end.
pub(crate) fn edges(text: &str) -> Result<EdgeChoice, String> {
    match text {
        "auto" => Ok(EdgeChoice::Auto),
        "off" => Ok(EdgeChoice::Off),
        degrees => sound(degrees, rules::degrees).map(EdgeChoice::Degrees),
    }
}

/// A net, as 13x13.
pub(crate) fn net(text: &str) -> Result<[usize; 2], String> {
    let wrong = "not of the form 13x13";
    let (m, n) = text.split_once(['x', 'X', '×']).ok_or(wrong)?;
    let side = |s: &str| s.trim().parse().map_err(|_| wrong.to_owned());
    let net = [side(m)?, side(n)?];
    net.into_iter().try_for_each(rules::side).map_err(|fault| fault.to_string())?;
    Ok(net)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units() {
        for (text, mm) in [
            ("0.05", 0.05),
            ("0.05mm", 0.05),
            ("20um", 0.02),
            ("20 µm", 0.02),
            ("0.002in", 0.0508),
            ("1e-3m", 1.0),
            ("2 inches", 50.8),
            (".5ft", 152.4),
        ] {
            assert!((positive(text).unwrap() - mm).abs() < 1e-12, "{text}");
        }
        for text in
            ["", "mm", "-1", "-1mm", "0", "nan", "inf", "5 parsec", "1e400", "5mmm", "1 2mm"]
        {
            assert!(positive(text).is_err(), "{text}");
        }
        assert_eq!(extent("0in"), Ok(0.0));
    }
}
