//! Detection of corners of a boundary loop.

use super::curve::MIN_POINTS;
use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, boundary};

/// A loop shorter than this multiple of the window has no corners.
const SHORTEST: f64 = 12.0;

/// The positions of corners in the loop, in ascending order. Noise and stair steps much shorter than `window` mm
/// have little influence.
pub(crate) fn find(mesh: &Mesh, ring: &[VertexId], window: f64) -> Vec<usize> {
    if ring.len() < MIN_POINTS || boundary::length(mesh, ring) < SHORTEST * window {
        return Vec::new();
    }
    let points: Vec<Point> = ring.iter().map(|&v| mesh.point(v)).collect();
    let corners = boundary::corners(&points, &boundary::turns(&points, window), window);
    let mut tips: Vec<usize> = corners.into_iter().map(|corner| corner.0).collect();
    tips.sort_unstable();
    tips.dedup();
    tips
}
