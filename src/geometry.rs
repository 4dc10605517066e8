//! The types that keep a point in space, a point in the parameter plane and
//! an index apart, and the names of boundary loops.

use std::fmt;

/// A point in space, in mm.
pub type Point = nalgebra::Point3<f64>;
/// A direction or displacement in space, in mm.
pub type Vector = nalgebra::Vector3<f64>;
/// A point of the parameter plane, in [0, 1]² on a patch.
pub type Uv = nalgebra::Point2<f64>;
/// A displacement in the parameter plane.
pub type UvVector = nalgebra::Vector2<f64>;

/// The index of a vertex of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VertexId(pub u32);

impl VertexId {
    /// The index as one into a slice of per-vertex values.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl From<usize> for VertexId {
    fn from(i: usize) -> Self {
        VertexId(i as u32)
    }
}

/// A boundary loop of what was measured of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The outer boundary.
    Outer,
    /// The rim of a hole, by its number.
    Hole(usize),
    /// The rim of an island, by the number of the hole that it is in and its own.
    Island {
        /// The hole.
        hole: usize,
        /// The island.
        number: usize,
    },
}

impl Bound {
    /// The hole, or that of the island.
    pub fn hole(self) -> Option<usize> {
        match self {
            Bound::Outer => None,
            Bound::Hole(hole) | Bound::Island { hole, .. } => Some(hole),
        }
    }

    /// The island.
    pub fn island(self) -> Option<usize> {
        match self {
            Bound::Island { number, .. } => Some(number),
            _ => None,
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Bound::Outer => write!(f, "the outer boundary"),
            Bound::Hole(hole) => write!(f, "hole {hole}"),
            Bound::Island { hole, .. } => write!(f, "an island in hole {hole}"),
        }
    }
}

/// Twice the signed area of the triangle `a b c`, its sign exact (Shewchuk's
/// adaptive predicate): positive where the corners run counter-clockwise.
pub fn orient2d(a: Uv, b: Uv, c: Uv) -> f64 {
    let coord = |p: Uv| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Whether the segments `a b` and `c d` cross at an inner point of both.
pub fn segments_cross(a: Uv, b: Uv, c: Uv, d: Uv) -> bool {
    let side = |p: Uv, q: Uv, r: Uv| orient2d(p, q, r);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Any unit vector perpendicular to the unit vector `n`, and the one that
/// completes the two to a right-handed frame (x, y, n).
pub fn plane_axes(n: Vector) -> (Vector, Vector) {
    let helper = if n.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let x = n.cross(&helper).normalize();
    (x, n.cross(&x))
}

/// A plane with axes: the local parameter plane of a neighbourhood, or the one
/// across the direction in which a hole is looked at. Points are projected along
/// its normal.
#[derive(Debug, Clone, Copy)]
pub struct LocalPlane {
    origin: Point,
    x: Vector,
    y: Vector,
    /// Unit normal.
    pub normal: Vector,
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
}

/// The unit normal of a triangle, by the right-hand rule; `None` if it has no area.
pub fn unit_normal([a, b, c]: [Point; 3]) -> Option<Vector> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// The lowest and the highest coordinates of some points; the origin of none.
pub fn bounds(mut points: impl Iterator<Item = Point>) -> [Point; 2] {
    let first = points.next().unwrap_or_else(Point::origin);
    points.fold([first; 2], |[low, high], p| [low.inf(&p), high.sup(&p)])
}

/// The distance from `p` to the segment `a b`.
pub fn segment_distance(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let t = (p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (p - (a + along * t.clamp(0.0, 1.0))).norm()
}

/// Whether the ray from `p` towards growing u crosses the side `a b` of a
/// polygon. A point is inside where an odd number of sides is crossed.
pub fn ray_crosses(p: Uv, (a, b): (Uv, Uv)) -> bool {
    (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
}

/// Whether a point is inside a closed polygon.
pub fn is_inside(p: Uv, polygon: &[Uv]) -> bool {
    let nexts = polygon.iter().cycle().skip(1);
    polygon.iter().zip(nexts).filter(|&(&a, &b)| ray_crosses(p, (a, b))).count() % 2 == 1
}

/// The lowest and the highest coordinates of some points of the parameter
/// plane; the origin of none.
pub fn uv_bounds(points: &[Uv]) -> [Uv; 2] {
    let first = points.first().copied().unwrap_or_else(Uv::origin);
    points.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)])
}
/// A length that is given in mm, in lengths of so many `mm`. It stays one, however small or
/// large these are.
pub(crate) fn length(x: f64, mm: f64) -> f64 {
    (x / mm).clamp(f64::MIN_POSITIVE, f64::MAX)
}

/// The same of a place.
pub(crate) fn in_lengths(place: Point, mm: f64) -> Point {
    place.map(|x| (x / mm).clamp(-f64::MAX, f64::MAX))
}
