//! What the user says about knots and fit.

use super::Goal;
use crate::error::{Result, of};
use crate::rules;
use crate::stages::fit;

/// What the user says about knots.
#[derive(Debug, Clone, Default)]
pub struct KnotOptions {
    /// κ in mm, the mean error below which the subdivision of the paper stops. `None`: it
    /// follows from the tolerance, and knots are then inserted and removed until the goal is met.
    pub kappa: Option<f64>,
    /// How often the domain may be halved. `None`: it follows from the number of points.
    pub depth: Option<u32>,
    /// The control points of a uniform net along u and v, which overrides both. `None`: the
    /// knots follow the shape.
    pub net: Option<[usize; 2]>,
    /// The largest number of control points of a face, or of all faces of a body together. Too few miss the
    /// tolerance; a large net takes memory and is slow in CAD programs. `None`: 250,000, or as many as the layout of a
    /// body needs.
    pub max_net: Option<usize>,
}

/// The largest number of control points unless one is named. CAD programs take minutes to open larger nets.
const MAX_NET: usize = 250_000;

/// The fewest measured points for a control point, unless a tolerance is named: smoothing looks at dozens of
/// points at a time, so that finer nets find nothing left to follow.
pub(super) const POINTS_A_CONTROL_POINT: usize = 2;

impl KnotOptions {
    /// The largest number of control points.
    pub(crate) fn largest_net(&self) -> usize {
        self.max_net.unwrap_or(MAX_NET)
    }

    /// The largest number of control points for a goal and so many measured points, if nets are searched for it.
    pub(crate) fn largest_net_for(&self, goal: &Goal, measured: usize) -> usize {
        match goal.named || !self.are_searched() {
            true => self.largest_net(),
            false => self.largest_worth(measured),
        }
    }

    /// The largest number of control points if nobody names a tolerance.
    pub(super) fn largest_worth(&self, measured: usize) -> usize {
        self.largest_net().min(measured / POINTS_A_CONTROL_POINT)
    }

    /// Whether the knots follow from the goal: the user has named neither κ nor a net.
    pub(super) fn are_searched(&self) -> bool {
        self.net.is_none() && self.kappa.is_none()
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.kappa.map_or(Ok(()), rules::length).map_err(of("kappa"))?;
        self.depth.map_or(Ok(()), rules::depth).map_err(of("depth"))?;
        self.max_net.map_or(Ok(()), rules::max_net).map_err(of("max_net"))?;
        let within = |net| rules::net(net, self.largest_net());
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
    /// The standard deviation of the noise, in mm, for which the tolerance would stand if nobody had named one. It
    /// bounds the work for a named tolerance; 0 sets no bound.
    pub worth: f64,
}
