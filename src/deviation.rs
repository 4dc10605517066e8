//! How far points are from the trimmed face: Euclidean distances to foot
//! points, to the trim curve where the foot falls into a hole. Islands in a hole
//! are faces, too.

use rayon::prelude::*;

use crate::geometry::{Point, Uv, is_inside, segment_distance, uv_bounds};
use crate::spline::{Curve, Surface, foot_point};

/// A surface and the holes cut out of it, and the islands left in them, and so
/// on.
#[derive(Debug)]
pub struct Face<'a> {
    surface: &'a Surface,
    rings: Vec<Ring>,
}

/// A trim loop. Between an odd number of them and an even one the surface ends.
#[derive(Debug)]
struct Ring {
    outline: Vec<Uv>,
    rim: Vec<Point>,
    low: Uv,
    high: Uv,
    /// How many loops run around it.
    depth: usize,
    /// Which lie within it.
    inner: Vec<usize>,
}

/// Distances in mm, over a set of points.
#[derive(Debug, Clone, Default)]
pub struct Deviation {
    /// Root mean square.
    pub rms: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// The largest.
    pub max: f64,
    /// The point that has it.
    pub max_at: [f64; 3],
    /// All of them, in the order of the points.
    pub distances: Vec<f64>,
}

/// Chords a knot span of a trim loop.
const CHORDS: usize = 16;

impl<'a> Face<'a> {
    /// The face of a surface without the holes whose loops are given, but with
    /// the islands whose loops are given.
    pub fn new<'b>(surface: &'a Surface, loops: impl Iterator<Item = &'b [Curve<2>]>) -> Self {
        let mut rings: Vec<Ring> = loops.map(|arcs| Ring::new(surface, arcs)).collect();
        for i in 0..rings.len() {
            let within = |j: &usize| *j != i && rings[i].contains(rings[*j].outline[0]);
            let inner: Vec<usize> = (0..rings.len()).filter(within).collect();
            inner.iter().for_each(|&j| rings[j].depth += 1);
            rings[i].inner = inner;
        }
        Face { surface, rings }
    }

    /// The distance of `p`, searched from the parameter point `start`.
    pub fn distance(&self, p: Point, start: Uv) -> f64 {
        let (at, distance) = foot_point(self.surface, p, start);
        let around: Vec<&Ring> = self.rings.iter().filter(|ring| ring.contains(at)).collect();
        match around.iter().max_by_key(|ring| ring.depth) {
            Some(hole) if around.len() % 2 == 1 => {
                let islands = hole.inner.iter().map(|&i| self.rings[i].distance(p));
                islands.fold(hole.distance(p), f64::min)
            }
            _ => distance,
        }
    }

    /// The deviation of points whose parameter points are given.
    pub fn deviation(&self, points: &[Point], starts: &[Uv]) -> Deviation {
        let distances: Vec<f64> =
            points.par_iter().zip(starts).map(|(&p, &start)| self.distance(p, start)).collect();
        Deviation::of(points, distances)
    }
}

impl Ring {
    fn new(surface: &Surface, arcs: &[Curve<2>]) -> Self {
        let mut outline = Vec::new();
        for arc in arcs {
            let (first, last) = arc.knots.range();
            let count = CHORDS * (arc.knots.breaks().len() - 1);
            let at = |i: usize| first + (last - first) * i as f64 / count as f64;
            outline.extend((0..count).map(|i| Uv::from(arc.point(at(i)))));
        }
        let rim = outline.iter().map(|&uv| surface.point(uv)).collect();
        let [low, high] = uv_bounds(&outline);
        Ring { outline, rim, low, high, depth: 0, inner: Vec::new() }
    }

    fn contains(&self, p: Uv) -> bool {
        if p.x < self.low.x || p.x > self.high.x || p.y < self.low.y || p.y > self.high.y {
            return false;
        }
        is_inside(p, &self.outline)
    }

    fn distance(&self, p: Point) -> f64 {
        let n = self.rim.len();
        let to = |i: usize| segment_distance(p, self.rim[i], self.rim[(i + 1) % n]);
        (0..n).map(to).fold(f64::INFINITY, f64::min)
    }
}

impl Deviation {
    fn of(points: &[Point], distances: Vec<f64>) -> Self {
        if distances.is_empty() {
            return Deviation::default();
        }
        let n = distances.len();
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        let worst = (0..n).max_by(|&i, &j| distances[i].total_cmp(&distances[j])).unwrap_or(0);
        let mut sorted = distances.clone();
        sorted.sort_by(f64::total_cmp);
        let percentile = |p: usize| sorted[(n * p).div_ceil(100).clamp(1, n) - 1];
        Deviation {
            rms: (squares / n as f64).sqrt(),
            p95: percentile(95),
            p99: percentile(99),
            max: distances[worst],
            max_at: points[worst].coords.into(),
            distances,
        }
    }

    /// How many points are farther than `tolerance`.
    pub fn beyond(&self, tolerance: f64) -> usize {
        self.distances.iter().filter(|&&d| d > tolerance).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::spline::KnotVector;
    use nalgebra::Vector2;

    /// A plate of 10 × 10 mm.
    fn plate() -> Surface {
        let k = KnotVector::uniform(3, 5);
        let net =
            (0..25).map(|n| Vector::new(10.0 * k.greville(n / 5), 10.0 * k.greville(n % 5), 0.0));
        Surface::new(k.clone(), k.clone(), net.collect())
    }

    /// A square loop around the middle.
    fn square(r: f64) -> Vec<Curve<2>> {
        let corner =
            [(-r, -r), (-r, r), (r, r), (r, -r)].map(|(u, v)| Vector2::new(0.5 + u, 0.5 + v));
        (0..4).map(|i| Curve::line(corner[i], corner[(i + 1) % 4])).collect()
    }

    #[test]
    fn over_a_hole_the_distance_is_to_its_rim() {
        let surface = plate();
        let arcs = square(0.1);
        let face = Face::new(&surface, std::iter::once(arcs.as_slice()));
        let d = |x: f64, y: f64, z: f64| face.distance(Point::new(x, y, z), Uv::new(0.5, 0.5));
        assert!((d(5.0, 4.5, 0.0) - 0.5).abs() < 1e-12);
        assert!((d(2.0, 5.0, 0.25) - 0.25).abs() < 1e-12);
        assert!((d(-3.0, 5.0, 4.0) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn an_island_is_a_face_and_a_hole_in_it_is_not() {
        let surface = plate();
        let loops = [square(0.1), square(0.4), square(0.3)];
        let face = Face::new(&surface, loops.iter().map(Vec::as_slice));
        let d = |x: f64, z: f64| face.distance(Point::new(x, 5.0, z), Uv::new(0.5, 0.5));
        assert!((d(9.5, 0.5) - 0.5).abs() < 1e-12);
        assert!((d(8.9, 0.0) - 0.1).abs() < 1e-12, "in the hole, near its rim");
        assert!((d(8.1, 0.0) - 0.1).abs() < 1e-12, "in the hole, near the island");
        assert!((d(7.5, 0.5) - 0.5).abs() < 1e-12, "on the island");
        assert!((d(5.8, 0.0) - 0.2).abs() < 1e-12, "in the island's hole");
    }
}
