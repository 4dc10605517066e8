//! Whole scans become solids: closed ones, ones with gaps, and ones that are inside out.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::path::Path;
use std::process::Output;

use crate::common::importers::{freecad, freecad_solid, opencascade_solid};
use crate::common::random::Random;
use crate::common::{arg, checked, convert, json, number, shared};
use scan2step::{Error, Options, Stage, TargetShape};

const RADII: [f64; 2] = [40.0, 15.0];

/// Runs `convert` for B-spline faces, which clean bodies get only if they are asked for.
fn with_splines(args: &[&str]) -> Output {
    convert(&[args, &["--surfaces", "spline"]].concat())
}

/// The same, which must succeed.
fn splined(args: &[&str]) {
    let output = with_splines(args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "convert {args:?}: {said}");
}

/// The scan of a torus: `turned` swaps the orientation, and triangles near the places in `gaps` are
/// left out.
fn torus(path: &Path, noise: f64, turned: bool, gaps: &[[f64; 2]]) {
    std::fs::write(path, torus_text(RADII, noise, (turned, 0), gaps)).expect("a file");
}

/// The same as text. `first` vertices stand before it.
fn torus_text(
    radii: [f64; 2],
    noise: f64,
    (turned, first): (bool, i32),
    gaps: &[[f64; 2]],
) -> String {
    let (n, m) = (120, 48);
    let mut random = Random(7);
    let mut text = String::new();
    let mut normal = || {
        // The sum of twelve uniform numbers has a variance of one.
        (0..12).map(|_| random.share()).sum::<f64>() - 6.0
    };
    for k in 0..n * m {
        let [u, v] =
            [(k / m, n), (k % m, m)].map(|(i, count)| TAU * f64::from(i) / f64::from(count));
        let tube = radii[1] + noise * normal();
        let reach = radii[0] + tube * v.cos();
        writeln!(text, "v {} {} {}", reach * u.cos(), reach * u.sin(), tube * v.sin())
            .expect("text");
    }
    for k in 0..n * m {
        let (i, j) = (k / m, k % m);
        let place = [f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)];
        let near = |gap: &[f64; 2]| (gap[0] - place[0]).hypot(gap[1] - place[1]) < 0.04;
        if gaps.iter().any(near) {
            continue;
        }
        let name = |i: i32, j: i32| 1 + first + (i % n) * m + j % m;
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        let (b, d) = if turned { (d, b) } else { (b, d) };
        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").expect("text");
    }
    text
}

fn volume() -> f64 {
    2.0 * PI * PI * RADII[0] * RADII[1] * RADII[1]
}

#[test]
fn a_torus_becomes_a_watertight_solid() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    for (name, noise, turned, gaps) in [
        ("clean", 0.0, false, &[][..]),
        ("noisy", 0.1, false, &[]),
        ("inverted", 0.0, true, &[]),
        ("gaps", 0.05, false, &[[0.3, 0.5], [0.7, 0.2]]),
    ] {
        let (scan, step, iges) = (path("torus.obj"), path("torus.step"), path("torus.igs"));
        torus(&scan, noise, turned, gaps);
        let (report, stages) = (path("torus.json"), path(name));
        let asked = ["--report", arg(&report), "--stages", arg(&stages), "--iges", "brep"];
        splined(&[&[arg(&scan), arg(&step), arg(&iges)], &asked[..]].concat());
        let report = json(&report);
        let shape = &report["shape"];
        assert_eq!(shape["kind"], "solid", "{name}");
        assert_eq!((&shape["folds"], &shape["free_edges"]), (&0.into(), &0.into()), "{name}");
        assert_eq!(report["fill"]["holes"].as_array().map(Vec::len), Some(gaps.len()), "{name}");
        assert_eq!(report["tolerance_met"], true, "{name}: {report}");
        let off = number(&report, "/shape/volume_mm3") / volume() - 1.0;
        // The flat triangles of the scan have 6e-3 less volume than the torus.
        let most = if noise > 0.0 { 2e-3 } else { 2e-4 };
        assert!(off.abs() < most, "{name}: the volume is {off} off");
        let seams = number(&report, "/shape/seam_deg/p95");
        assert!(seams < 0.2, "{name}: seams of {seams}°");
        if noise > 0.0 {
            let rms = number(&report, "/deviation/rms_mm");
            assert!((0.7..1.3).contains(&(rms / noise)), "{name}: rms {rms}");
        }
        for file in ["1-mesh.ply", "2-smooth.ply", "3-filled.ply", "4-layout.ply"] {
            assert!(stages.join(file).exists(), "{name}: {file}");
        }
        for file in [&step, &iges] {
            let found = opencascade_solid(file);
            assert_eq!(found["solids"], 1, "{name}: {found}");
            assert_eq!(found["faces"], shape["faces"], "{name}");
            assert_eq!(found["valid"], true, "{name}: {found}");
            assert_eq!(found["uses"], serde_json::json!({ "2": shape["edges"] }), "{name}");
            let there = number(&found, "/volume") / number(&report, "/shape/volume_mm3") - 1.0;
            assert!(there.abs() < 1e-4, "{name}: {there}");
        }
        let back = checked(&step, &scan);
        assert!(number(&back, "/scan_to_face/rms_mm") < 1.3 * noise.max(0.01), "{name}: {back}");
    }
}

/// The scan of a torus with a bump that is as wide as two edges of the triangles.
fn bumpy_torus(path: &Path) {
    let on = |u: f64, v: f64, tube: f64| {
        let reach = RADII[0] + tube * v.cos();
        [reach * u.cos(), reach * u.sin(), tube * v.sin()]
    };
    let top = on(0.7, 1.0, RADII[1]);
    let moved = |line: &str| {
        let Some(point) = line.strip_prefix("v ") else { return format!("{line}\n") };
        let p: Vec<f64> = point.split(' ').map(|x| x.parse().expect("a number")).collect();
        let (u, v) = (p[1].atan2(p[0]), p[2].atan2(p[0].hypot(p[1]) - RADII[0]));
        let off = p.iter().zip(&top).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let [x, y, z] = on(u, v, RADII[1] + (-off / 8.0).exp());
        format!("v {x} {y} {z}\n")
    };
    let text: String = torus_text(RADII, 0.0, (false, 0), &[]).lines().map(moved).collect();
    std::fs::write(path, text).expect("a file");
}

#[test]
fn single_faces_get_more_knots_where_they_miss_the_tolerance() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let (scan, step, report) = (path("bump.obj"), path("bump.step"), path("bump.json"));
    bumpy_torus(&scan);
    splined(&[arg(&scan), arg(&step), "--tolerance", "0.05", "--report", arg(&report)]);
    let report = json(&report);
    crate::common::assert_schema(&report);
    assert_eq!(report["tolerance_met"], true, "{report}");
    assert_eq!((&report["shape"]["folds"], &report["shape"]["free_edges"]), (&0.into(), &0.into()));
    // Without more knots in single faces, all faces have the same net, and the bump misses the tolerance.
    let nets: Vec<String> = report["faces"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|face| face["net"].to_string())
        .collect();
    let finer = nets.iter().filter(|net| **net != nets[nets.len() / 2]).count();
    assert!(0 < finer && finer < nets.len() / 2, "{nets:?}");
    let found = opencascade_solid(&step);
    assert_eq!(found["valid"], true, "{found}");
    assert_eq!(found["uses"], serde_json::json!({ "2": report["shape"]["edges"] }), "{found}");
}

#[test]
fn freecad_opens_a_torus() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    torus(&path("torus.obj"), 0.02, false, &[]);
    splined(&[arg(&path("torus.obj")), arg(&path("torus.step"))]);
    let Some(found) = freecad_solid(&path("torus.step")) else { return };
    assert_eq!(found["valid"], true, "{found}");
    let off = number(&found, "/volume") / volume() - 1.0;
    assert!(off.abs() < 4e-3, "{found}");
}

#[test]
fn about_as_many_faces_come_out_as_are_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    torus(&path("torus.obj"), 0.02, false, &[]);
    let faces = |count: &str| {
        let report = path("torus.json");
        let (scan, step) = (path("torus.obj"), path("torus.step"));
        splined(&[arg(&scan), arg(&step), "--faces", count, "--report", arg(&report)]);
        let report = json(&report);
        assert_eq!(report["options"]["faces"].to_string(), count);
        (number(&report, "/shape/faces"), report["hints"].to_string())
    };
    let [few, many] = ["30", "90"].map(faces);
    assert!((24.0..=36.0).contains(&few.0) && !few.1.contains("not about"), "{few:?}");
    assert!((72.0..=108.0).contains(&many.0) && !many.1.contains("not about"), "{many:?}");
    let (least, hints) = faces("4");
    assert!(
        least > 4.0 && hints.contains(&format!("has {least} faces, and not about 4")),
        "{hints}"
    );
}

#[test]
fn the_faces_together_keep_the_bound_on_control_points() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let (scan, step, report) = (path("torus.obj"), path("torus.step"), path("torus.json"));
    torus(&scan, 0.0, false, &[]);
    let run = |most: usize| {
        let most = most.to_string();
        // No net keeps this tolerance.
        let options = ["--tolerance", "1e-6", "--max-net", &most, "--report", arg(&report)];
        let output = with_splines(&[&[arg(&scan), arg(&step)], &options[..]].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = run(100);
    assert_eq!((code, step.exists()), (Some(1), false), "{said}");
    let least = said.split("--max-net of ").nth(1).and_then(|rest| rest.split(' ').next());
    let least: usize = least.and_then(|least| least.parse().ok()).expect("the help names it");
    assert!(said.contains(&format!("have at least {least} control points")), "{said}");
    assert_eq!(run(least - 1).0, Some(1));
    for most in [least, 3 * least] {
        let (code, said) = run(most);
        assert_eq!(code, Some(3), "{said}");
        let report = json(&report);
        let faces = report["faces"].as_array().expect("faces");
        let net = |face: &serde_json::Value| number(face, "/net/0") * number(face, "/net/1");
        let sum: f64 = faces.iter().map(net).sum();
        assert!(sum <= most as f64 && sum > 0.3 * most as f64, "{sum} of {most}");
    }
}

#[test]
fn a_finer_layout_that_fails_leaves_the_sound_faces() {
    let soup = formats::read_scan(&crate::common::fixture("ring.obj")).expect("a mesh");
    let solid = |tolerance: f64, most: usize, stops: bool| {
        let options = Options::builder().tolerance(tolerance).max_net(most);
        let options = options.build().expect("options");
        let scan = scan2step::mesh_components(&soup, &options).expect("a mesh");
        let mut layouts = Vec::new();
        let made = crate::common::body_of(&scan, TargetShape::Solid, &options, &mut |stage| {
            if let Stage::Layout(quads) = stage {
                layouts.push(quads.blocks());
            }
            if stops && layouts.len() == 2 { Err(Error::Singular("watch")) } else { Ok(()) }
        });
        (made, layouts)
    };
    // Faces are far from the scan, so that the layout is made finer, for which there are too few control points.
    let (_, layouts) = solid(1e-3, 1_000_000, false);
    assert!(layouts.len() > 1 && layouts[1] > layouts[0], "{layouts:?}");
    let (made, seen) = solid(1e-3, 225 * layouts[0], false);
    assert_eq!(seen, layouts[..2]);
    assert_eq!(made.expect("a solid").surfaces().len(), layouts[0]);
    // An error of the caller stops the conversion all the same.
    let (made, _) = solid(1e-3, 1_000_000, true);
    assert!(matches!(made, Err(Error::Singular("watch"))), "{made:?}");
}

#[test]
fn real_bodies_become_solids() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    // A sculpture with four handles, and a part with sharp edges and knife edges.
    for (scan, most) in [("fertility.ply", 120.0), ("trimstar.stl.gz", 80.0)] {
        let Some(scan) = shared("scans/B").map(|scans| scans.join(scan)) else { return };
        let (step, report) = (path("body.step"), path("body.json"));
        let output = with_splines(&[arg(&scan), arg(&step), "--report", arg(&report)]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        let faces = number(&json(&report), "/shape/faces");
        assert!(faces <= most, "{faces} faces of {}", scan.display());
        let found = opencascade_solid(&step);
        assert_eq!(found["valid"], true, "{found}");
    }
}

#[test]
fn the_number_of_threads_does_not_change_a_byte() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    torus(&path("torus.obj"), 0.05, false, &[[0.5, 0.5]]);
    let files = ["1", "2", "5"].map(|threads| {
        let out = path("torus.step");
        splined(&[arg(&path("torus.obj")), arg(&out), "--threads", threads]);
        std::fs::read(out).expect("a file")
    });
    assert!(files[0] == files[1] && files[1] == files[2]);
}

#[test]
fn a_body_is_no_face() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    torus(&path("torus.obj"), 0.0, false, &[]);
    let out = path("torus.step");
    let output = with_splines(&[arg(&path("torus.obj")), arg(&out), "--shape", "face"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("genus 1"), "{said}");
    assert!(!out.exists());
}

#[test]
fn a_body_has_a_page_and_a_picture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    torus(&path("torus.obj"), 0.05, false, &[[0.5, 0.5]]);
    let [page, picture, report] = ["torus.html", "torus.png", "torus.json"].map(&path);
    let files = [&page, &picture, &report].map(|file| ["--report", arg(file)]).concat();
    splined(&[&[arg(&path("torus.obj")), arg(&path("torus.step"))], &files[..]].concat());
    let text = std::fs::read_to_string(&page).expect("a page");
    crate::common::assert_schema(&json(&report));
    let faces = number(&json(&report), "/shape/faces");
    for words in [format!("a solid of {faces} faces"), "irregular vertices".into()] {
        assert!(text.contains(&words), "{words}");
    }
    assert!(!text.contains("Parameter plane"), "several faces have no common plane");
    let bytes = std::fs::read(&picture).expect("a picture");
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 50_000, "{}", bytes.len());
}

/// The shells of a pipe and of a torus with a large gap, checked in both CAD kernels.
#[test]
fn open_bodies_become_shells_with_their_ends_open() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let place = |k: i32| [0.4 + 0.03 * f64::from(k / 9), 0.3 + 0.05 * f64::from(k % 9)];
    let window: Vec<[f64; 2]> = (0..54).map(place).collect();
    let ends: Vec<[f64; 2]> = (0..40).map(|k| [0.5, 0.025 * f64::from(k)]).collect();
    for (name, gaps, loops, euler) in [("window", &window, 1, -1), ("pipe", &ends, 2, 0)] {
        let (scan, step, iges) = (path("torus.obj"), path("torus.step"), path("torus.igs"));
        torus(&scan, 0.05, false, gaps);
        let report = path("torus.json");
        let asked = ["--report", arg(&report), "--iges", "brep"];
        splined(&[&[arg(&scan), arg(&step), arg(&iges)], &asked[..]].concat());
        let report = json(&report);
        crate::common::assert_schema(&report);
        let shape = &report["shape"];
        assert_eq!((&shape["kind"], &shape["shells"]), (&"shell".into(), &1.into()), "{name}");
        assert_eq!((&shape["folds"], &shape["solids"]), (&0.into(), &0.into()), "{name}");
        assert!(shape["volume_mm3"].is_null(), "{name}");
        let holes = report["fill"]["holes"].as_array().expect("holes");
        assert_eq!(holes.len(), loops, "{name}");
        assert!(holes.iter().all(|hole| hole["trimmed"] == true), "{name}: {holes:?}");
        let count = |of: &str| shape[of].as_i64().expect("a number");
        // An end that lies inside of one face is an inner loop of it, so that the face is no disk.
        let text = std::fs::read_to_string(&step).expect("text");
        let inner = text.matches("=FACE_BOUND(").count() as i64;
        let characteristic = count("vertices") - count("edges") + count("faces") - inner;
        assert_eq!(characteristic, euler, "{name}");
        assert!(count("free_edges") >= 2 * loops as i64, "{name}");
        let rms = number(&report, "/deviation/rms_mm");
        assert!((0.035..0.065).contains(&rms), "{name}: rms {rms}");
        let free = count("free_edges");
        for file in [&step, &iges] {
            let found = opencascade_solid(file);
            assert_eq!(found["valid"], true, "{name}: {found}");
            assert_eq!((&found["solids"], &found["shells"]), (&0.into(), &1.into()), "{name}");
            let uses = serde_json::json!({ "1": free, "2": count("edges") - free });
            assert_eq!(found["uses"], uses, "{name}");
        }
        if let Some(found) = freecad(&step) {
            assert_eq!(found["valid"], true, "{name}: {found}");
        }
    }
}

#[test]
fn a_torus_in_a_torus_is_a_void_if_it_faces_inwards() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    // The whole scan may also be inside out.
    for (name, outer_turned, inner_turned, voids) in
        [("void", false, true, 1), ("inside out", true, false, 1), ("nested", false, false, 0)]
    {
        let (scan, step, report) = (path("two.obj"), path("two.step"), path("two.json"));
        let outer = torus_text(RADII, 0.0, (outer_turned, 0), &[]);
        let inner = torus_text([RADII[0], 8.0], 0.0, (inner_turned, 120 * 48), &[]);
        std::fs::write(&scan, outer + &inner).expect("a file");
        let all = ["--component", "all", "--report", arg(&report)];
        splined(&[&[arg(&scan), arg(&step)], &all[..]].concat());
        let report = json(&report);
        crate::common::assert_schema(&report);
        let volumes = [0, 1].map(|k| number(&report, &format!("/components/{k}/shape/volume_mm3")));
        let inner = 2.0 * PI * PI * RADII[0] * 64.0 * if voids == 1 { -1.0 } else { 1.0 };
        for (found, there) in volumes.into_iter().zip([volume(), inner]) {
            assert!((found / there - 1.0).abs() < 0.01, "{name}: {volumes:?}");
        }
        let found = opencascade_solid(&step);
        assert_eq!(found["valid"], true, "{name}: {found}");
        assert_eq!(
            (&found["solids"], &found["shells"]),
            (&(2 - voids).into(), &2.into()),
            "{name}"
        );
        let there = number(&found, "/volume") / (volumes[0] + volumes[1]) - 1.0;
        assert!(there.abs() < 1e-4, "{name}: {there}");
    }
}

/// A ball of triangles between meridians and parallels. `first` vertices stand before it.
fn ball_text(radius: f64, turned: bool, first: usize) -> String {
    let n = 16;
    let mut text = format!("v 0 0 {radius}\nv 0 0 {}\n", -radius);
    for (i, j) in (1..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        let [tilt, turn] = [i, j].map(|k| PI * f64::from(k) / f64::from(n));
        let [x, y] = [turn.cos(), turn.sin()].map(|of| radius * tilt.sin() * of);
        writeln!(text, "v {x} {y} {}", radius * tilt.cos()).expect("text");
    }
    let name = |i: i32, j: i32| match i {
        0 => 1,
        i if i == n => 2,
        i => 3 + 2 * n * (i - 1) + j % (2 * n),
    };
    for (i, j) in (0..n).flat_map(|i| (0..2 * n).map(move |j| (i, j))) {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        for mut t in [[a, b, c], [a, c, d]] {
            if turned {
                t.swap(1, 2);
            }
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                let [a, b, c] = t.map(|v| v as usize + first);
                writeln!(text, "f {a} {b} {c}").expect("text");
            }
        }
    }
    text
}

#[test]
fn what_lies_in_a_void_is_a_solid_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    // The third ball lies in the void of the first one.
    for radii in [&[30.0, 20.0, 10.0][..], &[40.0, 30.0, 20.0, 10.0]] {
        let (scan, step, report) = (path("balls.obj"), path("balls.step"), path("balls.json"));
        let mut text = String::new();
        for (k, &radius) in radii.iter().enumerate() {
            let first = text.lines().filter(|line| line.starts_with('v')).count();
            text += &ball_text(radius, k % 2 == 1, first);
        }
        std::fs::write(&scan, text).expect("a file");
        let all = ["--component", "all", "--report", arg(&report)];
        splined(&[&[arg(&scan), arg(&step)], &all[..]].concat());
        let report = json(&report);
        let of = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
        for (k, &radius) in radii.iter().enumerate() {
            let found = number(&report, &format!("/components/{k}/shape/volume_mm3"));
            let there = if k % 2 == 1 { -of(radius) } else { of(radius) };
            assert!((found / there - 1.0).abs() < 0.01, "{found} instead of {there}");
        }
        let found = opencascade_solid(&step);
        assert_eq!(found["valid"], true, "{found}");
        let counts = [radii.len().div_ceil(2), radii.len()].map(serde_json::Value::from);
        assert_eq!([&found["solids"], &found["shells"]], counts.each_ref(), "{found}");
    }
}
