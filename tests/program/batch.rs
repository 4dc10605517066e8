//! `scan2step batch` from outside: failures, resuming, shards, names, summaries, and the arguments.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{arg, files, json};
use serde_json::Value;

fn program(args: &[&str], folder: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    command.args(args).current_dir(folder).env_remove("SOURCE_DATE_EPOCH");
    command.output().expect("the program runs")
}

/// Runs `batch` in a folder and returns its exit code and output.
fn batch(folder: &Path, args: &[&str]) -> (Option<i32>, String) {
    let output = program(&[&["batch"], args].concat(), folder);
    let said = [output.stdout, output.stderr].map(|s| String::from_utf8_lossy(&s).into_owned());
    (output.status.code(), said.concat())
}

/// A small wavy sheet with a hole. Different heights make different scans.
fn sheet(path: &Path, height: f64) {
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    let (side, ply) = (14, path.extension().is_some_and(|e| e == "ply"));
    let mut points = String::new();
    let mut triangles = Vec::new();
    for (i, j) in (0..side * side).map(|k| (k / side, k % side)) {
        let (x, y) = (2.0 * f64::from(i), 2.0 * f64::from(j));
        let z = height * (0.2 * x).sin() * (0.15 * y).cos();
        points += &format!("{}{x} {y} {z}\n", if ply { "" } else { "v " });
        let in_hole = (6..8).contains(&i) && (6..8).contains(&j);
        if i + 1 < side && j + 1 < side && !in_hole {
            let k = i * side + j;
            triangles.extend([[k, k + side, k + side + 1], [k, k + side + 1, k + 1]]);
        }
    }
    let rows = triangles.iter().map(|&[a, b, c]| match ply {
        true => format!("3 {a} {b} {c}\n"),
        false => format!("f {} {} {}\n", a + 1, b + 1, c + 1),
    });
    let rows: String = rows.collect();
    let head = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side,
        triangles.len()
    );
    let head = if ply { head } else { String::new() };
    std::fs::write(path, head + &points + &rows).expect("a scan");
}

/// Three scans. The second one is broken.
fn three() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    sheet(&folder.path().join("scans/a.ply"), 1.0);
    std::fs::write(folder.path().join("scans/b.ply"), "ply\nformat ascii 1.0\nend_header\n")
        .expect("a file");
    sheet(&folder.path().join("scans/deep/c.obj"), 2.0);
    folder
}

/// A value of every scan in the summary.
fn each(folder: &Path, key: &str) -> Vec<Value> {
    let summary = json(&folder.join("cad/summary.json"));
    let scans = summary["scans"].as_array().expect("scans");
    scans.iter().map(|scan| scan[key].clone()).collect()
}

fn modified(path: PathBuf) -> std::time::SystemTime {
    std::fs::metadata(path).and_then(|m| m.modified()).expect("a file with a time")
}

#[test]
fn a_failure_stops_no_other_scan() {
    let folder = three();
    let path = folder.path();
    let (code, said) = batch(path, &["scans", "--out", "cad", "--report", "json"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("error: scans/b.ply: ") && said.contains("\nhelp: "), "{said}");
    assert!(said.contains("2 ok, 1 failed"), "{said}");
    let cad = path.join("cad");
    assert_eq!(
        files(&cad),
        [".scan2step", "a.report.json", "a.step", "deep", "summary.csv", "summary.json"]
    );
    assert_eq!(files(&cad.join("deep")), ["c.report.json", "c.step"]);
    assert_eq!(each(path, "status"), ["ok", "failed", "ok"]);
    assert_eq!(each(path, "exit_code"), [0, 1, 0]);
    assert_eq!(each(path, "file"), ["scans/a.ply", "scans/b.ply", "scans/deep/c.obj"]);
    assert_eq!(each(path, "holes")[0], 1);
    // The figures are those of the scan's own report.
    let report = json(&cad.join("a.report.json"));
    assert_eq!(each(path, "max_mm")[0], report["fit"]["max_mm"]);
    assert_eq!(each(path, "tolerance_mm")[0], report["tolerance_mm"]);
    assert_eq!(each(path, "net")[0][0], report["fit"]["net"]);
    // Its command makes these files, and not the record of the batch.
    let words = ["scan2step", "convert", "scans/a.ply", "cad/a.step", "--report=cad/a.report.json"];
    assert_eq!(report["command"], serde_json::json!(words));
    let output = &each(path, "outputs")[0][0];
    assert_eq!(output["file"], "a.step");
    assert_eq!(output["sha256"], report["outputs"][0]["sha256"]);
    let table = std::fs::read_to_string(cad.join("summary.csv")).expect("a summary");
    let mut rows = table.lines();
    let head = "file,status,exit_code,seconds,shape,faces,net,rms_mm,max_mm,tolerance_mm,holes,error,outputs,help,hints,units,units_assumed";
    assert_eq!(rows.next(), Some(head));
    assert!(rows.next().is_some_and(|row| row.starts_with("scans/a.ply,ok,0,")), "{table}");
    assert!(rows.next().is_some_and(|row| row.starts_with("scans/b.ply,failed,1,")), "{table}");
}

#[test]
fn what_is_there_is_skipped_until_something_changes() {
    let folder = three();
    let path = folder.path();
    let run = |options: &[&str]| {
        let (_, said) = batch(path, &[&["scans", "--out", "cad"], options].concat());
        let status = each(path, "status").into_iter();
        let status: Vec<String> = status.map(|s| s.as_str().expect("text").into()).collect();
        (status.join(" "), said)
    };
    assert_eq!(run(&[]).0, "ok failed ok");
    let first = (each(path, "seconds"), modified(path.join("cad/a.step")));
    // A failed scan is tried again. Options for speed, messages and folders change nothing.
    let (status, said) = run(&["--threads", "1", "-v"]);
    assert_eq!(status, "skipped failed skipped", "{said}");
    assert_eq!(each(path, "exit_code"), [0, 1, 0]);
    assert_eq!(each(path, "seconds")[0], first.0[0]);
    assert_eq!(modified(path.join("cad/a.step")), first.1);
    // A corrected scan, one with a new time, and one whose file is missing.
    sheet(&path.join("scans/b.ply"), 0.5);
    let scan = std::fs::read(path.join("scans/a.ply")).expect("a scan");
    std::fs::write(path.join("scans/a.ply"), scan).expect("a scan");
    std::fs::remove_file(path.join("cad/deep/c.step")).expect("a file");
    assert_eq!(run(&[]).0, "skipped ok ok");
    // Another scan of the same size, other options, and `--force`.
    let scan = std::fs::read_to_string(path.join("scans/deep/c.obj")).expect("a scan");
    let other = scan.replacen("v 0 0 0\n", "v 0 0 1\n", 1);
    assert_ne!(scan, other);
    std::fs::write(path.join("scans/deep/c.obj"), other).expect("a scan");
    assert_eq!(run(&[]).0, "skipped skipped ok");
    assert_eq!(run(&["--tolerance", "0.5"]).0, "ok ok ok");
    assert_eq!(run(&["--tolerance", "0.5", "--format", "both"]).0, "ok ok ok");
    assert_eq!(run(&["--tolerance", "0.5", "--format", "both"]).0, "skipped skipped skipped");
    assert_eq!(run(&["--tolerance", "0.5", "--format", "both", "--force"]).0, "ok ok ok");
    assert!(path.join("cad/deep/c.igs").is_file());
}

/// A program that opens a pipe without a writer waits forever.
#[cfg(unix)]
#[test]
fn pipes_are_no_scans_of_patterns_and_folders() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    sheet(&path.join("scans/a.ply"), 1.0);
    let made = Command::new("mkfifo").arg(path.join("scans/b.ply")).status();
    assert!(made.expect("mkfifo runs").success());
    for scans in ["scans/*.ply", "scans"] {
        let (code, said) = batch(path, &[scans, "--out", "cad", "--force"]);
        assert_eq!(code, Some(0), "{said}");
        assert_eq!(each(path, "status"), ["ok"]);
    }
}

/// The numbers of a glTF file are in another file, which may change alone.
#[test]
fn a_scan_in_two_files_is_known_by_both() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    let points: Vec<[f32; 3]> = (0..36)
        .map(|k| ((k / 6) as f32, (k % 6) as f32))
        .map(|(x, y)| [x * 1e-3, y * 1e-3, (0.5 * x).sin() * 3e-4])
        .collect();
    let corners = (0..25_u16).map(|k| k / 5 * 6 + k % 5);
    let corners: Vec<u16> = corners.flat_map(|k| [k, k + 6, k + 7, k, k + 7, k + 1]).collect();
    let write = |points: &[[f32; 3]]| {
        let mut bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend(corners.iter().flat_map(|k| k.to_le_bytes()));
        std::fs::write(path.join("scan.bin"), bytes).expect("a file");
    };
    let scan = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [{ "uri": "scan.bin", "byteLength": 36 * 12 + 150 * 2 }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 * 12 },
            { "buffer": 0, "byteOffset": 36 * 12, "byteLength": 150 * 2 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 36, "type": "VEC3",
              "min": [0.0, 0.0, -1.0], "max": [1.0, 1.0, 1.0] },
            { "bufferView": 1, "componentType": 5123, "count": 150, "type": "SCALAR" },
        ],
    });
    std::fs::write(path.join("scan.gltf"), scan.to_string()).expect("a file");
    write(&points);
    let run = || {
        let (code, said) = batch(path, &["scan.gltf", "--out", "cad"]);
        assert_eq!(code, Some(0), "{said}");
        each(path, "status")
    };
    assert_eq!(run(), ["ok"]);
    assert_eq!(run(), ["skipped"]);
    let higher: Vec<_> = points.iter().map(|&[x, y, z]| [x, y, 1.5 * z]).collect();
    write(&higher);
    assert_eq!(run(), ["ok"]);
}

#[test]
fn shards_share_the_work_and_the_summary() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    for name in ["a", "b", "c", "d", "e"] {
        sheet(&path.join(format!("scans/{name}.ply")), 1.0);
    }
    let shard = |k| ["scans", "--out", "cad", "--shard", k];
    assert_eq!(batch(path, &shard("2/3")).0, Some(0));
    assert_eq!(each(path, "status"), ["pending", "ok", "pending", "pending", "ok"]);
    // Two runs at the same time.
    std::thread::scope(|scope| {
        for k in ["1/3", "3/3"] {
            scope.spawn(move || assert_eq!(batch(path, &shard(k)).0, Some(0)));
        }
    });
    assert_eq!(each(path, "status"), ["ok"; 5]);
    assert_eq!(batch(path, &["scans", "--out", "cad", "--jobs", "2"]).0, Some(0));
    assert_eq!(each(path, "status"), ["skipped"; 5]);
    for k in ["0/3", "4/3", "1", "1/0", "a/b"] {
        assert_eq!(batch(path, &shard(k)).0, Some(2), "{k}");
    }
}

#[test]
fn scans_of_the_same_stem_get_names_of_their_own() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    for scan in ["one/a.ply", "one/a.obj", "two/a.ply", "two/.hidden.ply"] {
        sheet(&path.join(scan), 1.0);
    }
    // The same scans with other names for their paths.
    for (out, scans) in [
        ("1", &["."][..]),
        ("2", &["one", "two"]),
        ("3", &["*/a.*", "one/a.ply"]),
        ("4", &["two/a.ply", "one/a.obj", "one/a.ply", "two"]),
    ] {
        let (code, said) = batch(path, &[scans, &["--out", out]].concat());
        assert_eq!(code, Some(0), "{said}");
        assert_eq!(files(&path.join(out).join("one")), ["a.obj.step", "a.ply.step"], "{scans:?}");
        assert_eq!(files(&path.join(out).join("two")), ["a.step"], "{scans:?}");
    }
}

#[test]
fn exit_codes_say_how_it_went() {
    let folder = three();
    let path = folder.path();
    let run = |args: &[&str]| batch(path, &[args, &["--out", "cad"]].concat());
    let missed = ["scans/a.ply", "scans/deep", "--net", "4x4", "--tolerance", "1e-6"];
    assert_eq!(run(&["scans/a.ply"]).0, Some(0));
    let (code, said) = run(&missed);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("note: tolerance not met: "), "{said}");
    assert_eq!(each(path, "status"), ["missed", "missed"]);
    // A skipped scan still misses its tolerance.
    assert_eq!(run(&missed).0, Some(3));
    assert_eq!(run(&["scans", "--net", "4x4", "--tolerance", "1e-6"]).0, Some(1));
    // A missing scan fails alone.
    let (code, said) = run(&["scans/none.ply", "scans/a.ply"]);
    assert_eq!(code, Some(1), "{said}");
    assert_eq!(each(path, "status"), ["ok", "failed"]);
    for (args, what) in [
        (&["none"][..], "error: none: no such file or folder\nhelp: "),
        (&["none*.ply"], "error: none*.ply: no scan found\nhelp: "),
        (&["cad"], "error: cad: no scan found\nhelp: "),
    ] {
        let (code, said) = run(args);
        assert_eq!(code, Some(1), "{said}");
        assert!(said.starts_with(what), "{said}");
    }
    for wrong in [&[][..], &["scans", "--tolerance", "-1"], &["scans", "--corners", "1,2,3,4"]] {
        assert_eq!(run(wrong).0, Some(2), "{wrong:?}");
    }
    let (_, said) = run(&["scans/a.ply", "--quiet"]);
    assert_eq!(said, "");
}

#[test]
fn a_scan_that_may_need_too_much_memory_is_refused_before_the_work() {
    let folder = three();
    let path = folder.path();
    let run = |size: &str, more: &[&str]| {
        batch(path, &[&["scans/a.ply", "--out", "cad", "--max-memory", size], more].concat())
    };
    let (code, said) = run("20M", &[]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("error: scans/a.ply: may need ") && said.contains("help: "), "{said}");
    assert_eq!(run("170MB", &[]).0, Some(0));
    // The bound assumes the largest net, because a named tolerance may need it.
    assert_eq!(run("170MB", &["--tolerance", "0.5"]).0, Some(1));
    assert_eq!(run("170MB", &["--tolerance", "0.5", "--max-net", "1000"]).0, Some(0));
    assert_eq!(run("much", &[]).0, Some(2));
}

#[cfg(unix)]
#[test]
fn a_batch_that_is_stopped_goes_on_where_it_was() {
    use std::os::unix::process::ExitStatusExt;
    use std::time::{Duration, Instant};

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    sheet(&path.join("scans/a.ply"), 1.0);
    crate::common::large_scan(&path.join("scans"));
    // A program that a shell runs in the background may have to ignore the signal.
    let mut run = Command::new("env");
    run.args(["--default-signal=INT", env!("CARGO_BIN_EXE_scan2step"), "batch", "scans"]);
    run.args(["--out", "cad", "--quiet"]).current_dir(path);
    let mut run = run.spawn().expect("the program runs");
    let begun = Instant::now();
    // The large scan has begun, because its file has a temporary name by now.
    let unfinished = || {
        let of_large = |name: &String| name.ends_with(".part");
        path.join("cad/a.step").is_file()
            && files(&path.join("cad/.scan2step")).len() > 1
            && !files(&path.join("cad")).iter().any(of_large)
    };
    while !unfinished() {
        assert!(run.try_wait().expect("its state").is_none(), "it ended before it was stopped");
        assert!(begun.elapsed() < Duration::from_secs(120), "no file after two minutes");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    let sent = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
    assert_eq!(run.wait().expect("it ends").signal(), Some(2));
    assert_eq!(files(&path.join("cad")), [".scan2step", "a.step"]);
    let records = files(&path.join("cad/.scan2step"));
    assert!(records.iter().all(|name| name.ends_with(".json")), "{records:?}");
    std::fs::remove_file(path.join("scans/large.stl")).expect("a file");
    sheet(&path.join("scans/large.obj"), 2.0);
    let (code, said) = batch(path, &["scans", "--out", "cad"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(each(path, "status"), ["skipped", "ok"]);
}

#[test]
fn completions_manual_and_help_name_every_command() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    let printed = |args: &[&str]| {
        let output = program(args, path);
        assert!(output.status.success(), "{args:?}");
        String::from_utf8(output.stdout).expect("text")
    };
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = printed(&["completions", shell]);
        assert!(script.contains("fill-only-holes-below"), "{shell}");
    }
    let page = printed(&["man"]);
    assert!(page.contains(".TH scan2step 1") && page.contains("batch"), "{page}");
    printed(&["man", arg(&path.join("new/man1"))]);
    let commands = ["convert", "inspect", "check", "batch", "completions", "man", "licences"];
    let mut pages = commands.map(|command| format!("scan2step-{command}.1")).to_vec();
    pages.push("scan2step.1".into());
    pages.sort();
    assert_eq!(files(&path.join("new/man1")), pages);
    let page = std::fs::read_to_string(path.join("new/man1/scan2step-batch.1")).expect("a page");
    assert!(page.contains("shard") && page.contains(".SH \"EXIT STATUS\""), "{page}");
    for command in commands {
        let help = printed(&[command, "--help"]);
        assert!(help.contains(&format!("Examples:\n  scan2step {command} ")), "{help}");
        assert!(help.contains("\n\nExit codes:\n  0: "), "{help}");
    }
    for command in [&[][..], &["convert"], &["batch"]] {
        let help = printed(&[command, &["--help"]].concat());
        assert!(help.contains("\n  SOURCE_DATE_EPOCH: the time stamp"), "{help}");
    }
    // The own licences come first, then those of packages.
    let licences = printed(&["licences"]);
    let places = ["the scan2step authors", "Apache License", "\nnalgebra "];
    let places = places.map(|text| licences.find(text).expect(text));
    assert!(places.is_sorted(), "{places:?}");
    assert_eq!(printed(&["licenses"]), licences);
}

/// A page names only pages that exist, and has the usual sections.
#[test]
fn manual_pages_name_one_another() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert!(program(&["man", "pages"], folder.path()).status.success());
    let pages = folder.path().join("pages");
    let names = files(&pages);
    assert_eq!(names.len(), 8, "{names:?}");
    for name in &names {
        let page = std::fs::read_to_string(pages.join(name)).expect("a page").replace("\\-", "-");
        for section in ["NAME", "SYNOPSIS", "EXAMPLES", "\"EXIT STATUS\"", "\"SEE ALSO\""] {
            assert!(page.contains(&format!("\n.SH {section}\n")), "{section} in {page}");
        }
        assert!(!page.contains(".SH EXTRA"), "{page}");
        for other in page.split("(1)").map(|before| before.split_whitespace().last()) {
            let Some(other) = other.filter(|other| other.starts_with("scan2step")) else {
                continue;
            };
            assert!(names.contains(&format!("{other}.1")), "{name} names {other}");
        }
    }
}

/// Every option has a heading, so that a reader finds it.
#[test]
fn options_are_in_groups() {
    for command in ["convert", "inspect", "check", "batch"] {
        let output = program(&[command, "--help"], Path::new("."));
        let help = String::from_utf8(output.stdout).expect("text");
        let (_, options) = help.split_once("\nOptions:\n").expect("options");
        let (options, _) = options.split_once("\n\n").expect("a group");
        let plain = options.lines().filter(|line| line.trim_start().starts_with('-')).count();
        assert_eq!(plain, 1, "only --help: {options}");
        for heading in ["\nThe scan:\n", "\nClouds of points:\n", "\nThe run:\n"] {
            assert!(help.contains(heading), "{heading} in {help}");
        }
    }
}

/// Help fits on a terminal of 80 columns.
#[test]
fn help_fits_on_a_terminal() {
    for command in ["convert", "inspect", "check", "batch", "completions", "man"] {
        let mut run = Command::new(env!("CARGO_BIN_EXE_scan2step"));
        let output = run.args([command, "--help"]).env("COLUMNS", "80").output().expect("it runs");
        let help = String::from_utf8(output.stdout).expect("text");
        let (_, notes) = help.split_once("Examples:\n").expect("examples");
        for line in notes.lines() {
            assert!(line.chars().count() < 80, "{command}: {line}");
        }
    }
}

/// Files that are no scans are named with the reason, and so are scans that were converted earlier.
#[test]
fn what_is_left_out_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    std::fs::create_dir(path.join("scans")).expect("a folder");
    sheet(&path.join("scans/a.ply"), 1.0);
    for name in ["notes.docx", "a.step", "a.report.html"] {
        std::fs::write(path.join("scans").join(name), "").expect("a file");
    }
    let text = "Scanned by daylight.\nThe left side is 3 mm too long.\n";
    std::fs::write(path.join("scans/notes.txt"), text).expect("a file");
    let (code, said) = batch(path, &["scans", "--out", "cad"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("left out: scans/notes.docx has not the extension of a scan\n"),
        "{said}"
    );
    assert!(said.contains("left out: scans/notes.txt has no line with three numbers\n"), "{said}");
    assert_eq!(said.matches("left out: ").count(), 2, "{said}");
    let summary = json(&path.join("cad/summary.json"));
    assert_eq!(summary["left_out"].as_array().map(Vec::len), Some(2));
    assert_eq!(summary["left_out"][0]["file"], "scans/notes.docx");
    let (_, said) = batch(path, &["scans/*", "--out", "cad"]);
    assert!(said.contains("scans/a.ply (converted earlier; --force converts it again)"), "{said}");
    assert!(said.contains("left out: scans/notes.docx "), "{said}");
    std::fs::remove_file(path.join("scans/a.ply")).expect("a file");
    let (code, said) = batch(path, &["scans", "--out", "cad"]);
    assert_eq!(code, Some(1));
    assert!(said.contains("no scan found; scans/notes.docx has not the extension"), "{said}");
}

/// The options that leave out parts of scans reach the conversion.
#[test]
fn crops_hold_for_every_scan() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    std::fs::create_dir(path.join("scans")).expect("a folder");
    sheet(&path.join("scans/a.ply"), 1.0);
    let (code, said) = batch(path, &["scans", "--out", "cad", "--box", "900,900,900;901,901,901"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("help: name a --box"), "{said}");
}

/// Hints reach the terminal and the table.
#[test]
fn hints_are_shown() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path();
    std::fs::create_dir(path.join("scans")).expect("a folder");
    sheet(&path.join("scans/a.ply"), 1.0);
    let (code, said) = batch(path, &["scans", "--out", "cad", "--units", "um"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("hint: "), "{said}");
    std::fs::copy(crate::common::fixture("relief.ply"), path.join("scans/a.ply")).expect("a copy");
    let (code, said) = batch(path, &["scans", "--out", "cad", "--tolerance", "5"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("hint: the tolerance, 5.000 mm, is "), "{said}");
    let table = std::fs::read_to_string(path.join("cad/summary.csv")).expect("a summary");
    assert!(table.contains("the tolerance, 5.000 mm, is "), "{table}");
}

/// An error names the folder of the user, not a file of our own in it.
#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    sheet(&folder.path().join("a.ply"), 1.0);
    let (code, said) = batch(folder.path(), &["a.ply", "--out", "a.ply/cad"]);
    assert_eq!(code, Some(1));
    assert!(said.starts_with("error: a.ply/cad: cannot be written: "), "{said}");
    assert!(!said.contains(".scan2step"), "{said}");
}

/// The table fits on a terminal of 80 columns, and small figures keep their digits.
#[test]
fn the_table_fits_on_a_terminal() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    sheet(&folder.path().join("a.ply"), 1.0);
    let args = ["batch", "a.ply", "--out", "cad", "--units", "um"];
    let output = program(&args, folder.path());
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.lines().all(|line| line.chars().count() < 80), "{table}");
    let rms = json(&folder.path().join("cad/summary.json"))["scans"][0]["rms_mm"].as_f64();
    let rms = rms.expect("a number");
    assert!(rms > 0.0 && rms < 1e-4, "{rms}");
    assert!(table.contains(&scan2step::words::significant(rms)), "{rms} in {table}");
    assert!(table.contains(" face "), "{table}");
}
