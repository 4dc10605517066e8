//! The options that `convert` and `batch` share.

use clap::Args;
use scan2step::EdgeChoice;

use super::choices::{Fit, Iges, Map, OutlineChoice, ShapeChoice, StepSchema, SurfacesChoice};
use super::colour::Colour;
use super::headings::{ACCURACY, DETAILS, FILES, HOLES, RUN, SCAN, SHAPE};
use super::numbers::{depth, edges, extent, faces, max_net, net, percentage, positive, support};
use super::pieces::{ComponentChoice, PartsChoice, component, parts};
use crate::cli::places::NamedCorners;

/// Options of the conversion, which `convert` and `batch` share.
#[derive(Debug, Args)]
pub(crate) struct How {
    /// What becomes of the scan
    #[arg(long, value_enum, default_value_t = ShapeChoice::Auto, help_heading = SHAPE)]
    pub shape: ShapeChoice,
    /// Which surfaces the faces get. Options that only B-spline faces have (--net, --kappa, --depth, --fit,
    /// --map, --outline, --corners, --faces, a length for --smooth) ask for spline
    #[arg(long, value_enum, default_value_t = SurfacesChoice::Auto, help_heading = SHAPE)]
    pub surfaces: SurfacesChoice,
    /// Leave prisms of few sides flat where a cylinder has all their corners
    #[arg(long, help_heading = SHAPE)]
    pub keep_polygons: bool,
    /// Make radii, angles and distances of planes in the scan of a part round where that is within two standard deviations
    #[arg(long, help_heading = SHAPE)]
    pub regularize: bool,
    /// The size of systematic errors of the scanner in mm, which neighbouring points share: faces of a scanned part may be so
    /// far off [default: about a third of the noise]
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub bias: Option<f64>,
    /// Turn a part so that its main plane lies in z = 0 and its main axis is one of the world; the report has the matrix
    #[arg(long, help_heading = SHAPE)]
    pub align: bool,
    /// Where exact faces end: auto, where another surface begins; an angle in degrees, also at every edge of the
    /// mesh that turns by more; off, nowhere, so that the faces are B-splines
    #[arg(long, value_name = "DEG|auto|off", default_value = "auto", value_parser = edges, help_heading = SHAPE)]
    pub edges: EdgeChoice,
    /// Cut handles and tunnels whose loop is not longer, in mm, and close them; 0 cuts none
    /// [default: a few edges]
    #[arg(long, value_name = "LEN", value_parser = extent, allow_hyphen_values = true, help_heading = SHAPE)]
    pub handles: Option<f64>,
    /// About how many faces a solid gets [default: as many as its shape needs]
    #[arg(long, value_name = "N", value_parser = faces, help_heading = SHAPE)]
    pub faces: Option<usize>,
    /// Largest distance of a smoothed point from the face, in mm, and of the face from the
    /// scan's triangles, to which the error of flat triangles is added [default: three times
    /// the noise of the scan]
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub tolerance: Option<f64>,
    /// Percentage of points that may exceed the tolerance
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = percentage, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub outliers: f64,
    /// Largest distance of a trim loop from the measured rim, in mm; 0 follows every tooth
    /// [default: the scatter of the rim, up to half of the scan's median edge at the rims, or the
    /// tolerance if that is larger; a named tolerance holds for loops, too]
    #[arg(long, value_name = "LEN", value_parser = extent, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub rim_tolerance: Option<f64>,
    /// Where the outer boundary goes: the four sides of the surface, or a trim loop inside it,
    /// as for holes
    #[arg(long, value_enum, default_value_t = OutlineChoice::Auto, help_heading = HOLES)]
    pub outline: OutlineChoice,
    /// Map of the scan to the parameter plane; mean values leave too little room for parts
    /// that stick out
    #[arg(long, value_enum, default_value_t = Map::LeastStretch, help_heading = DETAILS)]
    pub map: Map,
    /// Where smoothing keeps a corner of the boundary: auto, none, or places as
    /// in --corners
    #[arg(long, value_name = "LIST|auto|none", default_value = "auto", allow_hyphen_values = true, help_heading = DETAILS)]
    pub boundary_corners: NamedCorners,
    /// Support of the smoothing, in mm, or auto, or off
    #[arg(long, value_name = "LEN|auto|off", default_value = "auto", value_parser = support, allow_hyphen_values = true, help_heading = ACCURACY)]
    pub smooth: scan2step::stages::smooth::Support,
    /// Method of the fit
    #[arg(long, value_enum, default_value_t = Fit::Refined, help_heading = DETAILS)]
    pub fit: Fit,
    /// Mean distance of a region, in mm, above which it gets more knots [default: from the
    /// tolerance]
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true, help_heading = DETAILS)]
    pub kappa: Option<f64>,
    /// Largest number of times that the domain is halved [default: from the number of points]
    #[arg(long, value_name = "N", value_parser = depth, help_heading = DETAILS)]
    pub depth: Option<u32>,
    /// A uniform control net, as 13x13; overrides --kappa and --depth
    #[arg(long, value_name = "MxN", value_parser = net, help_heading = DETAILS)]
    pub net: Option<[usize; 2]>,
    /// Largest number of control points, of all faces of a body together [default: 250000, or as
    /// many as the layout of a body needs]
    #[arg(long, value_name = "N", value_parser = max_net, help_heading = DETAILS)]
    pub max_net: Option<usize>,
    /// Fill holes whose rim is shorter than this, in mm, and cut out the others; reports list
    /// the rims, from which ragged triangles were trimmed
    #[arg(long, value_name = "LEN", value_parser = positive, allow_hyphen_values = true, conflicts_with = "keep_fills", help_heading = HOLES)]
    pub fill_only_holes_below: Option<f64>,
    /// Fill all holes, and cut none out
    #[arg(long, help_heading = HOLES)]
    pub keep_fills: bool,
    /// Component of the scan: auto, largest, all, or a number (0 is the largest). By default every closed
    /// piece of a clean mesh, and otherwise the largest
    #[arg(long, value_name = "auto|largest|all|N", default_value = "auto", value_parser = component, help_heading = SCAN)]
    pub component: ComponentChoice,
    /// The parts of a file with several: keep, each once, placed as in the file; merge, all as one mesh; a number
    /// that `inspect` lists, that part alone; name:TEXT, the places of this name, or of a path of names with " / "
    /// between them [default: keep where all meshes are closed, and otherwise merge]
    #[arg(long, value_name = "keep|merge|N|name:TEXT", value_parser = parts, help_heading = SCAN)]
    pub parts: Option<PartsChoice>,
    /// Write nothing if a part cannot be converted
    #[arg(long, help_heading = SCAN)]
    pub strict: bool,
    /// STEP schema
    #[arg(long, value_enum, default_value_t = StepSchema::Ap242, help_heading = FILES)]
    pub schema: StepSchema,
    /// IGES form: trimmed surfaces (144) or a shell (514)
    #[arg(long, value_enum, default_value_t = Iges::Trimmed, help_heading = FILES)]
    pub iges: Iges,
}

/// Options of a run that do not change its files.
#[derive(Debug, Args)]
pub(crate) struct Manner {
    /// Threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = RUN)]
    pub threads: Option<u16>,
    /// Average a scan that may need more memory than this, as 4G, to as many places as fit, or refuse it; the estimate
    /// uses the counts of the scan and the largest net
    #[arg(long, value_name = "SIZE", help_heading = RUN)]
    pub max_memory: Option<bytesize::ByteSize>,
    /// Print errors only, and a note if a named tolerance is not met
    #[arg(short, long, conflicts_with = "verbose", help_heading = RUN)]
    pub quiet: bool,
    /// Colours in messages
    #[arg(long, value_enum, default_value_t = Colour::Auto, help_heading = RUN)]
    pub color: Colour,
    /// Print more
    #[arg(short, long, help_heading = RUN)]
    pub verbose: bool,
}
