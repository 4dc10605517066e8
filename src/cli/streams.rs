//! Standard input, standard output and standard error. A run continues if the other end of an
//! output is closed.

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::Path;

use formats::Error;
use scan2step::words::printable;

/// What names standard input or standard output on the command line.
pub(crate) const DASH: &str = "-";

/// What messages and files call standard input, and standard output.
pub(crate) const STDIN: &str = "stdin";
pub(crate) const STDOUT: &str = "stdout";

/// Whether an output goes to standard output.
pub(crate) fn is_stdout(path: &Path) -> bool {
    path == Path::new(DASH)
}

/// An output as messages and reports call it.
pub(crate) fn shown(path: &Path) -> String {
    if is_stdout(path) { STDOUT.into() } else { path.display().to_string() }
}

/// Prints a line on standard error. What would control the terminal is escaped.
pub(crate) fn say(line: impl Display) {
    say_as_is(printable(&line.to_string()));
}

/// Prints a line that has colours, and whose parts are printable, on standard error. If that fails, there is no
/// other place to report it.
pub(crate) fn say_as_is(line: impl Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints a result on standard output. A closed pipe is no failure, because its reader has read
/// what it wanted. A full disk is one.
pub(crate) fn print(text: &[u8]) -> Result<(), Error> {
    let mut out = std::io::stdout();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            let help = "check that its disk has room, or name a file";
            Err(Error::new(STDOUT, format!("cannot be written: {e}"), help))
        }
        _ => Ok(()),
    }
}
