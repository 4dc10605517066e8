//! The commands of scan2step: arguments, progress, messages, files and exit codes.

mod args;
mod batch;
mod body;
mod cad;
mod check;
mod convert;
mod input;
mod inspect;
mod manual;
mod messages;
mod output;
mod places;
mod progress;
mod report;
mod settings;
mod spelling;
mod stages;
mod streams;
mod subprocess;
mod temp_files;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};

/// The result of a run that did not fail as a whole.
enum Outcome {
    /// Everything that was asked for is done.
    Done,
    /// Files were written, but a tolerance that the user named is not met.
    Missed,
    /// At least one of many scans failed. Its message was already shown.
    Failed,
}

impl Outcome {
    /// The worse of two outcomes.
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
    let args = args::Cli { command: args.command.completed(&matches) };
    // Without signal handling a stopped run leaves its temporary files.
    if let Err(e) = temp_files::sweep_when_stopped() {
        streams::say(format_args!("note: Ctrl-C will leave temporary files: {e}"));
    }
    let colour = args.command.colour();
    // An environment variable with a wrong value is a usage error, like an option.
    if let Err(failure) = args.command.check_surroundings() {
        return tell(&failure, colour, USAGE);
    }
    let done = match &args.command {
        args::Command::Convert(args) => among(args.manner.threads, || convert::run(args)),
        args::Command::Inspect(args) => among(args.look.threads, || inspect::run(args)),
        args::Command::Check(args) => among(args.look.threads, || check::run(args)),
        args::Command::Batch(args) => {
            let of_batch = matches.subcommand().map_or(&matches, |(_, of_batch)| of_batch);
            batch::run(args, of_batch)
        }
        args::Command::Completions(args) => manual::completions(args),
        args::Command::Man(args) => manual::man(args),
    };
    match done {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Missed) => ExitCode::from(3),
        Ok(Outcome::Failed) => ExitCode::FAILURE,
        Err(failure) => {
            temp_files::sweep();
            tell(&failure, colour, FAILED)
        }
    }
}

/// Runs a command on one of the pool's own threads. Called from outside the pool, each of the
/// thousands of parallel loops would have to wake a thread and wait for it.
fn among(
    threads: Option<u16>,
    command: impl FnOnce() -> Result<Outcome, Failure> + Send,
) -> Result<Outcome, Failure> {
    scan2step::threads::run(threads.map(usize::from), command)
        .map_err(|e| Failure { error: e.to_string(), help: e.help() })?
}

/// Exit codes: the run failed; the program was called wrongly.
const FAILED: u8 = 1;
const USAGE: u8 = 2;

/// Prints what is wrong and what to do.
fn tell(failure: &Failure, colour: args::Colour, code: u8) -> ExitCode {
    let (red, blue, plain) =
        if colour.is_on() { ("\x1b[1;31m", "\x1b[1;36m", "\x1b[0m") } else { ("", "", "") };
    let [error, help] = [&failure.error, &failure.help].map(|text| spelling::spelled(text));
    streams::say(format_args!("{red}error{plain}: {error}"));
    streams::say(format_args!("{blue}help{plain}: {help}"));
    ExitCode::from(code)
}

impl args::Command {
    fn colour(&self) -> args::Colour {
        match self {
            Self::Convert(args) => args.manner.color,
            Self::Batch(args) => args.manner.color,
            Self::Inspect(args) => args.look.color,
            Self::Check(args) => args.look.color,
            Self::Completions(_) | Self::Man(_) => args::Colour::Auto,
        }
    }

    /// Checks the environment variables that a command reads.
    fn check_surroundings(&self) -> Result<(), Failure> {
        match self {
            Self::Convert(_) | Self::Batch(_) => cad::time_stamp().map(|_| ()),
            _ => Ok(()),
        }
    }
}
