//! Options that are numbers. The rules of the library say which values are valid.

use std::str::FromStr;

use scan2step::rules::{self, Fault};
use scan2step::smooth::Support;

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
    text.trim().parse().map_err(|_| "not a number".into())
}

/// A length above 0, in mm.
pub fn positive(text: &str) -> Result<f64, String> {
    sound(text, rules::length)
}

/// A length of 0 or more, in mm.
pub fn extent(text: &str) -> Result<f64, String> {
    sound(text, rules::extent)
}

/// A percentage of points.
pub fn percentage(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    match rules::share(x / 100.0) {
        Ok(()) => Ok(x),
        Err(_) => Err("not a percentage from 0 to below 100".into()),
    }
}

/// A number of halvings of the domain.
pub fn depth(text: &str) -> Result<u32, String> {
    sound(text, rules::depth)
}

/// The bound on the control points of a net.
pub fn max_net(text: &str) -> Result<usize, String> {
    sound(text, rules::max_net)
}

/// A number of faces.
pub fn faces(text: &str) -> Result<usize, String> {
    sound(text, rules::faces)
}

/// The bound on the points of a cloud.
pub fn max_points(text: &str) -> Result<usize, String> {
    sound(text, rules::max_points)
}

/// The support of the smoothing.
pub fn support(text: &str) -> Result<Support, String> {
    match text {
        "auto" => Ok(Support::Auto),
        "off" => Ok(Support::Off),
        length => positive(length).map(Support::Fixed),
    }
}

/// A net, as 13x13.
pub fn net(text: &str) -> Result<[usize; 2], String> {
    let wrong = "not of the form 13x13";
    let (m, n) = text.split_once(['x', 'X', '×']).ok_or(wrong)?;
    let side = |s: &str| s.trim().parse().map_err(|_| wrong.to_owned());
    let net = [side(m)?, side(n)?];
    net.into_iter().try_for_each(rules::side).map_err(|fault| fault.to_string())?;
    Ok(net)
}
