//! Damage: no reader may panic, break what a cloud promises, or misread a file
//! that was cut.

use std::panic::{AssertUnwindSafe, catch_unwind};

use formats::{Points, Result};

use crate::seeds;
use crate::seeds::surveys::{with_checksums, without_checksums};
use damage::{Random, damage};

#[path = "../read/mutations/damage.rs"]
mod damage;

/// How often each file is damaged. `POINT_ROUNDS` in the environment raises it.
const ROUNDS: usize = 10_000;

/// Reads a file, and tells its bytes if that panics.
fn survive(name: &str, content: &[u8]) -> Result<Points> {
    let read = catch_unwind(AssertUnwindSafe(|| seeds::read_soundly(name, content)));
    read.unwrap_or_else(|_| panic!("{name}: {}", content.escape_ascii()))
}

#[test]
fn seeds_can_be_read() {
    for (name, content) in seeds::all() {
        seeds::read_soundly(name, &content).unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn files_cut_at_any_byte_give_what_they_hold_or_an_error() {
    for (name, content) in seeds::all() {
        let whole = survive(name, &content).expect("a sound file");
        let mut errors = 0;
        for end in 0..content.len() {
            match survive(name, &content[..end]) {
                Ok(part) => check_part(name, end, &part, &whole),
                Err(error) => {
                    assert!(!error.what.is_empty() && error.help.ends_with('.'), "{error}");
                    errors += 1;
                }
            }
        }
        assert!(errors > 0, "{name} can be cut anywhere");
    }
}

/// Every point of a cut file but the last is a point of the whole one. (A text
/// without a count may end in a number that has lost its last digits.)
fn check_part(name: &str, end: usize, part: &Points, whole: &Points) {
    assert!(part.len() <= whole.len(), "{name} at {end}");
    let sure = part.len().saturating_sub(1);
    for i in 0..sure {
        assert_eq!(part.absolute(i), whole.absolute(i), "{name} at {end}, point {i}");
    }
}

/// Numbers that headers like to lie with.
const LIES: [&str; 7] =
    ["0", "1", "2147483648", "4294967295", "9223372036854775808", "18446744073709551615", "-1"];

#[test]
fn numbers_that_lie_are_survived() {
    for (name, content) in seeds::all() {
        let mut at = 0;
        while at < content.len() {
            let digits = content[at..].iter().take_while(|b| b.is_ascii_digit()).count();
            for lie in LIES.iter().filter(|_| digits > 0) {
                let file = [&content[..at], lie.as_bytes(), &content[at + digits..]].concat();
                drop(survive(name, &file));
            }
            at += digits + 1;
        }
    }
}

/// The same for headers of bytes.
#[test]
fn bytes_that_lie_are_survived() {
    const SHORT: [u32; 4] = [0, 1, 1 << 31, u32::MAX];
    const LONG: [u64; 3] = [1 << 40, 1 << 63, u64::MAX];
    for (name, content) in seeds::all() {
        if !is_survey(name) {
            continue;
        }
        // Within the points, every fourth place is enough.
        for at in (0..content.len() - 8).filter(|at| *at < 500 || at % 4 == 0) {
            let lies = SHORT.map(|lie| lie.to_le_bytes().to_vec()).into_iter();
            for lie in lies.chain(LONG.map(|lie| lie.to_le_bytes().to_vec())) {
                let mut file = content.clone();
                file.splice(at..at + lie.len(), lie);
                drop(survive(name, &resealed(name, file)));
            }
        }
    }
}

#[test]
fn numbers_in_e57_that_lie_are_survived() {
    let content = without_checksums(&seeds::surveys::e57());
    let xml = content.windows(5).position(|word| word == b"<?xml").expect("a description");
    let mut at = xml;
    while at < content.len() {
        let digits = content[at..].iter().take_while(|b| b.is_ascii_digit()).count();
        for lie in LIES.iter().chain(&["nan", "1e999"]).filter(|_| digits > 0) {
            let mut file = [&content[..at], lie.as_bytes(), &content[at + digits..]].concat();
            let length = u64::from_le_bytes(content[32..40].try_into().expect("a length"));
            let length = length + lie.len() as u64 - digits as u64;
            file[32..40].copy_from_slice(&length.to_le_bytes());
            drop(survive("lie.e57", &with_checksums(&file)));
        }
        at += digits + 1;
    }
}

/// Whether a seed is of a format of bytes with a header of numbers.
fn is_survey(name: &str) -> bool {
    ["e57", "las", "laz"].iter().any(|end| name.ends_with(end))
}

/// A damaged file. E57 gets new checksums, because otherwise nothing would be read.
fn resealed(name: &str, file: Vec<u8>) -> Vec<u8> {
    match name.ends_with("e57") {
        true => with_checksums(&without_checksums(&file)),
        false => file,
    }
}

#[test]
fn random_damage_is_survived() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for (name, good) in seeds::all() {
        let rounds = std::env::var("POINT_ROUNDS").ok().and_then(|rounds| rounds.parse().ok());
        let is_e57 = name.ends_with("e57");
        for _ in 0..rounds.unwrap_or(ROUNDS) {
            let mut file = if is_e57 { without_checksums(&good) } else { good.clone() };
            damage(&mut file, &mut random);
            let file = if is_e57 { with_checksums(&file) } else { file };
            drop(survive(name, &file));
        }
    }
}
