//! Corner detection on a rim.
//!
//! The input is a closed polyline. The output is the positions of its corners: vertices where the
//! line turns by a large angle both at a coarse and at a fine scale.

use crate::geometry::Point;

/// A corner turns by at least this angle, in radians, between its two arms.
const TURN: f64 = 0.9;

/// At a corner, arms of half the length see at least this share of the turn. At a round bend they
/// see only half of it.
const SHARP: f64 = 0.75;

/// The length of the arms: at least this many mean edges, so that the teeth of a rim do not count
/// as corners, and at least this share of the loop.
const ARM: (f64, f64) = (6.0, 1.0 / 16.0);

/// The largest number of corners of a loop. If there are more, the sharpest ones are kept, and the
/// curve rounds the others as far as its knots allow.
const MAX_CORNERS: usize = 4;

/// Returns the positions of the corners of a closed polyline in ascending order. `walked[i]` is the
/// length from point 0 to point i, and `total` is the length of the whole loop, both in mm.
pub(crate) fn find(points: &[Point], walked: &[f64], total: f64) -> Vec<usize> {
    let n = points.len();
    let arm = (ARM.0 * total / n as f64).max(ARM.1 * total);
    // The arms of a square's corners must not be longer than its sides.
    if arm > 0.25 * total {
        return Vec::new();
    }
    let ring = ClosedPolyline { points, walked, total };
    let turns: Vec<f64> = (0..n).map(|i| ring.turn(i, 0.5 * arm)).collect();
    let sharp = |&i: &usize| {
        let whole = ring.turn(i, arm);
        whole >= TURN && turns[i] >= SHARP * whole
    };
    let mut found: Vec<usize> =
        (0..n).filter(sharp).filter(|&i| ring.is_peak(&turns, i, arm)).collect();
    found.sort_by(|&i, &j| turns[j].total_cmp(&turns[i]));
    found.truncate(MAX_CORNERS);
    found.sort_unstable();
    found
}

struct ClosedPolyline<'a> {
    points: &'a [Point],
    walked: &'a [f64],
    total: f64,
}

impl ClosedPolyline<'_> {
    /// The point at length `s` along the loop.
    fn at(&self, s: f64) -> Point {
        let n = self.points.len();
        let s = s.rem_euclid(self.total);
        let i = self.walked.partition_point(|&w| w <= s).clamp(1, n) - 1;
        let end = self.walked.get(i + 1).copied().unwrap_or(self.total);
        let length = (end - self.walked[i]).max(f64::MIN_POSITIVE);
        let share = ((s - self.walked[i]) / length).clamp(0.0, 1.0);
        self.points[i] + share * (self.points[(i + 1) % n] - self.points[i])
    }

    /// The angle in radians between the arm that arrives at point `i` and the arm that leaves it.
    /// Both arms have the length `arm`.
    fn turn(&self, i: usize, arm: f64) -> f64 {
        let (here, s) = (self.points[i], self.walked[i]);
        (here - self.at(s - arm)).angle(&(self.at(s + arm) - here))
    }

    /// Whether no point within an arm's length turns more. Among equal points the first counts.
    fn is_peak(&self, turns: &[f64], i: usize, arm: f64) -> bool {
        let n = turns.len();
        let ahead = |j: usize| (self.walked[j % n] - self.walked[i]).rem_euclid(self.total);
        let later = (i + 1..i + n).take_while(|&j| ahead(j) < arm);
        let earlier = (i + 1..i + n).rev().take_while(|&j| self.total - ahead(j) < arm);
        let less = |j: usize| turns[j] < turns[i] || (turns[j] == turns[i] && j > i);
        later.chain(earlier).all(|j| less(j % n))
    }
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
        let mut walked = vec![0.0];
        for i in 0..n {
            walked.push(walked[i] + (points[(i + 1) % n] - points[i]).norm());
        }
        let total = walked.pop().unwrap_or_default();
        let total = if walked.len() == n { total } else { 0.0 };
        find(&points, &walked, total).len()
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
