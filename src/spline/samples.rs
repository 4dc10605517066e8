//! Points with the parameters at which a surface should pass them.

use crate::geometry::{Point, Uv};

/// Weighted points with parameters; the lists run in parallel.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// Points in mm.
    pub points: Vec<Point>,
    /// Their parameter points.
    pub uv: Vec<Uv>,
    /// Their weights in a least-squares fit, positive.
    pub weights: Vec<f64>,
    /// Whether they end inside the domain, and the surface goes on beyond them.
    pub open: bool,
}

impl Samples {
    /// How many points there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}
