//! Standard error and standard output. A run continues if the other end of one is closed.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;

use super::{Failure, output};

/// Prints a line on standard error. If that fails, there is no other place to report it.
pub fn say(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints a result on standard output. A closed pipe is no failure, because its reader has read
/// what it wanted. A full disk is one.
pub fn print(text: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(output::failed(Path::new("standard output"), e).into())
        }
        _ => Ok(()),
    }
}
