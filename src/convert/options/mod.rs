//! Everything that a user may choose.

mod builder;

pub use builder::Builder;

use formats::LengthUnit;

use super::memory::MemoryBound;
use super::places::NamedPlaces;
use super::{Cut, TargetShape};
use crate::error::{Error, Result, of};
use crate::geometry::{Point, in_lengths, length};
use crate::stages::adapt::KnotOptions;
use crate::stages::{adapt, cloud, fill, fit, parameterize, smooth, trim};
use crate::{mesh, rules};

/// What [`convert`](crate::convert()) is asked for. [`Options::default`] finds
/// everything on the scan, whose numbers have the unit that it declares, or are millimetres; [`Options::builder`]
/// changes what is named. There are no unsound ones: what is wrong with a value is
/// said when they are built.
///
/// ```
/// use scan2step::Options;
///
/// # fn main() -> scan2step::Result<()> {
/// let options = Options::builder().name("fender").tolerance(0.05).build()?;
/// # drop(options);
/// assert!(Options::builder().tolerance(-0.05).build().is_err());
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Options {
    pub(crate) name: String,
    pub(crate) unit_mm: Option<f64>,
    pub(crate) cloud: cloud::Options,
    pub(crate) keeps_origin: bool,
    pub(crate) remesh: bool,
    pub(crate) component: mesh::Choice,
    pub(crate) all_components: bool,
    pub(crate) handles: Option<f64>,
    pub(crate) weld: mesh::SeamWidth,
    pub(crate) outer: mesh::Outer,
    pub(crate) smooth: smooth::Options,
    pub(crate) fill: fill::Options,
    pub(crate) parameterize: parameterize::Options,
    pub(crate) knots: KnotOptions,
    pub(crate) shape: Option<TargetShape>,
    pub(crate) surfaces: SurfaceChoice,
    pub(crate) keep_polygons: bool,
    pub(crate) regularize: bool,
    pub(crate) bias: Option<f64>,
    pub(crate) align: bool,
    pub(crate) edges: EdgeChoice,
    pub(crate) faces: Option<usize>,
    pub(crate) method: fit::Method,
    pub(crate) tolerance: Option<f64>,
    pub(crate) outliers: f64,
    pub(crate) rim_tolerance: Option<f64>,
    pub(crate) cut: Cut,
    pub(crate) threads: Option<usize>,
    pub(crate) max_memory: Option<u64>,
    /// A mesh is averaged, as it may need more memory otherwise.
    pub(crate) bound: Option<MemoryBound>,
    pub(crate) places: NamedPlaces,
}

/// Which surfaces the faces get.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceChoice {
    /// Planes, cylinders, cones, spheres and tori where a clean mesh has them, and otherwise B-splines.
    #[default]
    Auto,
    /// B-splines only.
    Spline,
}

/// Where exact faces end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum EdgeChoice {
    /// Where another surface begins.
    #[default]
    Auto,
    /// Nowhere: there are no sharp edges, and so no exact faces.
    Off,
    /// Also at every edge of the mesh that turns by more than this angle, in degrees.
    Degrees(f64),
}

impl Default for Options {
    fn default() -> Self {
        Options {
            name: "scan".into(),
            unit_mm: None,
            cloud: cloud::Options::default(),
            keeps_origin: false,
            remesh: false,
            component: mesh::Choice::default(),
            all_components: false,
            handles: None,
            weld: mesh::SeamWidth::Auto,
            outer: mesh::Outer::default(),
            smooth: smooth::Options::default(),
            fill: fill::Options::default(),
            parameterize: parameterize::Options::default(),
            knots: KnotOptions::default(),
            shape: None,
            surfaces: SurfaceChoice::Auto,
            keep_polygons: false,
            regularize: false,
            bias: None,
            align: false,
            edges: EdgeChoice::Auto,
            faces: None,
            method: fit::Method::default(),
            tolerance: None,
            outliers: 0.0,
            rim_tolerance: None,
            cut: Cut::default(),
            threads: None,
            max_memory: None,
            bound: None,
            places: NamedPlaces::default(),
        }
    }
}

impl Options {
    /// Whether no part of the scan is left out by its place.
    pub fn keeps_all(&self) -> bool {
        self.cloud.crop.keeps_all()
    }

    /// Options to change one by one.
    pub fn builder() -> Builder {
        Builder::default()
    }

    /// The same for another piece of the scan.
    #[must_use]
    pub fn of_component(&self, component: mesh::Choice) -> Self {
        Options { component, ..self.clone() }
    }

    /// The same for a shape.
    #[must_use]
    pub fn of_shape(&self, shape: TargetShape) -> Self {
        Options { shape: Some(shape), ..self.clone() }
    }

    /// The largest number of places whose means take the place of the points of a cloud or the vertices of a mesh, if
    /// memory bounds it ([`Options::fitting`]).
    pub fn most_places(&self) -> Option<usize> {
        self.cloud.most_places.or_else(|| self.bound.as_ref().map(MemoryBound::places))
    }

    /// The part's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the result of a cloud lies in the scan's own frame.
    pub fn keeps_origin(&self) -> bool {
        self.keeps_origin
    }

    /// The option that asks for B-spline surfaces: only they have what it names. `None` if nothing does.
    pub fn spline_option(&self) -> Option<&'static str> {
        let (map, default) = (&self.parameterize, parameterize::Options::default());
        let asking = [
            (self.surfaces == SurfaceChoice::Spline, "surfaces"),
            (self.edges == EdgeChoice::Off, "edges"),
            (self.knots.net.is_some(), "net"),
            (self.knots.kappa.is_some(), "kappa"),
            (self.knots.depth.is_some(), "depth"),
            (self.method != fit::Method::default(), "fit"),
            (map.method != default.method, "map"),
            (map.outline.is_some(), "outline"),
            (self.corners().is_some() || self.places.corners.is_some(), "corners"),
            (self.faces.is_some(), "faces"),
            (matches!(self.smooth.support, smooth::Support::Fixed(_)), "smooth"),
        ];
        asking.into_iter().find(|(is_asking, _)| *is_asking).map(|(_, option)| option)
    }

    /// The number of threads that share the work, if it is named.
    pub fn threads(&self) -> Option<usize> {
        self.threads
    }

    /// The number of bytes that a conversion may need, if it is bounded.
    pub fn max_memory(&self) -> Option<u64> {
        self.max_memory
    }

    /// Which piece of the scan.
    pub fn component(&self) -> mesh::Choice {
        self.component
    }

    /// Whether all pieces are converted.
    pub fn all_components(&self) -> bool {
        self.all_components
    }

    /// The pieces of a scan that are converted.
    pub fn chosen(&self, scan: &mesh::Components) -> Vec<mesh::Choice> {
        match self.all_components {
            true => scan.all(self.outer()),
            false => vec![self.component],
        }
    }

    /// The longest loop of a handle that is cut, in mm, if it is named.
    pub fn handles(&self) -> Option<f64> {
        self.handles
    }

    /// Which boundary loop is the outer one: the one named, else the one with the first of the
    /// corners that are named.
    pub fn outer(&self) -> mesh::Outer {
        match (self.outer, self.corners()) {
            (mesh::Outer::Auto, Some([first, ..])) => mesh::Outer::Near(first),
            (outer, _) => outer,
        }
    }

    /// The points, in mm, next to which the corners of the domain lie, if they are named.
    pub fn corners(&self) -> Option<[Point; 4]> {
        self.parameterize.corners
    }

    /// The unit of the scan's numbers, if one is named that has a name.
    pub fn unit(&self) -> Option<LengthUnit> {
        use LengthUnit::{Centimetre, Foot, Inch, Metre, Micrometre, Millimetre, UsSurveyFoot};
        let mm = self.unit_mm?;
        let named = [Millimetre, Micrometre, Centimetre, Metre, Inch, Foot, UsSurveyFoot];
        named.into_iter().find(|unit| unit.in_mm() == mm)
    }

    /// The length of a scan's unit in mm: the one named, else the one that the scan declares, else
    /// a millimetre.
    pub(crate) fn unit_of(&self, declared: Option<LengthUnit>) -> f64 {
        self.unit_mm.or(declared.map(LengthUnit::in_mm)).unwrap_or(1.0)
    }

    /// The same in lengths of so many `mm`. What `fill` is told of noise and support is
    /// found by the stage before it.
    pub(crate) fn in_lengths(&self, mm: f64) -> Self {
        let parameterize = parameterize::Options {
            corners: self.corners().map(|corners| corners.map(|p| in_lengths(p, mm))),
            ..self.parameterize.clone()
        };
        let knots =
            KnotOptions { kappa: self.knots.kappa.map(|k| length(k, mm)), ..self.knots.clone() };
        Options {
            outer: self.outer.in_lengths(mm),
            smooth: self.smooth.in_lengths(mm),
            parameterize,
            knots,
            tolerance: self.tolerance.map(|tolerance| length(tolerance, mm)),
            rim_tolerance: self.rim_tolerance.map(|rim| rim / mm),
            cut: self.cut.in_lengths(mm),
            ..self.clone()
        }
    }

    /// How near loops keep to some rims.
    pub(crate) fn trim<'a>(
        &self,
        tolerance: f64,
        rims: impl Iterator<Item = &'a [Point]>,
    ) -> trim::Options {
        match self.rim_tolerance {
            Some(rim) => trim::Options { tolerance, rim, least_rim: rim, keeps_vertices: false },
            None => trim::Options::of_rims(rims, tolerance, self.tolerance.is_some()),
        }
    }

    /// How knots and fit are adapted to a scan with this noise, for which a tolerance that nobody names would
    /// stand for the noise `worth`.
    pub(crate) fn adapt(&self, noise: f64, worth: f64) -> adapt::Options {
        let noise = if self.smooth.support == smooth::Support::Off { noise } else { 0.0 };
        adapt::Options { knots: self.knots.clone(), method: self.method, noise, worth }
    }

    fn check(&self) -> Result<()> {
        self.unit_mm.map_or(Ok(()), rules::length).map_err(of("unit"))?;
        if let mesh::Outer::Near(place) = self.outer {
            rules::points(&[place]).map_err(of("outer"))?;
        }
        if self.places.corners.as_ref().is_some_and(|corners| corners.len() != 4) {
            return Err(Error::Corners("not four places".into()));
        }
        self.cloud.check()?;
        self.smooth.check()?;
        self.fill.check()?;
        self.parameterize.check()?;
        self.knots.check()?;
        if self.shape == Some(TargetShape::Void) {
            return Err(of("shape")(rules::Fault::Void));
        }
        if let EdgeChoice::Degrees(degrees) = self.edges {
            rules::degrees(degrees).map_err(of("edges"))?;
        }
        self.faces.map_or(Ok(()), rules::faces).map_err(of("faces"))?;
        self.tolerance.map_or(Ok(()), rules::length).map_err(of("tolerance"))?;
        self.bias.map_or(Ok(()), rules::length).map_err(of("bias"))?;
        self.handles.map_or(Ok(()), rules::extent).map_err(of("handles"))?;
        if let mesh::SeamWidth::Fixed(length) = self.weld {
            rules::extent(length).map_err(of("weld"))?;
        }
        self.rim_tolerance.map_or(Ok(()), rules::extent).map_err(of("rim_tolerance"))?;
        rules::share(self.outliers).map_err(of("outliers"))?;
        if let Cut::FromLength(length) = self.cut {
            rules::extent(length).map_err(of("cut"))?;
        }
        self.threads.map_or(Ok(()), rules::threads).map_err(of("threads"))?;
        Ok(())
    }
}
