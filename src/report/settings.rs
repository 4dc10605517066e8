//! What the caller asked for, by the names that options have on the command line.

use formats::{iges, step};

use super::ScanSource;
use super::figures::fit_method;
use crate::convert::{Cut, EdgeChoice, Options, ScanPlace, SurfaceChoice, TargetShape};
use crate::geometry::Point;
use crate::mesh::{Choice, Outer, SeamWidth};
use crate::stages::parameterize;
use crate::stages::smooth::{Corners, Support};

/// What the caller asked for. `None`, and "auto", leave it to what is found on the scan.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct Settings {
    /// The symbol of the unit of the scan's numbers.
    pub units: Option<&'static str>,
    /// The distance in mm to which a cloud of points is thinned.
    pub spacing: Option<f64>,
    /// The largest number of points of a cloud.
    pub max_points: Option<usize>,
    /// The scan of a cloud with several, counted from 0.
    pub scan: Option<usize>,
    /// Where the result lies if a cloud is far from zero: "local" or "keep".
    pub origin: &'static str,
    /// A place on the outer boundary loop: one item.
    pub outer: Option<Vec<ScanPlace>>,
    /// What the scan becomes: "auto", "face", "shell" or "solid".
    pub shape: &'static str,
    /// The farthest that a point of the smoothed scan may be from the face, in mm.
    pub tolerance: Option<f64>,
    /// How far a trim loop may be from the measured rim, in mm.
    pub rim_tolerance: Option<f64>,
    /// The percentage of points that may exceed the tolerance.
    pub outliers: f64,
    /// The four corners of the domain.
    pub corners: Option<Vec<ScanPlace>>,
    /// Where the outer boundary goes: "auto", "sides" or "trimmed".
    pub outline: &'static str,
    /// The map to the parameter plane: "least-stretch" or "mean-value".
    pub map: &'static str,
    /// Where smoothing keeps a corner of the boundary: "auto", "none" or places.
    pub boundary_corners: Setting<Vec<ScanPlace>>,
    /// Support of the smoothing: "auto", "off" or a length in mm.
    pub smooth: Setting<f64>,
    /// How to fit: "blend", "refined" or "global".
    pub fit: &'static str,
    /// The paper's κ, in mm.
    pub kappa: Option<f64>,
    /// The largest number of times that the domain is halved.
    pub depth: Option<u32>,
    /// Control points of a uniform net along u and v.
    pub net: Option<[usize; 2]>,
    /// The largest number of control points.
    pub max_net: usize,
    /// The longest loop of a handle that is cut, in mm.
    pub handles: Option<f64>,
    /// The distance in mm at which points of rims are joined.
    pub weld: Option<f64>,
    /// Whether a mesh is taken by its points alone.
    pub remesh: bool,
    /// Two corners of a box outside of which everything was left out, in the scan's numbers.
    pub r#box: Option<[[f64; 3]; 2]>,
    /// A plane below which everything was left out: a x + b y + c z > d in the scan's numbers.
    pub above: Option<[f64; 4]>,
    /// Whether the plane under the object was left out.
    pub remove_plane: bool,
    /// The surfaces of faces: "auto" or "spline".
    pub surfaces: &'static str,
    /// Whether prisms of few sides stay flat.
    pub keep_polygons: bool,
    /// Whether sizes of a scan become round.
    pub regularize: bool,
    /// The size of systematic errors of the scanner in mm.
    pub bias: Option<f64>,
    /// Whether a part is turned to the axes of the world.
    pub align: bool,
    /// Where exact faces end: "auto", "off" or an angle in degrees.
    pub edges: Setting<f64>,
    /// About how many faces a solid gets.
    pub faces: Option<usize>,
    /// Holes with a rim shorter than this, in mm, stay filled.
    pub fill_only_holes_below: Option<f64>,
    /// Whether all holes stay filled.
    pub keep_fills: bool,
    /// Which component: "auto", "largest", "all" or a number.
    pub component: Setting<usize>,
    /// What becomes of the parts of a file with several: "keep", "merge", a number or "name:" and a name. `None` leaves
    /// it to what suits the file.
    pub parts: Option<String>,
    /// Whether a part that fails fails all.
    pub strict: bool,
    /// The axis that points up in the result: "keep", "y" or "z".
    pub up: &'static str,
    /// The schema of STEP files: "ap203", "ap214" or "ap242".
    pub schema: &'static str,
    /// The form of IGES files: "trimmed" or "brep".
    pub iges: &'static str,
}

/// One of a few words, or a value.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
pub enum Setting<T> {
    /// One of the words that the option knows.
    Word(&'static str),
    /// A value.
    Value(T),
}

impl Settings {
    /// The settings that some options stand for. Files have the default schema and form until
    /// [`Settings::of_files`] names others.
    pub fn of(options: &Options, source: &ScanSource) -> Self {
        let at = |points: &[Point]| -> Vec<ScanPlace> {
            let numbers = |p: &Point| ScanPlace::Point((p / source.unit.in_mm()).into());
            points.iter().map(numbers).collect()
        };
        let named = &options.places;
        let outer = match options.outer {
            Outer::Near(place) => Some(at(&[place])),
            Outer::Auto => None,
        };
        Settings {
            units: options.unit().map(|unit| unit.symbol()),
            spacing: options.cloud.spacing,
            max_points: options.cloud.max_points,
            scan: options.cloud.scan,
            origin: if options.keeps_origin { "keep" } else { "local" },
            outer: named.outer.map(|place| vec![place]).or(outer),
            shape: options.shape.map_or("auto", TargetShape::word),
            tolerance: options.tolerance,
            rim_tolerance: options.rim_tolerance,
            outliers: 100.0 * options.outliers,
            corners: named.corners.clone().or(options.parameterize.corners.map(|c| at(&c))),
            outline: match options.parameterize.outline {
                None => "auto",
                Some(parameterize::Outline::Sides) => "sides",
                Some(parameterize::Outline::Free) => "trimmed",
            },
            map: match options.parameterize.method {
                parameterize::MapMethod::LeastStretch => "least-stretch",
                parameterize::MapMethod::MeanValue => "mean-value",
            },
            boundary_corners: match (&named.boundary_corners, &options.smooth.corners) {
                (Some(places), _) => Setting::Value(places.clone()),
                (None, Corners::Auto) => Setting::Word("auto"),
                (None, Corners::None) => Setting::Word("none"),
                (None, Corners::At(points)) => Setting::Value(at(points)),
            },
            smooth: match options.smooth.support {
                Support::Auto => Setting::Word("auto"),
                Support::Off => Setting::Word("off"),
                Support::Fixed(h) => Setting::Value(h),
            },
            fit: fit_method(options.method),
            kappa: options.knots.kappa,
            depth: options.knots.depth,
            net: options.knots.net,
            max_net: options.knots.largest_net(),
            r#box: options.cloud.crop.within,
            above: options.cloud.crop.above,
            remove_plane: options.cloud.crop.without_plane,
            handles: options.handles,
            remesh: options.remesh,
            weld: match options.weld {
                SeamWidth::Auto => None,
                SeamWidth::Fixed(length) => Some(length),
            },
            surfaces: match options.surfaces {
                SurfaceChoice::Auto => "auto",
                SurfaceChoice::Spline => "spline",
            },
            keep_polygons: options.keep_polygons,
            regularize: options.regularize,
            bias: options.bias,
            align: options.align,
            edges: match options.edges {
                EdgeChoice::Auto => Setting::Word("auto"),
                EdgeChoice::Off => Setting::Word("off"),
                EdgeChoice::Degrees(degrees) => Setting::Value(degrees),
            },
            faces: options.faces,
            fill_only_holes_below: match options.cut {
                Cut::FromLength(length) => Some(length),
                Cut::All | Cut::None => None,
            },
            keep_fills: options.cut == Cut::None,
            component: match options.component {
                _ if options.all_components => Setting::Word("all"),
                Choice::Auto => Setting::Word("auto"),
                Choice::Largest => Setting::Word("largest"),
                Choice::Number(n) => Setting::Value(n),
            },
            parts: None,
            strict: false,
            up: "keep",
            schema: schema(step::Schema::default()),
            iges: form(iges::Form::default()),
        }
    }

    /// The same with the schema and the form of the files that were written.
    #[must_use]
    pub fn of_files(self, step: step::Schema, iges: iges::Form) -> Self {
        Settings { schema: schema(step), iges: form(iges), ..self }
    }
}

impl Settings {
    /// The same with what was chosen of the scene of the file: its parts, whether one that fails fails all, and the axis
    /// that points up.
    #[must_use]
    pub fn of_scene(self, parts: Option<String>, strict: bool, up: &'static str) -> Self {
        Settings { parts, strict, up, ..self }
    }
}

fn schema(schema: step::Schema) -> &'static str {
    match schema {
        step::Schema::Ap203 => "ap203",
        step::Schema::Ap214 => "ap214",
        step::Schema::Ap242 => "ap242",
    }
}

fn form(form: iges::Form) -> &'static str {
    match form {
        iges::Form::Trimmed => "trimmed",
        iges::Form::Brep => "brep",
    }
}
