//! Damage: no reader may panic, break what a cloud promises, or misread a file
//! that was cut.

use std::panic::{AssertUnwindSafe, catch_unwind};

use formats::{Points, Result};

use crate::seeds;
use damage::{Random, damage};

#[path = "../read/mutations/damage.rs"]
mod damage;

/// How often each file is damaged.
const ROUNDS: usize = 5_000;

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

#[test]
fn random_damage_is_survived() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for (name, good) in seeds::all() {
        for _ in 0..ROUNDS {
            let mut file = good.clone();
            damage(&mut file, &mut random);
            drop(survive(name, &file));
        }
    }
}
