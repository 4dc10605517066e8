//! Files with which people's complaints began, beside the project. Each of them must become what is right.

use std::path::{Path, PathBuf};

use crate::common::{
    arg, check, checked, convert, converted, files, inspect, inspected, json, shared,
};
use serde_json::Value;

fn case(name: &str) -> Option<PathBuf> {
    shared(&format!("cases/{name}"))
}

/// The report of a conversion, and what it says.
fn report(folder: &Path, scan: &Path, options: &[&str]) -> (Value, String) {
    let out = folder.join("out.step");
    let report = folder.join("out.json");
    let mut args = vec![arg(scan), arg(&out), "--report", arg(&report)];
    args.extend(options);
    let said = converted(&args);
    (json(&report), said)
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn blocks_are_one_sheet() {
    for name in ["weld-nodes-translated.glb", "weld-blocks-1e-5mm.obj"] {
        let Some(scan) = case(name) else { return };
        let folder = tempfile::tempdir().unwrap();
        let (report, said) = report(folder.path(), &scan, &[]);
        let trims = report["trim"].as_array().map(Vec::len);
        assert_eq!((report["input"]["components"].as_u64(), trims), (Some(1), Some(2)), "{name}");
        assert!(said.contains("of rims joined"), "{said}");
    }
}

#[test]
fn sheets_that_overlap_become_one_by_their_points() {
    let Some(scan) = case("weld-overlap.obj") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (_, said) = report(folder.path(), &scan, &[]);
    assert!(said.contains("overlap") && said.contains("--remesh"), "{said}");
    std::fs::remove_file(folder.path().join("out.step")).unwrap();
    let (report, _) = report(folder.path(), &scan, &["--remesh"]);
    assert_eq!(
        (&report["input"]["components"], &report["shape"]["kind"]),
        (&1.into(), &"face".into())
    );
}

#[test]
fn a_slit_tube_has_no_invented_ends() {
    let Some(scan) = case("shape-slit-tube.ply") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (report, _) = report(folder.path(), &scan, &[]);
    assert_ne!(report["shape"]["kind"], "solid");
    let found = checked(&folder.path().join("out.step"), &scan);
    let [low, high] = [0, 1].map(|k| number(&found["cad"]["bounds_mm"][k][2]));
    assert!(low > -0.5 && high < 70.5, "{low} to {high}");
}

#[test]
fn both_sides_of_a_plate_are_sheets() {
    for name in ["cloud-two-sides-thick1.5.xyz.gz", "cloud-two-sides-thickn1.5.xyz.gz"] {
        let Some(scan) = case(name) else { return };
        let found = inspected(&scan);
        assert_eq!(found["components"], 2, "{name}");
        assert!((number(&found["cloud"]["layers_mm"]) - 1.5).abs() < 0.02, "{name}");
        assert!((number(&found["cloud"]["noise_mm"]) - 0.03).abs() < 0.003, "{name}");
    }
}

#[test]
fn ends_of_pipes_lie_on_their_rims() {
    let Some(scan) = case("shell-pipe-open-ends.ply") else { return };
    let folder = tempfile::tempdir().unwrap();
    report(folder.path(), &scan, &[]);
    let found = checked(&folder.path().join("out.step"), &scan);
    let [low, high] = [0, 1].map(|k| number(&found["cad"]["bounds_mm"][k][2]));
    // The aim is 0.06 mm. It was up to 0.49 mm, then 0.21 mm.
    assert!(low.abs() < 0.2 && (high - 100.0).abs() < 0.2, "{low} to {high}");
}

#[test]
fn a_tolerance_that_is_said_to_be_met_is_met() {
    let Some(scan) = case("shell-tolerance-radial.ply") else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.step");
    let converted = convert(&[arg(&scan), arg(&out), "--tolerance", "0.12"]);
    match converted.status.code() {
        Some(3) => {}
        Some(0) => {
            let checked = check(&[arg(&out), arg(&scan), "--tolerance", "0.12"]);
            assert_eq!(
                checked.status.code(),
                Some(0),
                "{}",
                String::from_utf8_lossy(&checked.stderr)
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn terraces_are_smoothed() {
    let Some(scan) = case("terraces-1mm.ply.gz") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (report, said) = report(folder.path(), &scan, &[]);
    assert!(said.contains("in steps of 1.000 mm"), "{said}");
    assert!(number(&report["noise_mm"]) >= 1.0 / 12f64.sqrt());
    let [m, n] = [0, 1].map(|k| number(&report["fit"]["net"][k]));
    assert!(m * n < 200.0, "{m} x {n}");
}

#[test]
fn attacks_end_soon() {
    let Some(scan) = case("attack/remesh_unbounded.glb") else { return };
    assert_eq!(inspect(&[arg(&scan)]).status.code(), Some(1));
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(convert(&[arg(&scan), arg(&folder.path().join("out.step"))]).status.code(), Some(1));
    assert_eq!(files(folder.path()).len(), 0);
}
