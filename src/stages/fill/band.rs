//! The band of measured points around a hole. They give the fill its shape.

use std::collections::VecDeque;

use foldhash::HashSet;

use super::front::OpenHole;
use crate::geometry::{Point, VertexId};
use crate::statistics::outlying;

/// The vertices around a hole, in breadth-first order from its rims: those that edges reach
/// over `wanted` vertices at most `width` from the rims.
pub(crate) fn band(
    OpenHole { around, rims, sizes }: OpenHole,
    width: f64,
    wanted: impl Fn(VertexId) -> bool,
) -> Vec<VertexId> {
    let mut seen: HashSet<VertexId> = rims.iter().copied().flatten().copied().collect();
    let mut queue: VecDeque<VertexId> = rims.iter().copied().flatten().copied().collect();
    let mut band = Vec::new();
    while let Some(v) = queue.pop_front() {
        band.push(v);
        for w in around.rings.neighbours(around.mesh, v) {
            if seen.insert(w) && wanted(w) && sizes.depth(around.mesh.point(w)) <= width {
                queue.push_back(w);
            }
        }
    }
    band
}

/// The width of the band. To show the curvature over a hole of half width `radius` it must be
/// about as wide as that. For wide holes it is less, because their long rims have many points.
pub(super) fn width(radius: f64, edge: f64) -> f64 {
    (0.8 * (radius * radius.min(12.0 * edge)).sqrt()).max(6.0 * edge)
}

/// The points as they were measured. Their errors are independent. Those of smoothed points are
/// not, and a fit would take them for shape.
pub(crate) struct MeasuredPoints<'a> {
    pub points: &'a [Point],
    pub noise: f64,
}

impl MeasuredPoints<'_> {
    /// The measured position of a vertex, or the smoothed one if smoothing has moved an outlier.
    pub(super) fn point(&self, v: VertexId, smoothed: Point) -> Point {
        let p = self.points[v.index()];
        let farthest = outlying(self.points.len()) * self.noise;
        if (p - smoothed).norm() <= farthest { p } else { smoothed }
    }
}
