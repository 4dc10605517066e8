//! Vertices between those that a map draws far apart.
//!
//! A tube's rings, the farthest out the most, come to lie several knot cells apart on the
//! square, and nothing would hold the surface between them.

use rayon::prelude::*;

use super::Parameterized;
use super::stretch;
use crate::geometry::{Point, Uv, UvVector, Vector, VertexId};
use crate::mesh::{EdgeMap, FaceOrigin, Mesh, Middles, Patch};

/// A side is long if it is so many times as long as vertices are apart on an even map.
const LONG: f64 = 2.0;

/// Rounds of halving at the most: beside a long side that stays, at a rim, there is always
/// another long one.
const MOST_ROUNDS: usize = 5;

/// Halves sides that the map draws out. Returns how many vertices that makes.
pub fn bridge(map: &mut Parameterized) -> usize {
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
    /// Halves the long sides, and `rounds` times at the most what then is long. The
    /// middles are on the surface as its normals bend it.
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
        for v in self.skirt.triangles.iter_mut().flatten().filter(|v| v.index() >= before) {
            *v = VertexId::from(v.index() + added);
        }
    }

    /// The sides, ascending, that are long, told by the parameter points of their ends if
    /// the vertices are at `uv`: those between two measured triangles or, where the domain
    /// has the same, on the patch's boundary.
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
            let is_square = self.skirt.triangles.is_empty();
            long.retain(|&side| edges.across(side).map_or(is_square, is_measured));
        }
        long
    }
}

/// The normals of the vertices, those of fills left out.
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
    let middles = Middles::new(&mut map.patch.mesh, sides.iter().copied(), middle);
    map.patch.divide(&middles, sides.iter().map(|side| side / 3));
}
