//! Files to read, and what to expect of them.

use std::io::Cursor;
use std::path::Path;

use formats::{Error, Points, Result, read_points_from};

pub fn read(name: &str, content: impl AsRef<[u8]>) -> Result<Points> {
    read_points_from(Path::new(name), Cursor::new(content.as_ref().to_vec()))
}

/// The cloud of a file that must be readable.
#[track_caller]
pub fn cloud(name: &str, content: impl AsRef<[u8]>) -> Points {
    read(name, content).unwrap_or_else(|e| panic!("{e}"))
}

/// The error of a file that must be refused. It has help and mentions `word`.
#[track_caller]
pub fn refusal(name: &str, content: impl AsRef<[u8]>, word: &str) -> Error {
    let error = read(name, content).expect_err("should be refused");
    assert!(error.help.ends_with('.'), "no help in: {error}");
    assert!(error.to_string().contains(word), "no {word:?} in: {error}");
    error
}

/// The points with the origin added.
pub fn places(cloud: &Points) -> Vec<[f64; 3]> {
    (0..cloud.len()).map(|i| cloud.absolute(i)).collect()
}
