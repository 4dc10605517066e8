//! The options of the program with arbitrary text as values.

use std::process::Command;

use proptest::prelude::*;

use crate::common::virtual_scan::{VirtualScan, relief};
use crate::{runner, tell};

const OPTIONS: [&str; 16] = [
    "--tolerance",
    "--outliers",
    "--smooth",
    "--kappa",
    "--depth",
    "--net",
    "--max-net",
    "--fill-only-holes-below",
    "--component",
    "--outer",
    "--corners",
    "--boundary-corners",
    "--threads",
    "--max-memory",
    "--units",
    "--outline",
];

/// Numbers, lists and words. None of them asks for a net that needs the memory of the whole
/// machine.
const VALUES: [&str; 36] = [
    "",
    " ",
    "-",
    "0",
    "-0",
    "1",
    "4",
    "-1",
    "20",
    "1.5",
    "1e-300",
    "5e-324",
    "1e300",
    "1e999",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "0x10",
    "１",
    "99999999999999999999999",
    "4x4",
    "3x9",
    "90x70",
    "4x",
    "x",
    "99999999999x99999999999",
    "0,1,2,3",
    "0,0,0,0",
    "0,9,109,119",
    "7,7",
    "1,2,3;4,5,6",
    "1e300,0,0;-1e300,0,0;0,1e300,0;0,-1e300,0",
    "nan,0,0",
    "none",
    "off",
];

#[test]
fn any_value_for_any_option() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scan = VirtualScan::new(relief, [12, 10], 0.05, vec![], 7);
    let file = std::fs::File::create(folder.path().join("a.ply"));
    scan.write_ply(&mut file.expect("a file")).expect("a scan");
    let typed = (prop::sample::select(&OPTIONS[..]), prop::sample::select(&VALUES[..]));
    let done = std::cell::Cell::new(0);
    let held = runner(150).run(&prop::collection::vec(typed, 1..3), |typed| {
        let mut run = Command::new(env!("CARGO_BIN_EXE_scan2step"));
        run.args(["convert", "a.ply", "a.step", "--quiet"]).current_dir(folder.path());
        // A net without a bound takes seconds to miss an extremely small tolerance.
        if typed.iter().all(|(option, _)| *option != "--max-net") {
            run.args(["--max-net", "2000"]);
        }
        run.args(typed.iter().flat_map(|(option, value)| [option, value]));
        let output = run.output().expect("the program runs");
        let said = String::from_utf8_lossy(&output.stderr);
        prop_assert!(matches!(output.status.code(), Some(0..=3)), "{}: {}", output.status, said);
        done.set(done.get() + u32::from(output.status.success()));
        let told = said.starts_with("error: ") || said.starts_with("tolerance not met: ");
        prop_assert!(output.status.success() || told, "{}", said);
        Ok(())
    });
    held.unwrap_or_else(tell);
    assert!(done.get() > 0, "everything was refused");
    println!("{} were done", done.get());
}
