//! Options, chosen one by one.

use formats::LengthUnit;

use super::{EdgeChoice, Options, SurfaceChoice};
use crate::convert::{Cut, ScanPlace, TargetShape};
use crate::error::Result;
use crate::geometry::Point;
use crate::mesh;
use crate::stages::{fit, parameterize, smooth};

/// Makes [`Options`]. What is not named is found on the scan, or as the method has
/// it; `None`, where a setter takes it, is the same as not to name it. The names are
/// those of the command line's options.
#[derive(Debug, Clone, Default)]
#[must_use]
pub struct Builder(Options);

impl Builder {
    /// The part's name in the CAD file. Without: "scan".
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.0.name = name.into();
        self
    }

    /// The unit of the scan's numbers. Without: the one that the scan declares, as glTF does,
    /// or else millimetres.
    pub fn unit(self, unit: LengthUnit) -> Self {
        self.unit_mm(unit.in_mm())
    }

    /// The length of the scan's unit, in mm, where it has no name.
    pub fn unit_mm(mut self, mm: f64) -> Self {
        self.0.unit_mm = Some(mm);
        self
    }

    /// Thins a cloud of points to this distance between neighbours, in mm. Without: to what its
    /// noise lets one tell.
    pub fn spacing(mut self, mm: impl Into<Option<f64>>) -> Self {
        self.0.cloud.spacing = mm.into();
        self
    }

    /// Takes at most so many points of a cloud, spread evenly. Without: all of them.
    pub fn max_points(mut self, count: impl Into<Option<usize>>) -> Self {
        self.0.cloud.max_points = count.into();
        self
    }

    /// Takes one scan of a cloud with several, counted from 0. Without: all of them together.
    pub fn scan_number(mut self, number: impl Into<Option<usize>>) -> Self {
        self.0.cloud.scan = number.into();
        self
    }

    /// Leaves out what is outside of a box between two places in the scan's own numbers.
    pub fn within(mut self, corners: impl Into<Option<[[f64; 3]; 2]>>) -> Self {
        self.0.cloud.crop.within = corners.into();
        self
    }

    /// Leaves out what is not above a plane `[a, b, c, d]`: a x + b y + c z > d in the scan's own numbers.
    pub fn above(mut self, plane: impl Into<Option<[f64; 4]>>) -> Self {
        self.0.cloud.crop.above = plane.into();
        self
    }

    /// Leaves out the largest plane that has the rest of the scan on one side: the turntable.
    pub fn without_plane(mut self, is_left_out: bool) -> Self {
        self.0.cloud.crop.without_plane = is_left_out;
        self
    }

    /// Whether the face of a scan that is far from the origin lies where the scan is. Without:
    /// it lies near the origin, which CAD programs need to keep its digits.
    pub fn keeps_origin(mut self, keeps: bool) -> Self {
        self.0.keeps_origin = keeps;
        self
    }

    /// Which piece of the scan. Without: the largest.
    pub fn component(mut self, component: mesh::Choice) -> Self {
        self.0.component = component;
        self
    }

    /// Converts all pieces of the scan that are worth a face, and not only one.
    pub fn all_components(mut self, all: bool) -> Self {
        self.0.all_components = all;
        self
    }

    /// Which of its boundary loops is the outer one; the others are holes.
    pub fn outer(mut self, outer: mesh::Outer) -> Self {
        self.0.outer = outer;
        self
    }

    /// The same by a vertex of the file, or by a point in the scan's own numbers.
    pub fn outer_place(mut self, place: impl Into<Option<ScanPlace>>) -> Self {
        self.0.places.outer = place.into();
        self
    }

    /// The support of the smoothing.
    pub fn smooth(mut self, support: smooth::Support) -> Self {
        self.0.smooth.support = support;
        self
    }

    /// Where smoothing keeps a corner of the boundary.
    pub fn boundary_corners(mut self, corners: smooth::Corners) -> Self {
        self.0.smooth.corners = corners;
        self
    }

    /// The same by vertices of the file, or by points in the scan's own numbers.
    pub fn boundary_corner_places(mut self, places: impl Into<Option<Vec<ScanPlace>>>) -> Self {
        self.0.places.boundary_corners = places.into();
        self
    }

    /// The angle, in radians, below which filling closes ears of its front: the
    /// paper's φ. Without: 5π/9.
    pub fn ear_angle(mut self, radians: f64) -> Self {
        self.0.fill.ear_angle = radians;
        self
    }

    /// Points, in mm, next to which the four corners of the domain lie, in any
    /// direction around; the first becomes (0, 0).
    pub fn corners(mut self, corners: impl Into<Option<[Point; 4]>>) -> Self {
        self.0.parameterize.corners = corners.into();
        self
    }

    /// The same four corners by vertices of the file, or by points in the scan's own numbers.
    pub fn corner_places(mut self, places: impl Into<Option<Vec<ScanPlace>>>) -> Self {
        self.0.places.corners = places.into();
        self
    }

    /// Where the outer boundary goes.
    pub fn outline(mut self, outline: impl Into<Option<parameterize::Outline>>) -> Self {
        self.0.parameterize.outline = outline.into();
        self
    }

    /// Which map to the parameter plane is made.
    pub fn map(mut self, method: parameterize::MapMethod) -> Self {
        self.0.parameterize.method = method;
        self
    }

    /// The paper's κ: the mean distance, in mm, above which a region gets more
    /// knots.
    pub fn kappa(mut self, mm: impl Into<Option<f64>>) -> Self {
        self.0.knots.kappa = mm.into();
        self
    }

    /// Halvings of the domain at the most.
    pub fn depth(mut self, halvings: impl Into<Option<u32>>) -> Self {
        self.0.knots.depth = halvings.into();
        self
    }

    /// A uniform net of so many control points along u and v; κ and depth are not
    /// looked at then.
    pub fn net(mut self, net: impl Into<Option<[usize; 2]>>) -> Self {
        self.0.knots.net = net.into();
        self
    }

    /// Control points at the most, of a face or of all faces of a body together. Without: 250,000, or as many as the layout
    /// of a body needs.
    pub fn max_net(mut self, control_points: usize) -> Self {
        self.0.knots.max_net = Some(control_points);
        self
    }

    /// Handles and tunnels whose loop is not longer, in mm, are cut and closed. The loop may run across
    /// gaps. At 0 none are cut. Without: a few edges.
    pub fn handles(mut self, mm: impl Into<Option<f64>>) -> Self {
        self.0.handles = mm.into();
        self
    }

    /// Points of a mesh's rims that are no farther from each other, in mm, are one point. At 0 none are. Without: those
    /// that are far nearer to each other than the edges there. Points that are equal but for rounding are always one.
    pub fn weld(mut self, mm: impl Into<Option<f64>>) -> Self {
        self.0.weld = mm.into().map_or(mesh::SeamWidth::Auto, mesh::SeamWidth::Fixed);
        self
    }

    /// A mesh is taken by its points alone, as a cloud is. Meshes of one surface that overlap become one.
    pub fn remesh(mut self, on: bool) -> Self {
        self.0.remesh = on;
        self
    }

    /// What components become: faces, shells or solids. Those that are voids in a solid are found. Without, the
    /// shape that suits them.
    pub fn shape(mut self, shape: impl Into<Option<TargetShape>>) -> Self {
        self.0.shape = shape.into();
        self
    }

    /// Which surfaces the faces get. Options that only B-spline surfaces have ask for these
    /// ([`Options::spline_option`]).
    pub fn surfaces(mut self, surfaces: SurfaceChoice) -> Self {
        self.0.surfaces = surfaces;
        self
    }

    /// Whether prisms of few sides stay flat where a cylinder has all their corners.
    pub fn keep_polygons(mut self, keeps: bool) -> Self {
        self.0.keep_polygons = keeps;
        self
    }

    /// Whether sizes of a scan's exact faces become round numbers that are within two standard deviations.
    pub fn regularize(mut self, regularizes: bool) -> Self {
        self.0.regularize = regularizes;
        self
    }

    /// The size in mm of systematic errors of the scanner, which neighbouring points share, so that they do not show as noise: waves and
    /// offsets of CT scans and of line scanners. Exact faces of a scan may be so far off, and it is part of their standard deviations.
    pub fn bias(mut self, length: Option<f64>) -> Self {
        self.0.bias = length;
        self
    }

    /// Whether a part with exact faces is turned to the axes of the world: its main plane lies in z = 0, and its main axis is one of
    /// them. [`Conversion::placement`](crate::Conversion::placement) says how.
    pub fn align(mut self, aligns: bool) -> Self {
        self.0.align = aligns;
        self
    }

    /// Where exact faces end. [`EdgeChoice::Off`] asks for B-spline faces.
    pub fn edges(mut self, edges: EdgeChoice) -> Self {
        self.0.edges = edges;
        self
    }

    /// About how many faces a solid or a shell gets. Without, as many as its shape needs. A hint in the report says if there
    /// are others.
    pub fn faces(mut self, count: impl Into<Option<usize>>) -> Self {
        self.0.faces = count.into();
        self
    }

    /// How to fit.
    pub fn fit(mut self, method: fit::Method) -> Self {
        self.0.method = method;
        self
    }

    /// The farthest that a smoothed point may be from the face, in mm. Without: from
    /// the noise of the scan.
    pub fn tolerance(mut self, mm: impl Into<Option<f64>>) -> Self {
        self.0.tolerance = mm.into();
        self
    }

    /// The share of points, from 0 to below 1, that may exceed the tolerance.
    /// Without: 0.
    pub fn outliers(mut self, share: f64) -> Self {
        self.0.outliers = share;
        self
    }

    /// How far a trim loop may be from the measured rim, in mm; at 0 it follows every tooth.
    /// Without: half the median length of the scan's edges at the rims, or the tolerance if
    /// that is more. A tolerance that is named binds loops, too, unless this is named.
    pub fn rim_tolerance(mut self, mm: impl Into<Option<f64>>) -> Self {
        self.0.rim_tolerance = mm.into();
        self
    }

    /// Which holes are cut out of the face. Without: all.
    pub fn cut(mut self, cut: Cut) -> Self {
        self.0.cut = cut;
        self
    }

    /// How many threads share the work, from 1 to 1024. They end with the conversion, whose
    /// result has the same bytes on any number of them. Without: the pool of the thread that
    /// calls, or a thread for each core ([`threads::run`](crate::threads::run)).
    pub fn threads(mut self, count: impl Into<Option<usize>>) -> Self {
        self.0.threads = count.into();
        self
    }

    /// The number of bytes that the conversion may need, by the estimate of
    /// [`Memory`](crate::convert::Memory). [`convert`](crate::convert) refuses a scan that may need
    /// more before its work begins. If it suffices, it takes means of the points or vertices at as many places as fit. Without:
    /// no bound.
    pub fn max_memory(mut self, bytes: impl Into<Option<u64>>) -> Self {
        self.0.max_memory = bytes.into();
        self
    }

    /// The options.
    ///
    /// # Errors
    /// [`Error::Corners`](crate::error::Error::Corners): not four places are named as corners.
    /// [`Error::Option`](crate::error::Error::Option): the first value that cannot be; lengths
    /// must be above 0, numbers finite, nets within their bounds
    /// ([`rules`](crate::rules)).
    pub fn build(self) -> Result<Options> {
        self.0.check()?;
        Ok(self.0)
    }
}
