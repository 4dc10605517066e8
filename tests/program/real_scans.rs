//! Real scans, if they are present. They are not part of the project.

use crate::common::importers::{freecad, opencascade};
use crate::common::{arg, convert, converted, json, number, shared};

/// Scans of class A of different kinds, with their numbers of holes: a shell, the underside of a
/// range scanner's figure, a car's body with its openings, a wavy sheet, and a roof. The running
/// boards of the car fold a little at the edge of the patch, which the check of Boolean arguments
/// finds.
const CONVERTED: [(&str, usize, bool); 5] = [
    ("scallop_shell.obj.gz", 0, true),
    ("bunny_bottom.ply.gz", 4, true),
    ("car_beetle.obj.gz", 10, false),
    ("stl_wavy_sheet.stl.gz", 0, true),
    ("roof_inspired.obj", 0, true),
];

#[test]
fn real_scans_become_faces_that_cad_opens() {
    for (name, holes, foldless) in CONVERTED {
        let Some(scan) = shared(&format!("scans/A/{name}")) else { return };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [step, report] = ["a.step", "a.json"].map(|n| folder.path().join(n));
        converted(&[arg(&scan), arg(&step), "--report", arg(&report)]);
        let found = opencascade(&step, None);
        for key in ["valid", "valid_unhealed", "oriented_loops"] {
            assert_eq!(found[key], true, "{name}: {key} in {found}");
        }
        assert!(found["argument_check"] == true || !foldless, "{name}: {found}");
        assert_eq!(found["wires_inner"], holes, "{name}: {found}");
        assert!(freecad(&step).is_none_or(|found| found["valid"] == true), "{name}");
        let r = json(&report);
        assert_eq!(r["parameterize"]["flipped"], 0, "{name}");
        println!("{name}: rms {} mm", number(&r, "/fit/rms_mm"));
    }
}

#[test]
fn a_named_tolerance_leaves_room_for_a_surface_without_folds() {
    let Some(scan) = shared("scans/A/bunny_flank.obj.gz") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [step, report] = ["a.step", "a.json"].map(|n| folder.path().join(n));
    // The tolerance is a thousandth of the diagonal. Over the smallest net that satisfies it, 27
    // Jacobian samples are inverted, and no other surface over this net satisfies it.
    let asked = ["--tolerance", "0.000141064"];
    converted(&[&[arg(&scan), arg(&step), "--report", arg(&report)], &asked[..]].concat());
    let r = json(&report);
    assert_eq!((&r["fit"]["folds"], &r["fit"]["within_pct"]), (&0.into(), &100.0.into()));
    assert_eq!(r["tolerance_met"], true);
    assert_eq!(opencascade(&step, None)["argument_check"], true);
}

/// Scans whose triangles the map stretches over several knot cells, and about a thousandth of their
/// diagonals. Over the knots that their points need, the face leaves some of these triangles.
const DRAWN_OUT: [(&str, &str); 2] =
    [("bunny_bottom.ply.gz", "0.000152814"), ("lion_head.obj.gz", "0.0015")];

#[test]
fn a_named_tolerance_holds_between_points_too() {
    for (name, tolerance) in DRAWN_OUT {
        let Some(scan) = shared(&format!("scans/A/{name}")) else { return };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [step, report] = ["a.step", "a.json"].map(|n| folder.path().join(n));
        let asked = ["--tolerance", tolerance, "--report", arg(&report)];
        converted(&[&[arg(&scan), arg(&step)], &asked[..]].concat());
        let back = &json(&report)["face_to_scan"];
        assert_eq!(back["beyond"], 0, "{name}: {back}");
    }
}

#[test]
fn whole_models_become_no_face() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let step = folder.path().join("a.step");
    for (name, reason) in [
        ("armadillo.obj.gz", "closed, genus 0, no boundary"),
        ("rocker_arm.obj.gz", "closed, genus 1, no boundary"),
        ("fertility.ply", "closed, genus 4, no boundary"),
    ] {
        let Some(scan) = shared(&format!("scans/B/{name}")) else { return };
        let output = convert(&[arg(&scan), arg(&step), "--shape", "face"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {said}");
        assert!(said.contains(reason), "{name}: {said}");
    }
}
