//! The examples for users of the library, run in the way of a user.

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::{arg, fixture, root};

/// Builds an example with the features of this test and runs it, because an example in the target folder
/// may be older than the library. `SCAN2STEP_EXAMPLES` is a folder of examples that were just built: `tests/run`
/// sets it, since cargo would build the library and its dependencies again, without the features that
/// the Python package asks for.
fn run(name: &str, args: &[&str]) -> Output {
    if let Some(folder) = std::env::var_os("SCAN2STEP_EXAMPLES") {
        let mut command = Command::new(Path::new(&folder).join(name));
        return command.args(args).current_dir(root()).output().expect("the example runs");
    }
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["run", "--quiet", "--example", name]).current_dir(root());
    if !cfg!(debug_assertions) {
        command.arg("--release");
    }
    if !cfg!(feature = "cli") {
        command.arg("--no-default-features");
    }
    command.arg("--").args(args).output().expect("cargo runs")
}

/// The same. The example must succeed. Returns its output.
fn printed(name: &str, args: &[&str]) -> String {
    let output = run(name, args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name} {args:?}: {said}");
    String::from_utf8(output.stdout).expect("text")
}

/// The number after some words.
fn after(text: &str, words: &str) -> f64 {
    let rest = text.split(words).nth(1).unwrap_or_else(|| panic!("no '{words}' in {text}"));
    rest.split_whitespace().next().unwrap_or_default().parse().expect("a number")
}

fn starts_a_step_file(path: &Path) -> bool {
    std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"ISO-10303-21;"))
}

#[test]
fn a_scan_converts_and_its_deviation_is_measured() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (scan, step) = (fixture("relief.ply"), folder.path().join("relief.step"));
    let said = printed("convert", &[arg(&scan), arg(&step), "0.2"]);
    assert!(said.ends_with("within tolerance: true\n"), "{said}");
    assert!(starts_a_step_file(&step));
    // The deviation of the file is the one that the conversion has printed.
    let found = printed("deviation", &[arg(&step), arg(&scan)]);
    assert!((after(&found, "scan to face: rms ") - after(&said, "rms ")).abs() < 1e-3, "{found}");
    assert!(found.starts_with("1 face, 3 loops"), "two holes and the outer one: {found}");
}

#[test]
fn an_example_says_what_is_wrong_with_a_tolerance() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (scan, step) = (fixture("relief.ply"), folder.path().join("relief.step"));
    let output = run("convert", &[arg(&scan), arg(&step), "-0.2"]);
    assert!(!output.status.success() && !step.exists());
    assert!(String::from_utf8_lossy(&output.stderr).contains("Length"), "{output:?}");
}

#[test]
fn a_mesh_of_ones_own_goes_stage_by_stage() {
    let said = printed("stages", &[]);
    let names: Vec<&str> = said.lines().filter_map(|line| line.split(':').next()).collect();
    let stages = ["mesh", "smooth", "fill", "parameterize", "fit", "trim", "write", "deviation"];
    assert_eq!(names, stages, "{said}");
}

#[test]
fn a_solid_of_truck_becomes_a_file() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [step, iges] = ["angle.step", "angle.igs"].map(|name| folder.path().join(name));
    let said = printed("solid", &[arg(&step), arg(&iges)]);
    // 40 × 5 mm and 25 × 5 mm, 50 mm long.
    assert!(said.starts_with("8 faces, 16250.000 mm³\n"), "{said}");
    assert_eq!(said.lines().filter(|line| line.starts_with("a face through")).count(), 8);
    assert!(starts_a_step_file(&step) && iges.exists());
}

#[test]
fn every_piece_gets_a_file_or_a_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut text = String::new();
    for k in 0..144 {
        let (x, y) = (f64::from(k % 12), f64::from(k / 12));
        text += &format!("v {x} {y} {}\n", 0.3 * (0.5 * x).sin());
    }
    for k in 0..121 {
        let a = 1 + k / 11 * 12 + k % 11;
        text += &format!("f {a} {} {} {}\n", a + 1, a + 13, a + 12);
    }
    // A Möbius strip, which has only one side.
    let n = 16;
    for k in 0..n {
        let angle = f64::from(k) / f64::from(n) * std::f64::consts::TAU;
        for t in [-1.0, 1.0] {
            let r = 5.0 + t * (angle / 2.0).cos();
            let (x, y) = (30.0 + r * angle.cos(), r * angle.sin());
            text += &format!("v {x} {y} {}\n", t * (angle / 2.0).sin());
        }
    }
    for k in 0..n {
        let (a, b) = (145 + 2 * k, 146 + 2 * k);
        let [c, d] = if k + 1 < n { [a + 2, b + 2] } else { [146, 145] };
        text += &format!("f {a} {c} {d} {b}\n");
    }
    let scan = folder.path().join("two.obj");
    std::fs::write(&scan, text).expect("a file");
    let said = printed("pieces", &[arg(&scan), arg(folder.path())]);
    assert!(said.contains("piece 0: rms"), "{said}");
    assert!(said.contains("piece 1: the surface is one-sided"), "{said}");
    assert!(starts_a_step_file(&folder.path().join("piece-0.step")));
    assert!(!folder.path().join("piece-1.step").exists());
}
