//! Everything that a user may choose.

mod builder;

pub use builder::Builder;

use crate::adapt::KnotOptions;
use crate::cut::Cut;
use crate::error::{Result, of};
use crate::geometry::Point;
use crate::{fill, fit, mesh, parameterize, rules, smooth};

/// What [`convert`](crate::convert) is asked for. [`Options::default`] finds
/// everything on the scan, whose numbers are millimetres; [`Options::builder`]
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
    pub(crate) unit_mm: f64,
    pub(crate) component: mesh::Choice,
    pub(crate) outer: mesh::Outer,
    pub(crate) smooth: smooth::Options,
    pub(crate) fill: fill::Options,
    pub(crate) parameterize: parameterize::Options,
    pub(crate) knots: KnotOptions,
    pub(crate) method: fit::Method,
    pub(crate) tolerance: Option<f64>,
    pub(crate) outliers: f64,
    pub(crate) cut: Cut,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            name: "scan".into(),
            unit_mm: 1.0,
            component: mesh::Choice::default(),
            outer: mesh::Outer::default(),
            smooth: smooth::Options::default(),
            fill: fill::Options::default(),
            parameterize: parameterize::Options::default(),
            knots: KnotOptions::default(),
            method: fit::Method::default(),
            tolerance: None,
            outliers: 0.0,
            cut: Cut::default(),
        }
    }
}

impl Options {
    /// Options to change one by one.
    pub fn builder() -> Builder {
        Builder::default()
    }

    /// The same for another piece of the scan.
    #[must_use]
    pub fn of_component(&self, component: mesh::Choice) -> Self {
        Options { component, ..self.clone() }
    }

    /// Which boundary loop is the outer one.
    pub fn outer(&self) -> mesh::Outer {
        self.outer
    }

    /// The points, in mm, next to which the corners of the domain lie, if they are named.
    pub fn corners(&self) -> Option<[Point; 4]> {
        self.parameterize.corners
    }

    fn check(&self) -> Result<()> {
        rules::length(self.unit_mm).map_err(of("unit"))?;
        if let mesh::Outer::Near(place) = self.outer {
            rules::points(&[place]).map_err(of("outer"))?;
        }
        self.smooth.check()?;
        self.fill.check()?;
        self.parameterize.check()?;
        self.knots.check()?;
        self.tolerance.map_or(Ok(()), rules::length).map_err(of("tolerance"))?;
        rules::share(self.outliers).map_err(of("outliers"))?;
        if let Cut::FromLength(length) = self.cut {
            rules::extent(length).map_err(of("cut"))?;
        }
        Ok(())
    }
}
