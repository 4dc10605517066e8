//! The four boundary vertices that become the corners of the square.

use crate::error::{Error, Result};
use crate::geometry::{Point, VertexId};
use crate::mesh::{Mesh, boundary};

/// The boundary's convex turns that are considered, at the most.
const TURNS: usize = 24;

/// Vertices at equal distances along the boundary that are considered besides.
const EVEN: usize = 16;

/// Positions in the outer loop nearest to the user's four points, turned so
/// that the first point's comes first.
pub fn given(mesh: &Mesh, outer: &[VertexId], points: &[Point; 4]) -> Result<[usize; 4]> {
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
struct Candidate {
    position: usize,
    /// Length along the loop, as a share of the whole.
    at: f64,
    /// How far it turns, as a share of a right angle: 1 for a square corner.
    turn: f64,
}

/// Sets of four corners that are tried at the most.
const SETS: usize = 8;

/// Sets of four positions, the best first: those whose turns are nearest to
/// right angles and whose opposite sides are most equal in length.
pub fn likely(mesh: &Mesh, outer: &[VertexId]) -> Result<Vec<[usize; 4]>> {
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
    rated.truncate(SETS);
    let sets: Vec<_> = rated.into_iter().map(|(_, four)| four).collect();
    if sets.is_empty() { Err(Error::TooSmall(outer.len())) } else { Ok(sets) }
}

/// Lower is better: a right angle or a sharper one costs nothing, a straight or concave place
/// one, and opposite sides of unequal length the logarithm of their ratio.
fn cost(four: [&Candidate; 4]) -> f64 {
    let missing: f64 = four.iter().map(|c| (1.0 - c.turn).clamp(0.0, 1.5)).sum();
    let side = |k: usize| (four[(k + 1) % 4].at - four[k].at).rem_euclid(1.0).max(1e-9);
    let uneven = |k: usize| (side(k) / side(k + 2)).ln().abs();
    missing + 0.5 * (uneven(0) + uneven(1))
}

fn candidates(mesh: &Mesh, ring: &[VertexId]) -> Vec<Candidate> {
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
        all.push(Candidate { position: i, at: walked / total, turn });
        walked += length;
    }
    let mut chosen = Vec::new();
    for i in peaks(&all, window / total) {
        let tip = boundary::tip(&points, i, window);
        all[tip].turn = all[i].turn;
        chosen.push(tip);
    }
    let step = n.div_ceil(EVEN).max(1);
    let far = |i: &usize| chosen.iter().all(|&j| apart(&all, *i, j) > window / total);
    let even: Vec<usize> = (0..n).step_by(step).filter(far).collect();
    chosen.extend(even);
    if chosen.len() < 4 {
        // So few vertices that windows overlap: take as many as there are.
        chosen.extend((0..n).step_by(step));
    }
    chosen.sort_unstable();
    chosen.dedup();
    let chosen: std::collections::HashSet<usize> = chosen.into_iter().collect();
    all.retain(|c| chosen.contains(&c.position));
    all
}

/// The sharpest convex turns that are the sharpest within a window.
fn peaks(all: &[Candidate], window: f64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..all.len()).filter(|&i| all[i].turn > 0.2).collect();
    order.sort_by(|&i, &j| all[j].turn.total_cmp(&all[i].turn).then(i.cmp(&j)));
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.len() < TURNS && kept.iter().all(|&j| apart(all, i, j) > window) {
            kept.push(i);
        }
    }
    kept
}

/// How far two boundary vertices are from each other, as a share of the loop.
fn apart(all: &[Candidate], i: usize, j: usize) -> f64 {
    let d = (all[i].at - all[j].at).abs();
    d.min(1.0 - d)
}
