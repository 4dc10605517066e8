//! Triangle meshes. A soup of polygons goes in ([`from_soup`]). An oriented, edge-manifold mesh
//! comes out, split into its connected components ([`Components`]). One component becomes a disk
//! with holes ([`Disk`]), which later stages fill ([`Patch`]) and flatten ([`Parameterized`]).
//!
//! What several stages need lives here as well: adjacency ([`EdgeMap`], `VertexRings`), boundary
//! loops ([`boundary`]), neighbours in space (`Neighbours`) and moving least squares (`mls`).

mod adjacency;
mod beside;
mod body;
pub mod boundary;
mod build;
pub(crate) mod caps;
mod components;
pub mod crossings;
mod disk;
mod edge_map;
mod even;
mod facing;
mod handles;
mod islands;
pub(crate) mod least_area;
mod midpoints;
pub(crate) mod mls;
mod neighbours;
mod nesting;
pub(crate) mod one_rings;
pub(crate) mod outline;
mod parameterized;
mod patch;
mod polygons;
pub(crate) mod progressive_mesh;
mod quad_mesh;
mod raw_points;
pub(crate) mod remesh;
mod rims;
mod rounding;
mod scale;
mod seam;
mod short_edges;
mod spikes;
mod stand_ins;
mod topology;
mod triangles;
mod vertices;
mod weld;

pub use crate::geometry::Bound;
pub(crate) use adjacency::Adjacency;
pub(crate) use build::from_soup_joined;
pub(crate) use build::orient;
pub use build::{Build, Repairs, from_soup};
pub use components::{Choice, Component, Components};
pub use disk::{Disk, Island, Outer};
pub(crate) use edge_map::Buckets;
pub use edge_map::EdgeMap;
pub(crate) use edge_map::VertexRings;
pub(crate) use facing::FacingPlaces;
pub use handles::Handle;
pub(crate) use handles::handles;
pub(crate) use midpoints::EdgeMidpoints;
pub(crate) use neighbours::Neighbours;
pub(crate) use nesting::Nested;
pub use parameterized::{Outline, Parameterized, Scaffold};
pub use patch::{FaceOrigin, Patch};
pub(crate) use polygons::cut_up;
pub use quad_mesh::QuadMesh;
pub use raw_points::RawPoints;
pub use rounding::FileRounding;
pub(crate) use rounding::VertexErrors;
pub(crate) use seam::SeamWidth;
pub use stand_ins::StandIns;
pub use topology::Topology;
pub(crate) use triangles::{Triangles, nearest_on};
pub(crate) use vertices::VertexMap;

use crate::geometry::{Point, Vector, VertexId, bounds};

/// An oriented triangle mesh. No edge has more than two triangles, and two triangles run along
/// their common edge in opposite directions. [`from_soup`] makes such a mesh of any soup. Functions
/// that take a mesh rely on these properties and do not check them.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Positions, in mm.
    pub points: Vec<Point>,
    /// Corners of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[VertexId; 3]>,
}

/// A vertex is treated as lying on a crease if an edge at it is this steep. The steepness is the
/// cosine of the angle between the edge and the vertex normal; 0.43 belongs to a turn of more than
/// a seventh of a full circle from this vertex to the next.
const CREASE_COSINE: f64 = 0.43;

impl Mesh {
    /// The mesh with all lengths multiplied by a factor.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.points.iter_mut().for_each(|p| *p *= factor);
        self
    }

    /// Appends the points and triangles of another mesh.
    pub(crate) fn append(&mut self, other: &Mesh) {
        let first = self.points.len();
        self.points.extend(&other.points);
        let behind = |v: VertexId| VertexId::from(first + v.index());
        self.triangles.extend(other.triangles.iter().map(|t| t.map(behind)));
    }

    /// The position of a vertex.
    pub fn point(&self, v: VertexId) -> Point {
        self.points[v.index()]
    }

    /// The positions of a triangle's corners.
    pub fn corners(&self, t: [VertexId; 3]) -> [Point; 3] {
        t.map(|v| self.point(v))
    }

    /// The angle at `tip` between two other vertices.
    pub(crate) fn angle(&self, a: VertexId, tip: VertexId, b: VertexId) -> f64 {
        (self.point(a) - self.point(tip)).angle(&(self.point(b) - self.point(tip)))
    }

    /// The ends of a side: side `3 t + k` leaves corner `k` of triangle `t`.
    pub(crate) fn side(&self, side: usize) -> (VertexId, VertexId) {
        let t = self.triangles[side / 3];
        (t[side % 3], t[(side + 1) % 3])
    }

    /// Twice the triangle's area times its unit normal.
    pub fn area_vector(&self, t: [VertexId; 3]) -> Vector {
        let [a, b, c] = self.corners(t);
        (b - a).cross(&(c - a))
    }

    /// The area of all triangles.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| 0.5 * self.area_vector(t).norm()).sum()
    }

    /// Unit normals of the vertices, each the area-weighted mean of its
    /// triangles' (zero where those cancel).
    pub(crate) fn vertex_normals(&self) -> Vec<Vector> {
        let mut normals = vec![Vector::zeros(); self.points.len()];
        for &t in &self.triangles {
            let n = self.area_vector(t);
            for v in t {
                normals[v.index()] += n;
            }
        }
        for n in &mut normals {
            *n = n.try_normalize(0.0).unwrap_or_else(Vector::zeros);
        }
        normals
    }

    /// Returns the vector from the middle of an edge to the middle of the curve above it, and the
    /// surface normal there. The curve lies on a smooth surface with these vertex `normals`
    /// (Vlachos, Peters, Boyd, Mitchell: Curved PN triangles, 2001). A vertex on a crease, or one
    /// without a normal, does not influence the curve.
    pub(crate) fn bend(&self, normals: &[Vector], a: VertexId, b: VertexId) -> (Vector, Vector) {
        let along = self.point(b) - self.point(a);
        let steep = CREASE_COSINE * along.norm();
        let [n, m] = [a, b].map(|v| {
            let normal = normals[v.index()];
            if along.dot(&normal).abs() < steep { normal } else { Vector::zeros() }
        });
        let bend = (along.dot(&m) * m - along.dot(&n) * n) / 8.0;
        // The slope of a cubic in its middle is minus one half of the mean slope at its ends.
        let lean = along.dot(&(n + m)) / along.norm_squared();
        let normal = n + m - 1.5 * lean * along;
        (bend, normal.try_normalize(0.0).unwrap_or_else(Vector::zeros))
    }

    /// Estimates in mm how far a triangle is from a smooth surface through its corners with these
    /// vertex `normals`. The estimate for an edge is an eighth of its length times the angle
    /// between the normals at its ends; the largest of the three edges counts.
    pub(crate) fn chord_error(&self, normals: &[Vector], t: [VertexId; 3]) -> f64 {
        let edge = |k: usize| {
            let [a, b] = [t[k], t[(k + 1) % 3]];
            let length = (self.point(b) - self.point(a)).norm();
            let angle = normals[a.index()].angle(&normals[b.index()]);
            if angle.is_finite() { length * angle / 8.0 } else { 0.0 }
        };
        (0..3).map(edge).fold(0.0, f64::max)
    }

    /// The root mean square of all triangles' chord errors, in mm.
    pub(crate) fn mean_chord_error(&self) -> f64 {
        let normals = self.vertex_normals();
        let squares = self.triangles.iter().map(|&t| self.chord_error(&normals, t).powi(2));
        (squares.sum::<f64>() / self.triangles.len().max(1) as f64).sqrt()
    }

    /// The mean length of the triangles' edges, in mm. Inner edges count twice.
    pub(crate) fn mean_edge(&self) -> f64 {
        let sides = |t: &[VertexId; 3]| {
            let [a, b, c] = self.corners(*t);
            (b - a).norm() + (c - b).norm() + (a - c).norm()
        };
        self.triangles.iter().map(sides).sum::<f64>() / (3 * self.triangles.len()).max(1) as f64
    }

    /// The lowest and the highest coordinates, or the origin twice for an empty mesh.
    pub(crate) fn bounds(&self) -> [Point; 2] {
        bounds(self.points.iter().copied())
    }

    /// The length of the diagonal of the bounding box, in mm.
    pub fn diagonal(&self) -> f64 {
        let [low, high] = self.bounds();
        (high - low).norm()
    }

    /// Extracts the triangles with the given numbers. The new mesh keeps only the vertices that
    /// these triangles use, in their old order. The second value gives the old number of each new
    /// vertex.
    pub(crate) fn part(&self, triangles: impl Iterator<Item = usize>) -> (Mesh, Vec<usize>) {
        let triangles: Vec<_> = triangles.map(|t| self.triangles[t]).collect();
        let mut used = vec![false; self.points.len()];
        triangles.iter().flatten().for_each(|v| used[v.index()] = true);
        let old: Vec<usize> = (0..used.len()).filter(|&v| used[v]).collect();
        let mut number = vec![VertexId(0); used.len()];
        old.iter().enumerate().for_each(|(new, &v)| number[v] = VertexId::from(new));
        let points = old.iter().map(|&v| self.points[v]).collect();
        let triangles = triangles.into_iter().map(|t| t.map(|v| number[v.index()])).collect();
        (Mesh { points, triangles }, old)
    }
}
