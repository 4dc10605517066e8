//! Runs of the program in the way of a user.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use super::arg;

/// Runs `scan2step convert` with the given arguments.
pub fn convert(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    command.arg("convert").args(args).env_remove("SOURCE_DATE_EPOCH");
    command.output().expect("the program runs")
}

/// Runs `scan2step inspect` with the given arguments.
pub fn inspect(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    command.arg("inspect").args(args).output().expect("the program runs")
}

/// The output of `inspect` for a scan as JSON.
pub fn inspected(scan: &Path) -> Value {
    let output = inspect(&[arg(scan), "--json"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "inspect {}: {said}", scan.display());
    serde_json::from_slice(&output.stdout).expect("it prints JSON")
}

/// Runs `scan2step check` with the given arguments.
pub fn check(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scan2step"));
    command.arg("check").args(args).output().expect("the program runs")
}

/// The output of `check` for a CAD file and a scan as JSON.
pub fn checked(cad: &Path, scan: &Path) -> Value {
    let output = check(&[arg(cad), arg(scan), "--json"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "check {}: {said}", cad.display());
    serde_json::from_slice(&output.stdout).expect("it prints JSON")
}

/// Runs `convert`, which must succeed, and returns its messages.
pub fn converted(args: &[&str]) -> String {
    let output = convert(args);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "convert {args:?}: {said}");
    said
}
