//! What could be better, and what the user can do about it: the hints of each face, and those
//! that concern the scan as a whole.

use super::{ScanSource, Setting, Settings};
use crate::Conversion;
use crate::geometry::{Vector, bounds};
use crate::words::mm;

/// The hints of some conversions of one scan.
pub(super) fn of(
    conversions: &[Conversion],
    source: &ScanSource,
    settings: &Settings,
) -> Vec<String> {
    let mut hints: Vec<String> = odd_size(source, conversions).into_iter().collect();
    for (k, c) in conversions.iter().enumerate() {
        let part = if conversions.len() > 1 { format!("component {k}: ") } else { String::new() };
        let own = c.hints.iter().cloned().chain(left_out(settings, c));
        hints.extend(own.map(|hint| part.clone() + &hint));
    }
    hints
}

/// Sizes of a scan in mm that make the assumed unit likely: more than a thimble, less than a
/// house.
const LIKELY_SIZES: [f64; 2] = [5.0, 50_000.0];

fn odd_size(source: &ScanSource, conversions: &[Conversion]) -> Option<String> {
    let points = conversions.iter().flat_map(|c| &c.surface.net);
    likely_unit(source, bounds(points.map(|&p| p.into())).map(|p| p.coords.into()))
}

/// Advice to name the unit of a scan, if its unit was assumed and makes its size unlikely. The
/// bounds of the scan are mm.
pub fn likely_unit(source: &ScanSource, [low, high]: [[f64; 3]; 2]) -> Option<String> {
    let across = (Vector::from(high) - Vector::from(low)).norm();
    let is_likely = (LIKELY_SIZES[0]..LIKELY_SIZES[1]).contains(&across);
    (source.unit_assumed && !is_likely).then(|| {
        let others: Vec<_> =
            ["mm", "cm", "m", "in"].into_iter().filter(|u| *u != source.unit.symbol()).collect();
        format!(
            "the scan is {} across if its numbers are {}; --units {} if they are not",
            mm(across),
            source.unit.symbol(),
            others.join(", ").replacen(", in", " or in", 1)
        )
    })
}

/// The share of the scan's triangles in other components that is worth a hint: a tenth of a
/// scan is more than dust.
const LEFT_OUT: f64 = 0.1;

fn left_out(settings: &Settings, c: &Conversion) -> Option<String> {
    let all = (c.input.triangles + c.input.island_triangles + c.input.left_out) as f64;
    let share = c.input.left_out as f64 / all.max(1.0);
    (settings.component != Setting::Word("all") && share > LEFT_OUT).then(|| {
        format!(
            "{:.0} % of the scan's triangles are in other pieces; --component all converts every one",
            100.0 * share
        )
    })
}
