//! Binary files that went through a program for text.
//!
//! Such a program puts a carriage return before every line feed, or takes the
//! bytes for letters and writes them as UTF-8, those that are none as U+FFFD.
//! Either shifts what follows, so that the readers stumble over nonsense.

use crate::Error;
use crate::read::Format;

/// What to do about it.
pub(crate) const SEND_AS_BINARY: &str =
    "Copy or download it again as a binary file, not as text, or send it zipped.";

/// Fewer signs than these in the head of a file may be chance.
const SIGNS: u64 = 4;

/// Looks through bytes for whether they can be text of that kind. Those of a
/// sound binary file soon turn out not to be, and are passed over then.
pub(crate) struct TextTrace {
    /// Whether everything is UTF-8 so far.
    utf8: bool,
    /// How many bytes of the current letter are yet to come.
    due: u8,
    /// Letters that are not ASCII.
    letters: u64,
    /// Whether a carriage return stands before each line feed so far.
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

    /// What was done to a binary file, if it has so many bytes too many: one
    /// for each line feed, or those that letters, `letters` of them before its
    /// proper end, take more.
    pub(crate) fn of_surplus(&self, surplus: u64, letters: u64) -> Option<&'static str> {
        if self.utf8 && letters > 0 {
            return Some(AS_LETTERS);
        }
        (self.pairs && self.feeds == surplus).then_some(AS_LINES)
    }

    /// The same for a file of which only this is known.
    pub(crate) fn of_part(&self) -> Option<&'static str> {
        if self.utf8 && self.letters >= SIGNS {
            return Some(AS_LETTERS);
        }
        (self.pairs && self.feeds >= SIGNS).then_some(AS_LINES)
    }
}

const AS_LETTERS: &str = "its bytes were converted to UTF-8 text";
const AS_LINES: &str = "it was sent as text, with carriage returns put in";

/// What was done to binary data that is or begins with `bytes`.
pub(crate) fn of(bytes: &[u8]) -> Option<&'static str> {
    let mut trace = TextTrace::new();
    trace.push(bytes);
    trace.of_part()
}

/// The same error, but with its true cause if that shows in the file's head.
pub(crate) fn explain(mut error: Error, format: Format, head: &[u8]) -> Error {
    if let Some(damage) = binary_part(format, head).and_then(of) {
        error.what = format!("{}, for {damage}", error.what);
        error.help = SEND_AS_BINARY.into();
    }
    error
}

/// What stands in `head` after the text that a binary file begins with.
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
        Format::Obj | Format::Gltf | Format::Off => None,
    }
}
