//! Tolerances that the noise of a scan makes unreachable.
//!
//! A surface that has followed the shape leaves what is noise, and this does not agree from
//! neighbour to neighbour. More control points then follow the noise, each as much of it as
//! one point has: with n of them for N points, a standard deviation of σ √(1 − n/N) is left.

use super::SAME;
use super::noise::POINTS_A_CONTROL_POINT;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::goal::TOLERANCE_OF_NOISE;
use crate::stages::adapt::problem::Problem;

/// The largest correlation along edges of distances that are mostly noise: that of noise is 0,
/// that of a shape that is missed nearly 1.
const MOST_CORRELATION: f64 = 0.3;

/// The share of the points, beyond those that may be left, that raised weights bring back in a
/// net as fine as noise allows.
const BROUGHT_BACK: f64 = 1e-3;

/// With so many times the control points noise stays the same. Of a shape that is missed, a net that is
/// a tenth finer each way leaves less than three quarters.
const MORE: f64 = 1.2;

/// What a net misses.
#[derive(Debug, Clone, Copy)]
pub struct Misfit {
    /// Its control points.
    control: f64,
    /// The standard deviation of the noise if all of it is that.
    noise: f64,
}

/// The standard deviation of the noise if what an attempt misses is noise, as more knots
/// since `before` have shown, and so much of it that no net reaches a named tolerance with
/// fewer than half as many control points as there are points. None that was smoothed
/// away hinders.
pub fn hindering_noise(
    problem: &Problem,
    attempt: &Attempt,
    before: &mut Option<Misfit>,
) -> Option<f64> {
    let goal = problem.goal;
    if !goal.named || !problem.options.noisy {
        return None;
    }
    let now =
        Misfit { control: attempt.surface.net.len() as f64, noise: misfit(problem, attempt)? };
    let was = *before.get_or_insert(now);
    if now.control < MORE * was.control {
        return None;
    }
    *before = Some(now);
    let least = now.noise * (1.0 - 1.0 / POINTS_A_CONTROL_POINT as f64).sqrt();
    let beyond = libm::erfc(goal.tolerance / least / std::f64::consts::SQRT_2);
    let is_noise = now.noise > SAME * was.noise && correlation(problem, attempt) < MOST_CORRELATION;
    (is_noise && beyond > goal.outliers + BROUGHT_BACK).then_some(now.noise)
}

/// The standard deviation of the noise if all that an attempt misses is noise; `None` if
/// it has as many control points as there are points.
fn misfit(problem: &Problem, attempt: &Attempt) -> Option<f64> {
    let left = 1.0 - attempt.surface.net.len() as f64 / problem.measured() as f64;
    (left > 0.0).then(|| attempt.rms() / left.sqrt())
}

/// The correlation, along the edges of measured triangles, of how far points are above a
/// surface. Those beyond the tolerance of noise count as if they were there: an edge of the
/// object would otherwise outvote all else.
fn correlation(problem: &Problem, attempt: &Attempt) -> f64 {
    let mesh = &problem.map.patch.mesh;
    let far = TOLERANCE_OF_NOISE * attempt.rms();
    let above = |v: usize| {
        let off = mesh.points[v] - attempt.surface.point(attempt.foot_points.uv[v]);
        off.dot(&problem.holds[v].normal).clamp(-far, far)
    };
    let above: Vec<f64> = (0..problem.measured()).map(above).collect();
    let is_measured = |t: &[usize; 3]| t.iter().all(|&v| v < above.len());
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| v.index()));
    let (mut products, mut squares) = (0.0, 0.0);
    for t in triangles.filter(is_measured) {
        let [a, b, c] = t.map(|v| above[v]);
        products += a * b + b * c + c * a;
        squares += a * a + b * b + c * c;
    }
    if squares > 0.0 { products / squares } else { 1.0 }
}
