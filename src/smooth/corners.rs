//! Where a boundary loop has a corner.

use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, boundary};

/// A boundary that turns by more than this within the window has a corner.
const TURN: f64 = std::f64::consts::FRAC_PI_4;

/// A loop shorter than this many windows is all curve.
const SHORTEST: f64 = 12.0;

/// Positions in the loop, ascending, at which it turns by more than 45°
/// between the arms of length `window` mm on both sides: noise and stair steps
/// much shorter than an arm do not count.
pub fn find(mesh: &Mesh, ring: &[VertexId], window: f64) -> Vec<usize> {
    let points: Vec<Point> = ring.iter().map(|&v| mesh.point(v)).collect();
    let n = points.len();
    let total: f64 = (0..n).map(|i| (points[(i + 1) % n] - points[i]).norm()).sum();
    if n < 8 || total < SHORTEST * window {
        return Vec::new();
    }
    let turns: Vec<f64> = (0..n).map(|i| turn(&points, i, window)).collect();
    let peaks = (0..n).filter(|&i| turns[i] > TURN && is_peak(&points, &turns, i, window));
    let mut tips: Vec<usize> = peaks.map(|i| boundary::tip(&points, i, window)).collect();
    tips.sort_unstable();
    tips.dedup();
    tips
}

/// The angle between the arms' directions.
fn turn(points: &[Point], i: usize, window: f64) -> f64 {
    let [before, after] = boundary::arms(points, i, window);
    before.angle(&after)
}

/// Whether no vertex within a window of `i` turns more (the first of equal
/// ones counts).
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
