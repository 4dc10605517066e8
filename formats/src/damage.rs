//! Detection of binary files that a program for text has damaged.
//!
//! Such a program inserts a carriage return before every line feed, or it interprets the bytes as
//! characters and writes them as UTF-8, with U+FFFD for invalid ones. Both shift the following
//! bytes, so that readers find invalid data. The input is bytes of a file. The output is a
//! description of the damage.

use crate::Error;
use crate::read::Format;

/// The advice for such files.
pub(crate) const SEND_AS_BINARY: &str =
    "Copy or download it again as a binary file, not as text, or send it zipped.";

/// The least number of signs of damage in the head of a file. Fewer may occur by chance.
const SIGNS: u64 = 4;

/// Tests whether bytes can be such text. The bytes of an undamaged binary file soon fail the test,
/// and the remaining bytes are skipped.
pub(crate) struct TextTrace {
    /// Whether all bytes so far are UTF-8.
    utf8: bool,
    /// The number of missing bytes of the current character.
    due: u8,
    /// The number of characters that are not ASCII.
    letters: u64,
    /// Whether there has been a carriage return before each line feed.
    pairs: bool,
    feeds: u64,
    last: u8,
}

impl TextTrace {
    pub(crate) fn new() -> TextTrace {
        TextTrace { utf8: true, due: 0, letters: 0, pairs: true, feeds: 0, last: 0 }
    }

    pub(crate) fn push(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if !self.utf8 && !self.pairs {
                return;
            }
            self.push_letter(byte);
            if byte == b'\n' {
                self.pairs &= self.last == b'\r';
                self.feeds += 1;
            }
            self.last = byte;
        }
    }

    fn push_letter(&mut self, byte: u8) {
        let due = match (self.due, byte) {
            (1.., 0x80..=0xbf) => self.due - 1,
            (0, 0..=0x7f) => return,
            (0, 0xc2..=0xdf) => 1,
            (0, 0xe0..=0xef) => 2,
            (0, 0xf0..=0xf4) => 3,
            _ => {
                self.utf8 = false;
                return;
            }
        };
        self.letters += u64::from(self.due == 0);
        self.due = due;
    }

    pub(crate) fn letters(&self) -> u64 {
        self.letters
    }

    /// The damage to a binary file that has `surplus` additional bytes. It is recognized if there
    /// is one for each line feed, or if the number is that of the additional bytes of characters.
    /// `letters` of them are before the proper end of the file.
    pub(crate) fn of_surplus(&self, surplus: u64, letters: u64) -> Option<&'static str> {
        if self.utf8 && letters > 0 {
            return Some(AS_LETTERS);
        }
        (self.pairs && self.feeds == surplus).then_some(AS_LINES)
    }

    /// The damage to a binary file of which only a part is known.
    pub(crate) fn of_part(&self) -> Option<&'static str> {
        if self.utf8 && self.letters >= SIGNS {
            return Some(AS_LETTERS);
        }
        (self.pairs && self.feeds >= SIGNS).then_some(AS_LINES)
    }
}

const AS_LETTERS: &str = "its bytes were converted to UTF-8 text";
const AS_LINES: &str = "it was sent as text with additional carriage returns";

/// The damage to binary data that begins with `bytes`.
pub(crate) fn of(bytes: &[u8]) -> Option<&'static str> {
    let mut trace = TextTrace::new();
    trace.push(bytes);
    trace.of_part()
}

/// Replaces the cause of an error by damage to the file, if the head of the file shows it.
pub(crate) fn explain(mut error: Error, format: Format, head: &[u8]) -> Error {
    if let Some(damage) = binary_part(format, head).and_then(of) {
        error.what = format!("{}, because {damage}", error.what);
        error.help = SEND_AS_BINARY.into();
    }
    error
}

/// The bytes of `head` after the text at the beginning of a binary file.
fn binary_part(format: Format, head: &[u8]) -> Option<&[u8]> {
    let after = |word: &[u8]| {
        let at = head.windows(word.len()).position(|w| w == word)?;
        head.get(at + word.len()..)
    };
    match format {
        Format::Ply => {
            after(b"format binary_")?;
            let body = after(b"end_header")?;
            body.strip_prefix(b"\r\n").or(body.get(1..))
        }
        Format::Stl => head.get(84..).filter(|_| head.contains(&0)),
        Format::Glb => after(b"BIN\0"),
        // After the header of its first entry.
        Format::ThreeMf => head.get(30..),
        Format::Obj | Format::Gltf | Format::Off => None,
    }
}
