//! The command line of scan2step.

#![deny(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used)]
// These macros panic if the other end of the stream is closed.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
