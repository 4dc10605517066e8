//! The command line of scan2step: arguments, progress, reports, exit codes.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
