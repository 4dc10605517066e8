//! Options whose values are a few words.

use clap::ValueEnum;
use formats::LengthUnit;

/// A unit on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Unit {
    #[value(alias = "micrometre", alias = "micrometres", alias = "µm")]
    Um,
    #[value(alias = "millimetre", alias = "millimetres", alias = "millimeter")]
    Mm,
    #[value(alias = "centimetre", alias = "centimetres", alias = "centimeter")]
    Cm,
    #[value(alias = "metre", alias = "metres", alias = "meter")]
    M,
    #[value(alias = "inch", alias = "inches")]
    In,
    #[value(alias = "foot", alias = "feet")]
    Ft,
}

impl From<Unit> for LengthUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Um => LengthUnit::Micrometre,
            Unit::Mm => LengthUnit::Millimetre,
            Unit::Cm => LengthUnit::Centimetre,
            Unit::M => LengthUnit::Metre,
            Unit::In => LengthUnit::Inch,
            Unit::Ft => LengthUnit::Foot,
        }
    }
}

/// Where the result lies if a scan is far from zero.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Origin {
    /// Near zero; the report and the file say from where its coordinates are measured
    Local,
    /// Where the scan is
    Keep,
}

/// The axis that points up in the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Up {
    /// Leave the numbers as they are
    Keep,
    /// Turn the scan so that y points up, as in glTF
    Y,
    /// Turn the scan so that z points up, as in CAD programs
    Z,
}

impl Up {
    /// Its word on the command line.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Up::Keep => "keep",
            Up::Y => "y",
            Up::Z => "z",
        }
    }
}

/// How a run shows its progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Steps {
    /// A bar, on a terminal
    Bar,
    /// A line of JSON for each step, with --quiet, too: {"stage":"fit","share":0.61,"seconds":1.5}
    Json,
}

/// What becomes of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShapeChoice {
    /// A solid if the scan is closed, or if fillings of its gaps add less than 5 % to its area;
    /// otherwise a face if one holds the scan, and a shell if not
    Auto,
    /// One trimmed face
    Face,
    /// A shell of several faces; the boundaries and holes of the scan stay open
    Shell,
    /// A solid of several faces; all gaps are filled
    Solid,
}

/// Which surfaces the faces get.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfacesChoice {
    /// Planes, cylinders, cones, spheres and tori where a mesh of a CAD program has them; otherwise
    /// B-splines
    Auto,
    /// B-splines
    Spline,
}

/// Where the outer boundary goes.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum OutlineChoice {
    /// The sides; a trim loop if the boundary is ragged, or if the sides stretch the map far
    /// more or cannot be made
    Auto,
    /// The four sides of the surface
    Sides,
    /// A trim loop
    Trimmed,
}

/// A map to the parameter plane on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Map {
    /// The map of least stretch
    LeastStretch,
    /// Mean value coordinates (Floater), as in the paper
    MeanValue,
}

/// A fitting method on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Fit {
    /// Blended local fits (Tekumalla & Cohen)
    Blend,
    /// Least squares by conjugate gradients
    Refined,
    /// Sparse global least squares
    Global,
}

/// A STEP schema on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum StepSchema {
    Ap203,
    Ap214,
    Ap242,
}

/// An IGES form on the command line.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Iges {
    Trimmed,
    Brep,
}
