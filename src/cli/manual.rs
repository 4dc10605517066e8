//! `scan2step completions`, `man` and `licences`: shell completions and manual pages, which clap
//! makes of the arguments, and the licences.

use std::path::PathBuf;

use clap::{Args, CommandFactory};

use super::args::Cli;
use super::{Failure, Outcome, output, streams, temp_files};

/// Options of `completions`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    scan2step completions bash > ~/.local/share/bash-completion/completions/scan2step\n  \
    scan2step completions zsh > \"${fpath[1]}/_scan2step\"\n  \
    scan2step completions fish > ~/.config/fish/completions/scan2step.fish")]
pub struct Completions {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Options of `man`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  scan2step man | man -l -\n  \
    scan2step man ~/.local/share/man/man1")]
pub struct Man {
    /// Folder for the pages of all commands; it is made if it does not exist [default: print
    /// the main page]
    pub dir: Option<PathBuf>,
}

/// Prints the completion script.
pub fn completions(args: &Completions) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "scan2step", &mut script);
    print(&script)
}

/// Prints the main page, or writes the pages of all commands.
pub fn man(args: &Man) -> Result<Outcome, Failure> {
    let Some(folder) = &args.dir else {
        let mut page = Vec::new();
        let rendered = clap_mangen::Man::new(Cli::command()).render(&mut page);
        rendered.map_err(|e| output::failed("scan2step.1".as_ref(), e))?;
        return print(&page);
    };
    let written = temp_files::folder(folder).and_then(|()| {
        clap_mangen::generate_to(Cli::command().disable_help_subcommand(true), folder)
    });
    written.map_err(|e| output::failed(folder, e))?;
    Ok(Outcome::Done)
}

/// Prints the licences.
pub fn licences() -> Result<Outcome, Failure> {
    let own = "scan2step is licensed under either of these two licences, as you choose.\n\n";
    let [mit, apache, linked] = [
        include_str!("../../LICENSE-MIT"),
        include_str!("../../LICENSE-APACHE"),
        include_str!("../../LICENSE-DEPENDENCIES"),
    ];
    print([own, mit, "\n", apache, "\n", linked].concat().as_bytes())
}

fn print(text: &[u8]) -> Result<Outcome, Failure> {
    streams::print(text)?;
    Ok(Outcome::Done)
}
