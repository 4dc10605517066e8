//! Triangulated parameter squares and the shapes that they are bent to.

use proptest::prelude::*;
use spade::{DelaunayTriangulation, Point2, Triangulation};

use crate::common::random::Random;

/// The triangulation of the parameter square.
#[derive(Debug, Clone, Copy)]
pub enum Mesh {
    /// A grid with the given numbers of squares whose vertices are moved by a share of a square.
    Grid([usize; 2], f64),
    /// The Delaunay triangulation of a number of random points.
    Delaunay(usize),
}

/// The shape that the square is bent to.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    Plane,
    Waves,
    /// A cylinder with the given share of a full turn.
    Cylinder(f64),
    /// A sphere without a cap of the given share.
    Sphere(f64),
    /// A strip whose sides have the given ratio.
    Needle(f64),
    /// A roof with a sharp ridge.
    Roof,
    /// A strip whose end is twisted by half a turn, so that it folds over itself.
    Twisted,
}

pub fn meshes() -> impl Strategy<Value = Mesh> {
    prop_oneof![
        3 => ((2..24_usize, 2..24_usize), prop_oneof![Just(0.0), 0.0..0.45, 0.45..1.5])
            .prop_map(|((m, n), moved)| Mesh::Grid([m, n], moved)),
        2 => (4..400_usize).prop_map(Mesh::Delaunay),
    ]
}

pub fn shapes() -> impl Strategy<Value = Shape> {
    prop_oneof![
        Just(Shape::Plane),
        Just(Shape::Waves),
        (0.1..0.99).prop_map(Shape::Cylinder),
        (0.001..0.7).prop_map(Shape::Sphere),
        (1.0..4.0).prop_map(|e| Shape::Needle(10f64.powf(e))),
        Just(Shape::Roof),
        Just(Shape::Twisted),
    ]
}

/// The corners of triangles.
pub type Triangles = Vec<[u32; 3]>;

impl Mesh {
    /// The points in the parameter square and the triangles.
    pub fn build(self, random: &mut Random) -> (Vec<[f64; 2]>, Triangles) {
        match self {
            Mesh::Grid(size, moved) => grid(size, moved, random),
            Mesh::Delaunay(count) => delaunay(count, random),
        }
    }

    /// The approximate length of an edge as a share of the side of the square.
    pub fn edge(self) -> f64 {
        match self {
            Mesh::Grid([m, n], _) => 1.0 / m.max(n) as f64,
            Mesh::Delaunay(count) => 1.0 / (count as f64).sqrt(),
        }
    }
}

fn grid([m, n]: [usize; 2], moved: f64, random: &mut Random) -> (Vec<[f64; 2]>, Triangles) {
    let mut at = |k: usize, count: usize| {
        let moved = if k == 0 || k == count { 0.0 } else { moved * (random.share() - 0.5) };
        (k as f64 + moved) / count as f64
    };
    let points = (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j)));
    let points = points.map(|(i, j)| [at(i, m), at(j, n)]).collect();
    let cells = (0..m).flat_map(|i| (0..n).map(move |j| (i * (n + 1) + j) as u32));
    let row = n as u32 + 1;
    let halves = |a: u32| [[a, a + row, a + row + 1], [a, a + row + 1, a + 1]];
    (points, cells.flat_map(halves).collect())
}

fn delaunay(count: usize, random: &mut Random) -> (Vec<[f64; 2]>, Triangles) {
    let mut made = DelaunayTriangulation::<Point2<f64>>::new();
    for _ in 0..count {
        made.insert(Point2::new(random.share(), random.share())).expect("finite");
    }
    let points = made.vertices().map(|v| [v.position().x, v.position().y]).collect();
    let corners = made.inner_faces().map(|f| f.vertices().map(|v| v.fix().index() as u32));
    (points, corners.collect())
}

impl Shape {
    /// A point of the shape, whose size is about 1.
    pub fn at(self, [u, v]: [f64; 2]) -> [f64; 3] {
        use std::f64::consts::{PI, TAU};
        match self {
            Shape::Plane => [u, v, 0.0],
            Shape::Waves => [u, v, 0.1 * (5.0 * u).sin() * (4.0 * v).cos()],
            Shape::Cylinder(share) => {
                let (sin, cos) = (share * TAU * u).sin_cos();
                [0.5 * cos, 0.5 * sin, v]
            }
            // The square is mapped to a disk, and the disk to the sphere without its cap.
            Shape::Sphere(cap) => {
                let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                let (r, angle) = (x.abs().max(y.abs()), y.atan2(x));
                let (sin, cos) = ((1.0 - cap) * PI * r).sin_cos();
                [0.5 * sin * angle.cos(), 0.5 * sin * angle.sin(), 0.5 * cos]
            }
            Shape::Needle(ratio) => [u, v / ratio, 0.0],
            Shape::Roof => [u, v, 0.5 - (u - 0.5).abs()],
            Shape::Twisted => {
                let (sin, cos) = (PI * u).sin_cos();
                [u, (v - 0.5) * cos, (v - 0.5) * sin]
            }
        }
    }
}
