//! The arguments, as clap reads them.

use std::io::IsTerminal;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::batch::args::Batch;
use super::manual::{Completions, Man};
use super::places::{Corners, Places};
use super::report::{Kind, ReportFile};
use formats::LengthUnit;

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
    /// The scan is a triangle mesh: .ply, .obj, .gltf, .glb or .stl, each also
    /// gzipped. The output's format is its extension's.
    Convert(Box<Convert>),
    /// Say what a scan is: counts, units, components, boundary loops, genus,
    /// noise, and what had to be repaired.
    Inspect(Inspect),
    /// Measure a CAD file against a scan, in both directions.
    ///
    /// The file is read back from disk, whoever wrote it: the distance of every
    /// point of the scan from the trimmed faces, and of samples of these from
    /// the scan, so that a hole that is not cut out shows.
    Check(Check),
    /// Convert many scans: go on after a failure, resume where it stopped.
    ///
    /// Every scan of the folders (and the folders in these), patterns and files
    /// becomes a CAD file in one folder, which gets a summary.csv and a
    /// summary.json, too. What is there from an earlier run is skipped, as long as
    /// scan, options and program are the same.
    Batch(Box<Batch>),
    /// Print a script that completes commands and options in a shell.
    Completions(Completions),
    /// Print the manual page, or write the pages of all commands.
    Man(Man),
}

/// How large a scan is.
#[derive(Debug, Args)]
pub struct Scale {
    /// Unit of the scan's numbers [default: metres for glTF, else mm]
    #[arg(long, value_name = "UNIT")]
    pub units: Option<Unit>,
}

/// What to look at, of a scan.
#[derive(Debug, Args)]
pub struct Piece {
    /// The scan.
    pub scan: PathBuf,
    #[command(flatten)]
    pub scale: Scale,
    /// A place on the boundary loop that is the outer one: a vertex index or a
    /// point, as in --corners of convert [default: the longest loop that does not run around a hole]
    #[arg(long, value_name = "V|x,y,z", allow_hyphen_values = true)]
    pub outer: Option<Places>,
}

/// Options of the commands that look at one piece of a scan.
#[derive(Debug, Args)]
pub struct Look {
    /// Which piece of the scan: largest, or a number (0 is the largest)
    #[arg(long, value_name = "largest|N", default_value = "largest", value_parser = one_component)]
    pub component: scan2step::mesh::Choice,
    /// Print one JSON object; lengths are mm
    #[arg(long)]
    pub json: bool,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Colours in messages
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    pub color: Colour,
}

/// Options of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  scan2step inspect fender.ply\n  \
    scan2step inspect relief.obj.gz --units in --json\n\n\
    Exit codes: 0 done, 1 failed, 2 usage.")]
pub struct Inspect {
    #[command(flatten)]
    pub piece: Piece,
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
    /// Farthest that a point of the scan may be from the faces, and a sample of
    /// these from the scan, in mm
    #[arg(long, value_name = "LEN", value_parser = positive)]
    pub tolerance: Option<f64>,
    /// Percentage of points, and of samples, that may exceed the tolerance
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = percentage)]
    pub outliers: f64,
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
    /// CAD files to write: .step, .stp, .igs or .iges.
    #[arg(required = true, value_name = "OUT", value_parser = cad_file)]
    pub out: Vec<CadFile>,

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
    #[command(flatten)]
    pub how: How,
    #[command(flatten)]
    pub manner: Manner,
}

/// How a scan becomes a face: what `convert` and `batch` have in common.
#[derive(Debug, Args)]
pub struct How {
    /// Farthest that a point of the smoothed scan may be from the face, in mm
    /// [default: from the noise of the scan]
    #[arg(long, value_name = "LEN", value_parser = positive)]
    pub tolerance: Option<f64>,
    /// Percentage of points that may exceed the tolerance
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = percentage)]
    pub outliers: f64,
    /// What becomes of the outer boundary: the four sides of the surface, or a trim
    /// loop inside it, as holes have them
    #[arg(long, value_enum, default_value_t = Outline::Auto)]
    pub outline: Outline,
    /// Where smoothing keeps a corner of the boundary: auto, none, or places as
    /// in --corners
    #[arg(long, value_name = "LIST|auto|none", default_value = "auto", allow_hyphen_values = true)]
    pub boundary_corners: Corners,
    /// Support of the smoothing, in mm, or auto, or off
    #[arg(long, value_name = "LEN|auto|off", default_value = "auto", value_parser = support)]
    pub smooth: scan2step::smooth::Support,
    /// How to fit
    #[arg(long, value_enum, default_value_t = Fit::Refined)]
    pub fit: Fit,
    /// Mean distance, in mm, above which a region gets more knots [default:
    /// from the tolerance]
    #[arg(long, value_name = "LEN", value_parser = positive)]
    pub kappa: Option<f64>,
    /// Halvings of the domain at the most [default: from the number of points]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=20))]
    pub depth: Option<u32>,
    /// A uniform control net, as 13x13; overrides --kappa and --depth
    #[arg(long, value_name = "MxN", value_parser = net)]
    pub net: Option<[usize; 2]>,
    /// Control points of the face at the most
    #[arg(long, value_name = "N", default_value_t = 250_000)]
    pub max_net: usize,
    /// Leave holes filled whose rim is shorter than this, in mm; cut out the
    /// others
    #[arg(long, value_name = "LEN", value_parser = positive, conflicts_with = "keep_fills")]
    pub fill_only_holes_below: Option<f64>,
    /// Leave all holes filled
    #[arg(long)]
    pub keep_fills: bool,
    /// Which piece of the scan: largest, all, or a number (0 is the largest)
    #[arg(long, value_name = "largest|all|N", default_value = "largest", value_parser = component)]
    pub component: Component,
    /// STEP schema
    #[arg(long, value_enum, default_value_t = Schema::Ap242)]
    pub schema: Schema,
    /// IGES form: trimmed surfaces (144) or a shell (514)
    #[arg(long, value_enum, default_value_t = Iges::Trimmed)]
    pub iges: Iges,
}

/// How a run goes about its work, which leaves the files as they are.
#[derive(Debug, Args)]
pub struct Manner {
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Refuse a scan that may need more memory than this, as 4G; told from its counts
    /// and the largest net, before the work
    #[arg(long, value_name = "SIZE")]
    pub max_memory: Option<bytesize::ByteSize>,
    /// Say nothing but errors
    #[arg(long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Colours in messages
    #[arg(long, value_enum, default_value_t = Colour::Auto)]
    pub color: Colour,
    /// Say more
    #[arg(short, long)]
    pub verbose: bool,
}

/// A unit on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Unit {
    Mm,
    Cm,
    M,
    In,
}

impl From<Unit> for LengthUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Mm => LengthUnit::Millimetre,
            Unit::Cm => LengthUnit::Centimetre,
            Unit::M => LengthUnit::Metre,
            Unit::In => LengthUnit::Inch,
        }
    }
}

/// What becomes of the outer boundary.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Outline {
    /// Sides
    Auto,
    /// The four sides of the surface
    Sides,
    /// A trim loop
    Trimmed,
}

/// A fitting method on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Fit {
    /// Blended local fits (Tekumalla & Cohen)
    Blend,
    /// The blended fit, refined to the least-squares optimum
    Refined,
    /// Sparse global least squares
    Global,
}

/// Which pieces of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    Largest,
    All,
    Number(usize),
}

/// A STEP schema on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Schema {
    Ap203,
    Ap214,
    Ap242,
}

/// An IGES form on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Iges {
    Trimmed,
    Brep,
}

/// When to colour.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Colour {
    Auto,
    Always,
    Never,
}

impl Colour {
    /// Whether standard error gets colours.
    pub fn is_on(self) -> bool {
        match self {
            Colour::Auto => {
                std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
            }
            Colour::Always => true,
            Colour::Never => false,
        }
    }
}

/// A CAD file to write.
#[derive(Debug, Clone)]
pub struct CadFile {
    pub path: PathBuf,
    pub kind: CadKind,
}

/// Its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CadKind {
    Step,
    Iges,
}

fn extension(path: &str) -> String {
    let extension = PathBuf::from(path).extension().map(|e| e.to_string_lossy().to_lowercase());
    extension.unwrap_or_default()
}

fn cad_file(path: &str) -> Result<CadFile, String> {
    let kind = match extension(path).as_str() {
        "step" | "stp" => CadKind::Step,
        "igs" | "iges" => CadKind::Iges,
        _ => return Err("not .step, .stp, .igs or .iges".into()),
    };
    Ok(CadFile { path: path.into(), kind })
}

fn report_file(path: &str) -> Result<ReportFile, String> {
    let kind = match extension(path).as_str() {
        "json" => Kind::Json,
        "html" | "htm" => Kind::Html,
        "png" => Kind::Png,
        _ => return Err("not .json, .html or .png".into()),
    };
    Ok(ReportFile { path: path.into(), kind })
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "not a number".to_string())
}

fn positive(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    if x > 0.0 && x.is_finite() { Ok(x) } else { Err("not a length above 0".into()) }
}

fn percentage(text: &str) -> Result<f64, String> {
    let x = number(text)?;
    if (0.0..100.0).contains(&x) {
        Ok(x)
    } else {
        Err("not a percentage from 0 to below 100".into())
    }
}

fn support(text: &str) -> Result<scan2step::smooth::Support, String> {
    use scan2step::smooth::Support;
    match text {
        "auto" => Ok(Support::Auto),
        "off" => Ok(Support::Off),
        length => positive(length).map(Support::Fixed),
    }
}

fn component(text: &str) -> Result<Component, String> {
    match text {
        "largest" => Ok(Component::Largest),
        "all" => Ok(Component::All),
        n => n.parse().map(Component::Number).map_err(|_| "not largest, all or a number".into()),
    }
}

fn one_component(text: &str) -> Result<scan2step::mesh::Choice, String> {
    use scan2step::mesh::Choice;
    match component(text) {
        Ok(Component::Largest) => Ok(Choice::Largest),
        Ok(Component::Number(n)) => Ok(Choice::Number(n)),
        _ => Err("not largest or a number".into()),
    }
}

fn net(text: &str) -> Result<[usize; 2], String> {
    let (m, n) = text.split_once(['x', 'X', '×']).ok_or("not of the form 13x13")?;
    let side = |s: &str| {
        let n: usize = s.trim().parse().map_err(|_| "not of the form 13x13".to_string())?;
        if n < 4 { Err("a bicubic net has at least 4x4 control points".to_string()) } else { Ok(n) }
    };
    Ok([side(m)?, side(n)?])
}
