//! Points with the parameters at which a surface should pass through them.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Point, Uv};

/// Weighted points with parameters. The lists have equal lengths.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Points in mm.
    pub points: Vec<Point>,
    /// Their parameter points.
    pub uv: Vec<Uv>,
    /// Their positive weights in a least-squares fit.
    pub weights: Vec<f64>,
    /// Whether the points end inside the domain, so that the surface continues beyond them.
    pub open: bool,
}

impl Samples {
    /// The number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Checks that the samples can be fitted.
    pub(crate) fn check(&self) -> Result<()> {
        if self.is_empty() {
            return Err(Error::Empty("there are no points to fit".into()));
        }
        if self.uv.len() != self.len() || self.weights.len() != self.len() {
            return Err(Error::Input("samples: points, parameters and weights differ in number"));
        }
        let finite = |x: &f64| x.is_finite();
        let places = self.points.par_iter().all(|p| p.iter().all(finite));
        let weights = self.weights.par_iter().all(|w| *w > 0.0 && w.is_finite());
        if places && weights && self.uv.par_iter().all(|at| at.iter().all(finite)) {
            return Ok(());
        }
        Err(Error::Input("samples: a number is not finite, or a weight is not above 0"))
    }
}
