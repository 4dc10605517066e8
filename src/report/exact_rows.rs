//! The tables of exact faces on the page.

use serde_json::{Value, json};

use super::exact_view::{ExactView, KINDS, OTHER};
use super::relations::along;
use super::{ExactFigures, RelationFigures, SizeFigures, SnapFigures, SurfaceFigures};
use crate::report::picture::colour::TINTS;

/// The most rows of a table of snaps. A page with more is too long to be read, and the JSON has all of them.
const MOST_SNAPS: usize = 400;

/// What the page shows of exact faces.
pub(super) fn rows(view: &ExactView) -> Value {
    let figures = &view.figures;
    let kinds = KINDS.iter().zip(view.counts).zip(TINTS).filter(|((_, count), _)| *count > 0);
    let kind = |((name, count), tint): ((&&str, usize), u32)| json!({ "name": name, "count": count, "colour": format!("#{tint:06x}") });
    let cylinders = figures.cylinders.iter().enumerate().map(|(number, row)| {
        json!({
            "number": number, "kind": row.name(), "radius_mm": row.radius_mm,
            "deviation_mm": row.radius_deviation_mm, "length_mm": row.length_mm,
            "sweep_deg": row.sweep_deg, "axis": along(row.axis), "at": row.at,
        })
    });
    let facet_faces = KINDS.iter().zip(view.counts).find(|(name, _)| **name == OTHER);
    json!({
        "kinds": kinds.map(kind).collect::<Vec<_>>(),
        "rounding_mm": figures.rounding_mm,
        "cylinders": cylinders.collect::<Vec<_>>(),
        "relations": figures.relations.iter().map(|of| relation(of, figures)).collect::<Vec<_>>(),
        "sizes": figures.round_sizes.iter().map(size).collect::<Vec<_>>(),
        "distances": figures.distances.iter().take(MOST_DISTANCES).collect::<Vec<_>>(),
        "snapped": figures.snap_phrases(),
        "snaps": figures.snaps.iter().take(MOST_SNAPS).map(snap).collect::<Vec<_>>(),
        "snaps_left": figures.snaps.len().saturating_sub(MOST_SNAPS),
        "facets": figures.facets.iter().map(|row| json!({
            "surface": row.surface, "triangles": row.triangles, "at": row.at, "why": row.why,
        })).collect::<Vec<_>>(),
        "risers": figures.risers.iter().map(|row| json!({
            "triangles": row.triangles, "at": row.at, "why": row.why,
        })).collect::<Vec<_>>(),
        "facet_faces": facet_faces.map_or(0, |(_, count)| count),
        "explained_pct": figures.explained_pct,
    })
}

/// The most rows of a table of distances.
const MOST_DISTANCES: usize = 100;

/// A size with the words for whether it was made round.
fn size(of: &SizeFigures) -> Value {
    json!({
        "size": of.size, "faces": listed(&of.faces), "unit": of.unit, "value": of.value,
        "deviation": of.standard_deviation, "round": of.round, "taken": of.taken,
    })
}

/// Numbers with commas.
fn listed(of: &[usize]) -> String {
    of.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// A relation with the numbers of its cylinders.
fn relation(of: &RelationFigures, figures: &ExactFigures) -> Value {
    let first = of.cylinders.first().and_then(|&first| figures.cylinders.get(first));
    let radius = first.filter(|_| of.kind == "equal radius").map(|row| row.radius_mm);
    json!({ "kind": of.kind, "cylinders": listed(&of.cylinders), "to": listed(&of.to), "radius_mm": radius })
}

/// A snap with what it changed.
fn snap(snap: &SnapFigures) -> Value {
    let changes = changes(&snap.before, &snap.after);
    json!({ "face": snap.face, "kind": snap.after.kind, "to": snap.to, "changes": changes })
}

/// The decimal places of a parameter. The last ones of a mm or a direction are those of the finest files.
const DECIMALS: usize = 10;

/// The parameters of a surface that a snap changed, with their values before and after. There are none if the change
/// is finer than what is written.
fn changes(before: &SurfaceFigures, after: &SurfaceFigures) -> Vec<Value> {
    let texts = |of: &SurfaceFigures| {
        [
            ("place", Some(place(of.at))),
            ("axis", of.axis.map(place)),
            ("radius", of.radius_mm.map(written)),
            ("tube radius", of.tube_radius_mm.map(written)),
            ("half angle", of.half_angle_deg.map(written)),
        ]
    };
    let pairs = texts(before).into_iter().zip(texts(after));
    pairs
        .filter(|(before, after)| before.1 != after.1)
        .map(|((what, before), (_, after))| json!({ "what": what, "before": before, "after": after }))
        .collect()
}

fn place(at: [f64; 3]) -> String {
    format!("({})", at.map(written).join(", "))
}

/// A number without the zeros behind its last digit.
fn written(x: f64) -> String {
    let text = format!("{x:.DECIMALS$}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".into(),
        text => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_with_their_last_digit() {
        let numbers = [20.0, 19.999999915793065, -1e-17, -2.5, 100.0];
        assert_eq!(numbers.map(written), ["20", "19.9999999158", "0", "-2.5", "100"]);
    }

    #[test]
    fn only_what_changed_is_written() {
        let before = SurfaceFigures {
            kind: "cylinder",
            at: [0.0; 3],
            axis: Some([0.0, 0.0, 1.0]),
            radius_mm: Some(4.999999),
            tube_radius_mm: None,
            half_angle_deg: None,
        };
        let after = SurfaceFigures { radius_mm: Some(5.0), ..before };
        assert_eq!(
            changes(&before, &after),
            [json!({ "what": "radius", "before": "4.999999", "after": "5" })]
        );
        assert!(changes(&after, &after).is_empty());
    }
}
