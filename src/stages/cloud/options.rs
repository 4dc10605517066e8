//! How triangles are made of points.

use crate::error::{Result, of};
use crate::rules;
use crate::stages::crop;

/// How triangles are made of points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Points closer than this, in the unit of the cloud, become one vertex. By default it is half
    /// of the spacing, or more where the noise is large. A length below the spacing keeps all
    /// points; one of many spacings loses detail.
    pub spacing: Option<f64>,
    /// The largest number of points that are taken, spread evenly over the cloud. By default all
    /// are. Too few points lose detail and holes.
    pub max_points: Option<usize>,
    /// The largest number of places whose means are meshed in place of the points. By default it is at least 250,000, and
    /// as large as the noise lets tell. A smaller number loses detail.
    pub most_places: Option<usize>,
    /// The scan that is taken, counted from 0. By default all scans are taken together.
    pub scan: Option<usize>,
    /// What is kept of the cloud, in its own numbers.
    pub crop: crop::Options,
}

impl Options {
    pub(crate) fn check(&self) -> Result<()> {
        self.crop.check()?;
        self.spacing.map_or(Ok(()), rules::length).map_err(of("spacing"))?;
        self.max_points.map_or(Ok(()), rules::max_points).map_err(of("max_points"))?;
        self.most_places.map_or(Ok(()), rules::max_points).map_err(of("most_places"))
    }

    /// The same for a cloud whose unit is so many `mm`; the spacing was in mm.
    pub(crate) fn in_lengths(&self, mm: f64) -> Self {
        Options { spacing: self.spacing.map(|spacing| spacing / mm), ..self.clone() }
    }
}
