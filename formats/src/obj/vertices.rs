//! Reader of the vertices of an OBJ file with tobj.

use std::io::Write as _;

use tobj::{LoadError, LoadOptions};

use super::statements::words;
use crate::limits::check_room;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::{Error, Location, Result, Soup};

/// The number of vertices that tobj receives at a time. So few stay in the cache.
const BATCH: usize = 4096;

/// The length of text in bytes after which tobj receives fewer vertices.
const LONG: usize = 1 << 20;

/// Vertices that wait for tobj.
#[derive(Default)]
pub(super) struct Vertices {
    /// A statement `v x y z` for each vertex. A weight or a colour is omitted, because tobj would
    /// divide by the weight.
    text: Vec<u8>,
    /// The line of each vertex in the file.
    lines: Vec<u64>,
    /// The statement `f 1 2 3 …` with all these vertices. tobj returns only vertices that a face
    /// uses, in the order of their use.
    list: Vec<u8>,
    listed: usize,
}

impl Vertices {
    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    pub(super) fn is_full(&self) -> bool {
        self.lines.len() >= BATCH || self.text.len() >= LONG
    }

    /// Adds the vertex in the current line of `source`.
    pub(super) fn push(&mut self, source: &Source, text: &[u8]) -> Result<()> {
        let mut words = words(text);
        let start = self.text.len();
        self.text.push(b'v');
        for _ in 0..3 {
            let Some(word) = words.next() else {
                self.text.truncate(start);
                let what = "has a vertex with fewer than three coordinates";
                return Err(source.error(what, EXPORT_AGAIN));
            };
            self.text.push(b' ');
            push_number(&mut self.text, word);
        }
        self.text.push(b'\n');
        self.lines.push(source.line);
        Ok(())
    }

    /// Reads the waiting vertices with tobj and adds them to the points of `soup`.
    pub(super) fn flush(&mut self, source: &Source, soup: &mut Soup) -> Result<()> {
        let Some(&last) = self.lines.last() else { return Ok(()) };
        check_room(&source.path, soup, self.len() as u64, 0)
            .map_err(|e| e.at(Location::Line(last)))?;
        self.write_list();
        self.text.extend_from_slice(&self.list);
        let mut rest = self.text.as_slice();
        let positions = load(&mut rest, self.lines.len());
        let taken = self.text.len() - rest.len();
        let positions = positions.map_err(|e| self.refusal(source, e, taken))?;
        soup.points.extend(positions.chunks_exact(3).map(|xyz| [xyz[0], xyz[1], xyz[2]]));
        self.text.clear();
        self.lines.clear();
        Ok(())
    }

    /// Adjusts the face statement to the number of vertices. Only the last batch has another
    /// number.
    fn write_list(&mut self) {
        if self.listed == self.lines.len() {
            return;
        }
        self.listed = self.lines.len();
        self.list.clear();
        self.list.push(b'f');
        for number in 1..=self.listed {
            // Writing to memory does not fail.
            let _ = write!(self.list, " {number}");
        }
        self.list.push(b'\n');
    }

    /// The error for text that tobj refused. It does not name a line, but it reads one line at a
    /// time, so the number of bytes that it has taken gives the line.
    fn refusal(&self, source: &Source, e: LoadError, taken: usize) -> Error {
        let mut statements = self.text[..taken].split_inclusive(|&b| b == b'\n');
        let statement = excerpt(statements.next_back().unwrap_or_default());
        let what = match e {
            LoadError::PositionParseError => {
                format!("has an unreadable vertex \u{201c}{statement}\u{201d}")
            }
            other => format!("cannot be read: {other}"),
        };
        let error = Error::new(&source.path, what, number_help(&statement));
        match self.lines.get(statements.count()) {
            Some(&line) => error.at(Location::Line(line)),
            None => error,
        }
    }
}

/// The coordinates of the `count` vertices in `text`.
fn load(text: &mut &[u8], count: usize) -> std::result::Result<Vec<f64>, LoadError> {
    let (models, _) =
        tobj::load_obj_buf(text, &LoadOptions::default(), |_| Ok(Default::default()))?;
    let positions = models.into_iter().next().map(|model| model.mesh.positions);
    // tobj should return exactly this number of coordinates.
    positions.filter(|p| p.len() == 3 * count).ok_or(LoadError::GenericFailure)
}

/// Adds `word` in a notation that tobj reads.
fn push_number(text: &mut Vec<u8>, word: &[u8]) {
    let usual = |b: &u8| matches!(b, b'0'..=b'9' | b'.' | b'-' | b'+' | b'e' | b'E');
    if word.iter().all(usual) {
        return text.extend_from_slice(word);
    }
    let word = String::from_utf8_lossy(word);
    // tobj also splits at white space outside of ASCII.
    let word = plain_number(word.trim()).replace(char::is_whitespace, "?");
    text.extend_from_slice(word.as_bytes());
}
