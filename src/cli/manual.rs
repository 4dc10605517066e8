//! `scan2step completions`, `man` and `licences`: shell completions and manual pages, which clap
//! makes of the arguments, and the licences.

use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};
use clap_mangen::roff::{Roff, bold, roman};

use super::args::Cli;
use super::output::Pending;
use super::{Failure, Outcome, notes, output, streams, temp_files};

/// Options of `completions`.
#[derive(Debug, Args)]
#[command(after_help = notes::COMPLETIONS.help())]
pub(crate) struct Completions {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Options of `man`.
#[derive(Debug, Args)]
#[command(after_help = notes::MAN.help())]
pub(crate) struct Man {
    /// Folder for the pages of all commands; it is made if it does not exist [default: print
    /// the main page]
    pub dir: Option<PathBuf>,
}

/// Prints the completion script.
pub(crate) fn completions(args: &Completions) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "scan2step", &mut script);
    print(&script)
}

/// Prints the main page, or writes the pages of all commands.
pub(crate) fn man(args: &Man) -> Result<Outcome, Failure> {
    let mut pages = pages();
    let Some(folder) = &args.dir else {
        return print(pages.swap_remove(0).1.as_bytes());
    };
    temp_files::folder(folder).map_err(|e| output::failed(folder, e))?;
    let written = pages.iter().map(|(name, text)| {
        output::write(&folder.join(format!("{name}.1")), |out| out.write_all(text.as_bytes()))
    });
    Pending::publish(written.collect::<Result<_, _>>()?)?;
    Ok(Outcome::Done)
}

/// Prints the licences.
pub(crate) fn licences() -> Result<Outcome, Failure> {
    let own = "scan2step is licensed under either of these two licences, as you choose.\n\n";
    let [mit, apache, linked] = [
        include_str!("../../LICENSE-MIT"),
        include_str!("../../LICENSE-APACHE"),
        include_str!("../../LICENSE-DEPENDENCIES"),
    ];
    print([own, mit, "\n", apache, "\n", linked].concat().as_bytes())
}

/// The pages of the program and of its commands, each with its name.
fn pages() -> Vec<(String, String)> {
    let mut program = Cli::command().disable_help_subcommand(true);
    // Gives commands the names of their pages.
    program.build();
    let commands: Vec<Command> =
        [&program].into_iter().chain(program.get_subcommands()).cloned().collect();
    let names: Vec<String> = commands.iter().map(page_name).collect();
    commands.iter().map(|command| (page_name(command), page(command, &names))).collect()
}

fn page_name(command: &Command) -> String {
    command.get_display_name().unwrap_or_else(|| command.get_name()).to_owned()
}

/// A page: what clap says of the options, then the notes, then the names of the other pages.
fn page(command: &Command, names: &[String]) -> String {
    let own = page_name(command);
    let others = names.iter().filter(|name| **name != own).map(|name| format!("{name}(1)"));
    let mut end = Roff::new();
    let notes = notes::of(command.get_name());
    end.control("SH", ["EXAMPLES"]);
    notes.examples.iter().for_each(|example| paragraph(&mut end, "", example));
    for ([_, title], meanings) in notes.parts() {
        if !meanings.is_empty() {
            end.control("SH", [title]);
        }
        meanings.iter().for_each(|(word, meaning)| paragraph(&mut end, word, meaning));
    }
    end.control("SH", ["SEE ALSO"]);
    end.text([roman(others.collect::<Vec<_>>().join(", "))]);
    let bare = command.clone().after_help(None::<&str>);
    options(bare) + &end.render()
}

/// The part of a page that clap makes.
fn options(command: Command) -> String {
    let mut text = Vec::new();
    // Memory takes everything.
    let _ = clap_mangen::Man::new(command).render(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

/// A word in bold with its meaning, or an example.
fn paragraph(page: &mut Roff, word: &str, text: &str) {
    if word.is_empty() {
        page.control("PP", []);
    } else {
        page.control("TP", []);
        page.text([bold(word)]);
    }
    page.text([roman(text)]);
}

fn print(text: &[u8]) -> Result<Outcome, Failure> {
    streams::print(text)?;
    Ok(Outcome::Done)
}
