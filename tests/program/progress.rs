//! The progress that a run shows.
#![cfg(unix)]

use crate::common::face_seen;
use std::process::{Command, Stdio};

use crate::common::{arg, fixture, large_scan};
use scan2step::{Error, Options, Stage};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// The stages that report their progress.
const LONG: [&str; 4] = ["smooth", "fill", "parameterize", "fit"];

#[test]
fn long_stages_tell_how_far_they_have_come() {
    let soup = formats::read_scan(&fixture("relief.ply")).expect("a scan");
    let mut told: Vec<(&str, f64)> = Vec::new();
    face_seen(&soup, &Options::default(), &mut |stage| {
        match stage {
            Stage::Within(name, share) => told.push((name, share)),
            ended => told.push((ended.name(), f64::INFINITY)),
        }
        Ok(())
    })
    .expect("it converts");
    for name in LONG {
        let end = told.iter().position(|t| *t == (name, f64::INFINITY)).expect("it ends");
        let own: Vec<f64> = told[..end].iter().filter(|t| t.0 == name).map(|t| t.1).collect();
        assert!(own.len() >= if name == "fill" { 1 } else { 5 }, "{name}: {own:?}");
        assert!(own.is_sorted_by(|a, b| a < b), "{name}: {own:?}");
        assert!(own.iter().all(|share| (0.0..=1.0).contains(share)), "{name}: {own:?}");
        assert!(told[end..].iter().all(|t| t.0 != name || t.1.is_infinite()), "{name}: {told:?}");
    }
}

#[test]
fn a_run_can_be_stopped_within_each_long_stage() {
    let soup = formats::read_scan(&fixture("relief.ply")).expect("a scan");
    for name in LONG {
        let stopped = face_seen(&soup, &Options::default(), &mut |stage| match stage {
            Stage::Within(now, _) if now == name => Err(Error::Stopped),
            ended if ended.name() == name => panic!("{name} went on to its end"),
            _ => Ok(()),
        });
        assert!(matches!(stopped, Err(Error::Stopped)), "{name}");
    }
}

#[test]
fn a_run_can_be_stopped_after_each_stage() {
    let soup = formats::read_scan(&fixture("relief.ply")).expect("a scan");
    let options = Options::builder().threads(2).build().expect("options");
    let run = |last: usize| {
        let mut ended = Vec::new();
        let answer = face_seen(&soup, &options, &mut |stage| {
            if !matches!(stage, Stage::Within(..)) {
                ended.push(stage.name());
            }
            if ended.len() > last { Err(Error::Stopped) } else { Ok(()) }
        });
        (answer, ended)
    };
    let (answer, all) = run(usize::MAX);
    assert!(answer.is_ok());
    for last in 0..all.len() {
        let (stopped, ended) = run(last);
        assert!(matches!(stopped, Err(Error::Stopped)), "after {}", all[last]);
        assert_eq!(ended, all[..=last]);
    }
}

/// The output of a run on a terminal, by the program `script` of util-linux.
fn on_a_terminal(command: &str) -> String {
    let mut script = Command::new("script");
    script.args(["--quiet", "--return", "--command", command, "/dev/null"]);
    script.env("TERM", "xterm").stdin(Stdio::null());
    let output = script.output().expect("`script`, of the package bsdutils, is there");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn the_bar_moves_within_stages_on_a_terminal() {
    let folder = folder();
    let scan = large_scan(folder.path());
    let step = folder.path().join("a.step");
    let program = env!("CARGO_BIN_EXE_scan2step");
    let said = on_a_terminal(&format!("'{program}' convert '{}' '{}'", arg(&scan), arg(&step)));
    // The stage and the filled half cells of the bar in each frame.
    let frame = |line: &str| {
        let filled = line.matches('━').count() * 2 + line.matches('╸').count();
        let name = LONG.iter().find(|name| line.contains(&format!(" {name} ")));
        name.filter(|_| filled > 0).map(|name| (*name, filled))
    };
    let frames: Vec<(&str, usize)> = said.split(['\r', '\n']).filter_map(frame).collect();
    assert!(frames.is_sorted_by_key(|frame| frame.1), "it goes back: {frames:?}");
    for name in ["smooth", "parameterize"] {
        let mut lengths: Vec<usize> =
            frames.iter().filter(|frame| frame.0 == name).map(|frame| frame.1).collect();
        lengths.dedup();
        assert!(lengths.len() > 1, "{name} stands still: {frames:?}");
    }
    let small = fixture("relief.ply");
    let quiet = format!("'{program}' convert '{}' '{}' --quiet", arg(&small), arg(&step));
    assert_eq!(on_a_terminal(&quiet), "");
}

/// The steps among the lines of standard error of a run, and the other lines.
fn steps_of_a_run(more: &[&str]) -> (Vec<(String, f64, f64)>, Vec<String>) {
    let folder = folder();
    let (scan, step) = (fixture("relief.ply"), folder.path().join("a.step"));
    let mut run = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    run.args(["convert", arg(&scan), arg(&step), "--progress", "json"]).args(more);
    let output = run.output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stderr).expect("text");
    let (steps, other): (Vec<&str>, Vec<&str>) = said.lines().partition(|l| l.starts_with('{'));
    let read = |line: &&str| {
        let step: serde_json::Value = serde_json::from_str(line).expect("JSON");
        assert_eq!(step.as_object().map(|step| step.len()), Some(3), "{line}");
        let number = |key: &str| step[key].as_f64().expect("a number");
        (step["stage"].as_str().expect("a name").to_owned(), number("share"), number("seconds"))
    };
    (steps.iter().map(read).collect(), other.into_iter().map(str::to_owned).collect())
}

#[test]
fn steps_can_be_read_by_a_program() {
    let (steps, other) = steps_of_a_run(&["--quiet"]);
    assert_eq!(other, Vec::<String>::new());
    let mut names: Vec<&str> = steps.iter().map(|step| step.0.as_str()).collect();
    names.dedup();
    let stages = ["mesh", "smooth", "fill", "parameterize", "fit", "trim", "brep", "deviation"];
    assert_eq!(names, [&["read"][..], &stages, &["write"]].concat());
    for name in names {
        let own: Vec<_> = steps.iter().filter(|step| step.0 == name).collect();
        assert!(own.is_sorted_by(|a, b| a.1 < b.1 && a.2 <= b.2), "{own:?}");
        assert!(own.iter().all(|step| step.1 > 0.0 && step.2 >= 0.0), "{own:?}");
        assert_eq!(own.last().map(|step| step.1), Some(1.0), "{own:?}");
        assert!(own.len() > usize::from(LONG.contains(&name)), "{own:?}");
    }
    let (_, other) = steps_of_a_run(&[]);
    assert!(other.iter().any(|line| line.starts_with("tolerance:")), "{other:?}");
    assert!(!other.iter().any(|line| line.starts_with("smooth  ")), "{other:?}");
}
