//! A membrane for holes that the front cannot close: wide, strongly curved
//! ones, on whose far side the extrapolated fronts miss each other.
//!
//! The rim is laid on a circle by chord length, the disk filled with points at
//! the rim's spacing, and the Delaunay triangulation of both carried into
//! space by letting every inner vertex be the mean of its neighbours. That
//! always ends, and always is a disk.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::geometry::{Point, VertexId};

/// The inner points, and triangles over the rim's vertices followed by those.
pub struct Membrane {
    pub points: Vec<Point>,
    pub triangles: Vec<[usize; 3]>,
}

/// A vertex of the planar triangulation with its number.
struct Numbered {
    at: Point2<f64>,
    number: usize,
}

impl HasPosition for Numbered {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

/// Spans a membrane over a closed polygon, counter-clockwise seen from the
/// side to which its triangles shall look. `joined` tells whether two of the
/// polygon's vertices are joined already; such an edge is not made again.
/// `None` where the numbers do not allow a triangulation.
pub fn span(
    rim: &[(VertexId, Point)],
    joined: impl Fn(VertexId, VertexId) -> bool,
) -> Option<Membrane> {
    let circle = circle(rim)?;
    let mut inner = hexagonal_points(&circle);
    // Each round splits the chords that may not be.
    for _ in 0..8 {
        let triangles = delaunay(&circle, &inner)?;
        let chords = forbidden_chords(&triangles, rim, &joined);
        if chords.is_empty() {
            let points = relax(rim, inner.len(), &triangles)?;
            return Some(Membrane { points, triangles });
        }
        inner.extend(chords.into_iter().map(|(i, j)| {
            Point2::new(0.5 * (circle[i].x + circle[j].x), 0.5 * (circle[i].y + circle[j].y))
        }));
    }
    None
}

/// The polygon on a circle of its own circumference, in mean edge lengths.
fn circle(rim: &[(VertexId, Point)]) -> Option<Vec<Point2<f64>>> {
    let n = rim.len();
    let side = |i: usize| (rim[(i + 1) % n].1 - rim[i].1).norm();
    let total: f64 = (0..n).map(side).sum();
    // No edge so short that it would vanish on the circle.
    let least = 1e-3 * total / n as f64;
    let sides: Vec<f64> = (0..n).map(|i| side(i).max(least)).collect();
    let total: f64 = sides.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let radius = n as f64 / std::f64::consts::TAU;
    let mut walked = 0.0;
    let place = |length: &f64| {
        let angle = std::f64::consts::TAU * walked / total;
        walked += length;
        Point2::new(radius * angle.cos(), radius * angle.sin())
    };
    Some(sides.iter().map(place).collect())
}

/// The points of a hexagonal grid of unit spacing that keep their distance
/// from the circle; at least its centre.
fn hexagonal_points(circle: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let radius = circle.len() as f64 / std::f64::consts::TAU;
    let height = 0.75f64.sqrt();
    let reach = (radius / height).ceil() as i64;
    let mut points = Vec::new();
    for row in -reach..=reach {
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for column in -reach - 1..=reach + 1 {
            let (x, y) = (column as f64 + shift, row as f64 * height);
            if x.hypot(y) < radius - 0.7 || (row == 0 && column == 0) {
                points.push(Point2::new(x, y));
            }
        }
    }
    points
}

fn delaunay(circle: &[Point2<f64>], inner: &[Point2<f64>]) -> Option<Vec<[usize; 3]>> {
    let all = circle.iter().chain(inner).enumerate();
    let vertices = all.map(|(number, &at)| Numbered { at, number }).collect();
    let plane = DelaunayTriangulation::<Numbered>::bulk_load(vertices).ok()?;
    let triangles: Vec<[usize; 3]> =
        plane.inner_faces().map(|f| f.vertices().map(|v| v.data().number)).collect();
    // As many as a disk with this boundary has.
    (triangles.len() == circle.len() + 2 * inner.len() - 2).then_some(triangles)
}

/// Inner edges between rim vertices that are joined already.
fn forbidden_chords(
    triangles: &[[usize; 3]],
    rim: &[(VertexId, Point)],
    joined: impl Fn(VertexId, VertexId) -> bool,
) -> Vec<(usize, usize)> {
    let n = rim.len();
    let sides = triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]);
    sides
        .filter(|&(i, j)| i < j && j < n && j - i != 1 && !(i == 0 && j == n - 1))
        .filter(|&(i, j)| joined(rim[i].0, rim[j].0))
        .collect()
}

/// Places the inner vertices so that each is the mean of its neighbours.
fn relax(rim: &[(VertexId, Point)], inner: usize, triangles: &[[usize; 3]]) -> Option<Vec<Point>> {
    let n = rim.len();
    let mut triplets = Vec::with_capacity(14 * inner);
    let mut right = faer::Mat::<f64>::zeros(inner, 3);
    // Each inner edge belongs to two triangles, once in each direction.
    for (i, j) in triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]) {
        let Some(row) = i.checked_sub(n) else { continue };
        triplets.push(Triplet::new(row, row, 1.0));
        match j.checked_sub(n) {
            Some(column) => triplets.push(Triplet::new(row, column, -1.0)),
            None => (0..3).for_each(|axis| right[(row, axis)] += rim[j].1[axis]),
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(inner, inner, &triplets).ok()?;
    let x = matrix.sp_cholesky(faer::Side::Lower).ok()?.solve(&right);
    Some((0..inner).map(|i| Point::new(x[(i, 0)], x[(i, 1)], x[(i, 2)])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(n: usize) -> Vec<(VertexId, Point)> {
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let at = |i: usize| Point::new(angle(i).cos(), angle(i).sin(), (2.0 * angle(i)).cos());
        (0..n).map(|i| (VertexId::from(i), at(i))).collect()
    }

    #[test]
    fn a_saddle_is_spanned_by_a_disk() {
        for n in [4, 5, 7, 30, 200] {
            let m = span(&ring(n), |_, _| false).unwrap();
            assert_eq!(m.triangles.len(), n + 2 * m.points.len() - 2);
            assert!(m.points.iter().all(|p| p.coords.norm() < 1.5));
        }
    }

    #[test]
    fn joined_vertices_are_not_joined_again() {
        let m = span(&ring(6), |_, _| true).unwrap();
        for t in &m.triangles {
            for (i, j) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                assert!(i.max(j) >= 6 || (i + 1) % 6 == j);
            }
        }
    }
}
