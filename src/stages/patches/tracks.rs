//! The curves along the sides of patches.
//!
//! Control points that depend on a regular span are those of the subdivision surface. At an end in
//! an irregular vertex, the curve leaves the limit point in the direction of the limit tangent, and
//! one control point is fitted to the limit curve by least squares, with parameters by arc length.

use nalgebra::Matrix3;

use super::PatchSource;
use super::corners::ROUNDS;
use super::pieces::{arguments, blossom, grid, spans};
use crate::geometry::{Point, Quarter, Uv, Vector};
use crate::spline::subdivision::{QuadPlace, limit_point, limit_tangent};
use crate::spline::{Curve, KnotVector};

/// The number of samples of the limit curve along a spoke. They are denser towards the irregular
/// vertex, where the parameters of the subdivision surface are uneven.
const SAMPLES: usize = 64;

/// The number of places at which the curve is compared with the limit curve.
const COMPARED: usize = 16;

/// The weight of the slope of the curve against the limit normals, beside that of distances. With
/// less weight the faces on both sides meet at larger angles, and with more the curve leaves the
/// limit curve (0.22° at 1 and 0.17° at 10 for the 95th percentile of a body with 38 irregular
/// vertices).
const SLOPE: f64 = 10.0;

/// The least and the largest speed of the curve at the regular end of its first span, as shares of
/// the length of the span. Beyond them the curve would turn back or leave with no speed.
const SPEEDS: [f64; 2] = [0.4, 1.6];

/// The limit curve from an irregular vertex along a side of a quad.
pub(super) struct Spoke {
    /// Points, their distances along the curve from the vertex, and the limit normals there.
    samples: Vec<(Vector, f64, Vector)>,
}

impl Spoke {
    /// The spoke that leaves corner `k` of a quad along side `k`.
    pub(super) fn new(source: &PatchSource, quad: usize, k: usize) -> Self {
        let ring = source.surface.ring(quad, k);
        let start = limit_point(&ring, source.control).coords;
        let mut samples = vec![(start, 0.0, source.surface.limit_normal(quad, k, source.control))];
        let mut scratch = Vec::new();
        for i in 1..=SAMPLES {
            let x = (i as f64 / SAMPLES as f64).powi(2);
            let place = QuadPlace { quad, at: from_corner(k, Uv::new(x, 0.0)) };
            let [p, du, dv] = source.surface.jet(source.control, place, &mut scratch);
            let (before, length, normal) = samples[i - 1];
            let n = du.cross(&dv).try_normalize(0.0).unwrap_or(normal);
            samples.push((p, length + (p - before).norm(), n));
        }
        Spoke { samples }
    }

    /// The length of the spoke.
    pub(crate) fn length(&self) -> f64 {
        self.samples[SAMPLES].1
    }

    /// The share of the length up to the parameter `x` of the subdivision surface.
    pub(crate) fn share(&self, x: f64) -> f64 {
        let i = x.max(0.0).sqrt() * SAMPLES as f64;
        let low = (i as usize).min(SAMPLES - 1);
        let [a, b] = [self.samples[low].1, self.samples[low + 1].1];
        (a + (i - low as f64) * (b - a)) / self.length().max(f64::MIN_POSITIVE)
    }

    /// The point and the normal at a distance along the curve from the vertex.
    pub(crate) fn at(&self, s: f64) -> (Vector, Vector) {
        let next = self.samples.partition_point(|sample| sample.1 < s).clamp(1, SAMPLES);
        let (a, b) = (&self.samples[next - 1], &self.samples[next]);
        let share = ((s - a.1) / (b.1 - a.1).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let normal = a.2.lerp(&b.2, share);
        (a.0.lerp(&b.0, share), normal.try_normalize(0.0).unwrap_or(a.2))
    }

    /// The distance along the curve of its point nearest to `p`.
    fn nearest(&self, p: Vector) -> f64 {
        let foot = |w: &[(Vector, f64, Vector)]| {
            let along = w[1].0 - w[0].0;
            let share = (p - w[0].0).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
            let share = share.clamp(0.0, 1.0);
            ((w[0].0 + along * share - p).norm_squared(), w[0].1 + share * (w[1].1 - w[0].1))
        };
        let feet = self.samples.windows(2).map(foot);
        feet.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |foot| foot.1)
    }
}

/// The place on the unit square of a quad at (u, v) from its corner `k`, with u along side `k`.
pub(super) fn from_corner(k: usize, at: Uv) -> Uv {
    Quarter(k).turned(1.0, at.into()).into()
}

impl PatchSource<'_> {
    /// The curve along side `k` of a block, counter-clockwise.
    pub(super) fn track(&self, block: usize, k: usize) -> Curve<3> {
        let count = self.knots.functions();
        let mut control: Vec<Vector> =
            (0..count).map(|i| self.regular_control(block, k, i).unwrap_or_default()).collect();
        let n = self.mesh.side;
        let first = self.quad_at(block, k, 0);
        // The last quad is entered from the other side of the track, where the end is the start.
        let (last, side) = self.surface.across(self.quad_at(block, k, n - 1), k);
        self.finish(first, k, &mut control);
        control.reverse();
        self.finish(last, side, &mut control);
        control.reverse();
        Curve::new(self.knots.clone(), control)
    }

    /// Control point `i` of the curve, or `None` if its support is next to an irregular vertex.
    fn regular_control(&self, block: usize, k: usize, i: usize) -> Option<Vector> {
        let piece = |t: usize| Some((grid(self, self.quad_at(block, k, t))?, t));
        let (grid, t) = spans(&self.knots, i).into_iter().find_map(piece)?;
        let at = |m: usize, depth: usize| {
            let [i, j] = Quarter(k).turned(3, [m, depth]);
            grid[4 * j + i]
        };
        let row = [0, 1, 2, 3].map(|m| (at(m, 0) + 4.0 * at(m, 1) + at(m, 2)) / 6.0);
        Some(blossom(row, arguments(&self.knots, i, t)))
    }

    /// Sets the first control points of a curve that leaves corner `k` of a quad along side `k`.
    fn finish(&self, quad: usize, k: usize, control: &mut [Vector]) {
        let ring = self.surface.ring(quad, k);
        control[0] = limit_point(&ring, self.control).coords;
        if self.surface.is_regular(quad) {
            return;
        }
        let spoke = Spoke::new(self, quad, k);
        let length = spoke.length();
        let curve = Curve::new(self.knots.clone(), control.to_vec());
        let speed = curve.derivatives(1.0)[1].norm().clamp(SPEEDS[0] * length, SPEEDS[1] * length);
        let tangent = limit_tangent(&ring, self.control).try_normalize(0.0).unwrap_or_default();
        let start = 2.0 * length - speed;
        // The first two knots inside are 1/4 and 1/2.
        control[1] = control[0] + tangent * (start * 0.25 / 3.0);
        let arc = |t: f64| length * t + (length - speed) * t * (1.0 - t);
        let mut places: Vec<(f64, f64)> =
            (1..COMPARED).map(|i| i as f64 / COMPARED as f64).map(|t| (t, arc(t))).collect();
        for _ in 0..=ROUNDS {
            control[2] = fitted(&self.knots, control, &spoke, &places);
            let curve = Curve::new(self.knots.clone(), control.to_vec());
            for (t, s) in &mut places {
                *s = spoke.nearest(curve.point(*t));
            }
        }
    }
}

/// Control point 2 by least squares. `places` are parameters of the curve, each with the distance
/// along the spoke that belongs to it.
fn fitted(knots: &KnotVector, control: &[Vector], spoke: &Spoke, places: &[(f64, f64)]) -> Vector {
    let mut matrix = Matrix3::zeros();
    let mut right = Vector::zeros();
    for &(t, s) in places {
        let (target, normal) = spoke.at(s);
        let basis = knots.basis(t);
        let mut rest = [Vector::zeros(); 2];
        let mut own = [0.0; 2];
        for (k, point) in control[basis.first..=basis.first + 3].iter().enumerate() {
            for order in 0..2 {
                let b = basis.derivative[order][k];
                if basis.first + k == 2 { own[order] = b } else { rest[order] += b * point }
            }
        }
        matrix += own[0] * own[0] * Matrix3::identity();
        right += own[0] * (target - rest[0]);
        let across = normal * normal.transpose();
        matrix += SLOPE * own[1] * own[1] * across;
        right -= SLOPE * own[1] * across * rest[1];
    }
    matrix.cholesky().map_or(control[2], |factor| factor.solve(&right))
}

/// The point of the limit surface, for corners.
pub(super) fn limit_at(
    source: &PatchSource,
    place: QuadPlace,
    scratch: &mut Vec<[f64; 3]>,
) -> Point {
    Point::from(source.surface.jet(source.control, place, scratch)[0])
}
