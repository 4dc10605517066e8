//! Distances between points and a trimmed face. Points and a face go in; Euclidean distances to the
//! nearest points of the face come out. These are foot points, or points of a trim curve if the
//! foot point lies in a hole. Islands in a hole belong to the face.

mod face;
mod face_to_scan;
mod face_tree;
mod network;
mod slab_polygon;
mod tessellation;

pub use face::TrimmedFace;
pub(crate) use face::{FastForm, TrimRing};
pub use face_to_scan::FaceToScan;
pub(crate) use face_to_scan::{
    MissedTriangle, SAMPLED, SAMPLES_PER_CELL, SurfaceOverMesh, middles, narrowest, samples_along,
    spanned,
};
pub(crate) use face_tree::{FacePlace, FaceTree};
pub(crate) use network::NetworkFaces;
pub use network::of_network;
pub(crate) use network::{NetworkToScan, network_to_scan};
pub use tessellation::{crossing_faces, tessellation};

use crate::geometry::Point;
use rayon::prelude::*;

/// The distances of a set of points, in mm.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Deviation {
    /// Root mean square.
    pub rms: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// The largest.
    pub max: f64,
    /// The point with the largest distance.
    pub max_at: [f64; 3],
    /// All distances, in the order of the points.
    pub distances: Vec<f64>,
    /// Which of the points are above the face, where that is known.
    above: Option<Vec<bool>>,
    /// The face nearest to each point, if there are several.
    faces: Vec<usize>,
}

impl Deviation {
    /// The statistics of the distances of some points. Both lists have the same order.
    pub fn of(points: &[Point], distances: Vec<f64>) -> Self {
        if distances.is_empty() {
            return Deviation::default();
        }
        let n = distances.len();
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        let worst = (0..n).max_by(|&i, &j| distances[i].total_cmp(&distances[j])).unwrap_or(0);
        let mut sorted = distances.clone();
        sorted.par_sort_unstable_by(f64::total_cmp);
        let percentile = |p: usize| sorted[(n * p).div_ceil(100).clamp(1, n) - 1];
        Deviation {
            rms: (squares / n as f64).sqrt(),
            p95: percentile(95),
            p99: percentile(99),
            max: distances[worst],
            max_at: points[worst].coords.into(),
            distances,
            above: None,
            faces: Vec::new(),
        }
    }

    /// The same with the points that are above the face.
    pub(crate) fn with_sides(self, above: Vec<bool>) -> Self {
        Deviation { above: Some(above), ..self }
    }

    /// The distances with signs, in the order of the points: positive above the face, on the
    /// side that the triangles of the scan face. The sign is that of the normal of the surface
    /// at the nearest place of the face. `None` where sides are not known: the face is one of
    /// a CAD file, or the distances are those of [`Deviation::of`].
    pub fn signed(&self) -> Option<Vec<f64>> {
        let signed = |(&d, &above): (&f64, &bool)| if above { d } else { -d };
        Some(self.distances.iter().zip(self.above.as_ref()?).map(signed).collect())
    }

    /// The deviation with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Deviation {
            rms: factor * self.rms,
            p95: factor * self.p95,
            p99: factor * self.p99,
            max: factor * self.max,
            max_at: self.max_at.map(|x| factor * x),
            distances: self.distances.iter().map(|d| factor * d).collect(),
            above: self.above,
            faces: self.faces,
        }
    }

    /// The number of points that are nearest to a face, and their root mean square and largest distance.
    pub(crate) fn of_face(&self, face: usize) -> (usize, f64, f64) {
        let own = self.distances.iter().zip(&self.faces).filter(|of| *of.1 == face);
        let sums = own.fold((0, 0.0, 0.0), |(count, squares, max), (&d, _)| {
            (count + 1, squares + d * d, f64::max(max, d))
        });
        (sums.0, (sums.1 / f64::max(sums.0 as f64, 1.0)).sqrt(), sums.2)
    }

    /// The number of points whose distance exceeds `tolerance`.
    pub(crate) fn beyond(&self, tolerance: f64) -> usize {
        self.distances.iter().filter(|&&d| d > tolerance).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Uv, Vector};
    use crate::spline::{Curve, KnotVector, Surface};
    use nalgebra::Vector2;

    /// A plate of 10 × 10 mm.
    fn plate() -> Surface {
        let k = KnotVector::uniform(3, 5);
        let net =
            (0..25).map(|n| Vector::new(10.0 * k.greville(n / 5), 10.0 * k.greville(n % 5), 0.0));
        Surface::new(k.clone(), k.clone(), net.collect())
    }

    /// A square loop around the middle of the domain.
    fn square(r: f64) -> Vec<Curve<2>> {
        let corner =
            [(-r, -r), (-r, r), (r, r), (r, -r)].map(|(u, v)| Vector2::new(0.5 + u, 0.5 + v));
        (0..4).map(|i| Curve::line(corner[i], corner[(i + 1) % 4])).collect()
    }

    #[test]
    fn over_a_hole_the_distance_is_to_its_rim() {
        let surface = plate();
        let arcs = square(0.1);
        let face = TrimmedFace::new(&surface, std::iter::once(arcs.as_slice()), true);
        let d = |x: f64, y: f64, z: f64| face.distance(Point::new(x, y, z), Uv::new(0.5, 0.5));
        assert!((d(5.0, 4.5, 0.0) - 0.5).abs() < 1e-12);
        assert!((d(2.0, 5.0, 0.25) - 0.25).abs() < 1e-12);
        assert!((d(-3.0, 5.0, 4.0) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn beyond_an_outer_loop_there_is_no_face() {
        let surface = plate();
        let loops = [square(0.4), square(0.1)];
        let face = TrimmedFace::new(&surface, loops.iter().map(Vec::as_slice), false);
        let d = |x: f64, z: f64| face.distance(Point::new(x, 5.0, z), Uv::new(0.5, 0.5));
        assert!((d(9.5, 0.0) - 0.5).abs() < 1e-12, "beyond the outer loop");
        assert!((d(8.5, 0.25) - 0.25).abs() < 1e-12, "on the face");
        assert!((d(5.9, 0.0) - 0.1).abs() < 1e-12, "in the hole");
    }

    #[test]
    fn an_island_is_a_face_and_a_hole_in_it_is_not() {
        let surface = plate();
        let loops = [square(0.1), square(0.4), square(0.3)];
        let face = TrimmedFace::new(&surface, loops.iter().map(Vec::as_slice), true);
        let d = |x: f64, z: f64| face.distance(Point::new(x, 5.0, z), Uv::new(0.5, 0.5));
        assert!((d(9.5, 0.5) - 0.5).abs() < 1e-12);
        assert!((d(8.9, 0.0) - 0.1).abs() < 1e-12, "in the hole, near its rim");
        assert!((d(8.1, 0.0) - 0.1).abs() < 1e-12, "in the hole, near the island");
        assert!((d(7.5, 0.5) - 0.5).abs() < 1e-12, "on the island");
        assert!((d(5.8, 0.0) - 0.2).abs() < 1e-12, "in the island's hole");
    }
}
