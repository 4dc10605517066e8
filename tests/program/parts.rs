//! The meshes of CAD programs become solids of the faces that the programs had.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;

use crate::common::importers::{freecad_solid, opencascade_solid};
use crate::common::random::Random;
use crate::common::{
    arg, check, checked, convert, converted, fixture, inspect, inspected, json, number, shared,
    unpacked,
};
use scan2step::Options;
use scan2step::formats::Soup;
use serde_json::{Value, json};

/// The sides of a cube whose corners are numbered by their coordinates.
const SIDES: [[u32; 4]; 6] =
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

/// The triangles of a cube between two corners, as ASCII STL. `turned` makes it face inwards.
fn cube(low: f64, high: f64, turned: bool, noise: f64) -> String {
    let mut random = Random(11);
    let mut corners = Vec::new();
    for k in 0..8 {
        let exact = [4, 2, 1].map(|bit| if k & bit == 0 { low } else { high });
        corners.push(exact.map(|x| x + noise * (random.share() - 0.5)));
    }
    let mut text = String::new();
    for [a, b, c, d] in SIDES.map(|side| side.map(|k| k as usize)) {
        for [p, q, r] in [[a, b, c], [a, c, d]] {
            let [q, r] = if turned { [r, q] } else { [q, r] };
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in [p, q, r].map(|k: usize| corners[k]) {
                writeln!(text, "vertex {x} {y} {z}").expect("text");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text
}

fn write_stl(path: &Path, cubes: &[String]) {
    std::fs::write(path, format!("solid cubes\n{}endsolid cubes\n", cubes.concat()))
        .expect("a file");
}

/// Converts a scan and returns its messages and its report, whose schema is checked.
fn made(scan: &Path, step: &Path, options: &[&str]) -> (String, Value) {
    let report = step.with_extension("json");
    let files = [arg(scan), arg(step), "--report", arg(&report)];
    let said = converted(&[&files[..], options].concat());
    let report = json(&report);
    crate::common::assert_schema(&report);
    (said, report)
}

/// The number of faces of each kind that there are.
fn kinds(report: &Value) -> Value {
    let all = report["shape"]["surfaces"].as_object().expect("an object").clone();
    all.into_iter().filter(|(_, count)| *count != 0).collect::<serde_json::Map<_, _>>().into()
}

#[test]
fn a_cube_comes_back_as_a_cube() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["cube.stl", "cube.step"].map(|name| folder.path().join(name));
    write_stl(&scan, &[cube(0.0, 20.0, false, 0.0)]);
    let (said, report) = made(&scan, &step, &[]);
    assert!(said.contains("a solid of 6 faces, 8000 mm³: 6 planes; exact within 0 mm"), "{said}");
    let shape = &report["shape"];
    assert_eq!(kinds(&report), json!({ "plane": 6 }));
    assert_eq!((&shape["edges"], &shape["vertices"]), (&12.into(), &8.into()));
    assert!((number(&report, "/shape/volume_mm3") / 8000.0 - 1.0).abs() < 1e-12);
    assert!(std::fs::metadata(&step).expect("a file").len() < 16_000);
    let found = opencascade_solid(&step);
    assert_eq!((&found["solids"], &found["valid"]), (&1.into(), &true.into()), "{found}");
    let back = checked(&step, &scan);
    assert!(number(&back, "/scan_to_face/max_mm") < 1e-9, "{back}");
    assert!(number(&back, "/face_to_scan/max_mm") < 1e-9, "{back}");

    let told = inspect(&[arg(&scan)]);
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert!(told.contains("a solid of 6 faces: 6 planes"), "{told}");
}

/// A block of 40 × 30 mm whose top is wavy, as ASCII STL with triangles of about 1.5 mm on the top and few elsewhere, and its volume. The vertices inside
/// of the top leave their rows by up to half of a share of their distance.
fn wavy_block(unevenness: f64) -> (String, f64) {
    let (nx, ny) = (26usize, 20usize);
    let height = |x: f64, y: f64| 10.0 + 1.5 * (0.16 * x).sin() * (0.14 * y + 0.3).cos();
    let mut random = Random(7);
    let mut off = |k: usize, n: usize| {
        let share = random.share() - 0.5;
        if 0 < k && k < n { k as f64 + unevenness * share } else { k as f64 }
    };
    let all = (0..=nx).flat_map(|i| (0..=ny).map(move |j| (i, j)));
    let places: Vec<[f64; 3]> = all
        .map(|(i, j)| {
            let (x, y) = (off(i, nx), off(j, ny));
            // The rim stays in its rows.
            let x = if j == 0 || j == ny { i as f64 } else { x };
            let y = if i == 0 || i == nx { j as f64 } else { y };
            let (x, y) = (40.0 * x / nx as f64, 30.0 * y / ny as f64);
            [x, y, height(x, y)]
        })
        .collect();
    let at = |i: usize, j: usize| places[i * (ny + 1) + j];
    let mut triangles: Vec<[[f64; 3]; 3]> = Vec::new();
    for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        let is_turned = unevenness > 0.0 && (i * 7 + j * 3) % 5 < 2;
        triangles.extend(if is_turned { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] });
    }
    let down = |p: [f64; 3]| [p[0], p[1], 0.0];
    let rim = (0..nx).map(|i| at(i, 0)).chain((0..ny).map(|j| at(nx, j)));
    let rim = rim.chain((1..=nx).rev().map(|i| at(i, ny))).chain((1..=ny).rev().map(|j| at(0, j)));
    let rim: Vec<[f64; 3]> = rim.collect();
    for k in 0..rim.len() {
        let (p, q) = (rim[k], rim[(k + 1) % rim.len()]);
        triangles.extend([[p, down(p), down(q)], [p, down(q), q]]);
        triangles.push([[20.0, 15.0, 0.0], down(q), down(p)]);
    }
    let mut text = String::new();
    for corners in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in corners {
            writeln!(text, "vertex {x:.6} {y:.6} {z:.6}").expect("text");
        }
        text += "endloop\nendfacet\n";
    }
    // The integral of the sine and the cosine, in closed form.
    let wave = 1.5 * (1.0 - (0.16f64 * 40.0).cos()) / 0.16
        * ((0.14f64 * 30.0 + 0.3).sin() - 0.3f64.sin())
        / 0.14;
    (text, 40.0 * 30.0 * 10.0 + wave)
}

#[test]
fn a_wavy_top_is_one_free_form_face_through_its_vertices() {
    let folder = tempfile::tempdir().expect("a folder");
    for unevenness in [0.0, 0.5] {
        let [scan, step] = ["wavy.stl", "wavy.step"].map(|name| folder.path().join(name));
        let (text, volume) = wavy_block(unevenness);
        write_stl(&scan, &[text]);
        let (said, report) = made(&scan, &step, &[]);
        assert_eq!(kinds(&report), json!({ "plane": 5, "spline": 1 }), "{said}");
        assert_eq!(report["exact"]["free_forms"], 1);
        let found = number(&report, "/shape/volume_mm3");
        // The triangles miss 7 mm³ of it.
        assert!((found - volume).abs() < 0.5, "{found} of {volume}");
        let faces = report["faces"].as_array().expect("faces");
        let top = faces.iter().find(|face| face["surface"] == "spline");
        let off = number(top.expect("a spline"), "/max_mm");
        assert!(off < 1e-3, "{off}");
        let found = opencascade_solid(&step);
        assert_eq!((&found["solids"], &found["valid"]), (&1.into(), &true.into()), "{found}");
        assert!((number(&found, "/volume") / volume - 1.0).abs() < 1e-4, "{found}");
    }
}

#[test]
fn options_of_splines_ask_for_splines() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["cube.stl", "cube.step"].map(|name| folder.path().join(name));
    write_stl(&scan, &[cube(0.0, 20.0, false, 0.0)]);
    let (_, report) = made(&scan, &step, &["--surfaces", "spline"]);
    assert_eq!(report["shape"]["surfaces"]["plane"], 0);
    let (said, report) = made(&scan, &step, &["--faces", "24"]);
    assert_eq!(report["shape"]["surfaces"]["plane"], 0);
    assert!(said.contains("--faces; without it, this is an exact solid of 6 faces"), "{said}");
}

#[test]
fn noise_is_no_exact_face() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["cube.stl", "cube.step"].map(|name| folder.path().join(name));
    write_stl(&scan, &[cube(0.0, 20.0, false, 0.05)]);
    let (_, report) = made(&scan, &step, &["--tolerance", "5"]);
    assert_eq!(report["shape"]["surfaces"]["plane"], 0, "{report}");
}

#[test]
fn every_closed_piece_is_a_solid_or_a_void() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["cubes.stl", "cubes.step"].map(|name| folder.path().join(name));
    let outer = cube(0.0, 20.0, false, 0.0);
    write_stl(&scan, &[outer.clone(), cube(5.0, 15.0, true, 0.0), cube(30.0, 34.0, false, 0.0)]);
    let (said, report) = made(&scan, &step, &[]);
    let of_shape = |kind: &str| {
        let bodies = report["components"].as_array().expect("a list");
        bodies.iter().filter(|body| body["shape"]["kind"] == kind).count()
    };
    assert_eq!((of_shape("solid"), of_shape("void")), (2, 1), "{said}");
    let found = opencascade_solid(&step);
    assert_eq!((&found["solids"], &found["valid"]), (&2.into(), &true.into()), "{found}");
    let volume = 8000.0 - 1000.0 + 64.0;
    assert!((number(&found, "/volume") / volume - 1.0).abs() < 1e-9, "{found}");
    // A piece that is named is the only one.
    let (said, report) = made(&scan, &step, &["--component", "2"]);
    assert_eq!(report["components"], Value::Null, "{said}");
    assert!((number(&report, "/shape/volume_mm3") - 64.0).abs() < 1e-9);
    assert!(said.contains("left out 24 triangles"), "{said}");
}

#[test]
fn shapes_that_are_named_hold() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["cube.stl", "cube.step"].map(|name| folder.path().join(name));
    write_stl(&scan, &[cube(0.0, 20.0, false, 0.0)]);
    let (_, report) = made(&scan, &step, &["--shape", "shell"]);
    assert_eq!(
        (&report["shape"]["kind"], &report["shape"]["solids"]),
        (&"shell".into(), &0.into())
    );
    assert_eq!(kinds(&report), json!({ "plane": 6 }));
    let output = convert(&[arg(&scan), arg(&step), "--shape", "face"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("closed, genus 0, no boundary"), "{said}");
}

#[test]
fn a_bracket_has_its_bores_and_fillets() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let step = folder.path().join("bracket.step");
    let [page, picture] = ["bracket.html", "bracket.png"].map(|name| folder.path().join(name));
    let reports = ["--report", arg(&page), "--report", arg(&picture), "--iges", "brep"];
    let iges = folder.path().join("bracket.igs");
    let (_, report) = made(&fixture("bracket.stl"), &step, &[&reports[..], &[arg(&iges)]].concat());
    let expected = json!({ "plane": 7, "cylinder": 5, "cone": 2, "torus": 1 });
    assert_eq!(kinds(&report), expected);
    let rows = report["exact"]["cylinders"].as_array().expect("a list").iter();
    let rows: Vec<(&str, f64)> = rows
        .map(|row| (row["kind"].as_str().expect("a word"), number(row, "/radius_mm")))
        .collect();
    let radii = [("round", 20.0), ("bore", 9.0), ("fillet", 8.0), ("bore", 2.75), ("bore", 2.75)];
    assert_eq!(rows.len(), radii.len());
    for ((kind, radius), (true_kind, true_radius)) in rows.into_iter().zip(radii) {
        assert_eq!(kind, true_kind);
        assert!((radius - true_radius).abs() < 1e-5, "{kind} of {radius}");
    }
    let volume = number(&report, "/shape/volume_mm3");
    for file in [&step, &iges] {
        let found = opencascade_solid(file);
        assert_eq!((&found["solids"], &found["valid"]), (&1.into(), &true.into()), "{found}");
        assert!((number(&found, "/volume") / volume - 1.0).abs() < 1e-6, "{found}");
    }
    assert!(freecad_solid(&step).is_none_or(|found| found["valid"] == true));
    let page = std::fs::read_to_string(page).expect("a page");
    assert!(page.contains("15 faces"));
    assert!(std::fs::metadata(picture).expect("a picture").len() > 10_000);
}

#[test]
fn check_takes_the_placement_of_an_aligned_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scan, step] = ["turned.obj", "turned.step"].map(|name| folder.path().join(name));
    // The bracket of the fixtures, standing on another side.
    let soup = scan2step::formats::read_scan(&fixture("bracket.stl")).expect("a mesh");
    let mut text = String::new();
    for [x, y, z] in &soup.points {
        writeln!(text, "v {} {} {}", z + 30.0, x - 7.0, y).expect("text");
    }
    for polygon in soup.polygons.iter() {
        let corners: Vec<String> = polygon.iter().map(|k| (k + 1).to_string()).collect();
        writeln!(text, "f {}", corners.join(" ")).expect("text");
    }
    std::fs::write(&scan, text).expect("a file");
    let (said, report) = made(&scan, &step, &["--align"]);
    assert!(said.contains("aligned: the main plane lies in z = 0"), "{said}");
    assert_eq!(report["placement"].as_array().map(Vec::len), Some(3));
    let planes = report["faces"].as_array().expect("faces").iter();
    let planes = planes.filter(|face| face["surface"] == "plane");
    let lowest = planes.filter(|face| number(face, "/parameters/axis/2") == -1.0);
    let lowest = lowest.map(|face| number(face, "/parameters/at/2")).fold(f64::INFINITY, f64::min);
    assert!(lowest.abs() < 1e-9, "{lowest}");
    let report = step.with_extension("json");
    let checked = |options: &[&str]| {
        let found = check(&[&[arg(&step), arg(&scan), "--json"], options].concat());
        serde_json::from_slice::<Value>(&found.stdout).expect("JSON")
    };
    let there = checked(&["--placement", arg(&report)]);
    assert!(number(&there, "/scan_to_face/max_mm") < 1e-4, "{there}");
    let away = checked(&[]);
    assert!(number(&away, "/scan_to_face/max_mm") > 1.0, "{away}");
    // Other files are named.
    let refused = check(&[arg(&step), arg(&scan), "--placement", arg(&step)]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && said.contains("turned.step"), "{said}");
}

#[test]
fn every_vertex_of_the_file_has_its_point() {
    let mut soup = Soup::default();
    for k in 0..8 {
        soup.points.push([4, 2, 1].map(|bit| if k & bit == 0 { 0.0 } else { 20.0 }));
    }
    for side in SIDES {
        soup.polygons.push(side);
    }
    let conversion = scan2step::convert(&soup, &Options::default(), &mut |_| Ok(()));
    let body = conversion.expect("a solid").into_body().expect("one body");
    assert!(body.exact().is_some());
    for vertex in 0..8 {
        assert!(body.point_of(vertex).is_some_and(|point| point < 8), "{vertex}");
    }
}

/// Arms of one radius from the middle of a pipe of that radius along z, one along x or two, each with a height of `HIGH`. The seams of
/// equal cylinders are ellipses that meet in two points, where the cylinders touch.
fn crossing(arms: &[f64]) -> Vec<crate::open_parts::Triangle> {
    const STEPS: usize = 48;
    let angle = |k: usize| TAU * k as f64 / STEPS as f64;
    // The seam is where z and x are as large as each other.
    let around = |k: usize, z: f64| [RADIUS * angle(k).cos(), RADIUS * angle(k).sin(), z];
    let seam = |k: usize, up: f64| around(k, up * RADIUS * angle(k).cos().abs());
    let swapped = |p: [f64; 3]| [p[2], p[1], p[0]];
    let has_arm = |k: usize| arms.iter().any(|arm| arm * angle(k).cos() > 1e-9);
    let mut polygons = Vec::new();
    for k in 0..STEPS {
        let is_cut = has_arm(k) || has_arm(k + 1);
        for up in [-1.0, 1.0] {
            let low = |k: usize| if is_cut { seam(k, up) } else { around(k, 0.0) };
            let mut side = vec![low(k), low(k + 1), around(k + 1, up * HIGH), around(k, up * HIGH)];
            if up < 0.0 {
                side.reverse();
            }
            polygons.push(side);
        }
    }
    let disk = |up: f64| (0..STEPS).map(|k| around(k, up * HIGH)).collect::<Vec<_>>();
    let mut ends = vec![disk(1.0), disk(-1.0).into_iter().rev().collect()];
    for &arm in arms {
        for k in 0..STEPS {
            let [low, high] = [seam(k, arm), seam(k + 1, arm)].map(swapped);
            let [far, top] = [k + 1, k].map(|k| swapped(around(k, arm * HIGH)));
            let mut side = vec![low, high, far, top];
            if arm > 0.0 {
                side.reverse();
            }
            polygons.push(side);
        }
        let end = disk(arm).into_iter().map(swapped);
        ends.push(if arm > 0.0 { end.rev().collect() } else { end.collect() });
    }
    crate::open_parts::fans(&[polygons, ends].concat())
}

const RADIUS: f64 = 12.0;
const HIGH: f64 = 30.0;

#[test]
fn cylinders_of_one_radius_that_cross_are_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [scan, step] = ["pipes.stl", "pipes.step"].map(|name| folder.path().join(name));
    // What two of them have in common is Steinmetz's solid.
    let (pipe, common) = (2.0 * PI * RADIUS.powi(2) * HIGH, 16.0 / 3.0 * RADIUS.powi(3));
    for (arms, expected, volume) in [
        (&[1.0][..], json!({"plane": 3, "cylinder": 2}), 1.5 * pipe - common / 2.0),
        (&[1.0, -1.0], json!({"plane": 4, "cylinder": 4}), 2.0 * pipe - common),
    ] {
        crate::open_parts::write_stl(&scan, &crossing(arms));
        let (said, report) = made(&scan, &step, &[]);
        assert_eq!(kinds(&report), expected, "{said}");
        let read = opencascade_solid(&step);
        assert_eq!(read["valid"], true, "{said}");
        let off = number(&read, "/volume") / volume - 1.0;
        assert!(off.abs() < 1e-6, "{off:e}: {said}");
    }
}

/// Real parts whose edges are off their surfaces, and whose meshers cut tori askew. They are found whole.
#[test]
fn parts_with_loose_edges_have_the_faces_of_their_truths() {
    let Some(parts) = shared("parts") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, fineness) in [
        ("featuretype", "coarse"),
        ("iso7040_nut", "coarse"),
        ("iso7040_nut", "fine"),
        ("u3_pulley", "fine"),
        ("odri_foot", "coarse"),
        ("nist_pmi_1", "coarse"),
        ("nist_pmi_1", "fine"),
        ("bq_display_housing", "fine"),
        ("u2_knob_housing", "coarse"),
    ] {
        let truth = json(&parts.join(format!("truth/{name}.json")));
        let mesh = parts.join(format!("stl/{name}.{fineness}.stl.gz"));
        let stl = folder.path().join(format!("{name}.stl"));
        std::fs::write(&stl, unpacked(&mesh)).expect("a file");
        let step = folder.path().join(format!("{name}.step"));
        let (_, report) = made(&stl, &step, &[]);
        let truths = truth["kinds"].as_object().expect("an object").clone();
        let truths = truths.into_iter().filter(|(_, n)| *n != 0);
        // A profile of a spline goes straight up in a face of its own.
        let spline = |kind: String| if kind == "extrusion" { "spline".into() } else { kind };
        let truths: serde_json::Map<_, _> = truths.map(|(kind, n)| (spline(kind), n)).collect();
        assert_eq!(kinds(&report), Value::from(truths), "{name} {fineness}");
        assert_eq!(opencascade_solid(&step)["valid"], true, "{name}");
    }
}

/// Three pairs of mirror images lie on a sphere whatever they are, as those at the flat walls of this part do.
#[test]
fn symmetry_makes_no_sphere() {
    let Some(parts) = shared("parts") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let stl = folder.path().join("part.stl");
    let mesh = parts.join("stl/u2_head_bottom.coarse.stl.gz");
    std::fs::write(&stl, unpacked(&mesh)).expect("a file");
    assert_eq!(number(&inspected(&stl), "/exact/surfaces/sphere"), 0.0);
}
