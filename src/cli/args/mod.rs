//! The arguments, as clap reads them.

mod choices;
mod colour;
mod files;
mod given;
pub(crate) mod headings;
mod how;
mod numbers;
mod pieces;

use std::path::PathBuf;

use clap::{ArgMatches, Args, Parser, Subcommand, ValueHint};
use scan2step::mesh::Choice;

pub(super) use choices::{
    Fit, Iges, Map, Origin, OutlineChoice, ShapeChoice, StepSchema, Steps, SurfacesChoice, Up,
};
pub(super) use colour::Colour;
pub(super) use files::{CadFile, CadKind, cad_file, report_file};
pub(super) use given::given;
pub(super) use how::{How, Manner};
pub(super) use pieces::{CloudArgs, ComponentChoice, CropArgs, Look, PartsChoice, Piece, Scale};

use super::batch::args::Batch;
use super::cad::part_name;
use super::manual::{Completions, Man};
use super::notes;
use super::places::Places;
use super::report::ReportFile;
use super::streams::{DASH, is_stdout};
use files::{InputFile, input_file};
use headings::{ACCURACY, DETAILS, FILES, RUN, SCAN};
use numbers::{percentage, positive};
use pieces::{component, one_component};

/// Turns 3D scans into B-spline faces, shells and solids in STEP and IGES.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
#[command(after_help = notes::PROGRAM.help())]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Convert one scan to one or more CAD files.
    ///
    /// The scan is a mesh (.ply, .obj, .gltf, .glb, .3mf, .stl or .off) or a cloud of points (.ply
    /// without faces, .xyz, .txt, .asc, .csv, .pts, .ptx, .pcd, .e57, .las or .laz), each also
    /// gzipped. The extension of an output gives its format.
    Convert(Box<Convert>),
    /// Print what a scan is: counts, units, components, boundary loops, genus, noise and
    /// repairs.
    Inspect(Inspect),
    /// Measure a CAD file against a scan, in both directions.
    ///
    /// The file is read from disk, whichever program wrote it. Every point of the scan is
    /// measured from the trimmed faces, and samples of the faces from the scan. A hole that is
    /// not cut out shows in the second direction.
    Check(Check),
    /// Convert many scans: continue after a failure, resume an earlier run.
    ///
    /// Every scan of the folders (and the folders in these), patterns and files becomes a CAD
    /// file in one folder, with a summary.csv and a summary.json. A scan that an earlier run
    /// has converted is skipped if scan, options and program are the same.
    Batch(Box<Batch>),
    /// Print a script that completes commands and options in a shell.
    Completions(Completions),
    /// Print the manual page, or write the pages of all commands.
    Man(Man),
    /// Print the licences of the program and of the packages that are linked into it.
    #[command(visible_alias = "licenses", after_help = notes::LICENCES.help())]
    Licences,
}

/// Options of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = notes::INSPECT.help())]
pub(crate) struct Inspect {
    #[command(flatten)]
    pub piece: Piece,
    /// Component of the scan: largest, or a number (0 is the largest)
    #[arg(long, value_name = "largest|N", default_value = "largest", value_parser = one_component, help_heading = SCAN)]
    pub component: Choice,
    #[command(flatten)]
    pub look: Look,
}

/// Options of `check`.
#[derive(Debug, Args)]
#[command(after_help = notes::CHECK.help())]
pub(crate) struct Check {
    /// The CAD file: STEP or IGES, or - for standard input
    #[arg(value_parser = input_file(), value_hint = ValueHint::FilePath)]
    pub cad: InputFile,
    #[command(flatten)]
    pub piece: Piece,
    /// Largest distance of a point of the scan from the faces, and of a sample of the faces
    /// from the scan, in mm
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub tolerance: Option<f64>,
    /// Percentage of points, and of samples, that may exceed the tolerance
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = percentage, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub outliers: f64,
    /// The JSON report of `convert --align`, whose matrix puts the scan to the part
    #[arg(long, value_name = "REPORT", value_hint = ValueHint::FilePath, help_heading = SCAN)]
    pub placement: Option<PathBuf>,
    /// Components of the scan that the faces are measured against: largest, all, or a number
    /// (0 is the largest), as for `convert`
    #[arg(long, value_name = "largest|all|N", default_value = "largest", value_parser = component, help_heading = SCAN)]
    pub component: ComponentChoice,
    #[command(flatten)]
    pub look: Look,
}

/// Options of `convert`.
#[derive(Debug, Args)]
#[command(after_help = notes::CONVERT.help())]
pub(crate) struct Convert {
    #[command(flatten)]
    pub piece: Piece,
    /// CAD files to write: .step, .stp, .igs or .iges, or - for standard output [default: the
    /// scan's name with .step; - if the scan is -]
    #[arg(value_name = "OUT", value_parser = cad_file)]
    pub out: Vec<CadFile>,
    /// Format of the output if no extension gives it [default: step]
    #[arg(long, value_enum, value_name = "FORMAT", help_heading = FILES)]
    pub to: Option<CadKind>,
    /// Refuse to replace a file that exists
    #[arg(long, help_heading = FILES)]
    pub no_clobber: bool,
    /// Write a report: figures (.json), a page with the scan to turn (.html), or a
    /// picture (.png), or - for JSON on standard output; can be given more than once
    #[arg(long, value_name = "FILE", value_parser = report_file, help_heading = FILES)]
    pub report: Vec<ReportFile>,
    /// Write each stage's mesh into this folder
    #[arg(long, value_name = "DIR", help_heading = FILES)]
    pub stages: Option<PathBuf>,
    #[command(flatten)]
    pub how: How,
    /// Corners of the domain: four vertex indices of the scan (V0,V1,V2,V3),
    /// or four points in the scan's numbers (x,y,z;x,y,z;…) [default: found]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true, help_heading = DETAILS)]
    pub corners: Option<Places>,
    /// How standard error shows how far the run has come
    #[arg(long, value_enum, default_value_t = Steps::Bar, help_heading = RUN)]
    pub progress: Steps,
    #[command(flatten)]
    pub manner: Manner,
    /// End when standard input ends: a batch holds its other end.
    #[arg(long, hide = true)]
    pub end_with_input: bool,
    /// The words of a command that makes the same files.
    #[arg(skip)]
    pub again: Vec<String>,
}

impl Convert {
    /// The name of the part: that of the scan's file, or, as standard input has none, of the first
    /// output.
    pub(crate) fn part_name(&self) -> String {
        let scan = &self.piece.scan;
        let out = self.out.iter().map(|file| &file.path).find(|path| !is_stdout(path));
        part_name(out.filter(|_| scan.is_stdin).unwrap_or(&scan.name))
    }

    /// Names the output if the user did not, and gives standard output its format.
    fn complete(&mut self) {
        let kind = self.to.unwrap_or(CadKind::Step);
        if self.out.is_empty() {
            let scan = &self.piece.scan;
            let name = format!("{}.{}", part_name(&scan.name), kind.extension());
            let path = if scan.is_stdin { DASH.into() } else { scan.name.with_file_name(name) };
            self.out.push(CadFile { path, kind });
        }
        self.out.iter_mut().filter(|file| is_stdout(&file.path)).for_each(|file| file.kind = kind);
    }
}

impl Command {
    /// The same with what follows from other arguments.
    #[must_use]
    pub(crate) fn completed(mut self, matches: &ArgMatches) -> Self {
        if let Command::Convert(convert) = &mut self {
            convert.complete();
            let given = matches.subcommand_matches("convert");
            convert.again = given.map(given::convert_again).unwrap_or_default();
        }
        self
    }
}
