//! The lines of an OBJ file that make the mesh, in a form that tobj reads.

use std::io::{self, BufRead, Read};

use super::out_of_range;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::{Error, Result};

/// How many vertices each face has that lists the vertices at the end.
const LISTED: u64 = 256;

/// A statement that is continued on many lines is bounded like a line.
const MAX_STATEMENT: usize = 64 << 20;

/// A reader that delivers one clean statement at a time:
///
/// - `v x y z number 0 0`. A weight or a colour is left out, for tobj would
///   divide by the weight;
/// - `f a b c`, vertex numbers only: tobj can overflow on numbers of texture
///   points. They are checked here, where the line is known;
/// - at the end, faces that list every vertex.
///
/// All else is left out; it alone may hold other text than ASCII.
pub(super) struct Statements {
    source: Source,
    /// The statement as the file has it.
    statement: Vec<u8>,
    /// The statement for tobj, and how much of it tobj has taken.
    clean: Vec<u8>,
    taken: usize,
    vertices: u64,
    corners: u64,
    /// The greatest vertex number so far, and its line.
    greatest: (i64, u64),
    /// How many vertices are listed, once the file is over.
    listed: Option<u64>,
    error: Option<Error>,
}

impl Statements {
    pub(super) fn new(source: Source) -> Statements {
        Statements {
            source,
            statement: Vec::new(),
            clean: Vec::new(),
            taken: 0,
            vertices: 0,
            corners: 0,
            greatest: (0, 0),
            listed: None,
            error: None,
        }
    }

    pub(super) fn source(&self) -> &Source {
        &self.source
    }

    pub(super) fn vertices(&self) -> usize {
        self.vertices as usize
    }

    /// The current statement, abridged, and what to advise about it.
    pub(super) fn current(&self) -> (String, &'static str) {
        let text = excerpt(&self.statement);
        let help = number_help(&text);
        (text, help)
    }

    /// The error that stopped reading: ours, or else `theirs`.
    pub(super) fn failure(&mut self, theirs: impl Fn(&Statements) -> Error) -> Error {
        self.error.take().unwrap_or_else(|| theirs(self))
    }

    /// Makes the next statement for tobj; an empty one at the end.
    fn advance(&mut self) -> Result<()> {
        self.clean.clear();
        self.taken = 0;
        while self.clean.is_empty() && self.listed.is_none() {
            if self.next_statement()? {
                self.translate()?;
            } else {
                self.check_greatest()?;
                self.listed = Some(0);
            }
        }
        if let (true, Some(first)) = (self.clean.is_empty(), self.listed) {
            self.list(first);
        }
        Ok(())
    }

    /// Reads a line and those that continue it.
    fn next_statement(&mut self) -> Result<bool> {
        let more = self.source.next_line(&mut self.statement)?;
        if self.source.line == 1 && self.statement.starts_with(b"\xef\xbb\xbf") {
            self.statement.drain(..3);
        }
        let mut line = Vec::new();
        while self.statement.last() == Some(&b'\\') {
            self.statement.pop();
            if !self.source.next_line(&mut line)? {
                break;
            }
            self.statement.push(b' ');
            self.statement.extend_from_slice(&line);
            if self.statement.len() > MAX_STATEMENT {
                return Err(self.source.error("has an endless statement", EXPORT_AGAIN));
            }
        }
        Ok(more)
    }

    fn translate(&mut self) -> Result<()> {
        let statement = std::mem::take(&mut self.statement);
        let text = without_comment(&statement).trim_ascii();
        let done = match text.split_first() {
            Some((b'v', rest)) if rest.first().is_none_or(u8::is_ascii_whitespace) => {
                self.vertex(rest)
            }
            Some((b'f', rest)) if rest.first().is_none_or(u8::is_ascii_whitespace) => {
                self.face(rest)
            }
            _ => Ok(()),
        };
        self.statement = statement;
        done
    }

    fn vertex(&mut self, text: &[u8]) -> Result<()> {
        let text = String::from_utf8_lossy(text);
        let mut words = text.split_ascii_whitespace();
        self.clean.extend_from_slice(b"v ");
        for _ in 0..3 {
            let Some(word) = words.next() else {
                let what = "has a vertex with fewer than three coordinates";
                return Err(self.source.error(what, EXPORT_AGAIN));
            };
            self.clean.extend_from_slice(plain_number(word).as_bytes());
            self.clean.push(b' ');
        }
        self.clean.extend_from_slice(format!("{} 0 0\n", self.vertices).as_bytes());
        self.vertices += 1;
        self.check_count(self.vertices)
    }

    fn face(&mut self, text: &[u8]) -> Result<()> {
        let mut corners = 0;
        self.clean.push(b'f');
        for word in text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
            self.corner(word)?;
            corners += 1;
        }
        if corners < 3 {
            self.clean.clear();
            return self.check_small_face();
        }
        self.clean.push(b'\n');
        self.corners += corners;
        self.check_count(self.corners)
    }

    /// Adds the vertex number of `1/2/3`.
    fn corner(&mut self, word: &[u8]) -> Result<()> {
        let number = word.split(|&b| b == b'/').next().unwrap_or(word);
        self.clean.push(b' ');
        self.clean.extend_from_slice(number);
        let Some(n) = std::str::from_utf8(number).ok().and_then(|n| n.parse::<i64>().ok()) else {
            // tobj would take an empty one for "none".
            let text = excerpt(word);
            let what = format!("has a face with the unreadable corner \u{201c}{text}\u{201d}");
            return Err(self.source.error(what, EXPORT_AGAIN));
        };
        if n == 0 || n < 0 && n.unsigned_abs() > self.vertices {
            return Err(out_of_range(&self.source, self.source.line, n, self.vertices));
        }
        // A face may come before its vertices: this is for the end.
        self.greatest = self.greatest.max((n, self.source.line));
        Ok(())
    }

    /// Points and lines among the faces bound no surface and are left out,
    /// but a last line without its end may be half a triangle.
    fn check_small_face(&self) -> Result<()> {
        if !self.source.ended_line {
            return Err(self.source.error("ends in the middle of a face", EXPORT_AGAIN));
        }
        Ok(())
    }

    fn check_greatest(&self) -> Result<()> {
        let (number, line) = self.greatest;
        if number > self.vertices as i64 {
            return Err(out_of_range(&self.source, line, number, self.vertices));
        }
        Ok(())
    }

    /// That the soup's 32-bit numbers suffice, also with the list at the end.
    fn check_count(&self, count: u64) -> Result<()> {
        if count + self.vertices <= u64::from(u32::MAX) {
            return Ok(());
        }
        let help = "Decimate the scan or cut it into parts.";
        Err(self.source.error("has more than four billion points or corners", help))
    }

    fn list(&mut self, first: u64) {
        let end = self.vertices.min(first + LISTED);
        if first < end {
            self.clean.push(b'f');
            for number in first + 1..=end {
                self.clean.extend_from_slice(format!(" {number}").as_bytes());
            }
            self.clean.push(b'\n');
        }
        self.listed = Some(end);
    }
}

/// The part before a comment. (In `1.#IND`, a NaN, there is none.)
fn without_comment(statement: &[u8]) -> &[u8] {
    let starts =
        |i: usize| statement[i] == b'#' && (i == 0 || statement[i - 1].is_ascii_whitespace());
    let end = (0..statement.len()).find(|&i| starts(i));
    &statement[..end.unwrap_or(statement.len())]
}

impl Read for Statements {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(into)?;
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Statements {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.taken == self.clean.len()
            && let Err(error) = self.advance()
        {
            self.error = Some(error);
            return Err(io::Error::other("see Statements::error"));
        }
        Ok(&self.clean[self.taken..])
    }

    fn consume(&mut self, n: usize) {
        self.taken += n;
    }
}
