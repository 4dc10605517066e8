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

/// Packed parts have checksums, so that most damage to a package is found at once. Here it is done to the XML.
#[test]
fn damaged_parts_of_3mf_are_survived() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for round in 0..100_000 {
        let (mut model, mut part) =
            (seeds::MODEL.as_bytes().to_vec(), seeds::PART.as_bytes().to_vec());
        damage(if round % 4 == 0 { &mut part } else { &mut model }, &mut random);
        let relationships = seeds::RELATIONSHIPS.as_bytes();
        let files: [(&str, &[u8]); 3] =
            [("_rels/.rels", relationships), ("3D/3dmodel.model", &model), ("3D/b.model", &part)];
        let read = seeds::survive("parts.3mf", &seeds::zip(&files));
        drop(read.unwrap_or_else(|file| panic!("{file}")));
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
