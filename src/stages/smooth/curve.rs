//! Smoothing of the boundary: each point of a loop is projected onto its MLS curve (section 3.1).
//!
//! The reference line through q, the foot point of r, in direction u minimises Σ ‖(pᵢ − q) − ⟨pᵢ −
//! q, u⟩ u‖² θ(‖pᵢ − q‖) over q and u. This problem is non-linear, because the weights move with q.
//! A parametric quadratic (u, v(u), w(u)) is fitted over that line; its value at u = 0 is the
//! projection. Only points between the same two corners of the loop take part.
//!
//! The loop already lies on the surface. A point therefore moves only within the surface and across
//! the loop, and no farther than the noise explains. The rim of a scan without noise does not move.

use nalgebra::Vector2;
use rayon::prelude::*;

use super::BESIDE;
use super::crossvalidation::{SupportScore, chosen};
use super::line::{quadratic, reference_line};
use crate::geometry::{NEGLIGIBLE, Point, Vector, plane_axes};
use crate::mesh::mls::REACH;
use crate::statistics::{SIGNIFICANT, outlying};

/// The supports that are tried, as multiples of the mean edge length of the loop.
const SUPPORTS: [f64; 7] = [2.0, 3.0, 4.5, 6.5, 9.5, 14.0, 20.0];

/// Loops and parts of loops with fewer points than this are not smoothed.
pub(super) const MIN_POINTS: usize = 8;

/// A loop of points on a surface.
pub(crate) struct RimPoints<'a> {
    /// The points, in order.
    pub points: &'a [Point],
    /// The unit normals of the surface at the points.
    pub normals: &'a [Vector],
    /// The standard deviations of the noise at the points, in mm.
    pub noise: &'a [f64],
}

/// The points between two corners, or a whole loop.
struct LoopPart {
    points: Vec<Point>,
    normals: Vec<Vector>,
    noise: Vec<f64>,
    closed: bool,
}

/// Smooths a closed loop with corners at the given positions. The part between two corners is
/// smoothed separately, with fixed ends. Each corner then moves to the place where the smoothed
/// parts meet. The support is the one that predicts left-out points best.
pub(crate) fn smooth_loop(rim: &RimPoints, corners: &[usize]) -> Vec<Point> {
    let n = rim.points.len();
    if n < MIN_POINTS {
        return rim.points.to_vec();
    }
    let mut out = match corners {
        [] => rim.part(0, n, true).smooth(),
        _ => rim.points.to_vec(),
    };
    for (k, &first) in corners.iter().enumerate() {
        let last = corners[(k + 1) % corners.len()];
        let count = (last + n - first - 1) % n + 2;
        let smooth = rim.part(first, count, false).smooth();
        for (i, p) in smooth.into_iter().enumerate().take(count - 1).skip(1) {
            out[(first + i) % n] = p;
        }
    }
    for &corner in corners {
        out[corner] = rim.corner_position(&out, corner).unwrap_or(out[corner]);
    }
    rim.spread_points(&mut out, corners);
    out
}

/// The number of rounds in which points are spread along the loop.
const SPREADING: usize = 12;

impl RimPoints<'_> {
    /// Spreads points along the loop where noise has crowded them. In each round a point moves half
    /// the way to the middle of its neighbours, along the line through them, but in total no
    /// farther than the noise explains.
    fn spread_points(&self, points: &mut [Point], corners: &[usize]) {
        let n = points.len();
        let mut moved = vec![0.0; n];
        for _ in 0..SPREADING {
            let before = points.to_vec();
            for i in (0..n).filter(|i| !corners.contains(i)) {
                let (a, b) = (before[(i + n - 1) % n], before[(i + 1) % n]);
                let Some(along) = (b - a).try_normalize(0.0) else { continue };
                let wanted = 0.5 * (nalgebra::center(&a, &b) - before[i]).dot(&along);
                let farthest = SIGNIFICANT * self.noise[i];
                let step = (moved[i] + wanted).clamp(-farthest, farthest) - moved[i];
                moved[i] += step;
                points[i] += step * along;
            }
        }
    }

    /// The place where the smoothed sides of a corner meet, or `None` if it is farther from the
    /// measured corner than the noise explains.
    fn corner_position(&self, smooth: &[Point], corner: usize) -> Option<Point> {
        let n = smooth.len();
        let normal = self.normals[corner];
        let (x, y) = plane_axes(normal);
        let raw = self.points[corner];
        let flat = |k: usize| {
            let d = smooth[k % n] - raw;
            Vector2::new(d.dot(&x), d.dot(&y))
        };
        let side = |near: usize, far: usize| (flat(near), (flat(near) - flat(far)).normalize());
        let (p, u) = side(corner + n - 1, corner + n - 1 - BESIDE);
        let (q, v) = side(corner + 1, corner + 1 + BESIDE);
        // Solve p + s u = q + t v. Nearly parallel sides have no usable intersection.
        let turn = u.perp(&v);
        let met = p + (q - p).perp(&v) / turn * u;
        let near = met.norm() <= outlying(n) * self.noise[corner] && turn.abs() > 0.3;
        (near && n > 4 * BESIDE).then(|| raw + met.x * x + met.y * y)
    }

    fn part(&self, first: usize, count: usize, closed: bool) -> LoopPart {
        let n = self.points.len();
        let indices = || (0..count).map(|i| (first + i) % n);
        LoopPart {
            points: indices().map(|i| self.points[i]).collect(),
            normals: indices().map(|i| self.normals[i]).collect(),
            noise: indices().map(|i| self.noise[i]).collect(),
            closed,
        }
    }
}

/// The move that the projection makes, in the surface and across the loop.
struct Move {
    across: Vector,
    by: f64,
    leverage: f64,
}

impl LoopPart {
    fn smooth(&self) -> Vec<Point> {
        if self.points.len() < MIN_POINTS {
            return self.points.clone();
        }
        let h = self.support();
        // The stair steps that a coarse mesh makes of a straight rim are not noise, but up to this
        // size they are smoothed as well.
        let deviations = outlying(self.points.len());
        let project = |i: usize| {
            let farthest = deviations * self.noise[i];
            let moved = self.project(i, h).map(|m| m.by.clamp(-farthest, farthest) * m.across);
            self.points[i] + moved.unwrap_or_else(Vector::zeros)
        };
        (0..self.points.len()).into_par_iter().map(project).collect()
    }

    /// The support that leave-one-out cross-validation selects.
    fn support(&self) -> f64 {
        let n = self.points.len();
        let length: f64 = (1..n).map(|i| (self.points[i] - self.points[i - 1]).norm()).sum();
        let spacing = length / (n - 1) as f64;
        let left_out = |i: usize, h: f64| {
            let m = self.project(i, h)?;
            Some((m.by / (1.0 - m.leverage).max(0.1)).powi(2))
        };
        let tried = SUPPORTS.iter().map(|k| k * spacing).filter(|&h| h < length / 6.0);
        let scored = tried.map(|h| SupportScore {
            h,
            squares: (0..n).into_par_iter().map(|i| left_out(i, h)).collect(),
        });
        chosen(&scored.collect::<Vec<_>>()).unwrap_or(SUPPORTS[0] * spacing)
    }

    fn project(&self, i: usize, h: f64) -> Option<Move> {
        let around = self.around(i, h);
        let r = self.points[i];
        let line = reference_line(r, &around, h)?;
        let (point, leverage) = quadratic(&line, &around, h)?;
        let across = self.normals[i].cross(&line.along).try_normalize(NEGLIGIBLE)?;
        Some(Move { across, by: (point - r).dot(&across), leverage })
    }

    /// The points within reach along this part of the loop.
    fn around(&self, i: usize, h: f64) -> Vec<Point> {
        let n = self.points.len();
        let mut around = vec![self.points[i]];
        for step in [1, n - 1] {
            let (mut j, mut length) = (i, 0.0);
            for _ in 0..(n - 1) / 2 {
                let next = (j + step) % n;
                let over_the_end = next.abs_diff(j) != 1;
                length += (self.points[next] - self.points[j]).norm();
                if (over_the_end && !self.closed) || length > REACH * h {
                    break;
                }
                around.push(self.points[next]);
                j = next;
            }
        }
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A deterministic substitute for noise with mean 0 and values of about ±1.
    fn jitter(i: usize) -> f64 {
        ((i * 7919 % 104_729) as f64 * 0.618_034).fract() * 2.0 - 1.0
    }

    fn noisy_circle(n: usize, noise: f64) -> Vec<Point> {
        (0..n)
            .map(|i| {
                let a = std::f64::consts::TAU * i as f64 / n as f64;
                let r = 10.0 + noise * jitter(i);
                Point::new(r * a.cos(), r * a.sin(), 0.0)
            })
            .collect()
    }

    fn smooth(points: &[Point], corners: &[usize], noise: f64) -> Vec<Point> {
        let normals = vec![Vector::z(); points.len()];
        let noise = vec![noise; points.len()];
        smooth_loop(&RimPoints { points, normals: &normals, noise: &noise }, corners)
    }

    fn rms_from_circle(points: &[Point]) -> f64 {
        let off = |p: &Point| (p.x.hypot(p.y) - 10.0).hypot(p.z).powi(2);
        (points.iter().map(off).sum::<f64>() / points.len() as f64).sqrt()
    }

    #[test]
    fn a_noisy_circle_becomes_round() {
        let raw = noisy_circle(200, 0.3);
        assert!(rms_from_circle(&smooth(&raw, &[], 0.17)) < 0.35 * rms_from_circle(&raw));
    }

    #[test]
    fn a_clean_circle_keeps_its_size() {
        assert!(rms_from_circle(&smooth(&noisy_circle(200, 0.0), &[], 0.17)) < 1e-3);
    }

    #[test]
    fn nothing_moves_without_noise() {
        let raw = noisy_circle(200, 0.3);
        assert_eq!(smooth(&raw, &[], 0.0), raw);
    }

    #[test]
    fn corners_stay_sharp_and_sides_become_straight() {
        let side = |i: usize| (i % 50) as f64 / 5.0;
        let square: Vec<Point> = (0..200)
            .map(|i| {
                let (s, off) = (side(i), 0.1 * jitter(i) * f64::from(i % 50 != 0));
                match i / 50 {
                    0 => Point::new(s, off, 0.0),
                    1 => Point::new(10.0 + off, s, 0.0),
                    2 => Point::new(10.0 - s, 10.0 + off, 0.0),
                    _ => Point::new(off, 10.0 - s, 0.0),
                }
            })
            .collect();
        let smooth = smooth(&square, &[0, 50, 100, 150], 0.06);
        for corner in [0, 50, 100, 150] {
            assert!((smooth[corner] - square[corner]).norm() < 0.06);
        }
        let rms = |points: &[Point]| points[1..50].iter().map(|p| p.y * p.y).sum::<f64>().sqrt();
        assert!(rms(&smooth) < 0.5 * rms(&square));
    }
}
