//! The command line of scan2step: arguments, progress, reports, exit codes.

#![deny(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used)]
// They panic where nobody listens any more.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
