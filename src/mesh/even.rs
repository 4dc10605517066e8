//! Even triangles for a body that has long or thin ones.
//!
//! Tessellations of CAD models have slivers and few vertices on flat parts. Long edges are divided,
//! which changes no surface, and edges are flipped where the surface is almost flat.

use super::remesh::divide;
use super::remesh::flips::{EdgeFlip, Sides, flip};
use super::{FaceOrigin, Mesh, Patch};
use crate::geometry::{MOST_ROUNDS, Vector, VertexId, unit_normal};

/// The longest edge as a share of the diagonal. The quads of a layout are about as large.
const LONGEST: f64 = 0.02;

/// The most points that are added. A body with a surface of four squares of its diagonal needs about
/// 20,000 for edges of the length above.
const MOST_ADDED: usize = 100_000;

/// Two triangles are flat if the cosine of the angle between them is at least this (8°). A flip of
/// their edge moves the surface by less than a fortieth of an edge.
const FLAT: f64 = 0.99;

impl Patch {
    /// A body without gaps.
    pub fn closed(mesh: Mesh) -> Self {
        Patch {
            measured: mesh.points.len(),
            origin: vec![FaceOrigin::Measured; mesh.triangles.len()],
            mesh,
            outer: Vec::new(),
            measured_outer: None,
            rims: Vec::new(),
            islands: Vec::new(),
            stand_ins: None,
            point_counts: None,
        }
    }

    /// The same surface of a body with triangles that are more even. The new points follow the old
    /// ones. They lie on edges, and do not count as measured. The rims are not kept.
    #[must_use]
    pub(crate) fn even(&self) -> Self {
        let mut points = self.mesh.points.clone();
        let mut origin = self.origin.clone();
        let mut triangles: Vec<[usize; 3]> =
            self.mesh.triangles.iter().map(|t| t.map(|v| v.index())).collect();
        let longest = LONGEST * self.mesh.diagonal();
        let most = points.len() + MOST_ADDED;
        // Each round halves the longest edges.
        for _ in 0..MOST_ROUNDS {
            let divided = divide(&mut points, &mut triangles, |_| longest, most);
            divided.iter().flatten().for_each(|&t| origin.push(origin[t]));
            flip_flat_edges(&points, &mut triangles, &origin);
            if divided.is_empty() {
                break;
            }
        }
        let triangles = triangles.into_iter().map(|t| t.map(VertexId::from)).collect();
        let mesh = Mesh { points, triangles };
        let stand_ins = self.stand_ins.clone();
        Patch { measured: self.measured, origin, stand_ins, ..Patch::closed(mesh) }
    }

    /// For each vertex whether it was measured or lies in a measured triangle.
    pub(crate) fn on_measured(&self) -> Vec<bool> {
        let mut on_measured = vec![false; self.mesh.points.len()];
        on_measured[..self.measured].fill(true);
        for t in self.measured_triangles() {
            self.mesh.triangles[t].iter().for_each(|v| on_measured[v.index()] = true);
        }
        on_measured
    }
}

/// Flips edges between almost flat triangles of the same origin.
fn flip_flat_edges(
    points: &[crate::geometry::Point],
    triangles: &mut [[usize; 3]],
    origin: &[FaceOrigin],
) {
    let mut sides = Sides::of(triangles);
    let normals =
        |pair: [[usize; 3]; 2]| pair.map(|t| unit_normal(t.map(|v| points[v])).unwrap_or_default());
    let may = |edge: &EdgeFlip| {
        let [s, t] = edge.numbers;
        let ([a, b], new) = (normals(edge.old), normals(edge.new));
        let mean: Vector = a + b;
        let keeps = |n: &Vector| n.dot(&mean) > FLAT * mean.norm();
        origin[s] == origin[t] && a.dot(&b) >= FLAT && new.iter().all(keeps)
    };
    flip(points, triangles, &mut sides, |_, _| false, may);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::mesh::EdgeMap;

    /// A flat box with two triangles on each side.
    fn flat_box() -> Mesh {
        let at = |k: usize| {
            Point::new((k & 1) as f64 * 40.0, (k >> 1 & 1) as f64 * 30.0, (k >> 2) as f64)
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles = halves.map(|t: [usize; 3]| t.map(VertexId::from)).collect();
        Mesh { points: (0..8).map(at).collect(), triangles }
    }

    fn volume(mesh: &Mesh) -> f64 {
        let of = |t: &[VertexId; 3]| {
            let [a, b, c] = mesh.corners(*t).map(|p| p.coords);
            a.dot(&b.cross(&c)) / 6.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    #[test]
    fn long_edges_are_divided_and_the_surface_stays() {
        let body = Patch::closed(flat_box());
        let even = body.even();
        assert_eq!((even.measured, even.mesh.points[..8].to_vec()), (8, body.mesh.points));
        assert_eq!(even.origin.len(), even.mesh.triangles.len());
        assert!((volume(&even.mesh) - 1200.0).abs() < 1e-9);
        let edges = EdgeMap::new(&even.mesh);
        let sides = 0..3 * even.mesh.triangles.len();
        assert!(sides.clone().all(|side| edges.across(side).is_some()));
        let longest = sides.map(|side| {
            let (a, b) = even.mesh.side(side);
            (even.mesh.point(b) - even.mesh.point(a)).norm()
        });
        assert!(longest.fold(0.0, f64::max) < 1.5 * LONGEST * even.mesh.diagonal());
    }

    #[test]
    fn a_fill_stays_a_fill() {
        let mut body = Patch::closed(flat_box());
        body.measured = 6;
        body.origin[2..4].fill(FaceOrigin::Hole(0));
        let even = body.even();
        let top = |t: usize| even.mesh.corners(even.mesh.triangles[t]).iter().all(|p| p.z == 1.0);
        assert!((0..even.origin.len()).all(|t| top(t) == (even.origin[t] != FaceOrigin::Measured)));
        let on_measured = even.on_measured();
        let between = |x: f64, end: f64| x > 0.0 && x < end;
        let inside = |p: &Point| p.z == 1.0 && between(p.x, 40.0) && between(p.y, 30.0);
        let points = even.mesh.points.iter().zip(on_measured);
        assert!(points.clone().any(|(p, _)| inside(p)));
        assert!(points.into_iter().all(|(p, measured)| measured != inside(p)));
    }
}
