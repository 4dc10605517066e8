//! Random damage: no reader may panic, whatever it makes of it. The fuzzers
//! (`formats/fuzz`) look further; what they found is replayed here.

use std::fs;
use std::path::Path;

use crate::seeds;

/// How often each file is damaged.
const ROUNDS: usize = 20_000;

/// Marsaglia's xorshift64.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end.max(1) as u64) as usize
    }
}

/// Bytes that mean something to some format.
const TELLING: &[u8] = b"\0\x01\x7f\x80\xff\n\r \t-+.0159eEvf/#\\\"{}[],:";

fn damage(file: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(4) {
        let at = random.below(file.len());
        let byte = TELLING[random.below(TELLING.len())];
        match (random.below(6), file.get_mut(at)) {
            (0, Some(old)) => *old ^= 1 << random.below(8),
            (1 | 2, Some(old)) => *old = byte,
            (3, Some(_)) => drop(file.remove(at)),
            (4, _) => file.insert(at, byte),
            (_, Some(_)) if random.below(4) == 0 => file.truncate(at),
            // A piece of the file once more, elsewhere.
            _ => {
                let end = file.len().min(at + random.below(24));
                let piece = file[at..end].to_vec();
                let to = random.below(file.len());
                file.splice(to..to, piece);
            }
        }
    }
}

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

/// Each file in `crashes` once broke a reader; its extension names the format.
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
