//! The commands of scan2step: arguments, progress, messages, files and exit codes.

mod args;
mod assembly;
mod batch;
mod cad;
mod check;
mod convert;
mod cylinders;
mod gaps;
mod input;
mod inspect;
mod inspect_parts;
mod manual;
mod messages;
mod notes;
mod output;
mod paragraphs;
mod parts;
mod places;
mod progress;
mod report;
mod settings;
mod spelling;
mod stages;
mod streams;
mod subprocess;
mod temp_files;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::error::ContextKind;
use clap::{CommandFactory, FromArgMatches};
use scan2step::words::printable;

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
pub(crate) fn run() -> ExitCode {
    let matches = args::Cli::command().try_get_matches().unwrap_or_else(|e| refuse(&e));
    let args = args::Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    let args = args::Cli { command: args.command.completed(&matches) };
    // Without signal handling a stopped run leaves its temporary files.
    if let Err(e) = temp_files::sweep_when_stopped() {
        streams::say(format_args!("note: Ctrl-C will leave temporary files: {e}"));
    }
    let colour = args.command.colour();
    // An environment variable with a wrong value is a usage error, like an option.
    if let Err(failure) = args.command.check_surroundings().and_then(|()| args.command.check_use())
    {
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
        args::Command::Licences => manual::licences(),
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

/// Prints what is wrong with the arguments, or help if it was asked for, and ends the program. A file
/// in the place of a command gets advice of its own.
fn refuse(error: &clap::Error) -> ! {
    let named = error.get(ContextKind::InvalidSubcommand).map(ToString::to_string);
    let Some(file) = named.filter(|named| Path::new(named).exists()) else { error.exit() };
    let failure = Failure {
        error: format!("{file}: is a file, where a command belongs"),
        help: format!("convert it with scan2step convert {file}, or see scan2step --help"),
    };
    let _ = tell(&failure, args::Colour::Auto, USAGE);
    std::process::exit(USAGE.into())
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
    let spelled = [&failure.error, &failure.help].map(|text| spelling::spelled(text));
    let [error, help] = [0, 1].map(|k| printable(&spelled[k]));
    streams::say_as_is(format_args!("{red}error{plain}: {error}"));
    streams::say_as_is(format_args!("{blue}help{plain}: {help}"));
    ExitCode::from(code)
}

impl args::Command {
    fn colour(&self) -> args::Colour {
        match self {
            Self::Convert(args) => args.manner.color,
            Self::Batch(args) => args.manner.color,
            Self::Inspect(args) => args.look.color,
            Self::Check(args) => args.look.color,
            Self::Completions(_) | Self::Man(_) | Self::Licences => args::Colour::Auto,
        }
    }

    /// Checks what no argument shows alone: where standard input and standard output are named, and
    /// whether an output has the format that `--to` names.
    fn check_use(&self) -> Result<(), Failure> {
        let is_dash = |path: &PathBuf| path.as_os_str() == streams::DASH;
        let wrong = |error: &str, help: &str| {
            Err(Failure { error: error.to_owned(), help: help.to_owned() })
        };
        match self {
            Self::Convert(args) if args.stages.as_ref().is_some_and(is_dash) => {
                wrong("--stages: needs a folder, not -", "name a folder for the stages' files")
            }
            Self::Convert(args)
                if args.to.is_some_and(|to| args.out.iter().all(|file| file.kind != to)) =>
            {
                wrong(
                    "--to: every output has the extension of another format",
                    "leave out --to, or name - to write to standard output",
                )
            }
            Self::Check(args) if args.cad.is_stdin && args.piece.scan.is_stdin => wrong(
                "stdin: cannot be both the CAD file and the scan",
                "name a file instead of one -",
            ),
            Self::Batch(args) if args.scans.iter().chain([&args.out]).any(is_dash) => wrong(
                "batch: reads and writes folders and files, not -",
                "convert a scan from standard input with scan2step convert -",
            ),
            _ => Ok(()),
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
