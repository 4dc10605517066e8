//! Writer of the exchange structure of ISO 10303-21: header, numbered entity instances, strings.

use std::collections::HashMap;
use std::fmt::{self, Write as _};
use std::io;

use crate::number::StepReal;

/// The name of an entity instance, `#12`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Id(u64);

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// The content of the header section (ISO 10303-21, clause 8).
pub(super) struct FileHeader<'a> {
    pub name: &'a str,
    pub time_stamp: &'a str,
    pub originating_system: &'a str,
    pub schema: &'a str,
    /// What the file has, for human readers.
    pub content: &'a str,
}

/// A file that is being written. Every entity instance is written as soon as it has a number.
pub(super) struct Part21<'a> {
    out: &'a mut dyn io::Write,
    last: u64,
    /// The instances that [`Part21::share`] has written.
    shared: HashMap<String, Id>,
}

impl<'a> Part21<'a> {
    pub(super) fn begin(out: &'a mut dyn io::Write, header: &FileHeader<'_>) -> io::Result<Self> {
        let preprocessor = concat!("scan2step-formats ", env!("CARGO_PKG_VERSION"));
        write!(
            out,
            "ISO-10303-21;\nHEADER;\n\
             FILE_DESCRIPTION(({}),'2;1');\n\
             FILE_NAME({},{},(''),(''),\n'{preprocessor}',{},'');\n\
             FILE_SCHEMA(({}));\nENDSEC;\nDATA;\n",
            Text(header.content),
            Text(header.name),
            Text(header.time_stamp),
            Text(header.originating_system),
            Text(header.schema),
        )?;
        Ok(Part21 { out, last: 0, shared: HashMap::new() })
    }

    /// Writes one entity instance and returns its name.
    pub(super) fn add(&mut self, body: fmt::Arguments<'_>) -> io::Result<Id> {
        self.last += 1;
        writeln!(self.out, "#{}={body};", self.last)?;
        Ok(Id(self.last))
    }

    /// Writes an entity instance that several others may refer to, or returns the name of the same
    /// instance that is there.
    pub(super) fn share(&mut self, body: fmt::Arguments<'_>) -> io::Result<Id> {
        let text = body.to_string();
        if let Some(&known) = self.shared.get(&text) {
            return Ok(known);
        }
        let id = self.add(format_args!("{text}"))?;
        self.shared.insert(text, id);
        Ok(id)
    }

    pub(super) fn end(self) -> io::Result<()> {
        self.out.write_all(b"ENDSEC;\nEND-ISO-10303-21;\n")?;
        self.out.flush() // a buffer that is dropped keeps its errors to itself
    }
}

/// Calls [`Part21::add`] with a format string: `add!(file, "ENTITY({})", x)`.
macro_rules! add {
    ($file:expr, $($body:tt)+) => { $file.add(format_args!($($body)+)) };
}
pub(super) use add;

/// Calls [`Part21::share`] with a format string.
macro_rules! share {
    ($file:expr, $($body:tt)+) => { $file.share(format_args!($($body)+)) };
}
pub(super) use share;

/// A string in apostrophes with escapes (ISO 10303-21, clause 6.4.3).
pub(super) struct Text<'a>(pub &'a str);

impl fmt::Display for Text<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_char('\'')?;
        let mut open = Alphabet::Basic;
        for c in self.0.chars() {
            let alphabet = Alphabet::of(c);
            if alphabet != open {
                f.write_str(open.close())?;
                f.write_str(alphabet.open())?;
                open = alphabet;
            }
            match (alphabet, c) {
                // Two apostrophes are one, too, but OpenCASCADE reads a name with "')" as nothing.
                (Alphabet::Basic, '\'') => f.write_str("\\X\\27")?,
                (Alphabet::Basic, '\\') => f.write_str("\\\\")?,
                (Alphabet::Basic, _) => f.write_char(c)?,
                (Alphabet::Two, _) => write!(f, "{:04X}", u32::from(c))?,
                (Alphabet::Four, _) => write!(f, "{:08X}", u32::from(c))?,
            }
        }
        f.write_str(open.close())?;
        f.write_char('\'')
    }
}

/// The number of bytes that a character takes in a string, which decides on its escape.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Alphabet {
    Basic,
    Two,
    Four,
}

impl Alphabet {
    fn of(c: char) -> Self {
        match c {
            ' '..='~' => Alphabet::Basic,
            '\0'..='\u{FFFF}' => Alphabet::Two,
            _ => Alphabet::Four,
        }
    }

    fn open(self) -> &'static str {
        match self {
            Alphabet::Basic => "",
            Alphabet::Two => "\\X2\\",
            Alphabet::Four => "\\X4\\",
        }
    }

    fn close(self) -> &'static str {
        if self == Alphabet::Basic { "" } else { "\\X0\\" }
    }
}

/// A list in parentheses that is divided into readable lines.
pub(super) struct List<I>(pub I);

impl<I, T> fmt::Display for List<I>
where
    I: Clone + IntoIterator<Item = T>,
    T: fmt::Display,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const A_LINE: usize = 10;
        f.write_char('(')?;
        for (i, item) in self.0.clone().into_iter().enumerate() {
            match i {
                0 => {}
                i if i % A_LINE == 0 => f.write_str(",\n")?,
                _ => f.write_char(',')?,
            }
            write!(f, "{item}")?;
        }
        f.write_char(')')
    }
}

/// A list of real numbers.
pub(super) fn reals(values: &[f64]) -> List<impl Clone + IntoIterator<Item = StepReal>> {
    List(values.iter().map(|&x| StepReal(x)))
}

/// The names of `count` consecutive entity instances that begin with `first`.
#[derive(Clone, Copy)]
pub(super) struct IdRange {
    pub first: Id,
    pub count: usize,
}

impl IdRange {
    pub(super) fn list(self) -> List<impl Clone + IntoIterator<Item = Id>> {
        let first = self.first.0;
        List((0..self.count as u64).map(move |i| Id(first + i)))
    }

    /// The `i`-th part of this range, if each part has `count` names.
    pub(super) fn part(self, i: usize, count: usize) -> IdRange {
        IdRange { first: Id(self.first.0 + (i * count) as u64), count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_escaped() {
        let text = |s| Text(s).to_string();
        assert_eq!(text("a');b\\c"), r"'a\X\27);b\\c'");
        assert_eq!(text("Größe"), r"'Gr\X2\00F600DF\X0\e'");
        assert_eq!(text("é😀"), r"'\X2\00E9\X0\\X4\0001F600\X0\'");
        assert_eq!(text("a\nb"), r"'a\X2\000A\X0\b'");
    }

    #[test]
    fn long_lists_break() {
        let list = List(0..12).to_string();
        assert_eq!(list, "(0,1,2,3,4,5,6,7,8,9,\n10,11)");
    }
}
