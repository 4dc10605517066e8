//! The arguments of `batch`.

use std::path::PathBuf;

use clap::{ArgMatches, Args, Command, ValueEnum};

use crate::cli::args::headings::{FILES, RUN};
use crate::cli::args::{CloudArgs, CropArgs, How, Manner, Scale, given};
use crate::cli::notes;
use crate::cli::report::ReportFormat;

/// Options of `batch`.
#[derive(Debug, Args)]
#[command(after_help = notes::BATCH.help())]
pub(crate) struct Batch {
    /// Folders with scans, patterns ('scans/**/*.ply'), or scans.
    #[arg(required = true, value_name = "DIR|GLOB")]
    pub scans: Vec<PathBuf>,
    /// Folder for the CAD files, reports and summaries; it is made if it does not exist
    #[arg(long, value_name = "DIR", help_heading = FILES)]
    pub out: PathBuf,
    /// Format of the CAD files
    #[arg(long, value_enum, default_value_t = Formats::Step, help_heading = FILES)]
    pub format: Formats,
    /// Also write reports: html, json or png, or several (html,png)
    #[arg(long, value_enum, value_name = "KIND", value_delimiter = ',', help_heading = FILES)]
    pub report: Vec<ReportFormat>,
    /// Convert a part of the scans: 3/16 is the third of sixteen parts, which can run at the
    /// same time
    #[arg(long, value_name = "K/N", value_parser = shard, help_heading = RUN)]
    pub shard: Option<Shard>,
    /// Convert again what an earlier run has converted
    #[arg(long, help_heading = RUN)]
    pub force: bool,
    /// Number of scans at the same time; they share the cores evenly, unless --threads gives
    /// the threads of each
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256), help_heading = RUN)]
    pub jobs: u16,
    #[command(flatten)]
    pub scale: Scale,
    #[command(flatten)]
    pub crop: CropArgs,
    #[command(flatten)]
    pub cloud: CloudArgs,
    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub manner: Manner,
}

/// Formats of the CAD files.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Formats {
    Step,
    Iges,
    Both,
}

impl Formats {
    /// The extensions of the files.
    pub(crate) fn extensions(self) -> &'static [&'static str] {
        match self {
            Formats::Step => &["step"],
            Formats::Iges => &["igs"],
            Formats::Both => &["step", "igs"],
        }
    }
}

/// One of several parts of the scans.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shard {
    /// The part, counted from 1.
    number: usize,
    of: usize,
}

impl Shard {
    /// Whether the scan at this position of the sorted list, counted from 0, is in the shard.
    pub(crate) fn has(self, place: usize) -> bool {
        place % self.of == self.number - 1
    }
}

fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/').map(|(k, n)| (k.trim().parse(), n.trim().parse()));
    let Some((Ok(number), Ok(of))) = parts else { return Err("not of the form 3/16".into()) };
    let shard = Shard { number, of };
    if (1..=of).contains(&number) { Ok(shard) } else { Err("counts from 1/N to N/N".into()) }
}

/// The options of `batch` that are passed on to every `convert`.
pub(crate) fn passed_on(matches: &ArgMatches) -> Vec<String> {
    let of_scan = CloudArgs::augment_args(Scale::augment_args(Command::new("shared")));
    let of_scan = CropArgs::augment_args(of_scan);
    let shared = How::augment_args(of_scan);
    given(&shared, matches)
}
