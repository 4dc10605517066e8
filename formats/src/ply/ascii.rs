//! Conversion of the rows of an ASCII body to words that ply-rs reads.
//!
//! ply-rs expects exactly one row in a line. It refuses blank lines and `.5`, `5.` and `nan`, and
//! it ignores additional values without an error.

use ply_rs::ply::PropertyType;

use super::header::Element;
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::{Error, Result};

/// The current line, the number of its bytes that are used, and the current row.
#[derive(Default)]
pub(super) struct AsciiRows {
    line: Vec<u8>,
    used: usize,
    row: String,
}

impl AsciiRows {
    /// The next row of `element` with only the wanted columns. `None` if the file ends before the
    /// row is complete.
    pub(super) fn next(
        &mut self,
        source: &mut Source,
        element: &Element,
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Option<&str>> {
        self.row.clear();
        for (name, kind) in &element.properties {
            let keep = wanted(name);
            let Some(token) = self.token(source, keep)? else {
                return Ok(None);
            };
            if matches!(kind, PropertyType::Scalar(_)) {
                continue;
            }
            let length = std::str::from_utf8(token).ok().and_then(|t| t.parse::<u64>().ok());
            let Some(length) = length else {
                return Err(self.unreadable(source, &element.name));
            };
            for _ in 0..length {
                if self.token(source, keep)?.is_none() {
                    return Ok(None);
                }
            }
        }
        if self.line[self.used..].iter().any(|b| !b.is_ascii_whitespace()) {
            let what = format!("has more values in a row than its {} has", element.name);
            return Err(source.error(what, EXPORT_AGAIN));
        }
        Ok(Some(&self.row))
    }

    /// The error that the current line contains a word that is not a number.
    pub(super) fn unreadable(&self, source: &Source, element: &str) -> Error {
        let text = excerpt(&self.line);
        let help = number_help(&text);
        source.error(format!("has an unreadable {element} \u{201c}{text}\u{201d}"), help)
    }

    /// The next token, which may be in a later line. If `keep`, it is added to the row.
    fn token(&mut self, source: &mut Source, keep: bool) -> Result<Option<&[u8]>> {
        let (start, end) = loop {
            if let Some(span) = next_span(&self.line, self.used) {
                break span;
            }
            self.used = 0;
            if !source.next_line(&mut self.line)? {
                return Ok(None);
            }
        };
        self.used = end;
        let token = &self.line[start..end];
        if keep {
            self.row.push_str(&plain_number(&String::from_utf8_lossy(token)));
            self.row.push(' ');
        }
        Ok(Some(token))
    }
}

fn next_span(line: &[u8], from: usize) -> Option<(usize, usize)> {
    let rest = &line[from..];
    let start = from + rest.iter().position(|b| !b.is_ascii_whitespace())?;
    let length = line[start..].iter().position(u8::is_ascii_whitespace);
    Some((start, length.map_or(line.len(), |n| start + n)))
}
