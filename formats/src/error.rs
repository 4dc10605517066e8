//! What can be wrong with a file, and where.

use std::fmt;
use std::path::PathBuf;

/// A result whose error names the file.
pub type Result<T> = std::result::Result<T, Error>;

/// A file that could not be read or written: which, what is wrong, where, and
/// what the user can do about it.
#[derive(Debug, thiserror::Error)]
#[error("{}: {what}{}", file.display(), at(place))]
#[non_exhaustive]
pub struct Error {
    /// The file as the user named it.
    pub file: PathBuf,
    /// What is wrong, in a few words, without the place.
    pub what: String,
    /// Where in the file, if the reader knows.
    pub place: Option<Location>,
    /// One sentence that says what to do.
    pub help: String,
}

/// A place in a file, or in what the file describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// Line of a text file, counted from 1.
    Line(u64),
    /// Byte offset, counted from 0.
    Byte(u64),
    /// Vertex as the file counts them, from 0.
    Vertex(u64),
    /// Face as the file counts them, from 0.
    Face(u64),
    /// Entity of a STEP file, by its number.
    Entity(u64),
    /// Entity of an IGES file, by the line of its directory entry.
    DirectoryEntry(u64),
    /// Another element: its kind ("accessor", "node") and index, from 0.
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

fn at(place: &Option<Location>) -> String {
    place.map(|p| format!(" ({p})")).unwrap_or_default()
}

impl Error {
    /// An error without a place.
    pub fn new(file: impl Into<PathBuf>, what: impl Into<String>, help: impl Into<String>) -> Self {
        Error { file: file.into(), what: what.into(), place: None, help: help.into() }
    }

    /// The same error, at `place`.
    #[must_use]
    pub fn at(mut self, place: Location) -> Self {
        self.place = Some(place);
        self
    }
}
