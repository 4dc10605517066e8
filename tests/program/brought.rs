//! What people bring: files of other kinds, places and names than a converter expects. None of them goes wrong in
//! silence.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::random::Random;
use crate::common::{
    arg, check, checked, convert, converted, files, fixture, inspect, inspected, json, number,
    shared,
};
use serde_json::Value;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

/// The points of a wavy sheet of 40 × 30, each with its place in the raster.
fn sheet() -> impl Iterator<Item = ([usize; 2], [f64; 3])> {
    (0..1200).map(|n| {
        let [i, j] = [n / 40, n % 40];
        let (x, y) = (j as f64, i as f64);
        ([i, j], [x, y, 40.0 + 2.0 * (0.2 * x).sin() * (0.15 * y).cos()])
    })
}

/// The same sheet as OBJ, with a comment before it, and moved.
fn obj(comment: &str, by: [f64; 3]) -> String {
    let mut text = format!("# {comment}\n");
    sheet().for_each(|(_, [x, y, z])| {
        text += &format!("v {:.3} {:.3} {:.6}\n", x + by[0], y + by[1], z + by[2]);
    });
    for (i, j) in (0..29).flat_map(|i| (0..39).map(move |j| (i, j))) {
        let a = 40 * i + j + 1;
        text += &format!("f {a} {} {} {}\n", a + 1, a + 41, a + 40);
    }
    text
}

/// The extents of a scan in its longest direction, and across it.
fn extents(found: &Value) -> [f64; 2] {
    let corner = |k: usize, axis: usize| found["bounds_mm"][k][axis].as_f64().expect("a bound");
    [0, 1].map(|axis| corner(1, axis) - corner(0, axis))
}

#[track_caller]
fn is_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 0.01 * expected, "{found}, not {expected}");
}

#[test]
fn numbers_of_points_are_skipped_and_said() {
    let folder = folder();
    let line =
        |(n, (_, [x, y, z])): (usize, ([usize; 2], [f64; 3]))| format!("{} {x} {y} {z}\n", n + 1);
    let scan = write(folder.path(), "scan.txt", sheet().enumerate().map(line).collect::<String>());
    let mut scans = vec![scan];
    scans.extend(shared("cases/text-id-first.txt"));
    for scan in scans {
        let found = inspected(&scan);
        assert!(extents(&found)[0] < 130.0, "{found}");
        let said = String::from_utf8(inspect(&[arg(&scan)]).stdout).expect("text");
        assert!(said.contains("the first column numbers the points"), "{said}");
    }
    let scan = write(
        folder.path(),
        "odd.txt",
        sheet().map(|(_, [x, y, z])| format!("{z} 7 {x} {y}\n")).collect::<String>(),
    );
    let output = inspect(&[arg(&scan), "--columns", "3,4,1", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    is_near(extents(&found)[0], 39.0);
}

#[test]
fn a_raster_of_heights_is_a_grid() {
    let folder = folder();
    let heights: String = sheet().map(|(_, [_, _, z])| format!("{z:.3} ")).collect();
    let head =
        "ncols 40\nnrows 30\nxllcorner 500000\nyllcorner 4600000\ncellsize 1\nNODATA_value -9999\n";
    let scan = write(folder.path(), "dem.asc", format!("{head}{heights}\n"));
    let found = inspected(&scan);
    assert_eq!(found["cloud"]["scans"][0]["grid"], serde_json::json!([30, 40]));
    assert_eq!((&found["mesher"], &found["points"]), (&"grid".into(), &1200.into()));
    is_near(extents(&found)[0], 39.0);
    if let Some(scan) = shared("cases/text-i2_dem200.asc.gz") {
        let found = inspected(&scan);
        assert_eq!(found["cloud"]["scans"][0]["grid"], serde_json::json!([200, 200]));
        is_near(extents(&found)[0], 99.5);
    }
}

#[test]
fn a_comment_names_the_unit() {
    let folder = folder();
    let made = write(folder.path(), "scan.obj", obj("Units: inches", [0.0; 3]));
    for scan in std::iter::once(made).chain(shared("cases/unit-comment-inches.obj")) {
        let found = inspected(&scan);
        assert_eq!((&found["units"], &found["units_assumed"]), (&"in".into(), &false.into()));
        let said = String::from_utf8(inspect(&[arg(&scan)]).stdout).expect("text");
        assert!(said.contains("the unit is that of the comment"), "{said}");
        let output = inspect(&[arg(&scan), "--units", "mm", "--json"]);
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(found["units"], "mm");
    }
}

#[test]
fn a_far_mesh_is_measured_from_a_round_origin() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let far = write(folder.path(), "far.obj", obj("", [500_123_000.0, 4_612_345_000.0, 0.0]));
    let near = write(folder.path(), "near.obj", obj("", [3000.0, 5000.0, 0.0]));
    let (step, report) = (at("far.step"), at("far.json"));
    let said = converted(&[arg(&far), arg(&step), "--report", arg(&report)]);
    assert!(said.contains("coordinates are measured from (500123000, 4612345000, 0) mm"), "{said}");
    assert_eq!(
        json(&report)["input"]["origin_mm"],
        serde_json::json!([500_123_000.0, 4_612_345_000.0, 0.0])
    );
    let deviation = |found: &Value| found["scan_to_face"]["max_mm"].as_f64().expect("a length");
    assert!(deviation(&checked(&step, &far)) < 0.05);
    let kept = at("kept.step");
    converted(&[arg(&far), arg(&kept), "--origin", "keep"]);
    let output = check(&[arg(&kept), arg(&far), "--origin", "keep", "--json"]);
    assert!(deviation(&serde_json::from_slice(&output.stdout).expect("JSON")) < 0.05);
    // No other mesh is moved.
    assert!(inspected(&near).get("origin_mm").is_none());
    if let Some(scan) = shared("cases/far-mesh-utm.obj") {
        let output = inspect(&[arg(&scan), "--units", "m", "--json"]);
        let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(
            found["origin_mm"],
            serde_json::json!([500_120_000.0, 4_612_350_000.0, 90_000.0])
        );
    }
}

#[test]
fn compressed_splats_are_named() {
    let Some(splat) = shared("cases/splat-packed.ply") else { return };
    let said = String::from_utf8(inspect(&[arg(&splat)]).stderr).expect("text");
    assert!(said.contains("compressed Gaussian splat") && said.contains("SuperSplat"), "{said}");
}

/// Whether text has a character that controls a terminal.
fn controls(text: &[u8]) -> bool {
    String::from_utf8_lossy(text).chars().any(|c| c.is_control() && c != '\n')
}

#[cfg(unix)]
#[test]
fn names_control_no_terminal_and_no_page() {
    let folder = folder();
    let name = "a\u{1b}[31m\u{7}\nerror: \u{9b}b";
    let scan = write(folder.path(), &format!("{name}.obj"), obj("", [0.0; 3]));
    let at = |name: &str| folder.path().join(name);
    let (step, page) = (at("a.step"), at("a.html"));
    let output = convert(&[arg(&scan), arg(&step), "--report", arg(&page)]);
    assert!(output.status.success() && !controls(&output.stderr));
    assert!(!controls(&std::fs::read(&page).expect("a page")));
    for more in [&[][..], &["--json"]] {
        let output = inspect(&[&[arg(&scan)], more].concat());
        assert!(output.status.success() && !controls(&output.stdout));
    }
    let text = std::fs::read_to_string(&step).expect("the file");
    let planted = at("planted.step");
    let named = text.replacen("=PRODUCT('", "=PRODUCT('\u{1b}]0;owned\u{7}", 1);
    assert_ne!(named, text);
    std::fs::write(&planted, named).expect("a file");
    let output = check(&[arg(&planted), arg(&scan)]);
    assert!(output.status.success() && !controls(&output.stdout));
    if let Some(scan) = shared("cases/attack/control_in_message.e57") {
        assert!(!controls(&inspect(&[arg(&scan)]).stderr));
    }
}

#[cfg(unix)]
#[test]
fn a_device_is_no_cad_file_and_no_scan() {
    let scan = fixture("relief.ply");
    for output in [
        check(&["/dev/zero", arg(&scan)]),
        inspect(&["/dev/zero"]),
        check(&[arg(&scan), "/dev/zero"]),
    ] {
        assert_eq!(output.status.code(), Some(1));
    }
    let output = check(&["/", arg(&scan)]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("is a folder"));
}

#[cfg(unix)]
#[test]
fn no_output_replaces_the_scan_under_another_name() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let scan = at("1-mesh.ply");
    std::fs::copy(fixture("relief.ply"), &scan).expect("a copy");
    std::fs::hard_link(&scan, at("hard.json")).expect("a link");
    std::os::unix::fs::symlink(&scan, at("soft.step")).expect("a link");
    let before = std::fs::read(&scan).expect("the scan");
    for more in [
        &["--stages", arg(folder.path())][..],
        &["--report", arg(&at("hard.json"))],
        &[arg(&at("soft.step"))],
    ] {
        let output = convert(&[&[arg(&scan)], more].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(1) && said.contains("no output may replace"),
            "{said}"
        );
    }
    assert!(std::fs::read(&scan).expect("the scan") == before);
    assert_eq!(files(folder.path()), ["1-mesh.ply", "hard.json", "soft.step"]);
}

#[test]
fn an_apostrophe_is_escaped_as_a_number() {
    let folder = folder();
    let scan = write(folder.path(), "a');b.obj", obj("", [0.0; 3]));
    let step = folder.path().join("a.step");
    converted(&[arg(&scan), arg(&step)]);
    let text = std::fs::read_to_string(&step).expect("the file");
    assert!(text.contains(r"PRODUCT('a\X\27);b'"), "no escape");
    assert_eq!(checked(&step, &scan)["cad"]["name"], "a');b");
}

#[test]
fn a_table_holds_no_formula() {
    let folder = folder();
    for name in ["=1+1.obj", "+a.obj", "-b.obj", "@c.obj"] {
        write(folder.path(), name, "v 0 0 0\n");
    }
    let mut batch = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    batch.args(["batch", "=1+1.obj", "+a.obj", "./-b.obj", "@c.obj", "--out", "out"]);
    batch.current_dir(folder.path()).output().expect("the program runs");
    let mut table = csv(&folder.path().join("out/summary.csv"));
    table.remove(0);
    assert_eq!(table.len(), 4);
    assert!(table.iter().all(|line| !line.starts_with(['=', '+', '-', '@'])), "{table:?}");
}

fn csv(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).expect("a table");
    text.lines().map(str::to_owned).collect()
}

#[test]
fn attacks_end() {
    let Some(attack) = shared("cases/attack") else { return };
    let at = |name: &str| attack.join(name);
    for name in ["remesh_unbounded.glb", "slow_inspect.stl", "fan.obj.gz"] {
        assert!(inspect(&[arg(&at(name))]).status.code().is_some(), "{name}");
    }
    let output = inspect(&[arg(&at("remesh_unbounded.glb"))]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("a few points are so far away"));
    let small = at("small.obj");
    for name in ["trimmed_copies.step", "quadratic_items.step"] {
        assert!(check(&[arg(&at(name)), arg(&small)]).status.code().is_some(), "{name}");
    }
    let folder = folder();
    let step = folder.path().join("fan.step");
    converted(&[arg(&at("fan.obj.gz")), arg(&step)]);
}

/// A hilly sheet of 120 × 90, its heights rounded to a step.
fn hills(step: f64) -> String {
    let mut text = String::new();
    for (i, j) in (0..90).flat_map(|i| (0..120).map(move |j| (i, j))) {
        let (x, y) = (j as f64, i as f64);
        let z = 8.0 * (0.05 * x).sin() * (0.04 * y).cos() + 0.1 * y;
        let z = if step > 0.0 { step * (z / step).round() } else { z };
        text += &format!("v {x} {y} {z}\n");
    }
    for (i, j) in (0..89).flat_map(|i| (0..119).map(move |j| (i, j))) {
        let a = 120 * i + j + 1;
        text += &format!("f {a} {} {} {}\n", a + 1, a + 121, a + 120);
    }
    text
}

#[test]
fn heights_in_steps_are_noise_and_no_facets() {
    let folder = folder();
    let truth = write(folder.path(), "truth.obj", hills(0.0));
    for (step, decimals) in [(1.0, "1.000 mm"), (0.25, "0.2500 mm")] {
        let scan = write(folder.path(), "scan.obj", hills(step));
        let out = folder.path().join("out.step");
        let report = folder.path().join("out.json");
        let said = converted(&[arg(&scan), arg(&out), "--report", arg(&report)]);
        assert!(said.contains(&format!("in steps of {decimals}")), "{said}");
        let report = json(&report);
        assert!(
            report["noise_mm"].as_f64().unwrap() >= step / 12f64.sqrt(),
            "{}",
            report["noise_mm"]
        );
        let off = checked(&out, &truth);
        assert!(off["face_to_scan"]["rms_mm"].as_f64().unwrap() < 0.05 * step, "{off}");
        std::fs::remove_file(&out).unwrap();
    }
}

/// A turned part of cones only, without a wall along its axis: rings of 32 vertices at heights in whole millimetres.
fn turned() -> String {
    let rings = [(0.0, 12.0), (1.0, 12.5), (2.0, 8.0), (3.0, 6.0), (4.0, 5.5), (6.0, 2.0)];
    let mut text = String::from("v 0 0 0\nv 0 0 6\n");
    for (z, r) in rings {
        for k in 0..32 {
            let at = f64::from(k) * std::f64::consts::TAU / 32.0;
            text += &format!("v {:.12} {:.12} {z}\n", r * at.cos(), r * at.sin());
        }
    }
    let v = |ring: usize, k: usize| 3 + 32 * ring + k % 32;
    for k in 0..32 {
        text += &format!("f 1 {} {}\nf 2 {} {}\n", v(0, k + 1), v(0, k), v(5, k), v(5, k + 1));
        for ring in 0..5 {
            let [a, b, c, d] = [v(ring, k), v(ring, k + 1), v(ring + 1, k + 1), v(ring + 1, k)];
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    text
}

#[test]
fn designed_heights_in_steps_stay_exact() {
    let folder = folder();
    let scan = write(folder.path(), "turned.obj", turned());
    let said = converted(&[arg(&scan), arg(&folder.path().join("out.step"))]);
    assert!(said.contains("2 planes and 5 cones"), "{said}");
}

/// Points on both sides of a curved plate of 60 × 40, with the normals of the sides if they are asked for.
fn plate(thickness: f64, has_normals: bool) -> String {
    let mut random = Random(7);
    let mut random = || random.share();
    let mut text = String::new();
    for n in 0..4800 {
        let [x, y] = [60.0 * random(), 40.0 * random()];
        let side = if n % 2 == 0 { 1.0 } else { -1.0 };
        // Three of these have about the spread of a normal error.
        let noise = 0.03 * ((0..3).map(|_| random()).sum::<f64>() - 1.5) * 2.0;
        let (slope, height) = (0.2 * (0.1 * x).cos(), 2.0 * (0.1 * x).sin());
        let long = f64::hypot(1.0, slope);
        let normal = [-slope / long, 0.0, 1.0 / long];
        let off = side * 0.5 * thickness + noise;
        let [a, c] = [x + off * normal[0], height + off * normal[2]];
        text += &format!("{a:.4} {y:.4} {c:.4}");
        if has_normals {
            text += &format!(" {:.4} 0 {:.4}", side * normal[0], side * normal[2]);
        }
        text += "\n";
    }
    text
}

#[test]
fn the_sides_of_a_plate_are_not_joined() {
    let folder = folder();
    for (thickness, has_normals) in [(1.5, false), (1.5, true), (0.5, false)] {
        let scan = write(folder.path(), "plate.xyz", plate(thickness, has_normals));
        let found = inspected(&scan);
        let layers = found["cloud"]["layers_mm"].as_f64().expect("two layers");
        assert!((layers - thickness).abs() < 0.05 * thickness, "{layers}");
        let noise = found["cloud"]["noise_mm"].as_f64().unwrap();
        assert!((0.02..0.04).contains(&noise), "{noise}");
        assert_eq!(found["components"], 2);
        std::fs::remove_file(&scan).unwrap();
    }
    let out = folder.path().join("out.step");
    let scan = write(folder.path(), "plate.xyz", plate(0.8, false));
    let said = converted(&[arg(&scan), arg(&out)]);
    assert!(said.contains("they are not joined"), "{said}");
    assert!(said.contains("not joined, as layers of points are not; --component all"), "{said}");
    assert!(!said.contains("--remesh") && !said.contains("--weld"), "{said}");
    let one = plate(0.0, false);
    assert!(inspected(&write(folder.path(), "one.xyz", one))["cloud"]["layers_mm"].is_null());
}

#[test]
fn sheets_that_overlap_are_named_and_become_one() {
    let folder = folder();
    // The second sheet goes on from the last rows of the first, its points between theirs.
    let mut text = String::new();
    let sheet = |text: &mut String, from: f64, first: usize| {
        for (i, j) in (0..30).flat_map(|i| (0..40).map(move |j| (i, j))) {
            let (x, y) = (from + f64::from(i), f64::from(j) + from / 100.0);
            *text += &format!("v {x} {y} {:.5}\n", 3.0 * (0.1 * x).sin() * (0.08 * y).cos());
        }
        for (i, j) in (0..29).flat_map(|i| (0..39).map(move |j| (i, j))) {
            let a = first + 40 * i + j;
            *text += &format!("f {a} {} {} {}\n", a + 40, a + 41, a + 1);
        }
    };
    sheet(&mut text, 0.0, 1);
    sheet(&mut text, 25.5, 1201);
    let scan = write(folder.path(), "overlap.obj", text);
    let out = folder.path().join("out.step");
    let said = converted(&[arg(&scan), arg(&out), "--surfaces", "spline"]);
    assert!(said.contains("component 1 touches or overlaps this one and is not joined"), "{said}");
    std::fs::remove_file(&out).unwrap();
    let report = folder.path().join("out.json");
    converted(&[arg(&scan), arg(&out), "--remesh", "--report", arg(&report)]);
    let report = json(&report);
    assert_eq!(report["input"]["components"], 1);
    assert!(report["shape"]["kind"] == "face", "{}", report["shape"]);
}

/// A pipe along z from 0 to 80 with a radius of 22, open at both ends, with normal noise of 0.03.
fn noisy_pipe(seed: u64) -> String {
    const AROUND: usize = 100;
    const ALONG: usize = 60;
    let mut random = Random(seed);
    let mut noise = || 0.03 * ((0..12).map(|_| random.share()).sum::<f64>() - 6.0);
    let mut text = String::new();
    for n in 0..AROUND * ALONG {
        let angle = TAU * (n % AROUND) as f64 / AROUND as f64;
        let z = 80.0 * (n / AROUND) as f64 / (ALONG - 1) as f64;
        let p = [22.0 * angle.cos() + noise(), 22.0 * angle.sin() + noise(), z + noise()];
        text += &format!("v {:.5} {:.5} {:.5}\n", p[0], p[1], p[2]);
    }
    for n in 0..AROUND * (ALONG - 1) {
        let next = n - n % AROUND + (n + 1) % AROUND;
        let [a, b, c, d] = [n, next, next + AROUND, n + AROUND].map(|v| v + 1);
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}

/// The borders of faces near a rim are bent where the net turns around the rim, and so is a straight line between parameter points.
#[test]
fn ends_of_noisy_pipes_lie_on_their_rims() {
    let folder = folder();
    let out = folder.path().join("out.step");
    let scan = write(folder.path(), "pipe.obj", noisy_pipe(2));
    converted(&[arg(&scan), arg(&out)]);
    let found = checked(&out, &scan);
    let [low, high] = [0, 1].map(|k| number(&found, &format!("/cad/bounds_mm/{k}/2")));
    // It was up to 0.23 mm.
    assert!(low.abs() < 0.15 && (high - 80.0).abs() < 0.15, "{low} to {high}");
}
