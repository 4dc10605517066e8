//! The error type of the readers and writers: a file, its fault, and the place in the file.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::words::printable;

/// A result with an [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// An error of reading or writing a file. It says which file, what is wrong, at which place, and
/// what the user can do about it.
#[derive(Debug, thiserror::Error)]
#[error("{}: {}{}", shown(file), printable(what), at(place))]
#[non_exhaustive]
pub struct Error {
    /// The path of the file as the user gave it.
    pub file: PathBuf,
    /// What is wrong, in a few words and without the place.
    pub what: String,
    /// The place in the file, if the reader knows it.
    pub place: Option<Location>,
    /// One sentence that tells the user what to do.
    pub help: String,
}

/// A place in a file or in the model that the file describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// A line of a text file, counted from 1.
    Line(u64),
    /// A byte offset, counted from 0.
    Byte(u64),
    /// A vertex in the order of the file, counted from 0.
    Vertex(u64),
    /// A face in the order of the file, counted from 0.
    Face(u64),
    /// The number of an entity instance in a STEP file.
    Entity(u64),
    /// The line of an entity's directory entry in an IGES file.
    DirectoryEntry(u64),
    /// Another element: its kind, for example "accessor" or "node", and its index, counted from 0.
    Element(&'static str, u64),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::Line(n) => write!(f, "line {n}"),
            Location::Byte(n) => write!(f, "byte {n}"),
            Location::Vertex(n) => write!(f, "vertex {n}"),
            Location::Face(n) => write!(f, "face {n}"),
            Location::Entity(n) => write!(f, "#{n}"),
            Location::DirectoryEntry(n) => write!(f, "directory entry {n}"),
            Location::Element(kind, n) => write!(f, "{kind} {n}"),
        }
    }
}

/// A path as messages show it.
fn shown(file: &Path) -> String {
    printable(&file.to_string_lossy()).into_owned()
}

fn at(place: &Option<Location>) -> String {
    place.map(|p| format!(" ({p})")).unwrap_or_default()
}

impl Error {
    /// Creates an error without a place.
    pub fn new(file: impl Into<PathBuf>, what: impl Into<String>, help: impl Into<String>) -> Self {
        Error { file: file.into(), what: what.into(), place: None, help: help.into() }
    }

    /// The same error with the place `place`.
    #[must_use]
    pub fn at(mut self, place: Location) -> Self {
        self.place = Some(place);
        self
    }
}
