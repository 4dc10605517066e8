//! Types for points in space, points in the parameter plane, vertex indices and boundary loops,
//! with elementary geometric functions.

mod fairing;
mod ordered;
mod quarter;
pub(crate) mod random;
pub(crate) mod sets;

use std::fmt;

pub(crate) use fairing::faired;
pub(crate) use ordered::OrderedFloat;
pub(crate) use quarter::Quarter;

/// A point in space. The unit is mm, or the pipeline's unit of length inside `convert`.
pub type Point = nalgebra::Point3<f64>;
/// A direction or displacement in space, in the unit of [`Point`].
pub type Vector = nalgebra::Vector3<f64>;
/// A point of the parameter plane. On a patch it lies in [0, 1]².
pub type Uv = nalgebra::Point2<f64>;
/// A displacement in the parameter plane.
pub type UvVector = nalgebra::Vector2<f64>;

/// In lists of numbers: no vertex, triangle or other item.
pub(crate) const NONE: u32 = u32::MAX;

/// The number of items that one task of a parallel loop processes. It does not depend on the number of
/// threads, so sums have a fixed order. Smaller blocks cost time, and larger ones leave threads idle.
pub(crate) const BLOCK: usize = 1 << 14;

/// Dividing so few items further takes longer than looking at each of them.
pub(crate) const FEW: usize = 16;

/// The number of items that suffice to estimate the mean of many. The estimate is about 3 % of their
/// standard deviation off.
pub(crate) const SAMPLE: usize = 1000;

/// The most rounds of an iteration that ends by itself, which nearly always takes far fewer. The bound
/// keeps an unforeseen input from hanging.
pub(crate) const MOST_ROUNDS: usize = 60;

/// The relative rounding of a computed number. A program that computes a place twice, say with sines
/// and cosines, gets numbers that differ by about this share.
pub(crate) const ROUNDING: f64 = 1e-12;

/// A share that no result shows: the square root of [`ROUNDING`]. What is so much shorter than what is beside it
/// has no direction, and a change so much smaller than what changes is none.
pub(crate) const NEGLIGIBLE: f64 = 1e-6;

/// An outlier is at least so many times as far off as its neighbours. Where the shape is missed, as along a
/// sharp edge, these are about as far off.
pub(crate) const ALONE: f64 = 4.0;

/// The height of an equilateral triangle with sides of length 1, which is also the area of two of them. An
/// even mesh has two triangles for each vertex.
pub(crate) const EQUILATERAL: f64 = 0.866_025_403_784_438_6;

/// The cosine of 60°. Normals with a larger angle between them belong to different sides of a part.
pub(crate) const SAME_SIDE: f64 = 0.5;

/// The number of a vertex of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VertexId(pub u32);

impl VertexId {
    /// The number as an index into a slice of per-vertex values.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl From<usize> for VertexId {
    fn from(i: usize) -> Self {
        VertexId(i as u32)
    }
}

/// A boundary loop of the measured part of a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The outer boundary.
    Outer,
    /// The rim of the hole with this number.
    Hole(usize),
    /// The rim of an island.
    Island {
        /// The number of the hole that contains the island.
        hole: usize,
        /// The number of the island.
        number: usize,
    },
}

impl Bound {
    /// The number of the hole, or of the hole that contains the island.
    pub fn hole(self) -> Option<usize> {
        match self {
            Bound::Outer => None,
            Bound::Hole(hole) | Bound::Island { hole, .. } => Some(hole),
        }
    }

    /// The number of the island.
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

/// Twice the signed area of the triangle `a b c`. It is positive if the corners run
/// counter-clockwise. The sign is exact (Shewchuk's adaptive predicate).
pub fn orient2d(a: Uv, b: Uv, c: Uv) -> f64 {
    let coord = |p: Uv| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// Whether the segments `a b` and `c d` cross at a point inside both.
pub(crate) fn segments_cross(a: Uv, b: Uv, c: Uv, d: Uv) -> bool {
    let side = |p: Uv, q: Uv, r: Uv| orient2d(p, q, r);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// A unit vector perpendicular to the unit vector `n`, and the vector that completes them to a
/// right-handed frame (x, y, n).
pub(crate) fn plane_axes(n: Vector) -> (Vector, Vector) {
    let helper = if n.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let x = n.cross(&helper).normalize();
    (x, n.cross(&x))
}

/// A plane with a frame, onto which points are projected along its normal. It serves as the local
/// parameter plane of a neighbourhood and as the projection plane of a hole.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalPlane {
    origin: Point,
    x: Vector,
    y: Vector,
    /// The unit normal.
    pub normal: Vector,
}

impl LocalPlane {
    /// The plane through `origin` with unit normal `normal`.
    pub(crate) fn new(origin: Point, normal: Vector) -> Self {
        let (x, y) = plane_axes(normal);
        LocalPlane { origin, x, y, normal }
    }

    /// The projection of `p`, in coordinates of the plane.
    pub(crate) fn flat(&self, p: Point) -> Uv {
        let d = p - self.origin;
        Uv::new(d.dot(&self.x), d.dot(&self.y))
    }

    /// The signed distance of `p` from the plane.
    pub(crate) fn height(&self, p: Point) -> f64 {
        (p - self.origin).dot(&self.normal)
    }

    /// The point above `uv` at the given height.
    pub(crate) fn lift(&self, uv: Uv, height: f64) -> Point {
        self.origin + uv.x * self.x + uv.y * self.y + height * self.normal
    }
}

/// The unit normal of a triangle by the right-hand rule, or `None` if the triangle has no area.
pub(crate) fn unit_normal([a, b, c]: [Point; 3]) -> Option<Vector> {
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// The least and the greatest of some numbers; ∞ and −∞ if there is none.
pub(crate) fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

/// The lowest and the highest coordinates of some points, or the origin twice if there are none.
pub(crate) fn bounds(mut points: impl Iterator<Item = Point>) -> [Point; 2] {
    let first = points.next().unwrap_or_else(Point::origin);
    points.fold([first; 2], |[low, high], p| [low.inf(&p), high.sup(&p)])
}

/// The same as plain numbers.
pub(crate) fn box_of(points: impl Iterator<Item = Point>) -> [[f64; 3]; 2] {
    bounds(points).map(|corner| corner.coords.into())
}

/// The distance from `p` to the segment `a b`.
pub fn segment_distance(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let t = (p - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (p - (a + along * t.clamp(0.0, 1.0))).norm()
}

/// Whether the ray from `p` in the direction of increasing u crosses the side `a b` of a polygon. A
/// point is inside if the ray crosses an odd number of sides.
pub fn ray_crosses(p: Uv, (a, b): (Uv, Uv)) -> bool {
    (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
}

/// Whether a point is inside a closed polygon.
pub(crate) fn is_inside(p: Uv, polygon: &[Uv]) -> bool {
    let nexts = polygon.iter().cycle().skip(1);
    polygon.iter().zip(nexts).filter(|&(&a, &b)| ray_crosses(p, (a, b))).count() % 2 == 1
}

/// The lowest and the highest coordinates of some points of the parameter plane, or the origin
/// twice if there are none.
pub(crate) fn uv_bounds(points: &[Uv]) -> [Uv; 2] {
    let first = points.first().copied().unwrap_or_else(Uv::origin);
    points.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)])
}
/// Converts a length from mm to a unit of `mm` millimetres. The result is always a positive, finite
/// length.
pub(crate) fn length(x: f64, mm: f64) -> f64 {
    (x / mm).clamp(f64::MIN_POSITIVE, f64::MAX)
}

/// Converts a point from mm to a unit of `mm` millimetres. The result is always finite.
pub(crate) fn in_lengths(place: Point, mm: f64) -> Point {
    place.map(|x| (x / mm).clamp(-f64::MAX, f64::MAX))
}
