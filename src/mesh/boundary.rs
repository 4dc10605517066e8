//! Boundary loops of a mesh, and measurements along them.

use std::collections::HashMap;

use super::{EdgeMap, Mesh};
use crate::geometry::{Point, Vector, VertexId};

/// A closed loop of boundary vertices in the direction of the triangles' sides. The surface lies to
/// its left.
pub(crate) type Loop = Vec<VertexId>;

/// The boundary loops of a mesh. Each starts at its lowest vertex, and they are ordered by that
/// vertex. At most one boundary side may leave each vertex; [`super::from_soup`] ensures this.
pub fn boundary_loops(mesh: &Mesh, edges: &EdgeMap) -> Vec<Loop> {
    let mut next: HashMap<VertexId, VertexId> = HashMap::new();
    let mut starts = Vec::new();
    for side in edges.open_sides() {
        let t = mesh.triangles[side / 3];
        next.insert(t[side % 3], t[(side % 3 + 1) % 3]);
        starts.push(t[side % 3]);
    }
    starts.sort_unstable();
    let mut loops = Vec::new();
    for start in starts {
        let mut ring = Vec::new();
        let mut v = start;
        while let Some(w) = next.remove(&v) {
            ring.push(v);
            v = w;
        }
        if !ring.is_empty() {
            loops.push(ring);
        }
    }
    loops
}

/// The length of a closed loop, in mm.
pub(crate) fn length(mesh: &Mesh, ring: &[VertexId]) -> f64 {
    sides(mesh, ring).sum()
}

/// The vector area of a closed loop, in mm². It points along the normal of a surface that has the
/// loop as its boundary and lies to its left.
pub fn area(mesh: &Mesh, ring: &[VertexId]) -> Vector {
    let at = |i: usize| mesh.point(ring[i % ring.len()]) - mesh.point(ring[0]);
    0.5 * (1..ring.len()).map(|i| at(i).cross(&at(i + 1))).sum::<Vector>()
}

/// The lengths of the loop's edges, each from a vertex to the next one.
pub(crate) fn sides<'a>(mesh: &'a Mesh, ring: &'a [VertexId]) -> impl Iterator<Item = f64> + 'a {
    let nexts = ring.iter().cycle().skip(1);
    ring.iter().zip(nexts).map(|(&a, &b)| (mesh.point(b) - mesh.point(a)).norm())
}

/// The directions in which a closed loop arrives at point `i` and leaves it. Each is a mean over
/// `window` mm along the loop, so noise and stair steps much shorter than that have little
/// influence.
pub(crate) fn arms(points: &[Point], i: usize, window: f64) -> [Vector; 2] {
    [-arm(points, i, window, points.len() - 1), arm(points, i, window, 1)]
}

/// A loop has a corner where its direction turns by at least this angle. The value is 45° in radians: half of the
/// turn at a corner of a rectangle.
const CORNER: f64 = std::f64::consts::FRAC_PI_4;

/// The angle by which a closed loop turns at each point between its arms of `window` mm, in radians.
pub(crate) fn turns(points: &[Point], window: f64) -> Vec<f64> {
    let turn = |i: usize| {
        let [before, after] = arms(points, i, window);
        before.angle(&after)
    };
    (0..points.len()).map(turn).collect()
}

/// The corners of a closed loop, the sharpest first: the points that turn by at least [`CORNER`] and
/// more than all others within `window` mm along the loop. Each has its tip and its turn.
pub(crate) fn corners(points: &[Point], turns: &[f64], window: f64) -> Vec<(usize, f64)> {
    let n = points.len();
    let length = |i: usize, step: usize| {
        move |&(j, walked): &(usize, f64)| {
            let next = (j + step) % n;
            let further = walked + (points[next] - points[j]).norm();
            (next != i && walked < window).then_some((next, further))
        }
    };
    let within = |i: usize, step: usize| {
        std::iter::successors(Some((i, 0.0)), length(i, step)).skip(1).map(|(j, _)| j)
    };
    // The first of equal points is the corner.
    let is_peak = |&i: &usize| {
        within(i, 1).all(|j| turns[j] <= turns[i]) && within(i, n - 1).all(|j| turns[j] < turns[i])
    };
    let mut found: Vec<usize> = (0..n).filter(|&i| turns[i] >= CORNER).filter(is_peak).collect();
    found.sort_by(|&i, &j| turns[j].total_cmp(&turns[i]).then(i.cmp(&j)));
    found.into_iter().map(|i| (tip(points, i, window), turns[i])).collect()
}

/// The sum of the displacements from point `i` to the points within `window` mm along the loop.
fn arm(points: &[Point], i: usize, window: f64, step: usize) -> Vector {
    let n = points.len();
    let (mut sum, mut length, mut j) = (Vector::zeros(), 0.0, i);
    for _ in 1..n {
        let next = (j + step) % n;
        length += (points[next] - points[j]).norm();
        j = next;
        sum += points[j] - points[i];
        if length >= window {
            break;
        }
    }
    sum
}

/// The tip of the corner near point `i` of a closed loop: the point within half a window that lies
/// farthest outward between the two directions of [`arms`]. The turning angle alone would not
/// single out the tip, because its neighbours have nearly the same angle.
pub(crate) fn tip(points: &[Point], i: usize, window: f64) -> usize {
    let [before, after] = arms(points, i, window).map(|d| d.try_normalize(0.0).unwrap_or(d));
    let outward = before - after;
    let n = points.len();
    let mut best = i;
    for step in [1, n - 1] {
        let (mut j, mut length) = (i, 0.0);
        for _ in 0..n / 2 {
            let next = (j + step) % n;
            length += (points[next] - points[j]).norm();
            if length > 0.5 * window {
                break;
            }
            j = next;
            if (points[j] - points[best]).dot(&outward) > 0.0 {
                best = j;
            }
        }
    }
    best
}
