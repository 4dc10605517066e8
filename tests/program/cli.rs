//! The program from outside: files, reports, exit codes, messages.

use crate::common::{arg, convert, converted, files, fixture, json, number, points};
use std::path::Path;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn stages_and_report_are_as_the_contract_has_them() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (scan, step, igs) = (fixture("relief.ply"), path("a.step"), path("a.igs"));
    let (report, stages) = (path("a.json"), path("stages"));
    converted(&[
        arg(&scan),
        arg(&step),
        arg(&igs),
        "--report",
        arg(&report),
        "--stages",
        arg(&stages),
    ]);
    assert_eq!(
        files(&stages),
        ["1-mesh.ply", "2-smooth.ply", "3-filled.ply", "4-parameterized.ply", "5-surface.json"]
    );
    let counts: Vec<usize> = ["1-mesh", "2-smooth", "3-filled", "4-parameterized"]
        .map(|s| points(&stages.join(format!("{s}.ply"))).len())
        .into();
    assert!(counts[0] == counts[1] && counts[1] < counts[2] && counts[2] <= counts[3]);
    let r = json(&report);
    for key in [
        "/noise_mm",
        "/tolerance_mm",
        "/outliers_pct",
        "/smooth/h_mm",
        "/smooth/moved_rms_mm",
        "/smooth/moved_max_mm",
        "/fill/holes/0/rim_vertices",
        "/fill/holes/0/rim_length_mm",
        "/fill/holes/0/added_vertices",
        "/fill/holes/0/added_triangles",
        "/parameterize/flipped",
        "/parameterize/stretch_l2",
        "/parameterize/stretch_max",
        "/fit/degree/0",
        "/fit/net/1",
        "/fit/knots_u",
        "/fit/knots_v",
        "/fit/rms_mm",
        "/fit/p95_mm",
        "/fit/max_mm",
        "/fit/max_at/2",
        "/fit/within_pct",
        "/deviation/rms_mm",
        "/deviation/p95_mm",
        "/deviation/p99_mm",
        "/deviation/max_mm",
        "/deviation/max_at/0",
        "/trim/1/control_points",
        "/trim/1/max_off_surface_mm",
        "/trim/1/max_from_rim_mm",
        "/outputs/0/bytes",
        "/stages/0/seconds",
        "/stages/0/peak_rss_mb",
        "/seconds",
        "/peak_rss_mb",
        "/input/vertices",
        "/input/triangles",
        "/input/components",
        "/input/boundary_loops",
    ] {
        assert!(number(&r, key).is_finite(), "{key}");
    }
    assert_eq!(r["input"]["units"], "mm");
    assert_eq!(r["input"]["units_assumed"], true);
    assert_eq!(r["tolerance_named"], false);
    assert_eq!(r["input"]["boundary_loops"], 3);
    assert_eq!(r["parameterize"]["flipped"], 0);
    assert_eq!(r["fill"]["holes"][0]["trimmed"], true);
    let surface = json(&stages.join("5-surface.json"));
    let rows = surface["net"].as_array().map(Vec::len);
    assert_eq!(rows.map(|n| n as f64), Some(number(&r, "/fit/net/0")));
    assert_eq!(surface["trim_loops"].as_array().map(Vec::len), Some(2));
    assert_eq!(
        files(folder.path()),
        ["a.igs", "a.json", "a.step", "stages"],
        "nothing is left over"
    );
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let (one, two) = (folder(), folder());
    let scan = fixture("relief.ply");
    for (folder, threads) in [(&one, "1"), (&two, "3")] {
        let out = ["a.step", "a.igs"].map(|n| folder.path().join(n));
        converted(&[arg(&scan), arg(&out[0]), arg(&out[1]), "--threads", threads]);
    }
    for name in ["a.step", "a.igs"] {
        let read = |f: &tempfile::TempDir| std::fs::read(f.path().join(name)).expect("a file");
        assert!(read(&one) == read(&two), "{name} differs");
    }
}

/// No file depends on the language, the time, the time zone or the folder.
#[test]
fn the_surroundings_give_the_same_bytes() {
    let around = [("C", "UTC", "x"), ("de_DE.UTF-8", "Asia/Kolkata", "y z")];
    let bytes = around.map(|(language, zone, name)| {
        let folder = folder();
        let inner = folder.path().join(name);
        std::fs::create_dir(&inner).expect("a folder");
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_scan2step"));
        run.args(["convert", arg(&fixture("relief.ply")), "a.step", "a.igs"]);
        run.env("LC_ALL", language).env("LANG", language).env("TZ", zone);
        let run = run.env_remove("SOURCE_DATE_EPOCH").current_dir(&inner).output();
        assert!(run.expect("the program runs").status.success());
        ["a.step", "a.igs"].map(|n| std::fs::read(inner.join(n)).expect("a file"))
    });
    assert!(bytes[0] == bytes[1], "the files differ");
}

#[test]
fn a_time_stamp_that_is_none_is_refused() {
    let folder = folder();
    let step = folder.path().join("a.step");
    let run = |command: &str, stamp: &str| {
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_scan2step"));
        run.args([command, arg(&fixture("relief.ply"))]).env("SOURCE_DATE_EPOCH", stamp);
        run.args(if command == "batch" { &["--out"][..] } else { &[] }).arg(&step);
        run.output().expect("the program runs")
    };
    for stamp in ["", "yesterday", "-1", "1.5", "253402300800"] {
        for command in ["convert", "batch"] {
            let refused = run(command, stamp);
            let said = String::from_utf8_lossy(&refused.stderr);
            assert_eq!(refused.status.code(), Some(2), "{command} {stamp}: {said}");
            let lines: Vec<&str> = said.lines().collect();
            assert!(lines[0].starts_with("error: SOURCE_DATE_EPOCH: "), "{said}");
            assert!(lines.len() == 2 && lines[1].starts_with("help: "), "{said}");
            assert!(files(folder.path()).is_empty(), "{command} {stamp}");
        }
    }
    assert!(run("convert", "86400").status.success());
    let file = std::fs::read_to_string(&step).expect("a file");
    assert!(file.contains("1970-01-02T00:00:00"));
}

#[test]
fn a_named_tolerance_that_is_missed_is_exit_3() {
    let folder = folder();
    let step = folder.path().join("a.step");
    let scan = fixture("relief.ply");
    let missed = convert(&[arg(&scan), arg(&step), "--tolerance", "0.000001", "--max-net", "400"]);
    let said = String::from_utf8_lossy(&missed.stderr);
    assert_eq!(missed.status.code(), Some(3), "{said}");
    assert!(said.contains("tolerance not met") && said.contains("the worst"), "{said}");
    assert!(step.exists(), "the file is written all the same");
    let met = convert(&[arg(&scan), arg(&step), "--tolerance", "2"]);
    assert_eq!(met.status.code(), Some(0));
}

#[test]
fn a_failed_run_leaves_what_was_there() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a.step"), "precious").expect("a file");
    std::fs::write(path("bad.ply"), "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n")
        .expect("a file");
    let output = convert(&[arg(&path("bad.ply")), arg(&path("a.step"))]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[0].starts_with("error: ") && lines[0].contains("bad.ply"), "{said}");
    assert!(lines[1].starts_with("help: "), "{said}");
    assert_eq!(std::fs::read_to_string(path("a.step")).expect("a file"), "precious");
    assert_eq!(files(folder.path()), ["a.step", "bad.ply"]);
}

#[test]
fn what_cannot_be_converted_is_refused_by_name() {
    let folder = folder();
    let scan = folder.path().join("tetrahedron.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    std::fs::write(&scan, text).expect("a file");
    let out = folder.path().join("a.step");
    let output = convert(&[arg(&scan), arg(&out), "--shape", "face"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("closed, genus 0, no boundary"), "{said}");
    assert!(!out.exists());
    // It is the smallest solid. Its sharp edges are rounded.
    let report = folder.path().join("a.json");
    converted(&[arg(&scan), arg(&out), "--report", arg(&report)]);
    let volume = json(&report)["shape"]["volume_mm3"].as_f64().expect("a volume");
    assert!((volume - 1.0 / 6.0).abs() < 0.005, "{volume}");
}

#[test]
fn the_smallest_scan_is_a_square() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let square = "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(path("square.obj"), square).expect("a file");
    converted(&[arg(&path("square.obj")), arg(&path("a.step"))]);
    std::fs::write(path("triangle.obj"), &square[..square.len() - 8]).expect("a file");
    // Three vertices do not have four sides, but they make a trim loop.
    let report = path("a.json");
    converted(&[arg(&path("triangle.obj")), arg(&path("a.step")), "--report", arg(&report)]);
    assert_eq!(json(&report)["parameterize"]["outline"], "free");
    let sides = ["--outline", "sides"];
    let output =
        convert(&[&[arg(&path("triangle.obj")), arg(&path("a.step"))], &sides[..]].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("too few for a face with four sides"), "{said}");
}

#[test]
fn usage_errors_are_exit_2() {
    let scan = fixture("relief.ply");
    for args in [
        &["--nonsense"][..],
        &[arg(&scan), "out.dxf"],
        &[arg(&scan), "out.step", "--tolerance", "-1"],
        &[arg(&scan), "out.step", "--tolerance", "nan"],
        &[arg(&scan), "out.step", "--net", "3x9"],
        &[arg(&scan), "out.step", "--corners", "a,b"],
        &[arg(&scan), "out.step", "--report", "out.txt"],
    ] {
        assert_eq!(convert(args).status.code(), Some(2), "{args:?}");
    }
}

/// What new users write is answered with what to write.
#[test]
fn usual_slips_get_advice() {
    let scan = fixture("relief.ply");
    let said = |args: &[&str]| {
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_scan2step"));
        let output = run.args(args).output().expect("the program runs");
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let convert = ["convert", arg(&scan), "out.step", "--tolerance"];
    let blank = said(&[&convert[..], &["0.2", "mm"]].concat());
    assert!(blank.contains("belongs to its number without a blank, as 0.2mm"), "{blank}");
    let comma = said(&[&convert[..], &["0,2"]].concat());
    assert!(comma.contains("write a decimal point, as 0.2"), "{comma}");
    let file = said(&[arg(&scan)]);
    let help = format!("help: convert it with scan2step convert {}", arg(&scan));
    assert!(file.contains("is a file, where a command belongs") && file.contains(&help), "{file}");
    assert!(said(&["nonsense"]).contains("unrecognized subcommand 'nonsense'"));
}

/// What is no scan is answered with the command that takes it.
#[test]
fn other_commands_are_named() {
    let folder = folder();
    let step = folder.path().join("a.step");
    converted(&[arg(&fixture("relief.ply")), arg(&step)]);
    let said = |file: &Path| {
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_scan2step"));
        let output = run.args(["inspect", arg(file)]).output().expect("the program runs");
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let (cad, all) = (said(&step), said(folder.path()));
    assert!(cad.contains("is a STEP file") && cad.contains("scan2step check "), "{cad}");
    assert!(all.contains("is a folder") && all.contains("scan2step batch "), "{all}");
}

#[test]
fn the_scan_is_never_overwritten() {
    let folder = folder();
    let step = folder.path().join("a.step");
    let scan = fixture("relief.ply");
    std::fs::copy(&scan, &step).expect("a copy");
    let output = convert(&[arg(&step), arg(&step)]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("a.step: is the scan, which no output may replace"), "{said}");
    let [kept, original] = [&step, &scan].map(|p| std::fs::read(p).expect("a file"));
    assert!(kept == original);
}

#[test]
fn an_impossible_place_is_said_at_once() {
    let folder = folder();
    let nowhere = folder.path().join("nowhere/a.step");
    for place in [arg(&nowhere), "no/such/folder.step"] {
        let output = convert(&["no-such-scan.ply", place]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1));
        assert!(said.starts_with(&format!("error: {place}: cannot be written: ")), "{said}");
        assert!(!said.contains(".part") && !said.contains(".scan2step"), "{said}");
    }
}

#[test]
fn units_scale_the_part() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let scan = fixture("relief.ply");
    let width = |units: &str| {
        let report = path("r.json");
        converted(&[
            arg(&scan),
            arg(&path("a.step")),
            "--units",
            units,
            "--net",
            "9x9",
            "--report",
            arg(&report),
        ]);
        number(&json(&report), "/fill/holes/0/rim_length_mm")
    };
    assert!((width("in") / width("mm") - 25.4).abs() < 1e-6);
}

#[test]
fn corners_and_nets_are_the_users() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let scan = fixture("relief.ply");
    let corners = "50,-40,0;50,40,0;-50,40,0;-50,-40,0";
    converted(&[
        arg(&scan),
        arg(&path("a.step")),
        "--corners",
        corners,
        "--net",
        "9x7",
        "--fit",
        "global",
        "--stages",
        arg(&path("s")),
    ]);
    let surface = json(&path("s").join("5-surface.json"));
    let first = [0, 1].map(|axis| number(&surface, &format!("/net/0/0/{axis}")));
    assert!((first[0] - 50.0).abs() < 1.0 && (first[1] + 40.0).abs() < 1.0, "{first:?}");
    assert_eq!(surface["net"].as_array().map(Vec::len), Some(9));
    assert_eq!(surface["net"][0].as_array().map(Vec::len), Some(7));
}

#[test]
fn holes_can_stay_filled() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let scan = fixture("relief.ply");
    let run = |options: &[&str]| {
        let (step, report) = (path("a.step"), path("r.json"));
        let mut args = vec![arg(&scan), arg(&step), "--report", arg(&report)];
        args.extend(options);
        converted(&args);
        json(&report)
    };
    let cut = |r: &serde_json::Value| r["trim"].as_array().map(Vec::len).expect("a list") - 1;
    let all = run(&[]);
    assert_eq!((cut(&all), cut(&run(&["--keep-fills"]))), (2, 0));
    let lengths = [0, 1].map(|h| number(&all, &format!("/fill/holes/{h}/rim_length_mm")));
    let between = (0.5 * (lengths[0] + lengths[1])).to_string();
    assert_eq!(cut(&run(&["--fill-only-holes-below", &between])), 1);
    let said = converted(&[arg(&scan), arg(&path("a.step")), "--fill-only-holes-below", &between]);
    assert!(said.contains("1 hole cut out, 1 kept filled → "), "{said}");
}

/// The relief twice at a distance of 200 mm, and a speck of dust.
fn two_sheets_and_dust(folder: &Path) -> std::path::PathBuf {
    let scan = crate::common::virtual_scan::relief_scan();
    let mut text = String::new();
    for shift in [0.0, 200.0] {
        for [x, y, z] in &scan.points {
            text += &format!("v {} {y} {z}\n", x + shift);
        }
    }
    for first in [1, 1 + scan.points.len() as u32] {
        for t in &scan.triangles {
            let [a, b, c] = t.map(|v| v + first);
            text += &format!("f {a} {b} {c}\n");
        }
    }
    text += "v 500 0 0\nv 501 0 0\nv 501 1 0\nf -3 -2 -1\n";
    let path = folder.join("two.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn every_component_becomes_a_face_when_asked() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (scan, step, report) = (two_sheets_and_dust(folder.path()), path("a.step"), path("a.json"));
    let said = converted(&[arg(&scan), arg(&step)]);
    assert!(said.contains("one of 3"), "{said}");
    let said = converted(&[
        arg(&scan),
        arg(&step),
        "--component",
        "all",
        "--report",
        arg(&report),
        "--stages",
        arg(&path("stages")),
    ]);
    assert!(said.contains("2 of 3"), "{said}");
    for piece in ["\ncomponent 0: tolerance: ", "\ncomponent 1: "] {
        assert!(said.contains(piece), "{said}");
    }
    let text = std::fs::read_to_string(&step).expect("a file");
    assert_eq!(text.matches("ADVANCED_FACE").count(), 2);
    assert_eq!(text.matches("OPEN_SHELL").count(), 2);
    assert_eq!(json(&report)["components"].as_array().map(Vec::len), Some(2));
    assert_eq!(json(&report)["components"][1]["input"]["component"], 1);
    assert_eq!(files(&path("stages")), ["component-0", "component-1"]);
    let missing = convert(&[arg(&scan), arg(&step), "--component", "3"]);
    assert_eq!(missing.status.code(), Some(1));

    // Both faces are compared with only the larger sheet, which the program says, and with both
    // sheets.
    let check = |component: &str| {
        let options = ["--component", component, "--tolerance", "1"];
        let output = crate::common::check(&[&[arg(&step), arg(&scan)], &options[..]].concat());
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (code, said) = check("largest");
    assert!(code == Some(3) && said.contains("components    1 of 3, without "), "{said}");
    let (code, said) = check("all");
    assert!(code == Some(0) && said.contains("components    2 of 3, without "), "{said}");
}

#[test]
fn silence_is_kept() {
    let folder = folder();
    let step = folder.path().join("a.step");
    let said = converted(&[arg(&fixture("relief.ply")), arg(&step), "--quiet"]);
    assert_eq!(said, "");
}

#[test]
fn in_a_pipe_every_stage_is_a_plain_line() {
    let folder = folder();
    let step = folder.path().join("a.step");
    let said = converted(&[arg(&fixture("relief.ply")), arg(&step)]);
    assert!(!said.contains('\x1b') && !said.contains('\r'), "{said:?}");
    let stages = [
        "read",
        "mesh",
        "smooth",
        "fill",
        "parameterize",
        "fit",
        "trim",
        "brep",
        "deviation",
        "write",
    ];
    let lines: Vec<&str> = said.lines().collect();
    let mut at = 0;
    for stage in stages {
        let begins = |line: &&str| line.split(' ').next() == Some(stage) && line.contains(" s");
        let found = lines[at..].iter().position(begins);
        at += found.unwrap_or_else(|| panic!("{stage} is not said in turn: {said}")) + 1;
    }
    assert!(said.contains("relief.ply: 4000 vertices, 7657 triangles"), "{said}");
    assert!(said.contains("units: the file does not say; assuming mm"), "{said}");
    assert!(said.contains("tolerance: ") && said.contains("three times the noise of "), "{said}");
    let result = lines.iter().find(|line| line.contains("control points, rms ")).expect("a result");
    assert!(result.contains("2 holes cut out") && result.ends_with(arg(&step)), "{said}");
    let coloured = converted(&[arg(&fixture("relief.ply")), arg(&step), "--color", "always"]);
    assert!(coloured.contains('\x1b'), "{coloured:?}");
}

#[test]
fn what_could_be_better_is_hinted_at() {
    let folder = folder();
    let (step, scan) = (folder.path().join("a.step"), fixture("relief.ply"));
    let hints = |options: &[&str]| -> Vec<String> {
        let said = converted(&[&[arg(&scan), arg(&step)], options].concat());
        let hints = said.lines().filter_map(|line| line.strip_prefix("hint: "));
        hints.map(str::to_owned).collect()
    };
    assert_eq!(hints(&[]), [""; 0]);
    let loose = hints(&["--tolerance", "5"]);
    assert!(loose.len() == 1 && loose[0].contains("times the noise"), "{loose:?}");
    let strict = hints(&["--tolerance", "0.005", "--outliers", "99"]);
    assert!(strict.len() == 1 && strict[0].contains("far below the noise"), "{strict:?}");
    let flat = hints(&["--smooth", "40"]);
    assert!(flat.iter().any(|hint| hint.contains("--smooth 40 moves them by")), "{flat:?}");
    let corners = hints(&["--corners", "50,-40,0;50,40,0;-50,40,0;-250,-40,0"]);
    assert!(corners.iter().any(|hint| hint.contains("named at (-250.000, ")), "{corners:?}");
    let unused = hints(&["--faces", "9", "--spacing", "2"]);
    assert_eq!(unused.len(), 2, "{unused:?}");
    assert!(unused[0].starts_with("--spacing has no effect on this face: "), "{unused:?}");
    let ring = folder.path().join("ring.igs");
    let said = converted(&[arg(&fixture("ring.obj")), arg(&ring), "--keep-fills"]);
    assert!(said.contains("hint: --keep-fills has no effect on this solid: "), "{said}");
    assert!(said.contains("trimmed surfaces that nothing joins; --iges brep "), "{said}");
    // A scan in metres whose file does not say so.
    let small = folder.path().join("small.obj");
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(&small, square).expect("a file");
    let said = converted(&[arg(&small), arg(&step)]);
    assert!(said.contains("hint: the scan is 1.414 mm across"), "{said}");
    assert!(!converted(&[arg(&small), arg(&step), "--units", "m"]).contains("across"));
}

/// Waves that are sampled with only six points per period.
#[test]
fn shape_that_few_points_show_is_kept() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (scan, step, report) = (path("waves.obj"), path("a.step"), path("a.json"));
    let side = 8;
    let mut text = String::new();
    for (i, j) in (0..side * side).map(|k| (f64::from(k / side), f64::from(k % side))) {
        let height = 10.0 * i.sin() * (0.7 * j).cos();
        text += &format!("v {} {} {height}\n", 15.0 * i, 15.0 * j);
    }
    for k in (0..side * (side - 1)).filter(|k| k % side != side - 1) {
        text += &format!("f {} {} {} {}\n", k + 1, k + side + 1, k + side + 2, k + 2);
    }
    std::fs::write(&scan, text).expect("a scan");
    let run = |options: &[&str]| {
        let fixed = [arg(&scan), arg(&step), "--tolerance", "0.5", "--report", arg(&report)];
        // With so few points no tolerance can be satisfied between them, and the run may say so.
        let output = convert(&[&fixed, options].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{said}");
        (said.contains("may be shape"), number(&json(&report), "/deviation/max_mm"))
    };
    for options in [[].as_slice(), &["--smooth", "off"]] {
        let (told, off) = run(options);
        assert!(!told && off <= 0.5, "{options:?}: {told} {off}");
    }
}

#[test]
fn a_support_that_fits_no_surface_is_refused() {
    let folder = folder();
    let (scan, step) = (fixture("relief.ply"), folder.path().join("a.step"));
    for support in ["0.001", "10000"] {
        let output = convert(&[arg(&scan), arg(&step), "--smooth", support]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("no surface can be fitted with a support of"), "{said}");
        assert!(said.contains("help: name a --smooth between"), "{said}");
    }
    assert!(!step.exists());
}

#[test]
fn lengths_have_units_and_the_output_a_default() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let scan = path("part.v2.ply");
    std::fs::copy(fixture("relief.ply"), &scan).expect("a copy");
    converted(&[arg(&scan), "--tolerance", "500um", "--units", "millimetres"]);
    converted(&[arg(&scan), arg(&path("b.step")), "--tolerance", "0.5"]);
    let [default, named] =
        ["part.v2.step", "b.step"].map(|name| std::fs::read(path(name)).expect("a file"));
    assert_eq!(default, named);
    let quiet = convert(&[arg(&scan), arg(&path("b.step")), "-q", "--tolerance", "0.05in"]);
    assert_eq!((quiet.status.code(), quiet.stderr.len()), (Some(0), 0));

    let kept = convert(&[arg(&scan), arg(&path("b.step")), "--no-clobber"]);
    let said = String::from_utf8_lossy(&kept.stderr);
    assert_eq!(kept.status.code(), Some(1));
    assert!(said.contains("b.step: exists already"), "{said}");
    converted(&[arg(&scan), arg(&path("c.step")), "--no-clobber"]);
}

#[test]
fn messages_name_what_is_wrong() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (scan, step) = (fixture("relief.ply"), path("a.step"));
    let said = |output: std::process::Output| {
        assert_ne!(output.status.code(), Some(0));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let missing = said(convert(&[arg(&scan), arg(&path("none/a.step"))]));
    assert!(missing.contains("none does not exist") && !missing.contains(".part"), "{missing}");
    for (option, value, words) in [
        ("--tolerance", "-1", "not a length above 0"),
        ("--tolerance", "5 parsec", "'parsec' is no unit of length"),
        ("--outliers", "-1", "not a percentage"),
        ("--units", "parsec", "um, mm, cm, m, in, ft"),
    ] {
        let wrong = said(convert(&[arg(&scan), arg(&step), option, value]));
        assert!(wrong.contains(words), "{wrong}");
    }
    converted(&[arg(&scan), arg(&step)]);
    let swapped = said(crate::common::check(&[arg(&scan), arg(&step)]));
    assert!(swapped.contains("name the CAD file first"), "{swapped}");
}
