//! A scan file opened for reading: gunzipped, with its head in view.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use crate::unzip::Unzip;
use crate::{Error, Place, Result};

/// How much of a file recognition may look at.
const HEAD: u64 = 8192;

/// No line of a sane scan is longer; a gzip bomb without line ends is.
const MAX_LINE: u64 = 64 << 20;

/// What to do about a file that is cut or damaged.
pub(crate) const EXPORT_AGAIN: &str =
    "The file is damaged or was cut short: copy or export it again, best as binary PLY.";

/// A stream of the (unzipped) bytes of one file. Nothing is held but a buffer,
/// so that memory grows only with what a reader keeps.
pub(crate) struct Source {
    /// The path as the user named it, for errors.
    pub(crate) path: PathBuf,
    /// The first bytes, which `stream` delivers as well.
    pub(crate) head: Vec<u8>,
    /// The length of the content if the file is not gzipped.
    pub(crate) len: Option<u64>,
    /// The content from its first byte on.
    pub(crate) stream: BufReader<Box<dyn Read>>,
    /// How many lines `next_line` has delivered: the number of the last one.
    pub(crate) line: u64,
    /// Whether that line had an end.
    pub(crate) ended_line: bool,
    eol: u8,
}

impl Source {
    /// Opens `path`, unzipping it if its first bytes are gzip's.
    pub(crate) fn open(path: &Path) -> Result<Source> {
        let cannot = |e: io::Error| {
            let what = format!("cannot be opened: {e}");
            Error::new(path, what, "Check the path and the permissions of the file.")
        };
        let mut file = File::open(path).map_err(cannot)?;
        let meta = file.metadata().map_err(cannot)?;
        if meta.is_dir() {
            return Err(Error::new(path, "is a folder", "Name the scan file itself."));
        }
        let head = take_head(&mut file).map_err(cannot)?;
        if !head.starts_with(&[0x1f, 0x8b]) {
            return Ok(Source::new(path, head, Some(meta.len()), Box::new(file)));
        }
        let mut zip = Unzip::new(Cursor::new(head).chain(file));
        let head = take_head(&mut zip)
            .map_err(|e| Error::new(path, format!("cannot be unzipped: {e}"), EXPORT_AGAIN))?;
        Ok(Source::new(path, head, None, Box::new(zip)))
    }

    fn new(path: &Path, head: Vec<u8>, len: Option<u64>, rest: Box<dyn Read>) -> Source {
        let eol = line_end(&head);
        let all: Box<dyn Read> = Box::new(Cursor::new(head.clone()).chain(rest));
        let stream = BufReader::with_capacity(64 << 10, all);
        Source { path: path.to_path_buf(), head, len, stream, line: 0, ended_line: true, eol }
    }

    /// Puts the next line into `line`, without its end; `false` after the last.
    pub(crate) fn next_line(&mut self, line: &mut Vec<u8>) -> Result<bool> {
        line.clear();
        let read = (&mut self.stream).take(MAX_LINE).read_until(self.eol, line);
        let read = read.map_err(|e| self.io_error(&e))?;
        self.line += u64::from(read > 0);
        if read as u64 == MAX_LINE {
            return Err(self.error("a line is longer than 64 MiB", EXPORT_AGAIN));
        }
        self.ended_line = line.last() == Some(&self.eol);
        if self.ended_line {
            line.pop();
            if line.last() == Some(&b'\r') {
                line.pop();
            }
        }
        Ok(read > 0)
    }

    /// An error at the last line delivered, if there was one.
    pub(crate) fn error(&self, what: impl Into<String>, help: impl Into<String>) -> Error {
        let error = Error::new(&self.path, what, help);
        if self.line > 0 { error.at(Place::Line(self.line)) } else { error }
    }

    /// The error that reading itself failed: a bad disk, a cut gzip stream.
    pub(crate) fn io_error(&self, e: &io::Error) -> Error {
        Error::new(&self.path, format!("cannot be read to its end: {e}"), EXPORT_AGAIN)
    }
}

fn take_head(from: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    from.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}

/// The byte that ends lines: `\r` alone in old Macintosh files, else `\n`
/// (perhaps after `\r`). The first line decides, for in a binary PLY file any
/// byte may follow the header.
fn line_end(head: &[u8]) -> u8 {
    match head.iter().position(|b| matches!(b, b'\r' | b'\n')) {
        Some(i) if head[i] == b'\r' && head.get(i + 1) != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}
