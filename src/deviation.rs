//! How far points are from the trimmed face: Euclidean distances to foot
//! points, to the trim curve where the foot falls into a hole.

use rayon::prelude::*;

use crate::geometry::{Point, Uv, ray_crosses, segment_distance};
use crate::spline::{Curve, Surface, foot_point};

/// A surface and the holes cut out of it.
#[derive(Debug)]
pub struct Face<'a> {
    surface: &'a Surface,
    holes: Vec<Hole>,
}

#[derive(Debug)]
struct Hole {
    outline: Vec<Uv>,
    rim: Vec<Point>,
    low: Uv,
    high: Uv,
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
    /// The face of a surface without the holes whose loops are given.
    pub fn new<'b>(surface: &'a Surface, loops: impl Iterator<Item = &'b [Curve<2>]>) -> Self {
        let holes = loops.map(|arcs| Hole::new(surface, arcs)).collect();
        Face { surface, holes }
    }

    /// The distance of `p`, searched from the parameter point `start`.
    pub fn distance(&self, p: Point, start: Uv) -> f64 {
        let (at, distance) = foot_point(self.surface, p, start);
        match self.holes.iter().find(|hole| hole.contains(at)) {
            Some(hole) => hole.distance(p),
            None => distance,
        }
    }

    /// The deviation of points whose parameter points are given.
    pub fn deviation(&self, points: &[Point], starts: &[Uv]) -> Deviation {
        let distances: Vec<f64> =
            points.par_iter().zip(starts).map(|(&p, &start)| self.distance(p, start)).collect();
        Deviation::of(points, distances)
    }
}

impl Hole {
    fn new(surface: &Surface, arcs: &[Curve<2>]) -> Self {
        let mut outline = Vec::new();
        for arc in arcs {
            let (first, last) = arc.knots.range();
            let count = CHORDS * (arc.knots.breaks().len() - 1);
            let at = |i: usize| first + (last - first) * i as f64 / count as f64;
            outline.extend((0..count).map(|i| Uv::from(arc.point(at(i)))));
        }
        let rim = outline.iter().map(|&uv| surface.point(uv)).collect();
        let low = outline.iter().fold(outline[0], |low, p| low.inf(p));
        let high = outline.iter().fold(outline[0], |high, p| high.sup(p));
        Hole { outline, rim, low, high }
    }

    fn contains(&self, p: Uv) -> bool {
        if p.x < self.low.x || p.x > self.high.x || p.y < self.low.y || p.y > self.high.y {
            return false;
        }
        let n = self.outline.len();
        let over = |i: &usize| ray_crosses(p, (self.outline[*i], self.outline[(i + 1) % n]));
        (0..n).filter(over).count() % 2 == 1
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

    #[test]
    fn over_a_hole_the_distance_is_to_its_rim() {
        let k = KnotVector::uniform(3, 5);
        let net =
            (0..25).map(|n| Vector::new(10.0 * k.greville(n / 5), 10.0 * k.greville(n % 5), 0.0));
        let surface = Surface::new(k.clone(), k.clone(), net.collect());
        let corner =
            [(0.4, 0.4), (0.4, 0.6), (0.6, 0.6), (0.6, 0.4)].map(|(u, v)| Vector2::new(u, v));
        let arcs: Vec<Curve<2>> =
            (0..4).map(|i| Curve::line(corner[i], corner[(i + 1) % 4])).collect();
        let face = Face::new(&surface, std::iter::once(arcs.as_slice()));
        let d = |x: f64, y: f64, z: f64| face.distance(Point::new(x, y, z), Uv::new(0.5, 0.5));
        assert!((d(5.0, 4.5, 0.0) - 0.5).abs() < 1e-12);
        assert!((d(2.0, 5.0, 0.25) - 0.25).abs() < 1e-12);
        assert!((d(-3.0, 5.0, 4.0) - 5.0).abs() < 1e-12);
    }
}
