//! Repair of boundary loops that smoothing has drawn across themselves. This happens at a slot that
//! is narrower than the support.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::BESIDE;
use crate::geometry::{Point, Uv, Vector, plane_axes, segments_cross};

/// The largest number of rounds. Each round moves the points half of the remaining way back.
const MAX_ROUNDS: usize = 12;

/// Moves the points of `smooth` near each crossing back towards `before`, the unsmoothed loop,
/// until the loop does not cross itself. `normals` are the normals of the surface at the points.
pub(crate) fn uncross(smooth: &mut [Point], before: &[Point], normals: &[Vector]) {
    let n = smooth.len();
    for _ in 0..MAX_ROUNDS {
        let mut back = vec![false; n];
        for i in crossed(smooth, normals) {
            (0..=2 * BESIDE + 1).for_each(|k| back[(i + n + k - BESIDE) % n] = true);
        }
        if !back.contains(&true) {
            return;
        }
        for i in (0..n).filter(|&i| back[i]) {
            smooth[i] = nalgebra::center(&smooth[i], &before[i]);
        }
    }
}

/// The edges that cross another edge when they are projected along the normal. An edge is given by
/// its first vertex.
fn crossed(points: &[Point], normals: &[Vector]) -> Vec<usize> {
    let n = points.len();
    let lengths: Vec<f64> = (0..n).map(|i| (points[(i + 1) % n] - points[i]).norm()).collect();
    let mean = lengths.iter().sum::<f64>() / n as f64;
    let places = points.iter().zip(0..).map(|(&p, i)| GeomWithData::new(p.into(), i));
    let tree: RTree<GeomWithData<[f64; 3], usize>> = RTree::bulk_load(places.collect());
    let mut found = Vec::new();
    for i in 0..n {
        // Edges whose first vertices are farther apart cannot cross. Each pair is found from its
        // longer edge. The reach is at least twice the mean length, because the two sides may lie
        // one above the other.
        let reach = 2.0 * lengths[i].max(mean);
        let near = tree.locate_within_distance(points[i].into(), reach * reach);
        for j in near.map(|place| place.data) {
            if cross(points, normals, i, j) {
                found.extend([i, j]);
            }
        }
    }
    found
}

fn cross(points: &[Point], normals: &[Vector], i: usize, j: usize) -> bool {
    let n = points.len();
    if i == j || (i + 1) % n == j || (j + 1) % n == i || normals[i].dot(&normals[j]) <= 0.0 {
        return false;
    }
    let (x, y) = plane_axes((normals[i] + normals[j]).normalize());
    let flat = |k: usize| {
        let d = points[k % n] - points[i];
        Uv::new(d.dot(&x), d.dot(&y))
    };
    segments_cross(flat(i), flat(i + 1), flat(j), flat(j + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_that_was_drawn_shut_opens_again() {
        let p = |x: f64, y: f64| Point::new(x, y, 0.0);
        // A square with a slot from the right. Then the two sides of the slot are swapped.
        let slot = [(10., 5.2), (8., 5.2), (6., 5.2), (6., 4.8), (8., 4.8), (10., 4.8)];
        let outside = [(10., 0.), (5., 0.), (0., 0.), (0., 5.), (0., 10.), (5., 10.), (10., 10.)];
        let before: Vec<Point> = slot.iter().chain(&outside).map(|&(x, y)| p(x, y)).collect();
        let normals = vec![Vector::z(); before.len()];
        assert!(crossed(&before, &normals).is_empty());
        let mut smooth = before.clone();
        smooth[1].y = 4.7;
        smooth[4].y = 5.3;
        assert!(!crossed(&smooth, &normals).is_empty());
        uncross(&mut smooth, &before, &normals);
        assert!(crossed(&smooth, &normals).is_empty());
    }
}
