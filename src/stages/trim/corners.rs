//! Corner detection on a rim.
//!
//! The input is a closed polyline. The output is the positions of its corners: vertices where the
//! line turns by a large angle both at a coarse and at a fine scale.

use crate::geometry::Point;
use crate::mesh::boundary;

/// At a corner, arms of half the length see at least this share of the turn. At a round bend they
/// see only half of it.
const SHARP: f64 = 0.75;

/// The length of the arms: at least this many mean edges, so that the teeth of a rim do not count
/// as corners, and at least this share of the loop.
const ARM: (f64, f64) = (6.0, 1.0 / 16.0);

/// The largest number of corners of a loop. If there are more, the sharpest ones are kept, and the
/// curve rounds the others as far as its knots allow.
const MAX_CORNERS: usize = 4;

/// Returns the positions of the corners of a closed polyline of the length `total`, in mm, in ascending order.
pub(super) fn find(points: &[Point], total: f64) -> Vec<usize> {
    let n = points.len();
    let arm = (ARM.0 * total / n as f64).max(ARM.1 * total);
    // The arms of a square's corners must not be longer than its sides.
    if arm > 0.25 * total {
        return Vec::new();
    }
    let near = boundary::turns(points, 0.5 * arm);
    let turns = boundary::turns(points, arm);
    let is_sharp = |(tip, turn): &(usize, f64)| near[*tip] >= SHARP * turn;
    let corners = boundary::corners(points, &turns, arm);
    let mut found: Vec<usize> =
        corners.into_iter().filter(is_sharp).map(|corner| corner.0).take(MAX_CORNERS).collect();
    found.sort_unstable();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of corners found on a closed curve of `n` points with teeth of half an edge.
    fn count(n: usize, teeth: f64, at: impl Fn(f64) -> [f64; 2]) -> usize {
        let point = |i: usize| {
            let [x, y] = at(i as f64 / n as f64);
            let out = 1.0 + if i.is_multiple_of(2) { teeth / n as f64 } else { 0.0 };
            Point::new(out * x, out * y, 0.0)
        };
        let points: Vec<Point> = (0..n).map(point).collect();
        let total = (0..n).map(|i| (points[(i + 1) % n] - points[i]).norm()).sum();
        find(&points, total).len()
    }

    /// A regular polygon with `k` sides in the unit circle.
    fn sides(k: usize, t: f64) -> [f64; 2] {
        let corner = |i: usize| {
            let a = std::f64::consts::TAU * i as f64 / k as f64;
            [a.cos(), a.sin()]
        };
        let (i, s) = ((k as f64 * t) as usize, (k as f64 * t).fract());
        let (a, b) = (corner(i), corner(i + 1));
        [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
    }

    #[test]
    fn polygons_have_corners_and_circles_none() {
        for (n, teeth) in [(48, 0.0), (96, 0.0), (300, 0.0), (96, 1.0), (300, 1.5)] {
            assert_eq!(count(n, teeth, |t| sides(4, t)), 4, "square of {n} points");
            assert_eq!(count(n, teeth, |t| sides(3, t)), 3, "triangle of {n} points");
            assert_eq!(count(n, teeth, |t| sides(200, t)), 0, "circle of {n} points");
            let ellipse = |t| sides(200, t).map(|x| x).into_iter().zip([1.0, 0.5]);
            let ellipse = |t| ellipse(t).map(|(x, s)| x * s).collect::<Vec<_>>();
            assert_eq!(count(n, teeth, |t| [ellipse(t)[0], ellipse(t)[1]]), 0, "ellipse");
        }
    }
}
