//! The commands of scan2step.

mod args;
mod cad;
mod check;
mod convert;
mod hints;
mod input;
mod inspect;
mod leftovers;
mod output;
mod places;
mod progress;
mod report;
mod settings;
mod stages;
mod talk;

use std::process::ExitCode;

use clap::Parser;

/// What a run says at its end.
enum Outcome {
    /// All that was asked holds.
    Done,
    /// Files were written, but a tolerance that the user named is not met.
    Missed,
}

impl Outcome {
    /// Both hold, or one is missed.
    fn and(self, other: Outcome) -> Outcome {
        if matches!(self, Outcome::Missed) { self } else { other }
    }
}

/// A run that failed: what is wrong, and what to do.
struct Failure {
    error: String,
    help: String,
}

impl From<formats::Error> for Failure {
    fn from(e: formats::Error) -> Self {
        Failure { error: e.to_string(), help: e.help }
    }
}

/// Parses the arguments, runs the command, reports what is wrong.
pub fn run() -> ExitCode {
    let args = args::Cli::parse();
    // Where signals cannot be heeded, a stopped run leaves its temporary files.
    if let Err(e) = leftovers::sweep_when_stopped() {
        eprintln!("note: Ctrl-C will leave temporary files: {e}");
    }
    let (colour, done) = match &args.command {
        args::Command::Convert(args) => (args.color, convert::run(args)),
        args::Command::Inspect(args) => (args.look.color, inspect::run(args)),
        args::Command::Check(args) => (args.look.color, check::run(args)),
    };
    match done {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Missed) => ExitCode::from(3),
        Err(failure) => {
            leftovers::sweep();
            let (red, blue, plain) =
                if colour.is_on() { ("\x1b[1;31m", "\x1b[1;36m", "\x1b[0m") } else { ("", "", "") };
            eprintln!("{red}error{plain}: {}", failure.error);
            eprintln!("{blue}help{plain}: {}", failure.help);
            ExitCode::FAILURE
        }
    }
}

fn plural(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
