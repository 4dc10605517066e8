//! The measured points around a hole, from which its fill takes its shape.

use std::collections::VecDeque;

use foldhash::HashSet;

use super::front::Hole;
use crate::geometry::{Point, VertexId};

/// The vertices that a walk over the mesh from the rims reaches without going
/// farther from them than `width`, or over vertices that are not `wanted`, in
/// the walk's order.
pub fn band(
    Hole { around, rims, sizes }: Hole,
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

/// How wide a band a hole's fill is taken from: wide enough for its curvature
/// to be seen, which for a hole of half width `radius` is about as far again,
/// but less for wide holes, whose long rims have points enough.
pub fn width(radius: f64, edge: f64) -> f64 {
    (0.8 * (radius * radius.min(12.0 * edge)).sqrt()).max(6.0 * edge)
}

/// The points as they were measured, if smoothing has not moved them much
/// farther than the noise: their deviations are independent, those of the
/// smoothed ones are not, and a fit would take these for shape.
pub struct Measured<'a> {
    pub points: &'a [Point],
    pub noise: f64,
}

/// Farther from the smoothed surface than this many standard deviations of the
/// noise, a point is an outlier.
const OUTLIER: f64 = 4.0;

impl Measured<'_> {
    /// The measured place of a vertex, or its smoothed one if the scanner erred.
    pub fn point(&self, v: VertexId, smoothed: Point) -> Point {
        let p = self.points[v.index()];
        if (p - smoothed).norm() <= OUTLIER * self.noise { p } else { smoothed }
    }
}
