//! A polygon of the parameter plane that a curve is to follow.

use nalgebra::Vector2;

use crate::geometry::{NEGLIGIBLE, Point, Uv};
use crate::spline::{Jet, Surface};

/// A polygon in the parameter plane of a surface.
#[derive(Debug, Clone)]
pub(super) struct Polygon<'a> {
    surface: &'a Surface,
    /// The parameter of the curve at each corner, ascending from 0. Those of an open polygon end at 1. A closed
    /// polygon is at its first corner again at 1.
    pub parameters: Vec<f64>,
    pub uv: Vec<Uv>,
    /// The surface and its derivatives at each corner.
    pub jets: Vec<Jet>,
    /// How far the curve may be from each corner, measured on the surface in mm.
    pub room: Vec<f64>,
    pub is_closed: bool,
    /// The least and the largest coordinate that a control point may have.
    pub range: [f64; 2],
}

impl<'a> Polygon<'a> {
    /// A polygon over foot points, each with its room, and its length in mm. `None` if it has none.
    pub(super) fn new(
        surface: &'a Surface,
        corners: &[(Uv, f64)],
        is_closed: bool,
        range: [f64; 2],
    ) -> Option<(Self, f64)> {
        let jets: Vec<_> = corners.iter().map(|corner| surface.jet(corner.0)).collect();
        let feet: Vec<_> = jets.iter().map(|jet| jet.s).collect();
        let (walked, total) = lengths(&feet, is_closed)?;
        let polygon = Polygon {
            parameters: walked.iter().map(|s| s / total).collect(),
            jets,
            surface,
            uv: corners.iter().map(|corner| corner.0).collect(),
            room: corners.iter().map(|corner| corner.1).collect(),
            is_closed,
            range,
        };
        Some((polygon, total))
    }

    /// The number of corners before parameter `t`.
    pub(super) fn before(&self, t: f64) -> usize {
        self.parameters.partition_point(|&p| p < t)
    }

    /// The number of edges.
    pub(super) fn edges(&self) -> usize {
        self.uv.len() - usize::from(!self.is_closed)
    }

    /// The point at `t`.
    pub(super) fn at(&self, t: f64) -> Uv {
        let i = self.parameters.partition_point(|&p| p <= t).clamp(1, self.edges()) - 1;
        let end = self.parameters.get(i + 1).copied().unwrap_or(1.0);
        let share = ((t - self.parameters[i]) / (end - self.parameters[i])).clamp(0.0, 1.0);
        self.uv[i] + share * (self.uv[(i + 1) % self.uv.len()] - self.uv[i])
    }

    /// The way in space from corner `k` to a place of the surface.
    pub(super) fn off(&self, at: Vector2<f64>, k: usize) -> Point {
        Point::from(self.surface.point(self.surface.clamp(at.into())) - self.jets[k].s)
    }
}

/// The lengths along a polygon from point 0 to each point, and the total length. `None` if
/// the total is not a positive finite number. Coincident points get a small distance.
pub(super) fn lengths(points: &[Point], is_closed: bool) -> Option<(Vec<f64>, f64)> {
    let n = points.len();
    let edges = n - usize::from(!is_closed);
    let side = |i: usize| (points[(i + 1) % n] - points[i]).norm();
    let around: f64 = (0..edges).map(side).sum();
    let least = NEGLIGIBLE * around / n as f64;
    let mut walked = vec![0.0];
    for i in 0..edges {
        walked.push(walked[i] + side(i).max(least));
    }
    let total = walked[edges];
    walked.truncate(n);
    (around > 0.0 && total.is_finite()).then_some((walked, total))
}
