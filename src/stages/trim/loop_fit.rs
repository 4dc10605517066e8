//! The fit of one trim loop.
//!
//! The input is a rim and the surface. The output is a closed curve in (u, v) that follows the foot points of the
//! rim, and measures against faults of the curve.

use std::borrow::Cow;

use super::follow::Follower;
use super::{Options, Rim, needles};
use crate::geometry::Point;
use crate::spline::{Curve, Surface, foot_point};

/// The largest number of additional corners. If more are needed, needles are removed instead.
const MAX_SHARP: usize = 32;

/// Loops may leave the surface while they are fitted. That is a fault, which is found later.
const ANYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// The current state of a loop.
#[derive(Debug, Clone)]
pub(crate) struct LoopFit<'a> {
    surface: &'a Surface,
    rim: Cow<'a, Rim>,
    follower: Follower<'a>,
    /// The position of the rim's vertex at parameter 0.
    first: usize,
    /// Whether the curve follows the parameter points of the map instead of foot points.
    on_map: bool,
    /// Vertices of the rim at which the loop has a corner although corner detection found none.
    sharp: Vec<usize>,
}

impl<'a> LoopFit<'a> {
    /// Fits the loop of a rim. `None` if the rim is a single point.
    pub(super) fn new(surface: &'a Surface, rim: &'a Rim, options: &Options) -> Option<Self> {
        LoopFit::around(surface, Cow::Borrowed(rim), options, false, Vec::new())
    }

    /// Fits the loop to the foot points of the rim's vertices, or, if `on_map`, to the parameter
    /// points that the map gave them. The foot points of a ragged rim can cross each other, but
    /// the points of the map cannot.
    fn around(
        surface: &'a Surface,
        rim: Cow<'a, Rim>,
        options: &Options,
        on_map: bool,
        sharp: Vec<usize>,
    ) -> Option<Self> {
        let foot = |(&p, &at)| {
            let foot = if on_map { at } else { foot_point(surface, p, at).0 };
            (foot, (surface.point(foot) - p).norm())
        };
        let feet: Vec<_> = rim.points.iter().zip(&rim.uv).map(foot).collect();
        let (follower, first) = Follower::around(surface, &feet, options, &sharp, ANYWHERE)?;
        Some(LoopFit { surface, rim, follower, first, on_map, sharp })
    }

    /// The arcs of the loop in the parameter plane.
    pub(crate) fn arcs(&self) -> Vec<Curve<2>> {
        self.follower.arcs()
    }

    /// The rim's vertex that follows a parameter.
    pub(super) fn vertex(&self, t: f64) -> Point {
        let n = self.rim.points.len();
        self.rim.points[(self.first + self.follower.before(t).min(n - 1)) % n]
    }

    /// Makes the loop follow its rim more closely around the parameters `places`, where it has a
    /// fault. It takes the first of these measures that is possible:
    /// 1. It halves the spans around the places.
    /// 2. It fits the loop to the parameter points of the map.
    /// 3. It adds a corner at the first place, which may be the tip of a slit.
    /// 4. It removes needles from the rim.
    ///
    /// `None` if none of them is possible.
    pub(crate) fn tighten(&mut self, places: &[Option<f64>], options: &Options) -> Option<()> {
        if self.follower.halve_at(places.iter().flatten().copied()).is_some() {
            return Some(());
        }
        let tip = places.iter().flatten().next().map(|&t| self.nearest(t));
        let new_tip = tip.filter(|tip| !self.sharp.contains(tip) && self.sharp.len() < MAX_SHARP);
        let (rim, sharp) = match new_tip {
            _ if !self.on_map => (self.rim.clone(), Vec::new()),
            Some(tip) => (self.rim.clone(), [&self.sharp[..], &[tip]].concat()),
            None => {
                let kept = needles::without(&self.rim.uv);
                if kept.len() == self.rim.uv.len() {
                    return None;
                }
                (Cow::Owned(self.rim.only(&kept)), Vec::new())
            }
        };
        *self = LoopFit::around(self.surface, rim, options, true, sharp)?;
        Some(())
    }

    /// The rim's vertex nearest to a parameter, before or after it.
    fn nearest(&self, t: f64) -> usize {
        (self.first + self.follower.nearest(t)) % self.rim.points.len()
    }
}
