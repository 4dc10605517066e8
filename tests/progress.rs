//! The progress that a run shows.
#![cfg(unix)]

mod common;

use std::process::{Command, Stdio};

use common::{arg, fixture, large_scan};
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
    scan2step::convert(&soup, &Options::default(), &mut |stage| {
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
        let stopped = scan2step::convert(&soup, &Options::default(), &mut |stage| match stage {
            Stage::Within(now, _) if now == name => Err(Error::Input("enough")),
            ended if ended.name() == name => panic!("{name} went on to its end"),
            _ => Ok(()),
        });
        assert!(matches!(stopped, Err(Error::Input("enough"))), "{name}");
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
