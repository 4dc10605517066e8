//! The lines of 80 columns of a file: its global section, directory and parameters (IGES 5.3,
//! clause 2.2.4).

use std::cell::Cell;
use std::path::Path;

use super::parameters::{Delimiters, Parameters};
use crate::{Error, Location, Result};

const EXPORT_AGAIN: &str = "The file is damaged or was cut short: copy it or export it again.";

/// The number of columns of a line before the letter of its section.
const DATA: usize = 72;
/// The number of columns of a parameter line that contain parameters.
const PARAMETERS: usize = 64;
/// The number of times that a parameter line may be read on average. The limit keeps the size of
/// the model in proportion to its file even if many entities refer to the same one.
const READINGS: usize = 8;

/// The directory entry of an entity.
#[derive(Debug, Clone, Copy)]
pub(super) struct DirectoryEntry {
    pub(super) kind: i64,
    pub(super) form: i64,
    /// The directory entry of the entity's matrix, or 0.
    pub(super) matrix: i64,
    /// Whether the entity is visible.
    pub(super) visible: bool,
    /// Whether the entity is not part of another one.
    pub(super) independent: bool,
    /// The first line of parameters, counted from 1, and the number of lines.
    lines: [usize; 2],
}

/// A file in memory.
pub(super) struct Deck<'a> {
    path: &'a Path,
    global: Vec<u8>,
    pub(super) directory: Vec<DirectoryEntry>,
    parameters: Vec<&'a [u8]>,
    delimiters: Delimiters,
    budget: Cell<usize>,
}

/// The lines of a file with any kind of line end, and their numbers.
fn lines(bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> {
    let feed = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    (1..).zip(bytes.split(move |b| *b == feed).map(<[u8]>::trim_ascii_end))
}

/// Whether the file begins with a line of an IGES file.
pub(crate) fn is_iges(bytes: &[u8]) -> bool {
    let Some((_, first)) = lines(bytes).find(|(_, line)| !line.is_empty()) else { return false };
    let number = first.get(DATA + 1..).unwrap_or_default().trim_ascii();
    matches!(first.get(DATA), Some(b'S' | b'G' | b'C' | b'B' | b'F'))
        && !number.is_empty()
        && number.iter().all(u8::is_ascii_digit)
}

impl<'a> Deck<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Result<Self> {
        let mut deck = Deck {
            path,
            global: Vec::new(),
            directory: Vec::new(),
            parameters: Vec::new(),
            delimiters: Delimiters::default(),
            budget: Cell::new(0),
        };
        let mut half: Option<&[u8]> = None;
        let mut last = 0;
        let mut complete = false;
        for (number, line) in lines(bytes).filter(|(_, line)| !line.is_empty()) {
            last = number;
            let at = Location::Line(number);
            match line.get(DATA) {
                Some(b'S') => {}
                Some(b'G') => deck.global.extend(&line[..DATA]),
                Some(b'D') => match half.take() {
                    None => half = Some(line),
                    Some(first) => {
                        let what = "a directory entry that is not made of numbers";
                        let entry =
                            DirectoryEntry::new(first, line).ok_or_else(|| deck.fault(what).at(at));
                        deck.directory.push(entry?);
                    }
                },
                Some(b'P') => deck.parameters.push(&line[..PARAMETERS]),
                Some(b'T') => {
                    complete = true;
                    break;
                }
                Some(b'C' | b'B') => {
                    let help = "Export it again in the fixed 80-column form.";
                    return Err(Error::new(path, "is IGES in compressed or binary form", help));
                }
                _ => {
                    let what = "a line without its section's letter in column 73";
                    return Err(deck.fault(what).at(at));
                }
            }
        }
        if !complete || half.is_some() {
            return Err(deck.fault("ends before its last section").at(Location::Line(last)));
        }
        deck.budget.set(READINGS * deck.parameters.len());
        deck.delimiters = Delimiters::of_global(&deck.global)
            .ok_or_else(|| deck.fault("a global section that names no delimiters"))?;
        Ok(deck)
    }

    fn fault(&self, what: impl Into<String>) -> Error {
        Error::new(self.path, what, EXPORT_AGAIN)
    }

    /// The directory entry with the number `pointer`.
    pub(super) fn entry(&self, pointer: i64) -> Result<DirectoryEntry> {
        let at = usize::try_from(pointer).ok().filter(|p| p % 2 == 1).map(|p| p / 2);
        let found = at.and_then(|at| self.directory.get(at)).copied();
        let what = || format!("refers to directory entry {pointer}, which it does not contain");
        found.ok_or_else(|| self.fault(what()))
    }

    /// The parameters of an entity after its type.
    pub(super) fn parameters(&self, pointer: i64) -> Result<Parameters<'_>> {
        let entry = self.entry(pointer)?;
        let [first, count] = entry.lines;
        // Some programs omit the number of lines.
        let end = first.checked_add(count.max(1));
        let lines = end.and_then(|end| self.parameters.get(first..end));
        let lines =
            lines.ok_or_else(|| self.error(pointer, "has parameters outside of the file"))?;
        let left = self.budget.get().checked_sub(lines.len());
        self.budget.set(left.ok_or_else(|| self.error(pointer, "is used too often"))?);
        let mut text = Vec::with_capacity(PARAMETERS * lines.len());
        lines.iter().for_each(|line| text.extend(*line));
        let mut parameters = Parameters::new(self, pointer, text, self.delimiters)?;
        if parameters.integer()? != entry.kind {
            return Err(self.error(pointer, "has the parameters of another entity"));
        }
        Ok(parameters)
    }

    /// The global parameters after the delimiters.
    pub(super) fn global(&self) -> Result<Parameters<'_>> {
        let rest = self.global[self.delimiters.length..].to_vec();
        Parameters::new(self, 0, rest, self.delimiters)
    }

    /// An error in an entity. Entity 0 stands for the global section.
    pub(super) fn error(&self, pointer: i64, what: impl Into<String>) -> Error {
        match u64::try_from(pointer) {
            Ok(at @ 1..) => self.fault(what).at(Location::DirectoryEntry(at)),
            _ => self.fault(format!("global section: {}", what.into())),
        }
    }

    /// An error for valid content that is not supported.
    pub(super) fn unread(&self, pointer: i64, what: impl Into<String>) -> Error {
        let help = "Export trimmed B-spline faces, as trimmed surfaces (144) or shells (514).";
        Error { help: help.into(), ..self.error(pointer, what) }
    }
}

impl DirectoryEntry {
    /// Parses an entry from its two lines.
    fn new(first: &[u8], second: &[u8]) -> Option<Self> {
        // An empty field is 0.
        let number = |line: &[u8], field: usize| {
            let text = std::str::from_utf8(line.get(8 * field..8 * field + 8)?).ok()?.trim();
            if text.is_empty() { Some(0) } else { text.parse::<i64>().ok() }
        };
        let status = first.get(64..72)?;
        let natural = |n: i64| usize::try_from(n).ok();
        Some(DirectoryEntry {
            kind: number(first, 0)?,
            form: number(second, 4)?,
            matrix: number(first, 6)?,
            visible: status[..2] != *b"01",
            independent: matches!(&status[2..4], b"00" | b"  " | b" 0"),
            lines: [natural(number(first, 1)?)?.checked_sub(1)?, natural(number(second, 3)?)?],
        })
    }
}
