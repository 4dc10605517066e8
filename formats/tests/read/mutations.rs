//! Random damage: no reader may panic. The fuzzers (`formats/fuzz`) search further, and the files
//! that they found are read here.

use std::fs;
use std::path::Path;

use crate::seeds;
use damage::{Random, damage};

mod damage;

/// The number of times that each file is damaged.
const ROUNDS: usize = 20_000;

#[test]
fn seeds_can_be_read() {
    for (name, content) in seeds::all() {
        seeds::read_soundly(name, &content).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn damaged_files_are_survived() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for (name, good) in seeds::all() {
        for _ in 0..ROUNDS {
            let mut file = good.clone();
            damage(&mut file, &mut random);
            let read = seeds::survive(name, &file);
            drop(read.unwrap_or_else(|file| panic!("{file}")));
        }
    }
}

/// Each file in `crashes` has broken a reader. The extension names the format.
#[test]
fn old_crashes_are_survived() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read/crashes");
    for entry in fs::read_dir(folder).expect("the crashes") {
        let path = entry.expect("a crash").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        if name != "README.md" {
            let read = seeds::survive(&name, &fs::read(&path).expect("a crash"));
            drop(read.unwrap_or_else(|file| panic!("{file}")));
        }
    }
}
