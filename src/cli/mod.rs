//! The commands of scan2step.

mod args;
mod batch;
mod cad;
mod check;
mod children;
mod convert;
mod hints;
mod input;
mod inspect;
mod leftovers;
mod manual;
mod memory;
mod output;
mod places;
mod progress;
mod report;
mod settings;
mod stages;
mod streams;
mod talk;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};

/// What a run says at its end.
enum Outcome {
    /// All that was asked holds.
    Done,
    /// Files were written, but a tolerance that the user named is not met.
    Missed,
    /// Of many scans one failed, which was said.
    Failed,
}

impl Outcome {
    /// The worse of both.
    fn and(self, other: Outcome) -> Outcome {
        match (&self, &other) {
            (Outcome::Failed, _) | (Outcome::Missed, Outcome::Done) => self,
            _ => other,
        }
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
    let matches = args::Cli::command().get_matches();
    let args = args::Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    // Where signals cannot be heeded, a stopped run leaves its temporary files.
    if let Err(e) = leftovers::sweep_when_stopped() {
        streams::say(format_args!("note: Ctrl-C will leave temporary files: {e}"));
    }
    let (colour, done) = match &args.command {
        args::Command::Convert(args) => (args.manner.color, convert::run(args)),
        args::Command::Inspect(args) => (args.look.color, inspect::run(args)),
        args::Command::Check(args) => (args.look.color, check::run(args)),
        args::Command::Batch(args) => {
            let of_batch = matches.subcommand().map_or(&matches, |(_, of_batch)| of_batch);
            (args.manner.color, batch::run(args, of_batch))
        }
        args::Command::Completions(args) => (args::Colour::Auto, manual::completions(args)),
        args::Command::Man(args) => (args::Colour::Auto, manual::man(args)),
    };
    match done {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Missed) => ExitCode::from(3),
        Ok(Outcome::Failed) => ExitCode::FAILURE,
        Err(failure) => {
            leftovers::sweep();
            let (red, blue, plain) =
                if colour.is_on() { ("\x1b[1;31m", "\x1b[1;36m", "\x1b[0m") } else { ("", "", "") };
            streams::say(format_args!("{red}error{plain}: {}", failure.error));
            streams::say(format_args!("{blue}help{plain}: {}", failure.help));
            ExitCode::FAILURE
        }
    }
}

fn plural(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
