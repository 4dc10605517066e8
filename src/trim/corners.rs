//! Corners of a rim.

use crate::geometry::Point;

/// A corner turns by at least this much, in radians, between its arms.
const TURN: f64 = 0.9;

/// Arms half as long see at least this share of the turn; of a round bend they
/// see half.
const SHARP: f64 = 0.75;

/// Arms have at least this many mean edges, so that the teeth of a rim do not
/// count, and are at least so long a share of the loop.
const ARM: (f64, f64) = (6.0, 1.0 / 16.0);

/// A loop has at most this many; of more the sharpest ones count. Where it turns
/// besides, the curve is round, as its knots allow.
const MOST: usize = 4;

/// Positions of the corners of a closed loop, ascending. `walked[i]` is the
/// length from point 0 to point i, `total` that of the loop, in mm.
pub fn find(points: &[Point], walked: &[f64], total: f64) -> Vec<usize> {
    let n = points.len();
    let arm = (ARM.0 * total / n as f64).max(ARM.1 * total);
    // A square's arms are no longer than its sides.
    if arm > 0.25 * total {
        return Vec::new();
    }
    let ring = Ring { points, walked, total };
    let turns: Vec<f64> = (0..n).map(|i| ring.turn(i, 0.5 * arm)).collect();
    let sharp = |&i: &usize| {
        let whole = ring.turn(i, arm);
        whole >= TURN && turns[i] >= SHARP * whole
    };
    let mut found: Vec<usize> =
        (0..n).filter(sharp).filter(|&i| ring.is_peak(&turns, i, arm)).collect();
    found.sort_by(|&i, &j| turns[j].total_cmp(&turns[i]));
    found.truncate(MOST);
    found.sort_unstable();
    found
}

struct Ring<'a> {
    points: &'a [Point],
    walked: &'a [f64],
    total: f64,
}

impl Ring<'_> {
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

    /// The angle between the arms of a length that come to point `i` and leave it.
    fn turn(&self, i: usize, arm: f64) -> f64 {
        let (here, s) = (self.points[i], self.walked[i]);
        (here - self.at(s - arm)).angle(&(self.at(s + arm) - here))
    }

    /// Whether no point within an arm's length turns more (the first of equal ones
    /// counts).
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

    /// Corners found on a closed curve of `n` points with teeth of half an edge.
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

    /// A polygon with so many sides around the unit circle.
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
