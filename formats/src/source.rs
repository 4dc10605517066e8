//! A scan file that is open for reading. Gzip is decompressed, and the first bytes are available
//! for the detection of the format.

use std::fs::{File, Metadata};
use std::io::{self, BufRead as _, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use crate::unzip::Unzip;
use crate::{Error, Location, Result};

/// The number of bytes that the detection of the format can use.
const HEAD: u64 = 8192;

/// The largest length of a line in bytes. It bounds the memory for a gzip bomb without line ends.
const MAX_LINE: u64 = 64 << 20;

/// The advice for a truncated or damaged file.
pub(crate) const EXPORT_AGAIN: &str =
    "The file is damaged or was cut short: copy or export it again, best as binary PLY.";

/// A stream of the decompressed bytes of one file. Only a buffer is in memory, so that memory grows
/// only with the data that a reader keeps.
pub(crate) struct Source {
    /// The path as the user gave it, for errors.
    pub(crate) path: PathBuf,
    /// The folder of the files that this file refers to. `None` if it may not refer to any.
    pub(crate) folder: Option<PathBuf>,
    /// The first bytes. `stream` delivers them, too.
    pub(crate) head: Vec<u8>,
    /// The length of the content in bytes, if the file is not compressed.
    pub(crate) len: Option<u64>,
    /// The content from its first byte on.
    pub(crate) stream: BufReader<Box<dyn Read>>,
    /// The number of lines that `next_line` has returned, which is the number of the last line.
    pub(crate) line: u64,
    /// Whether the last line had a line end.
    pub(crate) ended_line: bool,
    eol: u8,
    pieces: PendingLine,
}

/// A line that contains line ends of another kind. `used` bytes of it have been returned.
#[derive(Default)]
struct PendingLine {
    line: Vec<u8>,
    used: usize,
    ended: bool,
}

impl Source {
    /// Opens the file at `path`. It may refer to files in the same folder.
    pub(crate) fn open(path: &Path) -> Result<Source> {
        let cannot = |e: io::Error| {
            let what = format!("cannot be opened: {e}");
            Error::new(path, what, "Check the path and the permissions of the file.")
        };
        let file = File::open(path).map_err(cannot)?;
        let meta = file.metadata().map_err(cannot)?;
        check_kind(path, &meta, "Name the scan file itself.")?;
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        Source::new(path, file, Some(meta.len()), folder.or(Some(Path::new("."))))
    }

    /// Creates a source from `content`. Its length is `len` if that is known. It is decompressed if
    /// it begins as a gzip file.
    pub(crate) fn new(
        path: &Path,
        mut content: impl Read + 'static,
        len: Option<u64>,
        folder: Option<&Path>,
    ) -> Result<Source> {
        let cannot = |what: &str, e: io::Error| {
            Error::new(path, format!("cannot be {what}: {e}"), EXPORT_AGAIN)
        };
        let zipped = take_head(&mut content).map_err(|e| cannot("read", e))?;
        let whole = Cursor::new(zipped.clone()).chain(content);
        let (head, len, stream): (_, _, Box<dyn Read>) = if zipped.starts_with(&[0x1f, 0x8b]) {
            let mut zip = Unzip::new(whole);
            let head = take_head(&mut zip).map_err(|e| cannot("unzipped", e))?;
            (head.clone(), None, Box::new(Cursor::new(head).chain(zip)))
        } else {
            (zipped, len, Box::new(whole))
        };
        Ok(Source {
            path: path.to_path_buf(),
            folder: folder.map(Path::to_path_buf),
            eol: line_end(&head),
            head,
            len,
            stream: BufReader::with_capacity(64 << 10, stream),
            line: 0,
            ended_line: true,
            pieces: PendingLine::default(),
        })
    }

    /// Stores the next line without its end in `line`. Returns `false` after the last line. A byte
    /// order mark at the beginning of the file is removed.
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
        if self.line == 1 && line.starts_with(b"\xef\xbb\xbf") {
            line.drain(..3);
        }
        Ok(read > 0)
    }

    /// The same for files that consist of text only. Each line may end with `\n`, `\r\n` or `\r`.
    pub(crate) fn next_text_line(&mut self, line: &mut Vec<u8>) -> Result<bool> {
        if self.pieces.used < self.pieces.line.len() {
            self.line += 1;
            self.next_piece(line);
            return Ok(true);
        }
        let more = self.next_line(line)?;
        let other = if self.eol == b'\n' { b'\r' } else { b'\n' };
        if self.eol == b'\r' && line.first() == Some(&other) {
            // This is the second byte of the `\r\n` at the end of the previous line.
            line.remove(0);
        }
        if line.contains(&other) {
            std::mem::swap(line, &mut self.pieces.line);
            (self.pieces.used, self.pieces.ended) = (0, self.ended_line);
            self.next_piece(line);
        }
        Ok(more)
    }

    fn next_piece(&mut self, line: &mut Vec<u8>) {
        let rest = &self.pieces.line[self.pieces.used..];
        let end = rest.iter().position(|b| matches!(b, b'\r' | b'\n'));
        line.clear();
        line.extend_from_slice(&rest[..end.unwrap_or(rest.len())]);
        self.pieces.used += line.len() + usize::from(end.is_some());
        self.ended_line = end.is_some() || self.pieces.ended;
    }

    /// An error at the last line that was returned, if there was one.
    pub(crate) fn error(&self, what: impl Into<String>, help: impl Into<String>) -> Error {
        let error = Error::new(&self.path, what, help);
        if self.line > 0 { error.at(Location::Line(self.line)) } else { error }
    }

    /// An error of reading itself, for example a bad disk or a truncated gzip stream.
    pub(crate) fn io_error(&self, e: &io::Error) -> Error {
        Error::new(&self.path, format!("cannot be read to its end: {e}"), EXPORT_AGAIN)
    }
}

/// Refuses a folder, and a device, which may have no end. A pipe has one.
pub(crate) fn check_kind(path: &Path, meta: &Metadata, help: &str) -> Result<()> {
    if meta.is_dir() {
        return Err(Error::new(path, "is a folder", help));
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = meta.file_type();
        if kind.is_char_device() || kind.is_block_device() || kind.is_socket() {
            return Err(Error::new(path, "is a device and not a file", help));
        }
    }
    Ok(())
}

fn take_head(from: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    from.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}

/// The byte that ends lines: `\r` in old Macintosh files, otherwise `\n`, perhaps after `\r`. The
/// first line decides, because any byte may follow the header of a binary PLY file.
fn line_end(head: &[u8]) -> u8 {
    match head.iter().position(|b| matches!(b, b'\r' | b'\n')) {
        Some(i) if head[i] == b'\r' && head.get(i + 1) != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}
