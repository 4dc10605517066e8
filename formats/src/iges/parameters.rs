//! Free-format parameters in lines of limited width.

use std::fmt::{self, Write as _};
use std::io;

use crate::number::IgesReal;

/// Collects the parameters of one record, separated by commas and closed by a
/// semicolon, into lines (IGES 5.3, clause 2.2.3). Numbers never cross the end
/// of a line; strings may.
pub(super) struct Parameters<'a> {
    width: usize,
    line: String,
    token: String,
    finish_line: &'a mut dyn FnMut(&str) -> io::Result<()>,
}

impl<'a> Parameters<'a> {
    /// `finish_line` gets each line as it is full.
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

    /// Appends a string with its length (Hollerith, clause 2.2.2.4).
    pub(super) fn text(&mut self, text: &str) -> io::Result<()> {
        let text = ascii(text);
        // An empty string is a parameter left out: `0H` is no constant.
        let whole = if text.is_empty() { ",".into() } else { format!("{}H{text},", text.len()) };
        // One that need not cross the end of a line does not: OpenCASCADE
        // stumbles where the length itself is cut in two.
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

    /// Closes the record.
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

/// `text` in printable ASCII, `_` standing for everything else.
pub(super) fn ascii(text: &str) -> String {
    text.chars().map(|c| if matches!(c, ' '..='~') { c } else { '_' }).collect()
}
