//! Tolerances that the noise of a scan makes unreachable.
//!
//! A surface that has followed the shape leaves the noise. More control points then follow the
//! noise, each as much of it as one point has: with n of them for N points, a standard deviation of
//! σ √(1 − n/N) is left.

use super::SAME;
use crate::stages::adapt::attempt::Attempt;
use crate::stages::adapt::options::POINTS_A_CONTROL_POINT;
use crate::stages::adapt::problem::Problem;
use crate::statistics::level;

/// The standard deviation of the noise if it is all that an attempt misses, and so much that no net
/// reaches a named tolerance with fewer than half as many control points as there are points. None
/// that was smoothed away hinders.
pub(crate) fn hindering_noise(problem: &Problem, attempt: &Attempt) -> Option<f64> {
    let (goal, noise) = (problem.goal, problem.options.noise);
    if !goal.named || noise == 0.0 {
        return None;
    }
    let left = |share: f64| noise * (1.0 - share).sqrt();
    let control = attempt.surface.net.len() as f64 / problem.measured() as f64;
    let is_noise = control < 1.0 && SAME * attempt.rms() <= left(control);
    let least = left(1.0 / POINTS_A_CONTROL_POINT as f64);
    let beyond = libm::erfc(goal.tolerance / least / std::f64::consts::SQRT_2);
    // Raised weights bring a few points back.
    (is_noise && beyond > goal.outliers + level()).then_some(noise)
}
