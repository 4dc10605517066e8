//! The arguments that the user gave, as words of a command line.

use clap::{Arg, ArgMatches, Args, Command, parser::ValueSource};

use super::{Convert, Manner};
use crate::cli::batch;
use crate::cli::streams::DASH;

/// Those options of a command that the user gave, one word each.
pub(crate) fn given(command: &Command, matches: &ArgMatches) -> Vec<String> {
    command.get_arguments().flat_map(|option| words(option, matches)).collect()
}

/// An option as often as the user gave it.
fn words(option: &Arg, matches: &ArgMatches) -> Vec<String> {
    let Some(long) = option.get_long() else { return Vec::new() };
    let values = values(option, matches);
    if !option.get_action().takes_values() {
        return values.iter().map(|_| format!("--{long}")).collect();
    }
    values.iter().map(|value| format!("--{long}={value}")).collect()
}

/// The values that the user gave.
fn values(argument: &Arg, matches: &ArgMatches) -> Vec<String> {
    let id = argument.get_id().as_str();
    if matches.value_source(id) != Some(ValueSource::CommandLine) {
        return Vec::new();
    }
    let values = matches.get_raw(id).into_iter().flatten();
    values.map(|value| value.to_string_lossy().into_owned()).collect()
}

/// Options of `convert` besides those of [`Manner`] that change no file.
const MANNER: [&str; 3] = ["progress", "no_clobber", "end_with_input"];

/// The words of a `convert` that makes the same files. Options that change no file are omitted.
pub(crate) fn convert_again(matches: &ArgMatches) -> Vec<String> {
    let whole = Convert::augment_args(Command::new("convert"));
    let manner = Manner::augment_args(Command::new("manner"));
    let changes_files = |option: &&Arg| {
        let id = option.get_id();
        !MANNER.contains(&id.as_str()) && manner.get_arguments().all(|other| other.get_id() != id)
    };
    let (files, options): (Vec<&Arg>, Vec<&Arg>) =
        whole.get_arguments().filter(changes_files).partition(|argument| argument.is_positional());
    let is_option = |path: &str| path.starts_with('-') && path != DASH;
    let file = |path: String| if is_option(&path) { format!("./{path}") } else { path };
    let files = files.iter().flat_map(|argument| values(argument, matches)).map(file);
    let options = options.iter().flat_map(|option| words(option, matches));
    // The reports that `batch` asks for itself are none of the user's.
    let options = options.filter(|word| !batch::is_record(word));
    ["scan2step".into(), "convert".into()].into_iter().chain(files).chain(options).collect()
}
