//! What could be better, and what the user can do about it: of all that was converted.

use scan2step::Conversion;
use scan2step::words::mm;

use super::args::{Component, Convert};
use super::input::Scan;

/// The hints of all conversions, with those that only the command line knows of.
pub fn all(args: &Convert, scan: &Scan, conversions: &[Conversion]) -> Vec<String> {
    let mut hints: Vec<String> = size(scan, conversions).into_iter().collect();
    for (k, c) in conversions.iter().enumerate() {
        let part = if conversions.len() > 1 { format!("component {k}: ") } else { String::new() };
        let own = c.hints.iter().cloned().chain(others(args, c));
        hints.extend(own.map(|hint| part.clone() + &hint));
    }
    hints
}

/// A scan of less than a thimble or more than a house is likelier in another unit.
const SIZES: [f64; 2] = [5.0, 50_000.0];

/// The diagonal of the box around the faces, in mm.
fn across(conversions: &[Conversion]) -> f64 {
    let points = conversions.iter().flat_map(|c| &c.surface.net);
    let [low, high] = scan2step::geometry::bounds(points.map(|&p| p.into()));
    (high - low).norm()
}

fn size(scan: &Scan, conversions: &[Conversion]) -> Option<String> {
    let across = across(conversions);
    let odd = scan.unit_assumed && !(SIZES[0]..SIZES[1]).contains(&across);
    odd.then(|| {
        format!(
            "the scan is {} across if its numbers are mm; --units m, cm or in if they are not",
            mm(across)
        )
    })
}

/// Share of the scan's triangles in pieces left out that is worth a word.
const LEFT_OUT: f64 = 0.1;

fn others(args: &Convert, c: &Conversion) -> Option<String> {
    let all = (c.input.triangles + c.input.island_triangles + c.input.left_out) as f64;
    let share = c.input.left_out as f64 / all.max(1.0);
    (args.how.component != Component::All && share > LEFT_OUT).then(|| {
        format!(
            "{:.0} % of the scan's triangles are in other pieces; --component all converts every one",
            100.0 * share
        )
    })
}
