//! What the user says about knots and fit.

use crate::error::{Result, of};
use crate::{fit, rules};

/// What the user says about knots.
#[derive(Debug, Clone)]
pub struct KnotOptions {
    /// κ in mm, the mean error below which the subdivision of the paper stops. `None`: it
    /// follows from the tolerance, and knots are then inserted and removed until the goal is met.
    pub kappa: Option<f64>,
    /// How often the domain may be halved. `None`: it follows from the number of points.
    pub depth: Option<u32>,
    /// The control points of a uniform net along u and v, which overrides both. `None`: the
    /// knots follow the shape.
    pub net: Option<[usize; 2]>,
    /// The largest number of control points, 250,000 by default. Too few miss the tolerance; a
    /// large net takes memory and is slow in CAD programs.
    pub max_net: usize,
}

impl Default for KnotOptions {
    fn default() -> Self {
        KnotOptions { kappa: None, depth: None, net: None, max_net: 250_000 }
    }
}

impl KnotOptions {
    /// Whether the knots follow from the goal: the user has named neither κ nor a net.
    pub(super) fn are_searched(&self) -> bool {
        self.net.is_none() && self.kappa.is_none()
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.kappa.map_or(Ok(()), rules::length).map_err(of("kappa"))?;
        self.depth.map_or(Ok(()), rules::depth).map_err(of("depth"))?;
        rules::max_net(self.max_net).map_err(of("max_net"))?;
        let within = |net| rules::net(net, self.max_net);
        self.net.map_or(Ok(()), within).map_err(of("net"))
    }
}

/// How to adapt knots and fit.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// What the user says about knots.
    pub knots: KnotOptions,
    /// How a surface is fitted over given knots.
    pub method: fit::Method,
    /// The standard deviation of the points' noise, in mm, if they were not smoothed; 0 otherwise.
    /// Outliers of noisy points are rejected, and the noise may put a named tolerance out of reach.
    pub noise: f64,
}
