//! Designers continue with exact parts: they measure bores, round an edge, pad a sketch, cut and fuse.

use std::path::Path;

use crate::common::importers::{freecad_operations, make_parts, opencascade_operations};
use crate::common::{arg, converted, fixture, json, number};
use serde_json::{Value, json};

/// How far volumes may be off, as a share. Importers integrate to about 1e-8.
const EXACT: f64 = 1e-6;

/// How far radii may be off, in mm: the numbers of the files have steps of 4e-6 mm.
const OF_RADIUS: f64 = 1e-5;

/// The results of the next steps in OpenCASCADE and FreeCAD, once the step file is made.
fn operated(scan: &Path, step: &Path) -> Vec<Value> {
    converted(&[arg(scan), arg(step)]);
    [Some(opencascade_operations(step)), freecad_operations(step)].into_iter().flatten().collect()
}

/// Checks the results of the next steps against the bores and the volume of a part.
fn assert_operable(name: &str, found: &Value, bores: &[f64], volume: f64) {
    assert_eq!((&found["solids"], &found["valid"]), (&1.into(), &true.into()), "{name}: {found}");
    assert_eq!(found["check"], Value::Null, "{name}: {found}");
    assert!((number(found, "/volume") / volume - 1.0).abs() < EXACT, "{name}: {volume} in {found}");
    let radii = found["bores"].as_array().expect("a list");
    assert_eq!(radii.len(), bores.len(), "{name}: {found}");
    for (found, radius) in radii.iter().zip(bores) {
        let off = (found.as_f64().expect("a radius") - radius).abs();
        assert!(off < OF_RADIUS, "{name}: {off} off {radius}");
    }
    for step in ["round", "pad", "cut", "fuse"] {
        let made = &found[step];
        if step == "round" && made.is_null() {
            // The flange has no straight edge.
            assert_eq!(name, "flange", "{found}");
            continue;
        }
        assert_eq!(made["valid"], true, "{name}, {step}: {found}");
        let share = number(made, "/volume") / number(made, "/expected");
        assert!((share - 1.0).abs() < EXACT, "{name}, {step}: {share} of {made}");
    }
}

#[test]
fn designers_continue_with_the_bracket() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let step = folder.path().join("bracket.step");
    let made = operated(&fixture("bracket.stl"), &step);
    for found in made {
        let volume = number(&found, "/volume");
        assert_operable("bracket", &found, &[2.75, 2.75, 9.0], volume);
    }
}

#[test]
fn designers_continue_with_parts_of_their_own() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    make_parts(folder.path());
    for name in ["block", "flange", "angle"] {
        let [scan, step, truth] =
            ["stl", "step", "json"].map(|end| folder.path().join(format!("{name}.{end}")));
        let truth = json(&truth);
        let bores = truth["bores"].as_array().expect("a list").iter();
        let bores: Vec<f64> = bores.map(|radius| radius.as_f64().expect("a radius")).collect();
        for found in operated(&scan, &step) {
            assert_operable(name, &found, &bores, number(&truth, "/volume"));
        }
    }
}

/// The checks above can fail: they notice a bore that was not found, and a volume that is off.
#[test]
#[should_panic(expected = "bracket")]
fn a_missing_bore_is_noticed() {
    let volume = json!({ "volume": 1.0, "expected": 1.0, "valid": true });
    let found = json!({
        "solids": 1, "valid": true, "check": null, "volume": 1.0, "bores": [2.75],
        "round": volume, "pad": volume, "cut": volume, "fuse": volume,
    });
    assert_operable("bracket", &found, &[2.75, 2.75], 1.0);
}
