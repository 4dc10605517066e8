//! The corners of a facet's outline.

use super::tessellation::{SLIVER, Tessellation};
use crate::geometry::segment_distance;

/// The corners of the outline of coplanar triangles: vertices that are farther from the chord of their neighbours than
/// the three errors explain. The second value is their number; if fewer than three are found, all vertices are
/// returned instead.
pub(super) fn of(mesh: &Tessellation, triangles: &[u32], facet_of: &[u32]) -> (Vec<u32>, usize) {
    let facet = facet_of[triangles[0] as usize];
    let mut outline: Vec<[u32; 2]> = Vec::new();
    for &t in triangles {
        for side in 3 * t as usize..3 * t as usize + 3 {
            let other = mesh.edges.across(side);
            if other.is_none_or(|other| facet_of[other / 3] != facet) {
                outline.push(mesh.ends(side));
            }
        }
    }
    outline.sort_unstable();
    let mut into: Vec<[u32; 2]> = outline.iter().map(|&[a, b]| [b, a]).collect();
    into.sort_unstable();
    let mut corners: Vec<u32> = Vec::new();
    for same in outline.chunk_by(|x, y| x[0] == y[0]) {
        let v = same[0][0];
        let at = into.partition_point(|x| x[0] < v);
        let Some(&[_, before]) = into.get(at).filter(|x| x[0] == v) else { continue };
        let [p, a, b] = [v, before, same[0][1]].map(|v| mesh.point(v));
        // A pinched vertex is where two outlines meet: certainly a corner.
        if same.len() > 1 || segment_distance(p, a, b) > SLIVER * mesh.error(v) {
            corners.push(v);
        }
    }
    let count = corners.len();
    if count < 3 {
        corners = triangles.iter().flat_map(|&t| mesh.corners(t)).collect();
        corners.sort_unstable();
        corners.dedup();
    }
    (corners, count)
}
