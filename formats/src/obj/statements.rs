//! The statements of an OBJ file.

use crate::Result;
use crate::source::{EXPORT_AGAIN, Source};

/// The largest length in bytes of a statement that continues on several lines.
const MAX_STATEMENT: usize = 64 << 20;

/// A statement and the text after its keyword.
pub(super) enum Statement<'a> {
    Vertex(&'a [u8]),
    Face(&'a [u8]),
    Comment(&'a [u8]),
    /// `o`: the following faces are an object of this name.
    Object(&'a [u8]),
    /// `g`: the following faces are in the groups of these names.
    Group(&'a [u8]),
    /// `usemtl`: the following faces have this material.
    Material(&'a [u8]),
    /// `mtllib`: materials are in these files.
    Library(&'a [u8]),
    /// A statement that defines neither the mesh nor its groups. Such statements, comments and names may contain
    /// non-ASCII text.
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
        statement(&self.text)
    }

    /// Reads the next statement. Returns `false` after the last one. A vertex or a face may
    /// continue on several lines. Other statements may not, because a name or a path may end with a
    /// backslash, and the vertex in the next line would be lost.
    pub(super) fn advance(&mut self) -> Result<bool> {
        let more = self.source.next_text_line(&mut self.text)?;
        let Some(mut end) = continued(&self.text) else { return Ok(more) };
        if !matches!(self.current(), Statement::Vertex(_) | Statement::Face(_)) {
            return Ok(more);
        }
        let mut line = Vec::new();
        loop {
            self.text.truncate(end);
            if !self.source.next_text_line(&mut line)? {
                return Ok(more);
            }
            self.text.push(b' ');
            let start = self.text.len();
            self.text.extend_from_slice(&line);
            if self.text.len() > MAX_STATEMENT {
                return Err(self.source.error("has an endless statement", EXPORT_AGAIN));
            }
            let Some(length) = continued(&line) else { return Ok(more) };
            end = start + length;
        }
    }
}

fn statement(text: &[u8]) -> Statement<'_> {
    let ends = |rest: &[u8]| rest.first().is_none_or(u8::is_ascii_whitespace);
    match text.trim_ascii_start() {
        [b'v', rest @ ..] if ends(rest) => Statement::Vertex(rest),
        // `fo` was the keyword of a face before version 3.0.
        [b'f', b'o', rest @ ..] | [b'f', rest @ ..] if ends(rest) => Statement::Face(rest),
        [b'#', rest @ ..] => Statement::Comment(rest),
        [b'o', rest @ ..] if ends(rest) => Statement::Object(rest),
        [b'g', rest @ ..] if ends(rest) => Statement::Group(rest),
        [b'u', b's', b'e', b'm', b't', b'l', rest @ ..] if ends(rest) => Statement::Material(rest),
        [b'm', b't', b'l', b'l', b'i', b'b', rest @ ..] if ends(rest) => Statement::Library(rest),
        _ => Statement::Other,
    }
}

/// The length of `line` without the backslash at its end, if it has one. Blanks may follow the
/// backslash. A comment never continues.
fn continued(line: &[u8]) -> Option<usize> {
    let rest = line.trim_ascii_end().strip_suffix(b"\\")?;
    let comment = line.split(u8::is_ascii_whitespace).any(|word| word.starts_with(b"#"));
    (!comment).then_some(rest.len())
}

/// The words of `text` up to a comment. The NaN `1.#IND` does not begin a comment.
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.take_while(|word| word[0] != b'#')
}
