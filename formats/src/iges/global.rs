//! The start and global sections (IGES 5.3, clauses 2.2.4.2 and 2.2.4.3).

use std::io;

use super::Options;
use super::parameters::Parameters;
use crate::time_stamp;

/// What the first two sections say of a file.
pub(super) struct FileSummary<'a> {
    /// The name of the product.
    pub(super) name: &'a str,
    /// What the file holds.
    pub(super) content: &'a str,
    /// What a reader of the file should know about it. It may be empty.
    pub(super) description: &'a str,
    pub(super) uncertainty_mm: f64,
    /// The largest coordinate.
    pub(super) reach: f64,
}

const WIDTH: usize = 72;

/// Writes the start section, which is for human readers. Returns the number of lines.
pub(super) fn start(header: &FileSummary<'_>, out: &mut dyn io::Write) -> io::Result<usize> {
    let content = format!("{} in millimetres", header.content);
    writeln!(out, "{content:WIDTH$}S{:7}", 1)?;
    let plain = |c: char| if c.is_ascii_graphic() || c == ' ' { c } else { '_' };
    let text: Vec<char> = header.description.chars().map(plain).collect();
    for (number, line) in (2..).zip(text.chunks(WIDTH)) {
        writeln!(out, "{:WIDTH$}S{number:7}", line.iter().collect::<String>())?;
    }
    Ok(1 + text.len().div_ceil(WIDTH))
}

/// Writes the 26 global parameters. Returns the number of lines.
pub(super) fn write(
    header: &FileSummary<'_>,
    options: &Options,
    out: &mut dyn io::Write,
) -> io::Result<usize> {
    let mut number = 0;
    let mut finish_line = |line: &str| {
        number += 1;
        writeln!(out, "{line:WIDTH$}G{number:7}")
    };
    let mut p = Parameters::new(WIDTH, &mut finish_line);
    sender(&mut p, header.name, options)?;
    model(&mut p, &time(&options.time_stamp), header.uncertainty_mm, header.reach)?;
    p.end()?;
    Ok(number)
}

/// Writes parameters 1 to 12: the delimiters, the names, and the number formats of the sender.
fn sender(p: &mut Parameters<'_>, name: &str, options: &Options) -> io::Result<()> {
    p.text(",")?;
    p.text(";")?;
    p.text(name)?;
    p.text(&options.file_name)?;
    p.text(&options.originating_system)?;
    p.text(concat!("scan2step-formats ", env!("CARGO_PKG_VERSION")))?;
    // The bits of an integer, and the largest power of ten and the digits in single and in double
    // precision.
    for limit in [32, 38, 6, 308, 15] {
        p.add(limit)?;
    }
    p.text(name)
}

/// Writes parameters 13 to 26: scale, units, time, resolution, size and version.
fn model(p: &mut Parameters<'_>, time: &str, resolution: f64, reach: f64) -> io::Result<()> {
    p.real(1.0)?;
    p.add(2)?; // millimetres
    p.text("MM")?;
    p.add(1)?; // one line weight …
    p.real(0.1)?; // … and its width
    p.text(time)?;
    p.real(resolution)?;
    p.real(reach)?;
    p.text("")?; // author
    p.text("")?; // organisation
    p.add(11)?; // version 5.3
    p.add(0)?; // no drafting standard
    p.text(time)?; // last modified
    p.text("") // no application protocol
}

/// A time stamp in the notation of IGES: `19700101.000000`.
fn time(time_stamp: &str) -> String {
    let [year, month, day, hour, minute, second] = time_stamp::fields(time_stamp);
    format!("{year:04}{month:02}{day:02}.{hour:02}{minute:02}{second:02}")
}
