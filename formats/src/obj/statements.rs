//! The statements of an OBJ file.

use crate::Result;
use crate::source::{EXPORT_AGAIN, Source};

/// A statement that is continued on many lines is bounded like a line.
const MAX_STATEMENT: usize = 64 << 20;

/// A statement, and what follows its keyword.
pub(super) enum Statement<'a> {
    Vertex(&'a [u8]),
    Face(&'a [u8]),
    /// One that does not make the mesh; it alone may hold other text than
    /// ASCII.
    Other,
}

/// Reads one statement at a time.
pub(super) struct Statements {
    source: Source,
    /// The current statement.
    text: Vec<u8>,
}

impl Statements {
    pub(super) fn new(source: Source) -> Statements {
        Statements { source, text: Vec::new() }
    }

    pub(super) fn source(&self) -> &Source {
        &self.source
    }

    pub(super) fn current(&self) -> Statement<'_> {
        let ends = |rest: &[u8]| rest.first().is_none_or(u8::is_ascii_whitespace);
        match self.text.trim_ascii_start() {
            [b'v', rest @ ..] if ends(rest) => Statement::Vertex(rest),
            // `fo`: a face, before version 3.0.
            [b'f', b'o', rest @ ..] | [b'f', rest @ ..] if ends(rest) => Statement::Face(rest),
            _ => Statement::Other,
        }
    }

    /// Reads a line and those that continue it; `false` after the last.
    pub(super) fn advance(&mut self) -> Result<bool> {
        let more = self.source.next_line(&mut self.text)?;
        if self.source.line == 1 && self.text.starts_with(b"\xef\xbb\xbf") {
            self.text.drain(..3);
        }
        let mut line = Vec::new();
        while self.text.last() == Some(&b'\\') {
            self.text.pop();
            if !self.source.next_line(&mut line)? {
                break;
            }
            self.text.push(b' ');
            self.text.extend_from_slice(&line);
            if self.text.len() > MAX_STATEMENT {
                return Err(self.source.error("has an endless statement", EXPORT_AGAIN));
            }
        }
        Ok(more)
    }
}

/// The words of `text` up to a comment. (`1.#IND`, a NaN, begins none.)
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.take_while(|word| word[0] != b'#')
}
