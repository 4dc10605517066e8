//! Code that the tests share: virtual scans, the program, the importers.
//!
//! No test uses all of it.
#![allow(dead_code, unused_imports)]

mod body;
pub mod importers;
mod plate;
#[cfg(feature = "cli")]
mod program;
pub mod random;
pub mod virtual_cloud;
pub mod virtual_scan;

use std::path::{Path, PathBuf};

pub use body::*;
pub use plate::plate;
#[cfg(feature = "cli")]
pub use program::*;
use serde_json::Value;

/// The folder of the project.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A file in `fixtures/`.
pub fn fixture(name: &str) -> PathBuf {
    root().join("fixtures").join(name)
}

/// A path as an argument.
pub fn arg(path: &Path) -> &str {
    path.to_str().expect("test paths are Unicode")
}

/// Reads a JSON file.
pub fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).expect("the report was written");
    serde_json::from_str(&text).expect("the report is JSON")
}

/// Asserts that a report is as the schema has it.
pub fn assert_schema(report: &Value) {
    let schema = json(&root().join("docs/report.schema.json"));
    let schema = jsonschema::draft202012::new(&schema).expect("the schema is one");
    let faults: Vec<String> = schema.iter_errors(report).map(|e| e.to_string()).collect();
    assert!(faults.is_empty(), "{faults:?} in {report:#}");
}

/// A file name that would be a program if it were not text.
pub const PLANTED: &str = "<img src=x onerror=planted=1>&\"'<script>planted=1<.ply";

/// Writes a wavy sheet of 720,000 triangles with noise to a folder.
pub fn large_scan(folder: &Path) -> PathBuf {
    let scan = folder.join("large.stl");
    let side = 600_u32;
    let at = |i: u32, j: u32| {
        let (x, y) = (0.1 * i as f32, 0.1 * j as f32);
        // Without noise, smoothing would have nothing to do.
        let mixed =
            (i.wrapping_mul(0x9E37_79B1) ^ j.wrapping_mul(0x85EB_CA77)).wrapping_mul(0x2C1B_3C6D);
        let noise = ((mixed ^ mixed >> 15).wrapping_mul(0x297A_2D39) >> 20) as f32 / 4096.0;
        [x, y, (0.3 * x).sin() + (0.2 * y).cos() + 0.02 * noise]
    };
    let mut bytes = vec![0; 80];
    bytes.extend((2 * side * side).to_le_bytes());
    for k in 0..side * side {
        let (i, j) = (k / side, k % side);
        let [a, b] = [at(i, j), at(i + 1, j + 1)];
        for t in [[a, at(i + 1, j), b], [a, b, at(i, j + 1)]] {
            bytes.extend([0; 12]);
            t.as_flattened().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
    }
    std::fs::write(&scan, bytes).expect("a file");
    scan
}

/// The sorted names of the files in a folder.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let name = |e: std::io::Result<std::fs::DirEntry>| {
        e.expect("an entry").file_name().to_string_lossy().into_owned()
    };
    let mut names: Vec<String> = entries.map(name).collect();
    names.sort();
    names
}

/// A number of a JSON value by its pointer.
pub fn number(value: &Value, pointer: &str) -> f64 {
    let found = value.pointer(pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number at {pointer} in {value}"))
}

/// The points of a PLY file.
pub fn points(path: &Path) -> Vec<[f64; 3]> {
    formats::read_scan(path).expect("the stage is a readable PLY").points
}

/// The folder of scans that are not part of the project, if it is present.
pub fn shared(path: &str) -> Option<PathBuf> {
    let found = root().join("../shared").join(path);
    if !found.exists() {
        eprintln!("NOT TESTED: {} is absent; it is not part of the project", found.display());
        return None;
    }
    Some(found)
}

/// What a file holds that gzip has packed.
pub fn unpacked(packed: &Path) -> Vec<u8> {
    std::process::Command::new("gzip").arg("-dc").arg(packed).output().expect("gzip runs").stdout
}
