//! Vertices between those that a map draws far apart.
//!
//! A tube's rings, the farthest out the most, come to lie several knot cells apart on the
//! square, and nothing would hold the surface between them.

use rayon::prelude::*;

use super::Parameterized;
use super::halve::{Middles, divide};
use super::stretch;
use crate::geometry::{Point, Uv, UvVector, Vector, VertexId};
use crate::mesh::{EdgeMap, FaceOrigin, Mesh, Patch};

/// A side is long if it is so many times as long as vertices are apart on an even map.
const LONG: f64 = 2.0;

/// Rounds of halving at the most: beside a long side that stays, at a rim, there is always
/// another long one.
const MOST_ROUNDS: usize = 5;

/// Halves sides that the map draws out. Returns how many vertices that makes.
pub fn bridge(map: &mut Parameterized) -> usize {
    let width = stretch::measure(&map.patch, &map.uv).aspect.sqrt();
    let long = LONG / (map.patch.measured as f64).sqrt();
    let is_long = |a: Uv, b: Uv| {
        let d = b - a;
        UvVector::new(d.x * width, d.y / width).norm() > long
    };
    map.halve(MOST_ROUNDS, is_long)
}

impl Parameterized {
    /// Halves the sides of measured triangles that are long, told by their parameter
    /// points, again and again. The middles are on the surface as its normals bend it.
    /// Returns how many there are.
    pub(crate) fn halve(
        &mut self,
        rounds: usize,
        is_long: impl Fn(Uv, Uv) -> bool + Sync,
    ) -> usize {
        let before = self.patch.mesh.points.len();
        let mut normals = measured_normals(&self.patch);
        for _ in 0..rounds {
            let sides = long_sides(self, &is_long);
            if sides.is_empty() {
                break;
            }
            halve(self, &sides, &mut normals);
        }
        let added = self.patch.mesh.points.len() - before;
        for v in self.skirt.triangles.iter_mut().flatten().filter(|v| v.index() >= before) {
            *v = VertexId::from(v.index() + added);
        }
        added
    }
}

/// The normals of the vertices, those of fills left out.
fn measured_normals(patch: &Patch) -> Vec<Vector> {
    let triangles = stretch::measured(patch).map(|t| patch.mesh.triangles[t]).collect();
    Mesh { points: patch.mesh.points.clone(), triangles }.vertex_normals()
}

/// The long sides between two measured triangles or, where the domain has the same, on the
/// patch's boundary, ascending.
fn long_sides(map: &Parameterized, is_long: impl Fn(Uv, Uv) -> bool + Sync) -> Vec<usize> {
    let mesh = &map.patch.mesh;
    let edges = EdgeMap::new(mesh);
    let is_measured = |side: usize| map.patch.origin[side / 3] == FaceOrigin::Measured;
    let may_be_halved = |side: usize| {
        let across = edges.across(side).map_or(map.skirt.triangles.is_empty(), is_measured);
        is_measured(side) && across
    };
    let is_halved = |&side: &usize| {
        let (a, b) = mesh.side(side);
        is_long(map.uv[a.index()], map.uv[b.index()]) && may_be_halved(side)
    };
    (0..3 * mesh.triangles.len()).into_par_iter().filter(is_halved).collect()
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
    divide(&mut map.patch, &middles, sides.iter().map(|side| side / 3));
}
