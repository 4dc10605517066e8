//! Scans from standard input, and files to standard output.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::common::{arg, converted, files, fixture};

/// Runs the program in a folder with this standard input.
fn run(folder: &Path, args: &[&str], input: &[u8]) -> Output {
    let mut run = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    run.args(args).current_dir(folder).env_remove("SOURCE_DATE_EPOCH");
    run.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut run = run.spawn().expect("the program runs");
    let mut to = run.stdin.take().expect("a pipe");
    let input = input.to_vec();
    // The program may refuse its arguments and read nothing.
    let writer = std::thread::spawn(move || to.write_all(&input));
    let output = run.wait_with_output().expect("it ends");
    let _ = writer.join().expect("no panic");
    output
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A scan that is called as standard input is, so that its outputs have the same bytes.
fn named_stdin(folder: &Path) -> Vec<u8> {
    let scan = read(&fixture("relief.ply"));
    std::fs::write(folder.join("stdin.ply"), &scan).expect("a file");
    scan
}

#[test]
fn a_pipe_gives_the_bytes_of_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = named_stdin(folder.path());
    let path = |name: &str| folder.path().join(name);
    converted(&[arg(&path("stdin.ply")), arg(&path("stdin.step")), arg(&path("stdin.igs"))]);
    for (args, file) in [
        (&["convert", "-"][..], "stdin.step"),
        (&["convert", "-", "-", "--to", "step"], "stdin.step"),
        (&["convert", "-", "--to", "iges"], "stdin.igs"),
        (&["convert", "stdin.ply", "-"], "stdin.step"),
    ] {
        let output = run(folder.path(), args, &scan);
        assert!(output.status.success(), "{args:?}: {}", said(&output));
        assert!(output.stdout == read(&path(file)), "{args:?}");
        assert!(said(&output).contains("2 holes cut out → stdout\n"), "{}", said(&output));
    }
    assert_eq!(files(folder.path()), ["stdin.igs", "stdin.ply", "stdin.step"]);
}

#[test]
fn the_format_names_the_output_where_no_extension_does() {
    let folder = tempfile::tempdir().expect("a folder");
    named_stdin(folder.path());
    let output = run(folder.path(), &["convert", "stdin.ply", "--to", "iges", "--quiet"], b"");
    assert!(output.status.success() && output.stdout.is_empty(), "{}", said(&output));
    assert_eq!(files(folder.path()), ["stdin.igs", "stdin.ply"]);
}

#[test]
fn a_report_goes_to_standard_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = read(&fixture("relief.ply"));
    let output = run(folder.path(), &["convert", "-", "a.step", "--report", "-"], &scan);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["input"]["file"], "stdin");
    assert_eq!(report["outputs"][0]["file"], "a.step");
    let step = std::fs::read_to_string(folder.path().join("a.step")).expect("a file");
    assert!(step.contains("PRODUCT('a'"), "the part has the name of the file");
    assert!(said(&output).contains("cut out → a.step, stdout\n"), "{}", said(&output));
}

/// The content alone tells the format, and whether it is gzipped.
#[test]
fn every_format_is_recognized_by_its_content() {
    let folder = tempfile::tempdir().expect("a folder");
    let stl = crate::common::large_scan(folder.path());
    for (scan, counts) in [
        (fixture("relief.ply"), "4000 vertices"),
        (fixture("relief.xyz"), "4000 points"),
        (fixture("ring.obj"), "2560 vertices"),
        (stl, "2160000 vertices"),
    ] {
        let output = run(folder.path(), &["inspect", "-"], &read(&scan));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let begins = text.strip_prefix("stdin\n  file        ");
        assert!(
            begins.is_some_and(|t| t.replace(',', "").starts_with(counts)),
            "{text}{}",
            said(&output)
        );
    }
}

#[test]
fn check_takes_either_file_from_a_pipe() {
    let folder = tempfile::tempdir().expect("a folder");
    let step = folder.path().join("a.step");
    let scan = fixture("relief.ply");
    converted(&[arg(&scan), arg(&step)]);
    let figures = |args: &[&str], input: &[u8]| {
        let output = run(folder.path(), args, input);
        assert!(output.status.success(), "{}", said(&output));
        let all: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        (all["scan_to_face"].clone(), all["face_to_scan"].clone())
    };
    let of_files = figures(&["check", "a.step", arg(&scan), "--json"], b"");
    assert_eq!(figures(&["check", "-", arg(&scan), "--json"], &read(&step)), of_files);
    assert_eq!(figures(&["check", "a.step", "-", "--json"], &read(&scan)), of_files);
}

#[test]
fn a_dash_that_makes_no_sense_is_refused_in_words() {
    let folder = tempfile::tempdir().expect("a folder");
    for (args, code, wrong) in [
        (&["check", "-", "-"][..], 2, "stdin: cannot be both the CAD file and the scan"),
        (&["batch", "-", "--out", "cad"], 2, "batch: reads and writes folders and files, not -"),
        (&["batch", ".", "--out", "-"], 2, "batch: reads and writes folders and files, not -"),
        (&["convert", "-", "--stages", "-"], 2, "--stages: needs a folder, not -"),
        (&["convert", "-", "a.step", "--to", "iges"], 2, "--to: every output has the extension"),
        (&["convert", "-", "--report", "-"], 1, "stdout: is named twice"),
        (&["convert", "-", "-", "-"], 1, "stdout: is named twice"),
        (&["convert", "-"], 1, "stdin: is empty"),
        (&["inspect", "-"], 1, "stdin: is empty"),
        (&["check", "-", "none.ply"], 1, "stdin: is empty"),
    ] {
        let output = run(folder.path(), args, b"");
        let said = said(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
        assert!(said.contains(&format!("error: {wrong}")) && said.contains("help: "), "{said}");
        assert!(output.stdout.is_empty() && files(folder.path()).is_empty(), "{args:?}");
    }
}

/// A run that fails writes nothing, also to standard output.
#[test]
fn a_failed_run_prints_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let scan = read(&fixture("relief.ply"));
    let args = ["convert", "-", "-", "--report", "none/a.html"];
    let output = run(folder.path(), &args, &scan);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(output.stdout.is_empty());
    let output = run(folder.path(), &["convert", "-"], &scan[..scan.len() / 2]);
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(output.stdout.is_empty());
    assert!(said(&output).contains("error: stdin: "), "{}", said(&output));
}

/// The reader of a pipe may have read enough before the end.
#[test]
fn a_closed_pipe_is_no_failure() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut convert = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    convert.args(["convert", arg(&fixture("relief.ply")), "-"]).current_dir(folder.path());
    let closed = std::io::pipe().expect("a pipe").1;
    let output = convert.stdout(closed).stderr(Stdio::piped()).spawn();
    let output = output.and_then(std::process::Child::wait_with_output).expect("it ends");
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(!said(&output).contains("panicked"), "{}", said(&output));
}

/// Ctrl-C ends a run whose scan does not come.
#[cfg(unix)]
#[test]
fn a_run_that_waits_for_its_scan_can_be_stopped() {
    use std::os::unix::process::ExitStatusExt;
    let folder = tempfile::tempdir().expect("a folder");
    // A program that a shell runs in the background may have to ignore the signal.
    let mut run = Command::new("env");
    run.args(["--default-signal=INT", env!("CARGO_BIN_EXE_scan2step"), "convert", "-", "a.step"]);
    run.current_dir(folder.path());
    let run = run.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut run = run.expect("the program runs");
    let open = run.stdin.take();
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert!(run.try_wait().expect("a status").is_none(), "it waits");
    let sent = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    let output = run.wait_with_output().expect("it ends");
    assert_eq!(output.status.signal(), Some(2), "{}", said(&output));
    assert!(files(folder.path()).is_empty());
    drop(open);
}
