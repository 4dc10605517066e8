//! Reports: what a conversion did and how well, as types, text, a page and a picture.
//!
//! [`Report`] goes in front of all of them: it is made of a [`Conversion`], the
//! [`ScanSource`] that it came from and the [`Settings`] that it was made with. The program's
//! `--report FILE` writes the same types, and `docs/report.schema.json` describes them.
//!
//! | feature | what it adds |
//! | --- | --- |
//! | none | the types: [`Report`], [`BodyFigures`] and their parts |
//! | `serde` | `serde::Serialize` for all of them |
//! | `json` | `Report::to_json`, the text of `--report FILE.json` |
//! | `picture` | `ReportView` and `picture_png`, the picture of `--report FILE.png` |
//! | `html` | `Report::write_html`, the page of `--report FILE.html` |
//!
//! Lengths are millimetres, points are x, y, z. Each field has the name that the JSON has.

mod assembly;
mod check;
mod cloud;
mod exact;
mod figures;
mod hints;
mod input;
#[cfg(feature = "json")]
mod json;
mod relations;
mod settings;
mod shape;
mod unused;

#[cfg(feature = "picture")]
mod exact_edges;
#[cfg(feature = "picture")]
mod exact_view;
#[cfg(feature = "picture")]
mod histogram;
#[cfg(feature = "picture")]
pub mod picture;
#[cfg(feature = "picture")]
mod scale;
#[cfg(feature = "picture")]
mod still;
#[cfg(feature = "picture")]
mod view;
#[cfg(feature = "picture")]
mod whole;

#[cfg(feature = "html")]
mod assembly_page;
#[cfg(feature = "html")]
mod bars;
#[cfg(feature = "html")]
mod command;
#[cfg(feature = "html")]
mod exact_rows;
mod exact_sizes;
#[cfg(feature = "html")]
mod face_mesh;
#[cfg(feature = "html")]
mod far_places;
#[cfg(feature = "html")]
mod filters;
#[cfg(feature = "html")]
mod html;
#[cfg(feature = "html")]
mod plane;
#[cfg(feature = "html")]
mod scene;

pub use assembly::{
    AssemblyInspection, AssemblyReport, AssemblySource, InspectedPartFigures, PartFigures,
    PlaceFigures,
};
pub use check::{
    CadFigures, CheckFigures, CheckedPart, CheckedPlace, CheckedScan, DistanceFigures,
    MeasuredComponents,
};
pub use cloud::{CloudFigures, CloudMeshFigures, ScanFigures};
pub use exact::{
    CylinderFigures, ExactFigures, FacetFigures, GapFigures, RiserFigures, SnapFigures,
    SurfaceFigures,
};
pub use exact_sizes::{PlaneDistanceFigures, SizeFigures, UncertaintyFigures};
pub use figures::{
    BodyFigures, DeviationFigures, FaceToScanFigures, FillFigures, FitFigures, HoleFigures,
    MapFigures, SmoothFigures, SurfaceFitFigures, ThinFigures, TrimFigures, TrimOf,
};
pub use hints::likely_unit;
pub use input::{
    EstimateFigures, InputFigures, InspectionFigures, PieceFigures, RimFigures, ScanSource,
};
pub use relations::RelationFigures;
pub use settings::{Setting, Settings};
pub use shape::{PatchFigures, SeamFigures, ShapeFigures, SurfaceCounts};
#[cfg(feature = "picture")]
pub use still::picture_png;
#[cfg(feature = "picture")]
pub use view::{ReportView, ViewRecorder};
#[cfg(feature = "picture")]
pub use whole::{AssemblyView, assembly_png};

use formats::scene::Placement;

use crate::convert::Conversion;

/// What a run was asked for, what it made and how well.
///
/// ```
/// use scan2step::formats::{LengthUnit, Soup};
/// use scan2step::report::{Report, Settings, ScanSource};
/// use scan2step::{Options, convert};
///
/// # fn main() -> scan2step::Result<()> {
/// // A flat sheet of 20 × 20 cm.
/// let mut soup = Soup { unit: Some(LengthUnit::Centimetre), ..Soup::default() };
/// for k in 0..21 * 21 {
///     soup.points.push([f64::from(k % 21), f64::from(k / 21), 0.0]);
/// }
/// for a in (0..21 * 20).filter(|a| a % 21 < 20) {
///     soup.polygons.push([a, a + 1, a + 22, a + 21]);
/// }
/// let options = Options::builder().tolerance(0.1).build()?;
/// let conversion = convert(&soup, &options, &mut |_| Ok(()))?;
///
/// let source = ScanSource::of("sheet.ply", &soup, &options);
/// let settings = Settings::of(&options, &source);
/// let report = Report::of(&conversion, &source, settings);
/// let face = &report.bodies[0];
/// assert_eq!(face.input.units, "cm");
/// assert!(face.tolerance_met && face.fit.deviation.max_mm < 0.1);
/// // With the feature `json`: std::fs::write("sheet.json", report.to_json())?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Report {
    /// The version of this library.
    pub scan2step: &'static str,
    /// The figures of each body. In the JSON those of the first stand beside the other fields, and all are in
    /// `components` if there are several.
    #[cfg_attr(feature = "serde", serde(flatten, serialize_with = "serialize_parts"))]
    pub bodies: Vec<BodyFigures>,
    /// The rows of the matrix that has put the parts to the axes of the world: it takes places of the scan's own frame, in mm, to those of the
    /// parts. `None` if they are where the scan is.
    pub placement: Option<[[f64; 4]; 3]>,
    /// Whether the caller named the tolerance.
    pub tolerance_named: bool,
    /// The percentage of points that may exceed the tolerance.
    pub outliers_pct: f64,
    /// What the caller asked for; `options` in the JSON.
    #[cfg_attr(feature = "serde", serde(rename = "options"))]
    pub settings: Settings,
    /// What could be better, and what to do about it: one sentence each. Options have the
    /// names that they have on the command line.
    pub hints: Vec<String>,
    /// The words of a command line that makes the same files; empty if there is none. The caller
    /// fills it in.
    pub command: Vec<String>,
    /// How long each stage took. The caller fills it in, as it has the clock.
    pub stages: Vec<StageFigures>,
    /// The files that were written. The caller fills it in.
    pub outputs: Vec<OutputFile>,
    /// Seconds since the run began. The caller fills it in.
    pub seconds: f64,
    /// The largest resident memory of the process, in MB (10⁶ bytes). The caller fills it in.
    pub peak_rss_mb: f64,
}

/// What one stage took.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StageFigures {
    /// Its name ([`Stage::name`](crate::convert::Stage::name)), or "read" or "write".
    pub name: String,
    /// How long it took.
    pub seconds: f64,
    /// The largest resident memory of the process up to its end, in MB (10⁶ bytes).
    pub peak_rss_mb: f64,
}

/// A file that a run has written.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OutputFile {
    /// The file as the caller named it.
    pub file: String,
    /// Its length.
    pub bytes: u64,
    /// The SHA-256 of its content, in hexadecimal.
    pub sha256: String,
}

/// The version of this library.
const VERSION: &str = env!("CARGO_PKG_VERSION");

impl Report {
    /// The report of a conversion. The command, stages, outputs, seconds and memory
    /// are empty or 0 until the caller fills them in.
    pub fn of(conversion: &Conversion, source: &ScanSource, settings: Settings) -> Self {
        let outliers = settings.outliers / 100.0;
        let figures = |body| {
            let mut figures = BodyFigures::of(body, source, outliers);
            figures.shape.fallback.clone_from(&conversion.fallback);
            figures
        };
        Report {
            scan2step: VERSION,
            bodies: conversion.bodies().map(figures).collect(),
            placement: conversion.placement().map(|of| placement_rows(&of)),
            tolerance_named: settings.tolerance.is_some(),
            outliers_pct: settings.outliers,
            hints: hints::of(conversion, source, &settings),
            settings,
            command: Vec::new(),
            stages: Vec::new(),
            outputs: Vec::new(),
            seconds: 0.0,
            peak_rss_mb: 0.0,
        }
    }

    /// The name of the scan's file without its folder; empty if there is no body.
    #[cfg(feature = "html")]
    fn name(&self) -> String {
        self.bodies.first().map_or(String::new(), |body| file_name(&body.input.file))
    }
}

/// The rows of the matrix of a placement, with the translation as last column.
pub fn placement_rows(of: &Placement) -> [[f64; 4]; 3] {
    let [x, y, z] = of.axes;
    [0, 1, 2].map(|k| [x[k], y[k], z[k], of.translation[k]])
}

/// The placement with such rows.
pub fn placement_of_rows(rows: [[f64; 4]; 3]) -> Placement {
    let axes = [0, 1, 2].map(|k| rows.map(|row| row[k]));
    Placement { axes, translation: rows.map(|row| row[3]) }
}

/// The name of a file without its folder.
#[cfg(feature = "html")]
fn file_name(path: &str) -> String {
    let path = std::path::Path::new(path);
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The figures of the first component, and all of them if there are several.
#[cfg(feature = "serde")]
fn serialize_parts<F: serde::Serialize, S: serde::Serializer>(
    figures: &[F],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(serde::Serialize)]
    struct Parts<'a, F> {
        #[serde(flatten)]
        first: Option<&'a F>,
        #[serde(skip_serializing_if = "Option::is_none")]
        components: Option<&'a [F]>,
    }
    let components = (figures.len() > 1).then_some(figures);
    serde::Serialize::serialize(&Parts { first: figures.first(), components }, serializer)
}
