//! Smoothing of polygons.

use super::Point;

/// The factors of Taubin's smoothing ("A signal processing approach to fair surface design", 1995), whose second step undoes how the first one
/// shrinks, and the number of both steps. They leave waves of ten edges, and take those of two and three, which are the outline of triangles.
const SMOOTHING: [f64; 2] = [0.5, -0.53];
const SMOOTHED: usize = 10;

/// The points of a polygon, of which those that are free are moved. It is closed if its first point is its last one, and else its ends stay.
pub(crate) fn faired(points: &[Point], is_free: impl Fn(usize) -> bool) -> Vec<Point> {
    let n = points.len();
    let mut own = points.to_vec();
    if n < 3 {
        return own;
    }
    let is_closed = points[0] == points[n - 1];
    for factor in SMOOTHING.iter().cycle().take(2 * SMOOTHED) {
        let old = own.clone();
        for k in (0..n).filter(|&k| is_free(k)) {
            let (before, behind) = match (k == 0 || k == n - 1, is_closed) {
                (false, _) => (old[k - 1], old[k + 1]),
                (true, true) => (old[n - 2], old[1]),
                (true, false) => continue,
            };
            own[k] = old[k] + *factor * (nalgebra::center(&before, &behind) - old[k]);
        }
    }
    own
}
