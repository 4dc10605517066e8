//! Writer of free-format parameters in lines of limited width (IGES 5.3, clause 2.2.3).

use std::fmt::{self, Write as _};
use std::io;

use crate::number::IgesReal;

/// Collects the parameters of one record in lines. Commas separate them, and a semicolon ends the
/// record. A number never crosses the end of a line, but a string may.
pub(super) struct Parameters<'a> {
    width: usize,
    line: String,
    token: String,
    finish_line: &'a mut dyn FnMut(&str) -> io::Result<()>,
}

impl<'a> Parameters<'a> {
    /// Begins a record. `finish_line` receives each complete line.
    pub(super) fn new(
        width: usize,
        finish_line: &'a mut dyn FnMut(&str) -> io::Result<()>,
    ) -> Self {
        Parameters { width, line: String::new(), token: String::new(), finish_line }
    }

    /// Appends a number or a pointer.
    pub(super) fn add(&mut self, value: impl fmt::Display) -> io::Result<()> {
        self.token.clear();
        write!(self.token, "{value},").map_err(io::Error::other)?;
        if self.line.len() + self.token.len() > self.width {
            self.flush()?;
        }
        self.line.push_str(&self.token);
        Ok(())
    }

    pub(super) fn real(&mut self, value: f64) -> io::Result<()> {
        self.add(IgesReal(value))
    }

    pub(super) fn reals(&mut self, values: &[f64]) -> io::Result<()> {
        values.iter().try_for_each(|&x| self.real(x))
    }

    /// Appends a string with its length (a Hollerith constant, clause 2.2.2.4).
    pub(super) fn text(&mut self, text: &str) -> io::Result<()> {
        let text = ascii(text);
        // An empty string is an omitted parameter, because `0H` is not a valid constant.
        let whole = if text.is_empty() { ",".into() } else { format!("{}H{text},", text.len()) };
        // A string crosses the end of a line only if it is longer than a line. OpenCASCADE fails if
        // the line ends within the length of a string.
        if self.line.len() + whole.len().min(self.width) > self.width {
            self.flush()?;
        }
        for c in whole.chars() {
            if self.line.len() == self.width {
                self.flush()?;
            }
            self.line.push(c);
        }
        Ok(())
    }

    /// Ends the record.
    pub(super) fn end(mut self) -> io::Result<()> {
        self.line.pop();
        self.line.push(';');
        self.flush()
    }

    fn flush(&mut self) -> io::Result<()> {
        (self.finish_line)(&self.line)?;
        self.line.clear();
        Ok(())
    }
}

/// `text` in printable ASCII. All other characters become `_`.
pub(super) fn ascii(text: &str) -> String {
    text.chars().map(|c| if matches!(c, ' '..='~') { c } else { '_' }).collect()
}
