//! What `convert` says of the cylinders of a part, and of what was moved within the rounding of the file.

use scan2step::ExactFit;
use scan2step::report::{ExactFigures, SizeFigures};
use scan2step::words::{plural, significant};

use super::progress::ProgressDisplay;

/// The lines of cylinders that a terminal shows. The report has all of them.
const MOST_LINES: usize = 8;

/// Says which bores and shafts a part has, how they lie to each other, and what was snapped.
pub(crate) fn say(progress: &ProgressDisplay, of: &str, exact: &ExactFit) {
    let figures = ExactFigures::of(exact);
    let lines = figures.cylinder_lines();
    for line in lines.iter().take(MOST_LINES) {
        progress.say(&format!("{of}cylinders: {line}"));
    }
    if lines.len() > MOST_LINES {
        let more = lines.len() - MOST_LINES;
        progress.say(&format!("{of}cylinders: {more} more kinds, which the report lists"));
    }
    let relations = figures.relation_phrases();
    if !relations.is_empty() {
        progress.say(&format!("{of}relations: {}", relations.join("; ")));
    }
    sizes(progress, of, &figures.round_sizes);
    let snaps = figures.snap_phrases();
    if !snaps.is_empty() {
        progress.say(&format!("{of}moved within the rounding: {}", snaps.join(", ")));
    }
}

/// Says which sizes of a scan are round, or were made so.
fn sizes(progress: &ProgressDisplay, of: &str, sizes: &[SizeFigures]) {
    for is_taken in [true, false] {
        let own: Vec<String> =
            sizes.iter().filter(|size| size.taken == is_taken).map(SizeFigures::phrase).collect();
        if own.is_empty() {
            continue;
        }
        let named = own.iter().take(MOST_LINES).cloned().collect::<Vec<_>>().join("; ");
        let more = match own.len().saturating_sub(MOST_LINES) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let (word, how) = match is_taken {
            true => ("made round", ""),
            false => ("round within two standard deviations", " (--regularize to take them)"),
        };
        progress.say(&format!("{of}{word}: {named}{more}{how}"));
    }
}

/// The radii of cylinders in mm in words, equal ones together: "20.00, 9.000 and 2 × 2.750 mm".
pub(crate) fn radii(radii: &[f64]) -> String {
    let mut named: Vec<(String, usize)> = Vec::new();
    for radius in radii.iter().map(|&radius| significant(radius)) {
        match named.last_mut() {
            Some((last, count)) if *last == radius => *count += 1,
            _ => named.push((radius, 1)),
        }
    }
    let left = named.split_off(named.len().min(MOST_LINES));
    let shown = named.into_iter().map(|(radius, count)| match count {
        1 => radius,
        count => format!("{count} × {radius}"),
    });
    let shown = shown.collect::<Vec<_>>().join(", ") + " mm";
    match left.len() {
        0 => shown,
        more => format!("{shown} and {}", plural(more, "smaller one")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_radii_stand_together_and_few_are_shown() {
        assert_eq!(radii(&[20.0, 9.0, 2.75, 2.75]), "20.00, 9.000, 2 × 2.750 mm");
        let many: Vec<f64> = (1..=10).rev().map(f64::from).collect();
        assert!(radii(&many).ends_with("3.000 mm and 2 smaller ones"), "{}", radii(&many));
    }
}
