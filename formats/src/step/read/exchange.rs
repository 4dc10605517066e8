//! Reader of the exchange structure of ISO 10303-21: an index of the entity instances. Each
//! instance is parsed when it is needed.
//!
//! The crate ruststep 0.4 is not used. It refuses apostrophes in strings, names line 8 for every
//! error, and takes 4.3 s of CPU time and 830 MB of memory for a file of 105 MB. The index takes
//! 0.2 s, and 20 MB in addition to the file.

use std::cell::Cell;
use std::path::Path;

use super::value::{Cursor, SimpleRecord};
use crate::{Error, Location, Result};

/// The advice for a file that is damaged or is not a STEP file.
pub(super) const EXPORT_AGAIN: &str =
    "The file is damaged or was cut short: copy it or export it again.";

/// A file in memory and the positions of its entity instances.
pub(super) struct Exchange<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// The number of each entity instance and the position of its value, in ascending order of the
    /// numbers.
    index: Vec<(u64, usize)>,
    /// The number of parts that may still be read. The limit keeps the size of the model in
    /// proportion to its file even if many entities refer to the same parts.
    budget: Cell<usize>,
    /// The number of bytes that may still be parsed. The limit keeps the time in proportion to the file even if
    /// many entities refer to the same long ones.
    work: Cell<usize>,
}

/// A byte is parsed so many times at most. Entities that many others refer to, as directions are, have 50 bytes, and
/// a reference to one has at least three. Parsing goes over an entity up to three times.
const PARSINGS: usize = 100;

/// An entity instance. A simple one has one record, and a complex one has several.
pub(super) struct Instance<'a> {
    pub(super) id: u64,
    pub(super) records: Vec<SimpleRecord<'a>>,
}

impl<'a> Exchange<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Result<Self> {
        let mut file = Exchange {
            path,
            bytes,
            index: Vec::new(),
            budget: Cell::new(bytes.len()),
            work: Cell::new(PARSINGS.saturating_mul(bytes.len())),
        };
        let mut cursor = Cursor::new(bytes);
        cursor.skip_blank();
        if !cursor.take(b"ISO-10303-21") {
            return Err(file.damaged(cursor.at, "does not begin with ISO-10303-21"));
        }
        file.end_statement(&mut cursor)?;
        loop {
            cursor.skip_blank();
            let begin = cursor.at;
            if cursor.take(b"#") {
                let id = cursor
                    .digits()
                    .ok_or(())
                    .map_err(|()| file.damaged(begin, "an entity without a number"))?;
                cursor.skip_blank();
                if !cursor.take(b"=") {
                    return Err(file.damaged(begin, format!("#{id} without =")));
                }
                cursor.skip_blank();
                file.index.push((id, cursor.at));
            } else if cursor.take(b"END-ISO-10303-21") {
                break;
            }
            file.end_statement(&mut cursor)?;
        }
        if !file.index.is_sorted() {
            file.index.sort_unstable();
        }
        if let Some(twice) = file.index.windows(2).find(|w| w[0].0 == w[1].0) {
            let what = format!("#{} is defined twice", twice[1].0);
            return Err(file.damaged(twice[1].1, what));
        }
        Ok(file)
    }

    fn end_statement(&self, cursor: &mut Cursor) -> Result<()> {
        let begin = cursor.at;
        if cursor.skip_statement() {
            return Ok(());
        }
        let at = if begin < self.bytes.len() { begin } else { self.bytes.len() };
        Err(self.damaged(at, "is incomplete: the text that begins here has no end"))
    }

    /// The entity instances of which some keyword is `wanted`.
    pub(super) fn all(&self, wanted: impl Fn(&str) -> bool) -> impl Iterator<Item = u64> {
        let is = move |at: usize| Cursor { bytes: self.bytes, at }.has_keyword(&wanted);
        self.index.iter().filter(move |(_, at)| is(*at)).map(|(id, _)| *id)
    }

    /// Whether some keyword of an entity instance is `name`.
    pub(super) fn is_a(&self, id: u64, name: &str) -> bool {
        let found = self.index.binary_search_by_key(&id, |(id, _)| *id);
        found.is_ok_and(|i| {
            Cursor { bytes: self.bytes, at: self.index[i].1 }.has_keyword(&|word| word == name)
        })
    }

    /// Parses an entity instance.
    pub(super) fn entity(&self, id: u64) -> Result<Instance<'a>> {
        let found = self.index.binary_search_by_key(&id, |(id, _)| *id);
        let at = found.map(|i| self.index[i].1).map_err(|_| {
            let what = format!("refers to #{id}, which it does not contain");
            Error::new(self.path, what, EXPORT_AGAIN)
        })?;
        let mut cursor = Cursor { bytes: self.bytes, at };
        let found = cursor.instance();
        let left = self.work.get().checked_sub(cursor.at - at);
        self.work.set(left.ok_or_else(|| self.error(id, "is used too often"))?);
        match found {
            Ok(records) => Ok(Instance { id, records }),
            Err(what) => Err(self.damaged(cursor.at, format!("#{id}: {what}"))),
        }
    }

    /// Counts `parts` of an entity instance as read.
    pub(super) fn spend(&self, id: u64, parts: usize) -> Result<()> {
        let left = self.budget.get().checked_sub(parts);
        self.budget.set(left.ok_or_else(|| self.error(id, "is used too often"))?);
        Ok(())
    }

    /// An error in an entity instance.
    pub(super) fn error(&self, id: u64, what: impl Into<String>) -> Error {
        Error::new(self.path, what, EXPORT_AGAIN).at(Location::Entity(id))
    }

    /// An error for valid content that is not supported.
    pub(super) fn unread(&self, id: u64, what: impl Into<String>) -> Error {
        let help = "Export the part as a boundary representation with its surfaces as B-splines.";
        Error::new(self.path, what, help).at(Location::Entity(id))
    }

    fn damaged(&self, at: usize, what: impl Into<String>) -> Error {
        let before = &self.bytes[..at.min(self.bytes.len())];
        let line = 1 + before.iter().filter(|b| **b == b'\n').count() as u64;
        Error::new(self.path, what, EXPORT_AGAIN).at(Location::Line(line))
    }
}
