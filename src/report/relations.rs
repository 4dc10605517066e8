//! How the cylinders of a part lie to each other: equal radii, and axes that are one line, parallel or perpendicular.

use super::exact::CylinderFigures;
use crate::geometry::{Point, Vector};
use crate::words::{mm, plain_mm, plural};

/// A relation of several cylinders.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct RelationFigures {
    /// "equal radius", "coaxial", "parallel" or "perpendicular".
    pub kind: &'static str,
    /// The cylinders, as positions in the list of cylinders.
    pub cylinders: Vec<usize>,
    /// The cylinders that these are perpendicular to: each to each. Empty for the other kinds.
    pub to: Vec<usize>,
}

/// Two values differ by so many roundings at most if the true ones are the same, as each is known within one.
const OF_TWO: f64 = 2.0;

/// What counts as the same. Axes that are parallel within the rounding have been made so exactly, and others are
/// told apart: over the whole part they leave each other by more than the rounding.
struct Sameness {
    /// The largest difference of two lengths.
    length: f64,
    /// The largest sine of the angle between two directions: then two lines of the length of the part leave each
    /// other by no more than the lengths differ.
    sine: f64,
}

impl Sameness {
    fn new(rounding: f64, diagonal: f64) -> Self {
        let length = OF_TWO * rounding;
        Sameness { length, sine: length / diagonal.max(f64::MIN_POSITIVE) }
    }

    fn is_radius(&self, a: &CylinderFigures, b: &CylinderFigures) -> bool {
        (a.radius_mm - b.radius_mm).abs() <= self.length
    }

    fn is_parallel(&self, a: &CylinderFigures, b: &CylinderFigures) -> bool {
        Vector::from(a.axis).cross(&Vector::from(b.axis)).norm() <= self.sine
    }

    fn is_perpendicular(&self, a: &CylinderFigures, b: &CylinderFigures) -> bool {
        Vector::from(a.axis).dot(&Vector::from(b.axis)).abs() <= self.sine
    }

    /// Whether two parallel axes are one line.
    fn is_line(&self, a: &CylinderFigures, b: &CylinderFigures) -> bool {
        (Point::from(b.at) - Point::from(a.at)).cross(&Vector::from(a.axis)).norm() <= self.length
    }
}

/// The relations of the cylinders of a part with this diagonal. `rounding` bounds the errors of its vertices.
pub(super) fn relations(
    rows: &[CylinderFigures],
    rounding: f64,
    diagonal: f64,
) -> Vec<RelationFigures> {
    let same = Sameness::new(rounding, diagonal);
    let all: Vec<usize> = (0..rows.len()).collect();
    let radii = groups(&all, |i, j| same.is_radius(&rows[i], &rows[j]));
    let directions = groups(&all, |i, j| same.is_parallel(&rows[i], &rows[j]));
    let lines: Vec<Vec<Vec<usize>>> = directions
        .iter()
        .map(|group| groups(group, |i, j| same.is_line(&rows[i], &rows[j])))
        .collect();
    // Coaxial cylinders are parallel, too. Those that are only this need no second relation.
    let parallel = directions.iter().zip(&lines).filter(|(_, lines)| lines.len() > 1);
    let parallel = parallel.map(|(group, _)| group.clone()).collect();
    let shared = |groups: Vec<Vec<usize>>, kind| {
        let several = groups.into_iter().filter(|group| group.len() > 1);
        several.map(move |cylinders| RelationFigures { kind, cylinders, to: Vec::new() })
    };
    let perpendicular = perpendicular(directions, |i, j| same.is_perpendicular(&rows[i], &rows[j]));
    shared(radii, "equal radius")
        .chain(shared(lines.into_iter().flatten().collect(), "coaxial"))
        .chain(shared(parallel, "parallel"))
        .chain(perpendicular)
        .collect()
}

/// Members in groups of the same, each compared with the first of a group.
fn groups(members: &[usize], is_same: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &member in members {
        match groups.iter_mut().find(|group| is_same(group[0], member)) {
            Some(group) => group.push(member),
            None => groups.push(vec![member]),
        }
    }
    groups
}

/// Each direction with those that are perpendicular to it. A pair of directions is told once, with the direction of
/// more cylinders first, so that no long list stands beside many short ones.
fn perpendicular(
    mut directions: Vec<Vec<usize>>,
    is_perpendicular: impl Fn(usize, usize) -> bool,
) -> Vec<RelationFigures> {
    directions.sort_by_key(|group| std::cmp::Reverse(group.len()));
    let mut found = Vec::new();
    for (number, group) in directions.iter().enumerate() {
        let others = directions[number + 1..].iter();
        let others = others.filter(|other| is_perpendicular(group[0], other[0]));
        let mut to: Vec<usize> = others.flatten().copied().collect();
        to.sort_unstable();
        if !to.is_empty() {
            found.push(RelationFigures { kind: "perpendicular", cylinders: group.clone(), to });
        }
    }
    found
}

/// The radii that a line names.
const NAMED_RADII: usize = 3;

/// The relations in short phrases, one for each kind that there is: "equal radii 2 × 2.750 mm".
pub(super) fn phrases(relations: &[RelationFigures], rows: &[CylinderFigures]) -> Vec<String> {
    let of_kind = |kind: &'static str| relations.iter().filter(move |of| of.kind == kind);
    let mut phrases = Vec::new();
    let radii: Vec<String> = of_kind("equal radius")
        .filter_map(|of| Some((of.cylinders.len(), rows.get(*of.cylinders.first()?)?.radius_mm)))
        .map(|(count, radius)| format!("{count} × {}", plain_mm(radius)))
        .collect();
    if let Some(more) = radii.len().checked_sub(NAMED_RADII).filter(|more| *more > 0) {
        let named = radii[..NAMED_RADII].join(", ");
        phrases.push(format!("equal radii {named} mm and {more} more"));
    } else if !radii.is_empty() {
        phrases.push(format!("equal radii {} mm", radii.join(", ")));
    }
    for kind in ["coaxial", "parallel"] {
        let sizes: Vec<usize> = of_kind(kind).map(|of| of.cylinders.len()).collect();
        let all: usize = sizes.iter().sum();
        match sizes.len() {
            0 => {}
            1 => phrases.push(format!("{all} {kind}")),
            several => phrases.push(format!("{all} {kind} in {}", plural(several, "group"))),
        }
    }
    let mut perpendicular: Vec<usize> = of_kind("perpendicular")
        .flat_map(|of| of.cylinders.iter().chain(&of.to))
        .copied()
        .collect();
    perpendicular.sort_unstable();
    perpendicular.dedup();
    if !perpendicular.is_empty() {
        phrases.push(format!("{} perpendicular", perpendicular.len()));
    }
    phrases
}

/// For each cylinder the last relation of these kinds that it is in. Those that are in none have numbers of their own.
fn labels(relations: &[RelationFigures], kinds: &[&str], count: usize) -> Vec<usize> {
    let mut labels: Vec<usize> = (relations.len()..).take(count).collect();
    for (number, of) in relations.iter().enumerate().filter(|(_, of)| kinds.contains(&of.kind)) {
        of.cylinders.iter().for_each(|&cylinder| labels[cylinder] = number);
    }
    labels
}

/// Cylinders of one kind, radius and direction in a line: "2 bores of radius 2.750 mm along z".
pub(super) fn lists(relations: &[RelationFigures], rows: &[CylinderFigures]) -> Vec<String> {
    let radii = labels(relations, &["equal radius"], rows.len());
    // Parallel ones come after coaxial ones and hold these.
    let directions = labels(relations, &["coaxial", "parallel"], rows.len());
    let all: Vec<usize> = (0..rows.len()).collect();
    let alike = |i: usize, j: usize| {
        rows[i].kind == rows[j].kind && radii[i] == radii[j] && directions[i] == directions[j]
    };
    let line = |group: Vec<usize>| {
        let first = &rows[group[0]];
        let place = |&i: &usize| {
            let [x, y, z] = rows[i].at.map(|x| format!("{x:.3}"));
            format!("({x}, {y}, {z})")
        };
        let more = match group.len().saturating_sub(NAMED_PLACES) {
            0 => String::new(),
            more => format!(" and {}", plural(more, "more place")),
        };
        let places: Vec<String> = group.iter().take(NAMED_PLACES).map(place).collect();
        format!(
            "{} of radius {}{} along {}, at {}{more}",
            plural(group.len(), first.name()),
            mm(first.radius_mm),
            first.radius_deviation_mm.map_or(String::new(), |by| format!(" ± {}", mm(by))),
            along(first.axis),
            places.join(", ")
        )
    };
    groups(&all, alike).into_iter().map(line).collect()
}

/// The places that a line names.
const NAMED_PLACES: usize = 3;

/// A direction in words: the name of an axis of the world, "nearly" if the written numbers are those of one, or the
/// numbers.
pub(super) fn along(axis: [f64; 3]) -> String {
    const AXES: [&str; 3] = ["x", "y", "z"];
    if let Some(k) = (0..3).find(|&k| (0..3).all(|i| i == k || axis[i] == 0.0)) {
        return AXES[k].into();
    }
    let written = axis.map(|x| match format!("{x:.4}") {
        zero if zero == "-0.0000" => "0.0000".into(),
        text => text,
    });
    match (0..3).find(|&k| (0..3).all(|i| i == k || written[i] == "0.0000")) {
        Some(k) => format!("nearly {}", AXES[k]),
        None => format!("({})", written.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(kind: &'static str, radius_mm: f64, at: [f64; 3], axis: [f64; 3]) -> CylinderFigures {
        let (length_mm, sweep_deg) = (10.0, 360.0);
        let (radius_deviation_mm, faces) = (None, Vec::new());
        CylinderFigures {
            kind,
            radius_mm,
            radius_deviation_mm,
            at,
            axis,
            length_mm,
            sweep_deg,
            faces,
        }
    }

    fn kinds_of(rows: &[CylinderFigures]) -> Vec<(&'static str, Vec<usize>, Vec<usize>)> {
        let found = relations(rows, 1e-6, 100.0);
        found.into_iter().map(|of| (of.kind, of.cylinders, of.to)).collect()
    }

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    #[test]
    fn coaxial_cylinders_are_told_as_this_and_not_as_parallel_ones() {
        let down = [0.0, 0.0, -1.0];
        let rows = [row("bore", 5.0, [1.0, 2.0, 0.0], Z), row("bore", 3.0, [1.0, 2.0, 9.0], down)];
        assert_eq!(kinds_of(&rows), [("coaxial", vec![0, 1], vec![])]);
        let rows = [row("bore", 5.0, [1.0, 2.0, 0.0], Z), row("bore", 3.0, [1.0, 2.1, 9.0], down)];
        assert_eq!(kinds_of(&rows), [("parallel", vec![0, 1], vec![])]);
    }

    #[test]
    fn values_are_the_same_within_twice_the_rounding_and_no_farther() {
        let at = |off: f64, tilt: f64| {
            [row("bore", 5.0, [0.0; 3], Z), row("bore", 4.0, [off, 0.0, 0.0], [tilt, 0.0, 1.0])]
        };
        assert_eq!(kinds_of(&at(1.9e-6, 0.0)), [("coaxial", vec![0, 1], vec![])]);
        assert_eq!(kinds_of(&at(2.1e-6, 0.0)), [("parallel", vec![0, 1], vec![])]);
        assert_eq!(kinds_of(&at(0.0, 1.9e-8)), [("coaxial", vec![0, 1], vec![])]);
        assert!(kinds_of(&at(0.0, 2.1e-8)).is_empty());
        let tilted =
            [row("bore", 5.0, [0.0; 3], Z), row("bore", 4.0, [0.0; 3], [1.0, 0.0, 2.1e-8])];
        assert!(kinds_of(&tilted).is_empty());
        let radii =
            |by: f64| kinds_of(&[row("bore", 5.0, [0.0; 3], Z), row("bore", 5.0 + by, X, X)]);
        assert_eq!(radii(1.9e-6)[0], ("equal radius", vec![0, 1], vec![]));
        assert_eq!(radii(2.1e-6), [("perpendicular", vec![0], vec![1])]);
    }

    #[test]
    fn many_directions_make_no_long_list() {
        // 100 bores along z, and 36 radial ones, of which 18 pairs are perpendicular.
        let upright = (0..100).map(|k| row("bore", 2.0, [f64::from(k), 0.0, 0.0], Z));
        let radial = (0..36).map(|k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::PI / 36.0).sin_cos();
            row("bore", 3.0, [0.0; 3], [cos, sin, 0.0])
        });
        let rows: Vec<CylinderFigures> = upright.chain(radial).collect();
        let found = relations(&rows, 1e-6, 100.0);
        let perpendicular: Vec<_> = found.iter().filter(|of| of.kind == "perpendicular").collect();
        assert_eq!(perpendicular.len(), 1 + 18);
        assert_eq!((perpendicular[0].cylinders.len(), perpendicular[0].to.len()), (100, 36));
        let numbers: usize = found.iter().map(|of| of.cylinders.len() + of.to.len()).sum();
        assert!(numbers < 4 * rows.len(), "{numbers} numbers");
    }

    #[test]
    fn phrases_count_groups() {
        let rows = [
            row("bore", 2.75, [0.0; 3], Z),
            row("bore", 2.75, [9.0, 0.0, 0.0], Z),
            row("round", 4.0, [0.0; 3], Z),
            row("shaft", 1.0, [0.0; 3], X),
        ];
        let found = relations(&rows, 1e-6, 100.0);
        let expected = ["equal radii 2 × 2.750 mm", "2 coaxial", "3 parallel", "4 perpendicular"];
        assert_eq!(phrases(&found, &rows), expected);
        let lists = lists(&found, &rows);
        assert_eq!(
            lists[0],
            "2 bores of radius 2.750 mm along z, at (0.000, 0.000, 0.000), (9.000, 0.000, 0.000)"
        );
        assert_eq!(lists[1], "1 round edge of radius 4.000 mm along z, at (0.000, 0.000, 0.000)");
    }

    #[test]
    fn a_direction_is_that_of_an_axis_only_if_its_numbers_are() {
        assert_eq!(along([0.0, 1.0, 0.0]), "y");
        assert_eq!(along([0.0, 1.0, -1e-7]), "nearly y");
        assert_eq!(along([0.6, -0.8, -1e-7]), "(0.6000, -0.8000, 0.0000)");
    }
}
