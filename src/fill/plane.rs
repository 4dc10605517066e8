//! A parameter plane: the local one in which the front checks for crossings, and
//! the chart of a hole that can be seen whole from one side.

use crate::geometry::{Point, Uv, Vector, orient2d, plane_axes, segments_cross};

/// A plane with axes; points are projected along its normal.
#[derive(Debug, Clone, Copy)]
pub struct LocalPlane {
    origin: Point,
    x: Vector,
    y: Vector,
    normal: Vector,
}

impl LocalPlane {
    /// The plane through `origin` with unit normal `normal`.
    pub fn new(origin: Point, normal: Vector) -> Self {
        let (x, y) = plane_axes(normal);
        LocalPlane { origin, x, y, normal }
    }

    /// The projection of `p`.
    pub fn flat(&self, p: Point) -> Uv {
        let d = p - self.origin;
        Uv::new(d.dot(&self.x), d.dot(&self.y))
    }

    /// How far `p` is above the plane.
    pub fn height(&self, p: Point) -> f64 {
        (p - self.origin).dot(&self.normal)
    }

    /// The point above `uv` at a height.
    pub fn lift(&self, uv: Uv, height: f64) -> Point {
        self.origin + uv.x * self.x + uv.y * self.y + height * self.normal
    }

    /// The angle, counter-clockwise from `from − at` to `to − at`, in [0, 2π).
    pub fn angle(&self, from: Point, at: Point, to: Point) -> f64 {
        let at = self.flat(at);
        let (d, e) = (self.flat(from) - at, self.flat(to) - at);
        (e.y.atan2(e.x) - d.y.atan2(d.x)).rem_euclid(std::f64::consts::TAU)
    }

    /// Whether the triangle `a b c` runs counter-clockwise and neither holds a
    /// corner of `edges` nor is crossed by one of them. Edges that end at a
    /// corner of the triangle may touch it there.
    pub fn is_free(&self, corners: [Point; 3], edges: &[(Point, Point)]) -> bool {
        let [a, b, c] = corners.map(|p| self.flat(p));
        if orient2d(a, b, c) <= 0.0 {
            return false;
        }
        let inside = |p: Uv| {
            orient2d(a, b, p) >= 0.0 && orient2d(b, c, p) >= 0.0 && orient2d(c, a, p) >= 0.0
        };
        edges.iter().all(|&(p, q)| {
            let ends = [p, q].map(|e| corners.contains(&e));
            let (p, q) = (self.flat(p), self.flat(q));
            let holds = (!ends[0] && inside(p)) || (!ends[1] && inside(q));
            let crosses = |s: Uv, t: Uv| segments_cross(s, t, p, q);
            !holds && !crosses(a, b) && !crosses(b, c) && !crosses(c, a)
        })
    }
}
