//! Insertion of vertices between vertices that the map places far apart.
//!
//! On the square, the rings of a tube lie several knot cells apart, most of all near the boundary.
//! Without further vertices nothing would hold the surface between them.

use rayon::prelude::*;

use super::Parameterized;
use super::stretch;
use crate::geometry::{Point, Uv, UvVector, Vector, VertexId};
use crate::mesh::{EdgeMap, EdgeMidpoints, FaceOrigin, Mesh, Patch};

/// A side is long if it exceeds this multiple of the distance between vertices on an even map.
const LONG: f64 = 2.0;

/// The largest number of rounds of halving. Next to a long side at a rim, which is not halved,
/// there is always another long side.
const MOST_ROUNDS: usize = 5;

/// Halves sides that the map stretches. Returns the number of new vertices.
pub(crate) fn insert_vertices(map: &mut Parameterized) -> usize {
    let before = map.patch.mesh.points.len();
    let width = stretch::measure(&map.patch, &map.uv).aspect.sqrt();
    let long = LONG / (map.patch.measured as f64).sqrt();
    let is_long = |a: Uv, b: Uv| {
        let d = b - a;
        UvVector::new(d.x * width, d.y / width).norm() > long
    };
    map.halve(MOST_ROUNDS, is_long);
    map.patch.mesh.points.len() - before
}

impl Parameterized {
    /// Halves long sides in up to `rounds` rounds. The new vertices lie on the curved surface that
    /// the vertex normals imply.
    pub(crate) fn halve(&mut self, rounds: usize, is_long: impl Fn(Uv, Uv) -> bool + Sync) {
        let before = self.patch.mesh.points.len();
        let mut normals = measured_normals(&self.patch);
        for _ in 0..rounds {
            let sides = self.long_sides(&self.uv, &is_long);
            if sides.is_empty() {
                break;
            }
            halve(self, &sides, &mut normals);
        }
        let added = self.patch.mesh.points.len() - before;
        for v in self.scaffold.triangles.iter_mut().flatten().filter(|v| v.index() >= before) {
            *v = VertexId::from(v.index() + added);
        }
    }

    /// The sides that are long for the parameter points `uv` of the vertices, in ascending order.
    /// Sides between two measured triangles are returned. Sides on the boundary are returned if the
    /// patch fills the whole domain.
    pub(crate) fn long_sides(
        &self,
        uv: &[Uv],
        is_long: impl Fn(Uv, Uv) -> bool + Sync,
    ) -> Vec<usize> {
        let mesh = &self.patch.mesh;
        let is_measured = |side: usize| self.patch.origin[side / 3] == FaceOrigin::Measured;
        let may_be = |&side: &usize| {
            let (a, b) = mesh.side(side);
            is_measured(side) && is_long(uv[a.index()], uv[b.index()])
        };
        let sides = (0..3 * mesh.triangles.len()).into_par_iter();
        let mut long: Vec<usize> = sides.filter(may_be).collect();
        if !long.is_empty() {
            let edges = EdgeMap::new(mesh);
            let is_square = self.scaffold.triangles.is_empty();
            long.retain(|&side| edges.across(side).map_or(is_square, is_measured));
        }
        long
    }
}

/// The normals of the vertices, computed from measured triangles only.
fn measured_normals(patch: &Patch) -> Vec<Vector> {
    let triangles = patch.measured_triangles().map(|t| patch.mesh.triangles[t]).collect();
    Mesh { points: patch.mesh.points.clone(), triangles }.vertex_normals()
}

fn halve(map: &mut Parameterized, sides: &[usize], normals: &mut Vec<Vector>) {
    let uv = &mut map.uv;
    let middle = |mesh: &Mesh, a: VertexId, b: VertexId| -> Point {
        uv.push(nalgebra::center(&uv[a.index()], &uv[b.index()]));
        let (bend, normal) = mesh.bend(normals, a, b);
        normals.push(normal);
        nalgebra::center(&mesh.point(a), &mesh.point(b)) + bend
    };
    let midpoints = EdgeMidpoints::new(&mut map.patch.mesh, sides.iter().copied(), middle);
    map.patch.divide(&midpoints, sides.iter().map(|side| side / 3));
}
