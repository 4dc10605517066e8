//! Files to read, and their expected results.

use std::fs;
use std::path::{Path, PathBuf};

use formats::{Error, Result, Soup, read_scan};
use tempfile::TempDir;

pub use crate::seeds::gzip;

/// A folder with one file.
pub struct Case {
    _folder: TempDir,
    pub path: PathBuf,
}

pub fn case(name: &str, content: impl AsRef<[u8]>) -> Case {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join(name);
    fs::write(&path, content).expect("a file for the test");
    Case { _folder: folder, path }
}

pub fn read(name: &str, content: impl AsRef<[u8]>) -> Result<Soup> {
    read_scan(&case(name, content).path)
}

/// The soup of a file that must be readable.
#[track_caller]
pub fn soup(name: &str, content: impl AsRef<[u8]>) -> Soup {
    read(name, content).unwrap_or_else(|e| panic!("{e}"))
}

/// The error of a file that must be refused. It has help and mentions `word`.
#[track_caller]
pub fn refusal(name: &str, content: impl AsRef<[u8]>, word: &str) -> Error {
    refused(read(name, content), word)
}

#[track_caller]
pub fn refused(result: Result<Soup>, word: &str) -> Error {
    let error = result.expect_err("should be refused");
    assert!(error.help.ends_with('.'), "no help in: {error}");
    assert!(error.to_string().contains(word), "no {word:?} in: {error}");
    error
}

pub fn polygons(soup: &Soup) -> Vec<Vec<u32>> {
    soup.polygons.iter().map(<[u32]>::to_vec).collect()
}

/// The triangles after each polygon is divided into a fan.
pub fn triangles(soup: &Soup) -> usize {
    soup.polygons.iter().map(|p| p.len() - 2).sum()
}

/// The folder of collected scans, if it is beside this checkout.
pub fn scans() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scans");
    folder.join("INDEX.tsv").is_file().then_some(folder)
}
