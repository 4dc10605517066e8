//! Selection of the four boundary vertices that are mapped to the corners of the square.

use crate::error::{Error, Result};
use crate::geometry::{Point, ROUNDING, VertexId};
use crate::mesh::{Mesh, boundary};

/// The largest number of convex turns of the boundary that are candidates.
const MAX_TURNS: usize = 24;

/// The number of vertices at equal distances along the boundary that are candidates as well.
const EVEN_CANDIDATES: usize = 16;

/// The positions in the outer loop of the vertices nearest to the four points of the user, in the
/// order of the loop. The vertex of the first point comes first.
///
/// # Errors
/// [`Error::Corners`] if two points have the same nearest vertex.
pub(super) fn given(mesh: &Mesh, outer: &[VertexId], points: &[Point; 4]) -> Result<[usize; 4]> {
    let nearest = |p: &Point| {
        let distance = |i: &usize| (mesh.point(outer[*i]) - p).norm_squared();
        (0..outer.len()).min_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
    };
    let found = points.each_ref().map(nearest);
    let mut sorted = found;
    sorted.sort_unstable();
    if sorted.windows(2).any(|w| w[0] == w[1]) {
        return Err(Error::Corners("two of them are the same boundary vertex".into()));
    }
    let first = sorted.iter().position(|&i| i == found[0]).unwrap_or(0);
    sorted.rotate_left(first);
    Ok(sorted)
}

/// A boundary vertex that may become a corner.
struct CornerCandidate {
    position: usize,
    /// Its position along the loop, as a share of the length of the loop.
    at: f64,
    /// The turning angle as a share of a right angle; 1 for a square corner.
    turn: f64,
}

/// The largest number of corner sets that are tried.
const MAX_SETS: usize = 8;

/// Sets of four positions, the best first. A set is good if its turning angles are near right
/// angles and its opposite sides have about equal lengths.
///
/// # Errors
/// [`Error::TooSmall`] if the boundary has fewer than four candidates.
pub(super) fn likely(mesh: &Mesh, outer: &[VertexId]) -> Result<Vec<[usize; 4]>> {
    let candidates = candidates(mesh, outer);
    let n = candidates.len();
    let mut rated: Vec<(f64, [usize; 4])> = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            for c in b + 1..n {
                for d in c + 1..n {
                    let four = [a, b, c, d].map(|i| &candidates[i]);
                    rated.push((cost(four), four.map(|f| f.position)));
                }
            }
        }
    }
    rated.sort_by(|a, b| a.0.total_cmp(&b.0));
    rated.truncate(MAX_SETS);
    let sets: Vec<_> = rated.into_iter().map(|(_, four)| four).collect();
    if sets.is_empty() { Err(Error::TooSmall(outer.len())) } else { Ok(sets) }
}

/// The cost of a set. A corner costs nothing if it is a right angle or sharper, and 1 if the
/// boundary is straight there; concave places cost up to 1.5. Opposite sides cost half the
/// logarithm of the ratio of their lengths.
fn cost(four: [&CornerCandidate; 4]) -> f64 {
    let missing: f64 = four.iter().map(|c| (1.0 - c.turn).clamp(0.0, 1.5)).sum();
    let side = |k: usize| (four[(k + 1) % 4].at - four[k].at).rem_euclid(1.0).max(ROUNDING);
    let uneven = |k: usize| (side(k) / side(k + 2)).ln().abs();
    missing + 0.5 * (uneven(0) + uneven(1))
}

fn candidates(mesh: &Mesh, ring: &[VertexId]) -> Vec<CornerCandidate> {
    let n = ring.len();
    let points: Vec<Point> = ring.iter().map(|&v| mesh.point(v)).collect();
    let lengths: Vec<f64> = boundary::sides(mesh, ring).collect();
    let total: f64 = lengths.iter().sum();
    let window = (total / 40.0).max(2.0 * total / n as f64);
    let normals = mesh.vertex_normals();
    let mut all = Vec::with_capacity(n);
    let mut walked = 0.0;
    for (i, length) in lengths.iter().enumerate() {
        let [before, after] = boundary::arms(&points, i, window);
        let normal = normals[ring[i].index()];
        let angle = normal.dot(&before.cross(&after)).signum() * before.angle(&after);
        let turn = angle / std::f64::consts::FRAC_PI_2;
        all.push(CornerCandidate { position: i, at: walked / total, turn });
        walked += length;
    }
    let mut chosen = Vec::new();
    for i in peaks(&all, window / total) {
        let tip = boundary::tip(&points, i, window);
        all[tip].turn = all[i].turn;
        chosen.push(tip);
    }
    let step = n.div_ceil(EVEN_CANDIDATES).max(1);
    let far = |i: &usize| chosen.iter().all(|&j| apart(&all, *i, j) > window / total);
    let even: Vec<usize> = (0..n).step_by(step).filter(far).collect();
    chosen.extend(even);
    if chosen.len() < 4 {
        // There are so few vertices that windows overlap. All of them become candidates.
        chosen.extend((0..n).step_by(step));
    }
    chosen.sort_unstable();
    chosen.dedup();
    let chosen: std::collections::HashSet<usize> = chosen.into_iter().collect();
    all.retain(|c| chosen.contains(&c.position));
    all
}

/// The sharpest convex turns. A turn counts only if it is the sharpest within a window.
fn peaks(all: &[CornerCandidate], window: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..all.len()).filter(|&i| all[i].turn > 0.2).collect();
    order.sort_by(|&i, &j| all[j].turn.total_cmp(&all[i].turn).then(i.cmp(&j)));
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.len() < MAX_TURNS && kept.iter().all(|&j| apart(all, i, j) > window) {
            kept.push(i);
        }
    }
    kept
}

/// The distance between two boundary vertices along the loop, as a share of its length.
fn apart(all: &[CornerCandidate], i: usize, j: usize) -> f64 {
    let d = (all[i].at - all[j].at).abs();
    d.min(1.0 - d)
}
