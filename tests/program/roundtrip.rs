//! The round trip: written files are imported by OpenCASCADE and FreeCAD.

use crate::common::importers::{freecad, opencascade, rewrite_freecad, rewrite_opencascade};
use crate::common::virtual_scan::{
    Star, VirtualScan, island_scan, paper_scan, ragged_scan, relief, relief_scan, rolled_scan,
};
use crate::common::{arg, checked, converted, fixture, json, number};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The expected properties of a scan's CAD face.
struct Expected<'a> {
    scan: &'a VirtualScan,
    /// The largest rms distance of true points from the imported face, in mm.
    rms: f64,
    /// The allowed excess of its bounding box, as a share of the part's size. Importers use the box
    /// of the surface between the extreme parameters of the loop.
    larger: f64,
}

/// Converts `input` to STEP and to both forms of IGES, and checks each file.
fn round_trip(input: &Path, options: &[&str], expected: &Expected) -> Value {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str| folder.path().join(name);
    let (step, trimmed, shell, report) =
        (file("part.step"), file("part.igs"), file("shell.igs"), file("report.json"));
    let mut args = vec![arg(input), arg(&step), arg(&trimmed), "--report", arg(&report)];
    args.extend(options);
    converted(&args);
    args.splice(1..5, [arg(&shell), "--iges", "brep"]);
    converted(&args);
    let report = json(&report);
    let area = true_area(expected.scan, &report);
    let outputs = [(step, true), (trimmed, false), (shell, true)];
    for (path, valid_unhealed) in &outputs {
        check_opencascade(path, *valid_unhealed, area, expected);
        check_freecad(path, area, expected);
    }
    report
}

/// The true area of the converted part in mm². Triangles that are attached by one side or one
/// vertex are excluded.
fn true_area(scan: &VirtualScan, report: &Value) -> f64 {
    let dropped = |kind: &str| report["input"]["repairs"][kind].as_f64().unwrap_or(0.0);
    let gone = dropped("rim_triangles_trimmed") + dropped("faces_dropped_at_bow_ties");
    scan.true_area() * (1.0 - gone / scan.triangles.len() as f64)
}

fn check_opencascade(path: &Path, valid_unhealed: bool, area: f64, expected: &Expected) {
    let truth = expected.scan.true_points(40);
    let found = opencascade(path, Some(&truth));
    let is = |key: &str, value: Value| assert_eq!(found[key], value, "{key} in {found}");
    let (faces, inner) = expected.scan.faces_and_inner_loops();
    is("roots", 1.into());
    is("file_faults", Value::Array(Vec::new()));
    is("faces", faces.into());
    is("wires_inner", inner.into());
    is("valid", true.into());
    // Healing assembles a 144. Without it none is valid.
    is("valid_unhealed", valid_unhealed.into());
    is("argument_check", true.into());
    is("oriented_loops", true.into());
    is("surface_type", "Geom_BSplineSurface".into());
    assert_eq!(found["pcurves_kept"][0], found["pcurves_kept"][1], "{found}");
    assert!(number(&found, "/max_tolerance_edge") <= 1e-6, "{found}");
    assert!(number(&found, "/max_tolerance_vertex") <= 1e-6, "{found}");
    assert!(number(&found, "/distance/rms") <= expected.rms, "{found}");
    check_size(&found, expected, (area, 0.002));
}

fn check_freecad(path: &Path, area: f64, expected: &Expected) {
    let Some(found) = freecad(path) else { return };
    let is = |key: &str, value: Value| assert_eq!(found[key], value, "{key} in {found}");
    let (faces, inner) = expected.scan.faces_and_inner_loops();
    is("faces", faces.into());
    is("wires_inner", inner.into());
    is("valid", true.into());
    is("check", Value::Null);
    // Typical next steps of users: cut the face with a box, offset it, extrude it.
    is("boolean_ok", true.into());
    is("offset_ok", true.into());
    is("extrude_ok", true.into());
    // The volume comes from a tessellation.
    check_size(&found, expected, (area, 0.01));
}

/// Compares the area, within a relative error, and the bounding box in mm with the truth.
fn check_size(found: &Value, expected: &Expected, (area, share): (f64, f64)) {
    let ratio = number(found, "/area") / area;
    assert!((ratio - 1.0).abs() < share, "{ratio} of the true area, {area} mm²");
    for axis in 0..3 {
        let truth = expected.scan.uv.iter().map(|&[u, v]| (expected.scan.truth)(u, v)[axis]);
        let low = truth.clone().fold(f64::INFINITY, f64::min);
        let high = truth.fold(f64::NEG_INFINITY, f64::max);
        let slack = expected.larger * (high - low) + 0.5;
        let found = [axis, axis + 3].map(|i| number(found, &format!("/bbox/{i}")));
        let off = (found[0] - low).abs().max((found[1] - high).abs());
        assert!(off < slack, "axis {axis}: {found:?} instead of {:?}", [low, high]);
    }
}

#[test]
fn the_relief_and_its_two_holes() {
    let scan = relief_scan();
    let report =
        round_trip(&fixture("relief.ply"), &[], &Expected { scan: &scan, rms: 0.06, larger: 0.01 });
    assert_eq!(report["trim"].as_array().map(Vec::len), Some(3));
}

#[test]
fn the_rolled_sheet_that_overhangs() {
    let scan = rolled_scan();
    round_trip(
        &fixture("rolled_sheet.obj"),
        &[],
        &Expected { scan: &scan, rms: 0.03, larger: 0.01 },
    );
}

#[test]
fn an_island_and_the_hole_in_it() {
    let scan = island_scan();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = written(&scan, folder.path());
    let report = round_trip(&input, &[], &Expected { scan: &scan, rms: 0.06, larger: 0.01 });
    let outer: Vec<bool> = (0..4).map(|i| report["trim"][i]["outer"] == true).collect();
    assert_eq!(outer, [true, false, true, false]);
}

#[test]
fn the_relief_cut_along_its_outer_boundary() {
    let expected = Expected { scan: &relief_scan(), rms: 0.06, larger: 0.01 };
    let report = round_trip(&fixture("relief.ply"), &["--outline", "trimmed"], &expected);
    let trim = report["trim"].as_array().expect("a list");
    let outer: Vec<bool> = trim.iter().map(|l| l["outer"] == true).collect();
    assert_eq!(outer, [true, false, false]);
    assert_eq!(trim[0]["hole"], Value::Null);
    let rim = number(&report, "/rim_tolerance_mm");
    for ring in trim {
        assert!(number(ring, "/max_from_rim_mm") <= rim, "{ring}");
        let off = number(ring, "/max_off_surface_mm");
        assert!(off > 0.0 && off < 1e-7, "{ring}");
    }
}

#[test]
fn an_island_within_an_outer_loop() {
    let scan = island_scan();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = written(&scan, folder.path());
    let options = ["--outline", "trimmed"];
    let report = round_trip(&input, &options, &Expected { scan: &scan, rms: 0.06, larger: 0.01 });
    let outer: Vec<bool> = (0..4).map(|i| report["trim"][i]["outer"] == true).collect();
    assert_eq!(outer, [true, false, true, false]);
}

#[test]
fn a_ragged_outer_boundary_is_cut_along() {
    let scan = ragged_scan();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = written(&scan, folder.path());
    let options = ["--outline", "trimmed"];
    round_trip(&input, &options, &Expected { scan: &scan, rms: 0.03, larger: 0.05 });
}

/// The results of the paper: about 8,100 noisy points, one hole, a rough boundary, a net of 13 ×
/// 13, and blended local fits.
#[test]
fn the_papers_run() {
    let scan = paper_scan();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = written(&scan, folder.path());
    let options = ["--net", "13x13", "--fit", "blend"];
    let report = round_trip(&input, &options, &Expected { scan: &scan, rms: 0.12, larger: 0.01 });
    assert_eq!(report["fit"]["net"], serde_json::json!([13, 13]));
    assert_eq!(report["fit"]["method"], "blend");
}

/// A scan in its own file.
fn written(scan: &VirtualScan, folder: &Path) -> PathBuf {
    let input = folder.join("scan.ply");
    let mut file = std::fs::File::create(&input).expect("a temporary file");
    scan.write_ply(&mut file).expect("a temporary file");
    input
}

/// The distance by which FreeCAD moves faces, in mm.
const MOVED: f64 = 0.5;

/// The way from a scan through our files, OpenCASCADE and FreeCAD and their STEP and IGES files
/// back to us. The result must be what was written, with the operations that were asked for.
fn there_and_back(scan: &VirtualScan, rms: f64) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str| folder.path().join(name);
    let input = written(scan, folder.path());
    let report = round_trip(&input, &[], &Expected { scan, rms, larger: 0.01 });
    let step = file("part.step");
    converted(&[arg(&input), arg(&step), "--quiet"]);
    let ours = checked(&step, &input);
    let ratio = number(&ours, "/cad/area_mm2") / true_area(scan, &report);
    assert!((ratio - 1.0).abs() < 0.002, "{ratio} of the true area");

    rewrite_opencascade(&step, folder.path());
    for name in ["occ.step", "occ-inch.step", "occ-plain.step", "occ144.igs", "occ514.igs"] {
        check_same(&ours, &checked(&file(name), &input), name);
    }
    let Some(areas) = rewrite_freecad(&step, folder.path(), MOVED) else { return };
    let both =
        |name: &str| ["step", "igs"].map(|end| checked(&file(&format!("{name}.{end}")), &input));
    for plain in both("fc-plain") {
        check_same(&ours, &plain, "fc-plain");
    }
    for cut in both("fc-cut") {
        let share = number(&cut, "/cad/area_mm2") / number(&ours, "/cad/area_mm2");
        assert!((0.2..0.8).contains(&share), "{share} of the face is left");
        let off = |found| number(found, "/face_to_scan/max_mm");
        assert!(off(&cut) <= off(&ours) + 0.01, "{cut}");
        assert!(number(&cut, "/scan_to_face/max_mm") > 5.0, "{cut}");
    }
    for moved in both("fc-offset") {
        let away = number(&moved, "/scan_to_face/rms_mm");
        let noise = number(&ours, "/scan_to_face/rms_mm");
        assert!((away - MOVED.hypot(noise)).abs() < 0.05 * MOVED, "{moved}");
    }
    for thick in both("fc-thick") {
        assert!(number(&thick, "/cad/faces") > 2.0);
        // Both sheets, and the walls.
        assert!(number(&thick, "/cad/area_mm2") > 2.0 * number(&areas, "/fc-plain") * 0.99);
        let off = |found| number(found, "/scan_to_face/rms_mm");
        assert!(off(&thick) <= 1.02 * off(&ours), "{thick}");
    }
}

/// Whether the file of another program has the face that it read.
fn check_same(ours: &Value, theirs: &Value, name: &str) {
    for key in ["/cad/faces", "/cad/loops"] {
        assert_eq!(number(ours, key), number(theirs, key), "{name}: {key}");
    }
    for key in ["/cad/area_mm2", "/scan_to_face/rms_mm", "/face_to_scan/rms_mm"] {
        let (here, there) = (number(ours, key), number(theirs, key));
        assert!((here - there).abs() < 1e-4 * here, "{name}: {key}: {here} became {there}");
    }
}

fn star(centre: [f64; 2], radius: f64) -> Star {
    Star { centre, radius, arms: 3.0 }
}

#[test]
fn a_face_without_a_hole_there_and_back() {
    there_and_back(&VirtualScan::new(relief, [60, 50], 0.03, vec![], 11), 0.03);
}

#[test]
fn a_face_with_a_hole_there_and_back() {
    let hole = star([0.55, 0.45], 0.12);
    there_and_back(&VirtualScan::new(relief, [70, 60], 0.03, vec![hole], 12), 0.04);
}

#[test]
fn a_face_with_twenty_holes_there_and_back() {
    let centre = |i: usize, n: usize| (i as f64 + 0.75) / (n as f64 + 0.5);
    let holes = (0..20).map(|k| star([centre(k % 5, 5), centre(k / 5, 4)], 0.045));
    let scan = VirtualScan::new(relief, [110, 90], 0.03, holes.collect(), 13);
    there_and_back(&scan, 0.04);
}

#[test]
fn a_hole_next_to_the_boundary_there_and_back() {
    let scan = VirtualScan::new(relief, [70, 60], 0.03, vec![star([0.115, 0.5], 0.075)], 14);
    there_and_back(&scan, 0.05);
}

#[test]
fn a_rolled_sheet_there_and_back() {
    there_and_back(&rolled_scan(), 0.03);
}

/// The checks above can fail: they notice a hole of the scan that the face does not have.
#[test]
fn a_filled_hole_is_noticed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let step = folder.path().join("filled.step");
    converted(&[arg(&fixture("relief.ply")), arg(&step), "--keep-fills"]);
    assert_eq!(opencascade(&step, None)["wires_inner"], 0);
    assert!(freecad(&step).is_none_or(|found| found["wires_inner"] == 0));
}
