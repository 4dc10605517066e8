//! What help texts and manual pages say after the options: examples, values, the environment and
//! exit codes.

use super::paragraphs::wrapped;

/// Words with what they mean.
type Meanings = &'static [(&'static str, &'static str)];

/// The notes of one command.
pub(crate) struct Notes {
    /// The name of the command; none for the program itself.
    pub command: &'static str,
    pub examples: &'static [&'static str],
    pub values: Meanings,
    pub environment: Meanings,
    pub exit_codes: Meanings,
}

const LENGTHS: (&str, &str) =
    ("LEN", "a length in mm, or with a unit: um, mm, cm, m, in or ft, as 0.05, 20um or 0.002in");
const DASH: (&str, &str) =
    ("-", "in place of a file: standard input, whose content tells the format, or standard output");
const TIME_STAMP: (&str, &str) = (
    "SOURCE_DATE_EPOCH",
    "the time stamp of the CAD files, in seconds since 1970; without it 1970, so that the same scan gives the same bytes",
);
const COLOURS: (&str, &str) = ("NO_COLOR", "if it is set, messages have no colours");

const DONE: (&str, &str) = ("0", "done");
const ALL: (&str, &str) = ("0", "everything that you asked for is satisfied");
const FAILED: (&str, &str) = ("1", "failed; nothing was written");
const USAGE: (&str, &str) = ("2", "the usage is wrong");

pub(crate) const PROGRAM: Notes = Notes {
    command: "",
    examples: &[
        "scan2step inspect fender.ply",
        "scan2step convert fender.ply fender.step --report fender.html",
        "scan2step check fender.step fender.ply --tolerance 0.5",
        "scan2step batch scans/ --out cad/",
    ],
    values: &[],
    environment: &[TIME_STAMP, COLOURS],
    exit_codes: &[ALL, FAILED, USAGE, ("3", "files were written, but a tolerance is not met")],
};

pub(crate) const CONVERT: Notes = Notes {
    command: "convert",
    examples: &[
        "scan2step convert fender.ply fender.step",
        "scan2step convert relief.obj relief.stp relief.igs --units in --tolerance 0.1",
        "scan2step convert face.glb face.step --report face.html --report face.png",
        "scan2step convert cup.ply cup.step --remove-plane --component largest",
        "zcat fender.ply.gz | scan2step convert - > fender.step",
    ],
    values: &[LENGTHS, DASH],
    environment: &[TIME_STAMP, COLOURS],
    exit_codes: &[
        ALL,
        FAILED,
        USAGE,
        ("3", "files were written, but a tolerance that you named is not met"),
    ],
};

pub(crate) const INSPECT: Notes = Notes {
    command: "inspect",
    examples: &[
        "scan2step inspect fender.ply",
        "scan2step inspect relief.obj.gz --units in --json",
    ],
    values: &[LENGTHS, DASH],
    environment: &[COLOURS],
    exit_codes: &[DONE, ("1", "failed"), USAGE],
};

pub(crate) const CHECK: Notes = Notes {
    command: "check",
    examples: &[
        "scan2step check fender.step fender.ply",
        "scan2step check relief.igs relief.obj --units in --tolerance 0.1 --outliers 1",
    ],
    values: &[LENGTHS, DASH],
    environment: &[COLOURS],
    exit_codes: &[ALL, ("1", "failed"), USAGE, ("3", "the tolerance is not met")],
};

pub(crate) const BATCH: Notes = Notes {
    command: "batch",
    examples: &[
        "scan2step batch scans/ --out cad/",
        "scan2step batch 'scans/**/*.ply' --out cad/ --format both --report html",
        "scan2step batch scans/ --out cad/ --shard $SLURM_ARRAY_TASK_ID/16",
    ],
    values: &[LENGTHS],
    environment: &[TIME_STAMP, COLOURS],
    exit_codes: &[
        ALL,
        ("1", "a scan failed"),
        USAGE,
        ("3", "all files were written, but a tolerance that you named is not met"),
    ],
};

pub(crate) const COMPLETIONS: Notes = Notes {
    command: "completions",
    examples: &[
        "scan2step completions bash > /etc/bash_completion.d/scan2step",
        "scan2step completions zsh > \"${fpath[1]}/_scan2step\"",
        "scan2step completions fish > ~/.config/fish/completions/scan2step.fish",
    ],
    values: &[],
    environment: &[],
    exit_codes: &[DONE, ("1", "failed"), USAGE],
};

pub(crate) const MAN: Notes = Notes {
    command: "man",
    examples: &["scan2step man | man -l -", "scan2step man ~/.local/share/man/man1"],
    values: &[],
    environment: &[],
    exit_codes: &[DONE, ("1", "failed"), USAGE],
};

pub(crate) const LICENCES: Notes = Notes {
    command: "licences",
    examples: &["scan2step licences | less"],
    values: &[],
    environment: &[],
    exit_codes: &[DONE, ("1", "failed"), USAGE],
};

/// The notes of the program and of each command.
const EVERY: [&Notes; 8] =
    [&PROGRAM, &CONVERT, &INSPECT, &CHECK, &BATCH, &COMPLETIONS, &MAN, &LICENCES];

/// The notes of a command; of the program itself for a name that is no command.
pub(super) fn of(command: &str) -> &'static Notes {
    EVERY.into_iter().find(|notes| notes.command == command).unwrap_or(&PROGRAM)
}

impl Notes {
    /// The parts with words and their meanings, each with its title in help texts and in manual
    /// pages.
    pub(crate) fn parts(&self) -> [([&'static str; 2], Meanings); 3] {
        [
            (["Values", "VALUES"], self.values),
            (["Environment", "ENVIRONMENT"], self.environment),
            (["Exit codes", "EXIT STATUS"], self.exit_codes),
        ]
    }

    /// The text at the end of help.
    pub(super) fn help(&self) -> String {
        let mut text = format!("Examples:\n  {}", self.examples.join("\n  "));
        for ([title, _], meanings) in self.parts() {
            if meanings.is_empty() {
                continue;
            }
            text += &format!("\n\n{title}:");
            for (word, meaning) in meanings {
                text.push('\n');
                text += &wrapped(&format!("  {word}: {meaning}"), 6);
            }
        }
        if self.command.is_empty() {
            text += "\n\nEach command has --help with examples of its own.";
        }
        text
    }
}
