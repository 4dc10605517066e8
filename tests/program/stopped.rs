//! Stopped runs and full disks. Nothing is left behind.
#![cfg(unix)]

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{arg, convert, files, fixture, large_scan};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Starts a run that writes stages and sends it a signal after it has written some of them. Returns
/// the signal that ended it and its messages.
fn stopped(folder: &Path, signal: &str) -> (Option<i32>, String) {
    let scan = large_scan(folder);
    let path = |name: &str| folder.join(name);
    let (step, page, stages) = (path("a.step"), path("a.html"), path("new/stages"));
    // Under nohup or in the background, tests inherit that signals are ignored.
    let mut run = Command::new("env");
    run.args(["--default-signal=HUP,INT", env!("CARGO_BIN_EXE_scan2step")]);
    run.args(["convert", arg(&scan), arg(&step), "--report", arg(&page), "--stages", arg(&stages)]);
    let mut run = run.stderr(Stdio::piped()).spawn().expect("the program runs");
    let begun = Instant::now();
    while !stages.is_dir() || files(&stages).is_empty() {
        assert!(
            run.try_wait().expect("its state").is_none(),
            "it ended before it could be stopped"
        );
        assert!(begun.elapsed() < Duration::from_secs(120), "no stage after two minutes");
        std::thread::sleep(Duration::from_millis(5));
    }
    let sent = Command::new("kill").args([signal, &run.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
    let output = run.wait_with_output().expect("it ends");
    (output.status.signal(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_run_that_is_stopped_leaves_nothing_behind() {
    for (signal, number) in [("-INT", 2), ("-TERM", 15), ("-HUP", 1)] {
        let folder = folder();
        let (ended_by, said) = stopped(folder.path(), signal);
        assert_eq!(ended_by, Some(number), "{said}");
        assert!(said.contains("stopped"), "{said}");
        assert_eq!(files(folder.path()), ["large.stl"], "{signal}");
    }
}

#[test]
fn the_conversions_of_a_killed_batch_end() {
    let folder = folder();
    large_scan(folder.path());
    let out = folder.path().join("out");
    let mut run = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    run.args(["batch", arg(folder.path()), "--out", arg(&out), "--quiet"]);
    let mut run =
        run.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program runs");
    let children = format!("/proc/{0}/task/{0}/children", run.id());
    let begun = Instant::now();
    let child = loop {
        let every =
            std::fs::read_dir(format!("/proc/{}/task", run.id())).into_iter().flatten().flatten();
        let found =
            every.filter_map(|task| std::fs::read_to_string(task.path().join("children")).ok());
        if let Some(child) = found
            .flat_map(|ids| ids.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
            .next()
        {
            break child;
        }
        if !Path::new(&children).exists() {
            eprintln!("NOT TESTED: this system does not list the children of a process");
            run.kill().expect("it is killed");
            run.wait().expect("it ends");
            return;
        }
        assert!(begun.elapsed() < Duration::from_secs(120), "no conversion after two minutes");
        std::thread::sleep(Duration::from_millis(5));
    };
    run.kill().expect("it is killed");
    run.wait().expect("it ends");
    let is_alive = || {
        let state = std::fs::read_to_string(format!("/proc/{child}/stat")).unwrap_or_default();
        !state.is_empty() && !state.contains(") Z")
    };
    while is_alive() {
        assert!(begun.elapsed() < Duration::from_secs(120), "the conversion goes on");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn what_was_there_before_a_run_was_stopped_stays() {
    let folder = folder();
    std::fs::create_dir_all(folder.path().join("new/stages/mine")).expect("a folder");
    std::fs::write(folder.path().join("a.step"), "precious").expect("a file");
    let path = folder.path();
    // A file exists already, so the run is stopped as soon as it has started.
    stopped(path, "-TERM");
    assert_eq!(files(path), ["a.step", "large.stl", "new"]);
    assert_eq!(files(&path.join("new/stages")), ["mine"]);
    assert_eq!(std::fs::read_to_string(path.join("a.step")).expect("a file"), "precious");
}

/// A limit on the size of files replaces a full disk. Both end a write with an error.
#[test]
fn a_full_disk_is_an_error_and_leaves_nothing_behind() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (out, options) in [
        ("a.step", &[][..]),
        ("a.igs", &[]),
        ("b.step", &["--stages", "stages"]),
        ("c.step", &["--net", "5x5", "--report", "c.html"]),
    ] {
        let mut run = Command::new("sh");
        // The limit is in blocks of 512 bytes. If the signal is ignored, it becomes an error.
        run.args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$@\"", "sh"]);
        run.args([env!("CARGO_BIN_EXE_scan2step"), "convert", arg(&fixture("relief.ply")), out]);
        let output = run.args(options).current_dir(folder.path()).output().expect("sh runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("cannot be written: "), "{said}");
        assert!(said.contains("\nhelp: check that the folder"), "{said}");
        assert_eq!(files(folder.path()), [""; 0], "{out}: {said}");
    }
    assert!(!path("stages").exists());
}

#[test]
fn what_cannot_be_written_to_is_said_before_the_work() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("file"), "").expect("a file");
    std::fs::create_dir(path("folder.step")).expect("a folder");
    std::os::unix::fs::symlink("/dev/full", path("full.step")).expect("a link");
    let (scan, good) = (fixture("relief.ply"), path("good.step"));
    for out in ["/proc/a", "file/a", "none/a", "folder", "full"] {
        let step = path(&format!("{out}.step"));
        let page = path(&format!("{out}.html"));
        let mut cases = vec![vec![arg(&step)]];
        if out.contains('/') {
            cases.push(vec![arg(&good), "--report", arg(&page)]);
        }
        for outs in cases {
            let output = convert(&[&[arg(&scan)], &outs[..]].concat());
            let said = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{outs:?}: {said}");
            assert!(said.starts_with("error: ") && said.contains("cannot be written"), "{said}");
            assert!(said.contains("\nhelp: ") && said.lines().count() == 2, "{said}");
        }
    }
    assert_eq!(files(folder.path()), ["file", "folder.step", "full.step"]);
}

#[test]
fn a_link_to_a_file_stays_a_link() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("real.step"), "old").expect("a file");
    std::os::unix::fs::symlink("real.step", path("link.step")).expect("a link");
    let output = convert(&[arg(&fixture("relief.ply")), arg(&path("link.step"))]);
    assert!(output.status.success());
    assert!(path("link.step").is_symlink());
    let written = std::fs::read_to_string(path("real.step")).expect("a file");
    assert!(written.starts_with("ISO-10303-21"));
}

/// If standard error cannot be written, the run continues. If standard output cannot be written,
/// the run stops, unless its reader has closed it.
#[cfg(target_os = "linux")]
#[test]
fn messages_may_be_lost_and_results_may_not() {
    let folder = folder();
    let step = folder.path().join("a.step");
    let scan = fixture("relief.ply");
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").expect("it is there");
    let gone = || std::io::pipe().expect("a pipe").1;
    let run = |args: &[&str], out: Stdio, said: Stdio| {
        let mut run = Command::new(env!("CARGO_BIN_EXE_scan2step"));
        let run = run.args(args).stdout(out).stderr(said).spawn().expect("the program runs");
        let output = run.wait_with_output().expect("it ends");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let convert = ["convert", arg(&scan), arg(&step)];
    for said in [Stdio::from(full()), Stdio::from(gone())] {
        assert_eq!(run(&convert, Stdio::null(), said).0, Some(0));
    }
    let missed = ["convert", arg(&scan), arg(&step), "--tolerance", "1e-6", "--max-net", "400"];
    assert_eq!(run(&missed, Stdio::null(), gone().into()).0, Some(3));
    let none = ["convert", "none.ply", arg(&step)];
    assert_eq!(run(&none, Stdio::null(), gone().into()).0, Some(1));
    let printing: [&[&str]; 4] = [
        &["inspect", arg(&scan)],
        &["check", arg(&step), arg(&scan)],
        &["man"],
        &["completions", "bash"],
    ];
    for args in printing {
        let (code, said) = run(args, full().into(), Stdio::piped());
        assert_eq!(code, Some(1), "{args:?}: {said}");
        assert!(said.starts_with("error: stdout: cannot be written: "), "{said}");
        let (code, said) = run(args, gone().into(), Stdio::piped());
        assert_eq!((code, said.as_str()), (Some(0), ""), "{args:?}");
    }
}
