//! Distances from a face to the triangles of the scan from which it was made. A face that passes
//! near every vertex of a scan may still be far from the triangles between sparse vertices. The
//! face is sampled over the parameter triangle of each scan triangle.

use rayon::prelude::*;

use crate::geometry::{Point, Uv, Vector};
use crate::mesh::{Mesh, VertexRings, nearest_on};
use crate::spline::{ParametricSurface, Surface, fast_evaluator};

/// The number of samples for each knot cell that a triangle spans in the parameter plane, along a
/// side.
pub(crate) const SAMPLES_PER_CELL: f64 = 2.0;

/// The largest number of samples along the side of a triangle.
const MAX_SAMPLES: usize = 64;

/// The number of triangles or places, approximately, that suffice for the mean and the percentile.
pub(crate) const SAMPLED: usize = 20_000;

/// The distances of places on faces from the triangles of the scan, in mm. A face that was fitted to a map of the
/// scan has one place for each triangle, the farthest of its samples there. A network has even samples.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct FaceToScan {
    /// The root mean square over an even sample of the places.
    pub rms: f64,
    /// The 95th percentile over the same sample.
    pub p95: f64,
    /// The largest distance.
    pub max: f64,
    /// The sample that has the largest distance.
    pub max_at: [f64; 3],
    /// The chord error at this sample: an estimate of the distance between the flat triangles and
    /// the surface that they represent. A distance may exceed the tolerance by this amount.
    pub chord_error: f64,
    /// The number of places that are farther from the triangles than the tolerance plus their chord error.
    pub beyond: usize,
    /// The number of places.
    pub places: usize,
}

impl FaceToScan {
    /// The same distances with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        FaceToScan {
            rms: factor * self.rms,
            p95: factor * self.p95,
            max: factor * self.max,
            max_at: self.max_at.map(|x| factor * x),
            chord_error: factor * self.chord_error,
            ..self
        }
    }
}

/// A surface over the triangles of a mesh whose vertices have parameter points.
pub(crate) struct SurfaceOverMesh<'a> {
    mesh: &'a Mesh,
    /// The numbers of the triangles that are compared with the surface.
    triangles: &'a [usize],
    uv: &'a [Uv],
    surface: &'a Surface,
    /// The triangles around each vertex, by their positions in `triangles`.
    rings: VertexRings,
    normals: Vec<Vector>,
    cells: [f64; 2],
}

/// A triangle from which the surface deviates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MissedTriangle {
    /// The number of the triangle in the mesh.
    pub triangle: usize,
    /// The deviation divided by the sum of the tolerance and the triangle's chord error.
    pub ratio: f64,
}

/// The result for one triangle.
struct TriangleDeviation {
    /// The position of the triangle in `triangles`.
    triangle: usize,
    /// The largest distance of its samples.
    distance: f64,
    at: Point,
}

impl<'a> SurfaceOverMesh<'a> {
    /// Prepares the comparison of the surface with some triangles.
    pub(crate) fn new(
        mesh: &'a Mesh,
        triangles: &'a [usize],
        uv: &'a [Uv],
        surface: &'a Surface,
    ) -> Self {
        let part = Mesh {
            points: mesh.points.clone(),
            triangles: triangles.iter().map(|&t| mesh.triangles[t]).collect(),
        };
        let cells = narrowest(surface);
        let (rings, normals) = (VertexRings::new(&part), part.vertex_normals());
        SurfaceOverMesh { mesh, triangles, uv, surface, rings, normals, cells }
    }

    /// The distances over the face. Samples outside the face are left out.
    pub(crate) fn report(&self, tolerance: f64, is_on: impl Fn(Uv) -> bool + Sync) -> FaceToScan {
        let count = self.triangles.len();
        if count == 0 {
            return FaceToScan::default();
        }
        let step = count.div_ceil(SAMPLED);
        let sample: Vec<usize> = (0..count).step_by(step).collect();
        let seen = self.seen(&sample, true, &is_on);
        let mut distances: Vec<f64> = seen.iter().map(|seen| seen.distance).collect();
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        let rms = (squares / distances.len() as f64).sqrt();
        let place = (95 * distances.len()).div_ceil(100).max(1) - 1;
        let p95 = *distances.select_nth_unstable_by(place, f64::total_cmp).1;
        let mut worst = farthest(seen);
        // No other triangle can have a larger distance than the bounds that are cheap to compute.
        let bounds = self.bounds(&is_on);
        let more: Vec<usize> = (0..count).filter(|&i| bounds[i] > worst.distance).collect();
        let more = farthest(self.seen(&more, true, &is_on));
        if more.distance > worst.distance {
            worst = more;
        }
        FaceToScan {
            rms,
            p95,
            max: worst.distance,
            max_at: worst.at.coords.into(),
            chord_error: self.chord_error(worst.triangle),
            beyond: self.deviating(&bounds, tolerance, 1.0, &is_on).len(),
            places: count,
        }
    }

    /// The triangles from which the surface deviates by more than `share` of the tolerance plus
    /// their chord error.
    pub(crate) fn missed(&self, tolerance: f64, share: f64) -> Vec<MissedTriangle> {
        let everywhere = |_| true;
        let left = |TriangleDeviation { triangle: i, distance, .. }| MissedTriangle {
            triangle: self.triangles[i],
            ratio: distance / (tolerance + self.chord_error(i)),
        };
        let seen = self.deviating(&self.bounds(&everywhere), tolerance, share, &everywhere);
        seen.into_iter().map(left).collect()
    }

    /// The farthest samples on the face of such triangles. `bounds` are upper bounds on the
    /// distances.
    fn deviating(
        &self,
        bounds: &[f64],
        tolerance: f64,
        share: f64,
        is_on: &(impl Fn(Uv) -> bool + Sync),
    ) -> Vec<TriangleDeviation> {
        let allowed = |i: usize| share * (tolerance + self.chord_error(i));
        let far = |&i: &usize| bounds[i] > share * tolerance && bounds[i] > allowed(i);
        let far: Vec<usize> = (0..bounds.len()).filter(far).collect();
        let seen = self.seen(&far, true, is_on).into_iter();
        seen.filter(|seen| seen.distance > allowed(seen.triangle)).collect()
    }

    /// For each triangle an upper bound on the distance between its samples and the scan.
    fn bounds(&self, is_on: &(impl Fn(Uv) -> bool + Sync)) -> Vec<f64> {
        let all: Vec<usize> = (0..self.triangles.len()).collect();
        self.seen(&all, false, is_on).into_iter().map(|seen| seen.distance).collect()
    }

    /// The results for some triangles. With `around`, each sample is compared with neighbouring
    /// triangles as well.
    fn seen(
        &self,
        which: &[usize],
        around: bool,
        is_on: &(impl Fn(Uv) -> bool + Sync),
    ) -> Vec<TriangleDeviation> {
        let surface = fast_evaluator(self.surface);
        which.par_iter().map(|&i| self.sample_triangle(i, around, &*surface, is_on)).collect()
    }

    /// Samples the surface at the centres of the parts into which a triangle is divided.
    fn sample_triangle(
        &self,
        i: usize,
        around: bool,
        surface: &(impl ParametricSurface + ?Sized),
        is_on: &impl Fn(Uv) -> bool,
    ) -> TriangleDeviation {
        let [a, b, c] = self.corners(i);
        let n = samples_along(spanned([a, b, c], self.cells));
        let mut seen = TriangleDeviation { triangle: i, distance: 0.0, at: Point::origin() };
        for (x, y) in middles(n) {
            let at = a + (b - a) * x + (c - a) * y;
            let place = surface.point(at);
            let distance = if around { self.distance(place, i) } else { self.to(i, place) };
            if distance > seen.distance && is_on(at) {
                seen = TriangleDeviation { distance, at: place, ..seen };
            }
        }
        seen
    }

    /// The parameter points of the corners of triangle `i`.
    fn corners(&self, i: usize) -> [Uv; 3] {
        self.mesh.triangles[self.triangles[i]].map(|v| self.uv[v.index()])
    }

    /// The distance from a place to the triangles near triangle `i`. The search moves to the
    /// nearest triangle around the present one until none is nearer.
    fn distance(&self, p: Point, i: usize) -> f64 {
        let (mut best, mut now) = (self.to(i, p), i);
        loop {
            let corners = self.mesh.triangles[self.triangles[now]];
            let near = corners.iter().flat_map(|&v| self.rings.triangles(v));
            let near = near.map(|&t| (self.to(t as usize, p), t as usize));
            let next = near.min_by(|x, y| x.0.total_cmp(&y.0));
            match next.filter(|(distance, _)| *distance < best) {
                Some((distance, t)) => (best, now) = (distance, t),
                None => return best,
            }
        }
    }

    /// The distance from a place to triangle `i`.
    fn to(&self, i: usize, p: Point) -> f64 {
        let corners = self.mesh.corners(self.mesh.triangles[self.triangles[i]]);
        (nearest_on(corners, p) - p).norm()
    }

    fn chord_error(&self, i: usize) -> f64 {
        self.mesh.chord_error(&self.normals, self.mesh.triangles[self.triangles[i]])
    }
}

/// The widths of the narrowest knot spans of a surface in u and in v.
pub(crate) fn narrowest(surface: &Surface) -> [f64; 2] {
    let narrowest =
        |breaks: Vec<f64>| breaks.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    [surface.u.breaks(), surface.v.breaks()].map(narrowest)
}

/// The number of samples along the sides of a triangle that spans so many knot cells.
pub(crate) fn samples_along(spanned: f64) -> usize {
    ((SAMPLES_PER_CELL * spanned).ceil() as usize).clamp(1, MAX_SAMPLES)
}

/// The larger of the numbers of cells that a triangle spans along u and along v. `cells` are the
/// widths of a cell.
pub(crate) fn spanned([a, b, c]: [Uv; 3], cells: [f64; 2]) -> f64 {
    let reach = |k: usize| {
        let side = |p: Uv, q: Uv| (p[k] - q[k]).abs();
        side(a, b).max(side(b, c)).max(side(c, a)) / cells[k]
    };
    reach(0).max(reach(1))
}

fn farthest(seen: Vec<TriangleDeviation>) -> TriangleDeviation {
    let none = TriangleDeviation { triangle: 0, distance: 0.0, at: Point::origin() };
    seen.into_iter().fold(none, |far, seen| if seen.distance > far.distance { seen } else { far })
}

/// The centres of the n² parts into which lines parallel to its sides divide a triangle, in
/// coordinates along two of its sides.
pub(crate) fn middles(n: usize) -> impl Iterator<Item = (f64, f64)> {
    let third = 1.0 / (3.0 * n as f64);
    let at = move |i: usize, j: usize, up: f64| {
        ((3 * i) as f64 * third + up * third, (3 * j) as f64 * third + up * third)
    };
    (0..n).flat_map(move |i| (0..n - i).map(move |j| (i, j))).flat_map(move |(i, j)| {
        let other = (i + j + 1 < n).then(|| at(i, j, 2.0));
        std::iter::once(at(i, j, 1.0)).chain(other)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexId;
    use crate::spline::KnotVector;

    /// A plate of 30 × 30 mm with a bulge of `high` mm between four points of a mesh.
    fn report(high: f64, tolerance: f64) -> FaceToScan {
        let k = KnotVector::uniform(3, 8);
        let bulge = |n: usize| if n == 8 * 3 + 4 { high } else { 0.0 };
        let net = (0..64)
            .map(|n| Vector::new(30.0 * k.greville(n / 8), 30.0 * k.greville(n % 8), bulge(n)));
        let surface = Surface::new(k.clone(), k.clone(), net.collect());
        let uv = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Uv::new(u, v));
        let points = uv.iter().map(|&at| surface.point(at)).collect();
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let triangles = triangles.into_iter().map(|t| t.map(VertexId)).collect();
        let mesh = Mesh { points, triangles };
        SurfaceOverMesh::new(&mesh, &[0, 1], &uv, &surface).report(tolerance, |_| true)
    }

    #[test]
    fn a_bulge_between_points_is_seen() {
        let flat = report(0.0, 0.1);
        assert!(flat.max < 1e-12 && flat.beyond == 0, "{flat:?}");
        let bulging = report(2.0, 0.1);
        // The height of the middle of the bulge is (4/9)² of that of the control point.
        assert!((bulging.max - 8.0 / 9.0).abs() < 0.1, "{bulging:?}");
        assert!(bulging.beyond > 0 && bulging.chord_error < 1e-9, "{bulging:?}");
    }

    #[test]
    fn the_parts_of_a_triangle_have_one_place_each() {
        for n in 1..6 {
            let all: Vec<(f64, f64)> = middles(n).collect();
            assert_eq!(all.len(), n * n);
            let mean = all.iter().fold((0.0, 0.0), |sum, at| (sum.0 + at.0, sum.1 + at.1));
            let third = (n * n) as f64 / 3.0;
            assert!((mean.0 - third).abs() < 1e-9 && (mean.1 - third).abs() < 1e-9);
        }
    }
}
