//! The arguments, as clap reads them.

mod choices;
mod colour;
mod files;
mod given;
mod how;
mod numbers;
mod pieces;

use std::path::PathBuf;

use clap::{ArgMatches, Args, Parser, Subcommand};
use scan2step::mesh::Choice;

pub use choices::{Fit, Iges, Map, Origin, OutlineChoice, ShapeChoice, StepSchema, Steps};
pub use colour::Colour;
pub use files::{CadFile, CadKind, cad_file};
pub use given::given;
pub use how::{How, Manner};
pub use pieces::{CloudArgs, ComponentChoice, CropArgs, Look, Piece, Scale};

use super::batch::args::Batch;
use super::cad::part_name;
use super::manual::{Completions, Man};
use super::places::Places;
use super::report::ReportFile;
use files::report_file;
use numbers::{percentage, positive};
use pieces::{component, one_component};

/// Turns 3D scans with holes into trimmed B-spline faces in STEP and IGES.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
#[command(after_help = "Examples:\n  scan2step inspect fender.ply\n  \
    scan2step convert fender.ply fender.step --report fender.html\n  \
    scan2step check fender.step fender.ply --tolerance 0.5\n  \
    scan2step batch scans/ --out cad/\n\n\
    Each command has --help with examples of its own.")]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Convert one scan to one or more CAD files.
    ///
    /// The scan is a mesh (.ply, .obj, .gltf, .glb, .stl or .off) or a cloud of points (.ply
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
}

/// Options of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  scan2step inspect fender.ply\n  \
    scan2step inspect relief.obj.gz --units in --json\n\n\
    Exit codes: 0 done, 1 failed, 2 usage.")]
pub struct Inspect {
    #[command(flatten)]
    pub piece: Piece,
    /// Component of the scan: largest, or a number (0 is the largest)
    #[arg(long, value_name = "largest|N", default_value = "largest", value_parser = one_component)]
    pub component: Choice,
    #[command(flatten)]
    pub look: Look,
}

/// Options of `check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  scan2step check fender.step fender.ply\n  \
    scan2step check relief.igs relief.obj --units in --tolerance 0.1 --outliers 1 --json\n\n\
    Exit codes: 0 all that was asked holds, 1 failed, 2 usage,\n\
    3 the tolerance is not met.")]
pub struct Check {
    /// The CAD file: STEP or IGES
    pub cad: PathBuf,
    #[command(flatten)]
    pub piece: Piece,
    /// Largest distance of a point of the scan from the faces, and of a sample of the faces
    /// from the scan, in mm
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true)]
    pub tolerance: Option<f64>,
    /// Percentage of points, and of samples, that may exceed the tolerance
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = percentage, allow_hyphen_values = true)]
    pub outliers: f64,
    /// Components of the scan that the faces are measured against: largest, all, or a number
    /// (0 is the largest), as for `convert`
    #[arg(long, value_name = "largest|all|N", default_value = "largest", value_parser = component)]
    pub component: ComponentChoice,
    #[command(flatten)]
    pub look: Look,
}

/// Options of `convert`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  scan2step convert fender.ply fender.step\n  \
    scan2step convert relief.obj relief.stp relief.igs --units in --tolerance 0.05\n  \
    scan2step convert face.glb face.step --report face.html --report face.png\n\n\
    Exit codes: 0 all that was asked holds, 1 failed (nothing written), 2 usage,\n\
    3 files written but a named tolerance is not met.")]
pub struct Convert {
    #[command(flatten)]
    pub piece: Piece,
    /// CAD files to write: .step, .stp, .igs or .iges [default: the scan's name with .step]
    #[arg(value_name = "OUT", value_parser = cad_file)]
    pub out: Vec<CadFile>,
    /// Refuse to replace a file that exists
    #[arg(long)]
    pub no_clobber: bool,

    /// Corners of the domain: four vertex indices of the scan (V0,V1,V2,V3),
    /// or four points in the scan's numbers (x,y,z;x,y,z;…) [default: found]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub corners: Option<Places>,
    /// Write a report: figures (.json), a page with the scan to turn (.html), or a
    /// picture (.png); can be given more than once
    #[arg(long, value_name = "FILE", value_parser = report_file)]
    pub report: Vec<ReportFile>,
    /// Write each stage's mesh into this folder
    #[arg(long, value_name = "DIR")]
    pub stages: Option<PathBuf>,
    /// How standard error shows how far the run has come
    #[arg(long, value_enum, default_value_t = Steps::Bar)]
    pub progress: Steps,
    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub manner: Manner,
    /// The words of a command that makes the same files.
    #[arg(skip)]
    pub again: Vec<String>,
}

impl Command {
    /// The same with what follows from other arguments.
    #[must_use]
    pub fn completed(mut self, matches: &ArgMatches) -> Self {
        let Command::Convert(convert) = &mut self else { return self };
        if let Some(matches) = matches.subcommand_matches("convert") {
            convert.again = given::convert_again(matches);
        }
        if convert.out.is_empty() {
            let name = format!("{}.step", part_name(&convert.piece.scan));
            let path = convert.piece.scan.with_file_name(name);
            convert.out.push(CadFile { path, kind: CadKind::Step });
        }
        self
    }
}
