//! Detection of corners of a boundary loop.

use super::curve::MIN_POINTS;
use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, boundary};

/// A boundary has a corner where its direction turns by more than this angle. The value is 45°.
const TURN: f64 = std::f64::consts::FRAC_PI_4;

/// A loop shorter than this multiple of the window has no corners.
const SHORTEST: f64 = 12.0;

/// The positions of corners in the loop, in ascending order. At a corner the direction turns by
/// more than 45° between the two arms of length `window` mm on its sides. Noise and stair steps
/// much shorter than an arm have little influence.
pub(crate) fn find(mesh: &Mesh, ring: &[VertexId], window: f64) -> Vec<usize> {
    let points: Vec<Point> = ring.iter().map(|&v| mesh.point(v)).collect();
    let n = points.len();
    let total: f64 = (0..n).map(|i| (points[(i + 1) % n] - points[i]).norm()).sum();
    if n < MIN_POINTS || total < SHORTEST * window {
        return Vec::new();
    }
    let turns: Vec<f64> = (0..n).map(|i| turn(&points, i, window)).collect();
    let peaks = (0..n).filter(|&i| turns[i] > TURN && is_peak(&points, &turns, i, window));
    let mut tips: Vec<usize> = peaks.map(|i| boundary::tip(&points, i, window)).collect();
    tips.sort_unstable();
    tips.dedup();
    tips
}

/// The angle between the directions of the two arms.
fn turn(points: &[Point], i: usize, window: f64) -> f64 {
    let [before, after] = boundary::arms(points, i, window);
    before.angle(&after)
}

/// Whether no vertex within a window of `i` turns more. The first of equal vertices is the peak.
fn is_peak(points: &[Point], turns: &[f64], i: usize, window: f64) -> bool {
    let n = points.len();
    let mut length = 0.0;
    let mut j = i;
    while length < window {
        let next = (j + 1) % n;
        length += (points[next] - points[j]).norm();
        j = next;
        if j == i {
            break;
        }
        if turns[j] > turns[i] {
            return false;
        }
    }
    (length, j) = (0.0, i);
    while length < window {
        let next = (j + n - 1) % n;
        length += (points[next] - points[j]).norm();
        j = next;
        if j == i {
            break;
        }
        if turns[j] >= turns[i] {
            return false;
        }
    }
    true
}
