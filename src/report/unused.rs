//! Options that the caller named, but that have no effect on what the scan is or becomes.

use super::{ScanSource, Settings};

/// A hint for each option without effect. `shape` is what the scan became.
pub(super) fn of(settings: &Settings, source: &ScanSource, shape: &str) -> Vec<String> {
    let is_mesh = source.cloud.is_none();
    let is_face = shape == "face";
    let fills =
        if shape == "shell" { "all its holes are cut out" } else { "all its holes stay filled" };
    let mesh = "the scan is a mesh, not a cloud";
    let unused = [
        (is_mesh && settings.spacing.is_some(), "spacing", mesh),
        (is_mesh && settings.max_points.is_some(), "max-points", mesh),
        (is_mesh && settings.scan.is_some(), "scan", mesh),
        (is_face && settings.faces.is_some(), "faces", "a face is one surface"),
        (!is_face && settings.keep_fills, "keep-fills", fills),
        (!is_face && settings.fill_only_holes_below.is_some(), "fill-only-holes-below", fills),
        (!is_face && settings.net.is_some(), "net", "only a single face has one net"),
    ];
    let named = unused.into_iter().filter(|(is_unused, ..)| *is_unused);
    named
        .map(|(_, option, why)| format!("--{option} has no effect on this {shape}: {why}"))
        .collect()
}
