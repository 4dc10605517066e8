//! Options that choose a scan and its components.

use clap::{Args, ValueHint};
use formats::points::{Columns, ReadOptions};
use scan2step::mesh::{Choice, Components, Outer};
use scan2step::{Builder, Options};

use super::choices::{Origin, Unit, Up};
use super::colour::Colour;
use super::files::{InputFile, input_file};
use super::headings::{CLOUD, RUN, SCAN};
use super::numbers::{extent, max_points, positive};
use crate::cli::places::Place;

/// The unit of a scan, and how its blocks are joined.
#[derive(Debug, Args)]
pub(crate) struct Scale {
    /// Unit of the scan's numbers [default: metres for glTF, else mm]
    #[arg(long, value_name = "UNIT", help_heading = SCAN)]
    pub units: Option<Unit>,
    /// Join points on the rims of a mesh that are no farther from each other, in mm; 0 joins none
    /// [default: a thousandth of the edges there]
    #[arg(long, value_name = "LEN", value_parser = extent, allow_hyphen_values = true, help_heading = SCAN)]
    pub weld: Option<f64>,
    /// The axis that points up in the result. The scan is turned about x if another one does in its format: y in
    /// glTF, z in all others. Places that are named are those of the turned scan
    #[arg(long, value_enum, default_value_t = Up::Keep, help_heading = SCAN)]
    pub up: Up,
}

/// Options of scans that are clouds of points.
#[derive(Debug, Args)]
pub(crate) struct CloudArgs {
    /// Thin a cloud of points to this distance between neighbours, in mm; holes that are not much
    /// wider are closed [default: to what its noise lets one tell]
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true, help_heading = CLOUD)]
    pub spacing: Option<f64>,
    /// Take at most so many points of a cloud, spread evenly [default: all]
    #[arg(long, value_name = "N", value_parser = max_points, help_heading = CLOUD)]
    pub max_points: Option<usize>,
    /// Take one scan of a cloud with several, counted from 0; `inspect` lists them [default: all
    /// together]
    #[arg(long = "scan", value_name = "N", help_heading = CLOUD)]
    pub scan_number: Option<usize>,
    /// Take only the points of these classes of a LAS or LAZ file, as 2,6 [default: all but
    /// noise, 7 and 18]
    #[arg(long = "class", value_name = "LIST", value_delimiter = ',', help_heading = CLOUD)]
    pub classes: Vec<u8>,
    /// Take only points with at least this intensity, in the numbers of a LAS, LAZ or E57 file
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true, help_heading = CLOUD)]
    pub min_intensity: Option<f64>,
    /// The columns of x, y and z in a text file, counted from 1, as 2,3,4, or their names, as East,North,Up; those
    /// of the normal may follow [default: found]
    #[arg(long, value_name = "LIST", help_heading = CLOUD)]
    pub columns: Option<Columns>,
    /// Take a mesh by its points alone, as a cloud: meshes of one surface that overlap become one
    #[arg(long, help_heading = SCAN)]
    pub remesh: bool,
    /// Where the result lies if the scan is far from zero: near zero, or where the scan is
    #[arg(long, value_enum, default_value_t = Origin::Local, help_heading = SCAN)]
    pub origin: Origin,
}

/// Options that leave out parts of a scan.
#[derive(Debug, Args)]
pub(crate) struct CropArgs {
    /// Leave out what is outside of a box between two places in the scan's numbers, as 0,0,0;10,10,5
    #[arg(long = "box", value_name = "x,y,z;x,y,z", value_parser = corners, allow_hyphen_values = true, help_heading = SCAN)]
    pub within: Option<[[f64; 3]; 2]>,
    /// Leave out what is not above a plane: a x + b y + c z > d in the scan's numbers, as 0,0,1,2.5
    #[arg(long, value_name = "a,b,c,d", value_parser = plane, allow_hyphen_values = true, help_heading = SCAN)]
    pub above: Option<[f64; 4]>,
    /// Leave out the largest plane that has the rest of the scan on one side: the turntable
    #[arg(long, help_heading = SCAN)]
    pub remove_plane: bool,
}

/// Numbers between commas.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|s| s.trim().parse()).collect();
    let numbers: [f64; N] = numbers.ok()?.try_into().ok()?;
    numbers.iter().all(|x| x.is_finite()).then_some(numbers)
}

fn corners(text: &str) -> Result<[[f64; 3]; 2], String> {
    let corners = text.split_once(';').and_then(|(a, b)| Some([numbers(a)?, numbers(b)?]));
    corners.ok_or_else(|| "not of the form x,y,z;x,y,z".into())
}

fn plane(text: &str) -> Result<[f64; 4], String> {
    let plane = numbers(text).filter(|[a, b, c, _]| [*a, *b, *c] != [0.0; 3]);
    plane.ok_or_else(|| "not of the form a,b,c,d, with a, b or c other than 0".into())
}

/// The scan and its outer boundary.
#[derive(Debug, Args)]
pub(crate) struct Piece {
    /// The scan, or - for standard input
    #[arg(value_parser = input_file(), value_hint = ValueHint::FilePath)]
    pub scan: InputFile,
    #[command(flatten)]
    pub scale: Scale,
    #[command(flatten)]
    pub crop: CropArgs,
    #[command(flatten)]
    pub cloud: CloudArgs,
    /// A place on the outer boundary loop: a vertex index, counted from 0, or a point in the
    /// scan's numbers [default: the largest loop that does not run around a hole]
    #[arg(long, value_name = "V|x,y,z", allow_hyphen_values = true, help_heading = SCAN)]
    pub outer: Option<Place>,
}

/// Options of the commands that print what they find.
#[derive(Debug, Args)]
pub(crate) struct Look {
    /// Print one JSON object; lengths are mm
    #[arg(long, help_heading = RUN)]
    pub json: bool,
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = RUN)]
    pub threads: Option<u16>,
    /// Colours in messages
    #[arg(long, value_enum, default_value_t = Colour::Auto, help_heading = RUN)]
    pub color: Colour,
}

impl CloudArgs {
    /// What is read of the file.
    pub(crate) fn reading(&self) -> ReadOptions {
        ReadOptions {
            classes: self.classes.clone(),
            min_intensity: self.min_intensity,
            columns: self.columns.clone(),
        }
    }

    /// A sentence for each option of reading that was named and does not matter for a mesh.
    pub(crate) fn unused_in_mesh(&self) -> impl Iterator<Item = &'static str> {
        let options = [
            (!self.classes.is_empty(), "--class has no effect: the scan is a mesh, not a cloud"),
            (
                self.min_intensity.is_some(),
                "--min-intensity has no effect: the scan is a mesh, not a cloud",
            ),
            (self.columns.is_some(), "--columns has no effect: the scan is a mesh, not a cloud"),
        ];
        options.into_iter().filter(|(is_named, _)| *is_named).map(|(_, sentence)| sentence)
    }

    /// The options of the library that they stand for, with the unit that was named.
    pub(crate) fn options(&self, scale: &Scale, crop: &CropArgs) -> Builder {
        let options = Options::builder()
            .within(crop.within)
            .above(crop.above)
            .without_plane(crop.remove_plane)
            .weld(scale.weld)
            .remesh(self.remesh)
            .spacing(self.spacing)
            .max_points(self.max_points)
            .scan_number(self.scan_number)
            .keeps_origin(matches!(self.origin, Origin::Keep));
        scale.units.map_or(options.clone(), |unit| options.unit(unit.into()))
    }
}

/// Components of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ComponentChoice {
    Auto,
    Largest,
    All,
    Number(usize),
}

impl ComponentChoice {
    /// The components that it names.
    pub(crate) fn of(self, scan: &Components, outer: Outer) -> Vec<Choice> {
        match self {
            ComponentChoice::Auto => vec![Choice::Auto],
            ComponentChoice::Largest => vec![Choice::Largest],
            ComponentChoice::Number(n) => vec![Choice::Number(n)],
            ComponentChoice::All => scan.all(outer),
        }
    }
}

pub(super) fn component(text: &str) -> Result<ComponentChoice, String> {
    match text {
        "auto" => Ok(ComponentChoice::Auto),
        "largest" => Ok(ComponentChoice::Largest),
        "all" => Ok(ComponentChoice::All),
        n => n
            .parse()
            .map(ComponentChoice::Number)
            .map_err(|_| "not auto, largest, all or a number".into()),
    }
}

pub(crate) fn one_component(text: &str) -> Result<Choice, String> {
    match component(text) {
        Ok(ComponentChoice::Auto | ComponentChoice::Largest) => Ok(Choice::Largest),
        Ok(ComponentChoice::Number(n)) => Ok(Choice::Number(n)),
        _ => Err("not largest or a number".into()),
    }
}

/// What becomes of the parts of a file with several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum PartsChoice {
    Keep,
    Merge,
    Number(usize),
    Name(String),
}

impl std::fmt::Display for PartsChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            PartsChoice::Keep => f.write_str("keep"),
            PartsChoice::Merge => f.write_str("merge"),
            PartsChoice::Number(number) => write!(f, "{number}"),
            PartsChoice::Name(name) => write!(f, "name:{name}"),
        }
    }
}

pub(super) fn parts(text: &str) -> Result<PartsChoice, String> {
    match (text, text.strip_prefix("name:")) {
        ("keep", _) => Ok(PartsChoice::Keep),
        ("merge", _) => Ok(PartsChoice::Merge),
        (_, Some(name)) if !name.is_empty() => Ok(PartsChoice::Name(name.to_owned())),
        _ => {
            let number = text.parse().map(PartsChoice::Number);
            number.map_err(|_| "not keep, merge, a number or name:TEXT".into())
        }
    }
}
