//! Standard error and standard output: where nobody listens any more a run goes on.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;

use super::{Failure, output};

/// Says a line on standard error. Where that cannot be written to, there is no other
/// place to say so.
pub fn say(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints what was asked for on standard output. A reader that has gone has what it
/// wanted; a disk that is full is a failure.
pub fn print(text: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(output::failed(Path::new("standard output"), e).into())
        }
        _ => Ok(()),
    }
}
