//! Moving least squares. Points around a place go in; the surface that they lie on near this
//! place comes out (Tekumalla & Cohen 2005, "MLS Projection Procedure").
//!
//! The projection of a point r has two steps. First, the reference plane through q = r + t n
//! minimises Σ ⟨n, pᵢ − r − t n⟩² θ(‖pᵢ − r − t n‖) over n and t. This problem is non-linear,
//! because the weights move with the plane. Then a polynomial is fitted over this plane with the
//! weights θ(‖pᵢ − q‖). The polynomial of the paper is bi-quadratic; this one has all terms up to
//! the fourth degree. The projection of r is the value of the polynomial at q. θ(x) = exp(−x²/h²).

mod plane;
mod polynomial;

pub(crate) use plane::{ReferencePlane, reference_plane};
pub(crate) use polynomial::Polynomial;

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::{Mesh, Neighbours, VertexRings};
use crate::geometry::{Point, ROUNDING, Vector, VertexId};

/// Points beyond this multiple of h are left out. Their weight is below 0.7 %.
pub(crate) const REACH: f64 = 2.25;

/// Points with normals, indexed for projections onto the surface that they sample.
#[derive(Debug)]
pub(crate) struct Cloud {
    points: Vec<Point>,
    normals: Vec<Vector>,
    near: Neighbours,
}

/// The result of a projection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection {
    /// The point on the local polynomial.
    pub point: Point,
    /// The unit normal of the local polynomial at this point.
    pub normal: Vector,
}

/// A point that takes part in a fit, or several points that are merged into one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Its position, or the mean position of the merged points.
    pub at: Point,
    /// The number of points that it represents.
    pub weight: f64,
    /// The covariance of the merged points as xx, yy, zz, xy, yz, zx. With it a fit to the mean is
    /// as exact as a fit to the single points.
    pub spread: [f32; 6],
}

impl From<Point> for Sample {
    fn from(at: Point) -> Self {
        Sample { at, weight: 1.0, spread: [0.0; 6] }
    }
}

impl Sample {
    /// Merges several samples into one. If none has any weight, the result is at the first one's
    /// position.
    pub(crate) fn merged(samples: impl Iterator<Item = Sample> + Clone) -> Sample {
        let first = samples.clone().next().map_or(Point::origin(), |s| s.at);
        let (mut weight, mut sum, mut squares) = (0.0, Vector::zeros(), Matrix3::zeros());
        for s in samples.filter(|s| s.weight > 0.0) {
            let d = s.at - first;
            weight += s.weight;
            sum += s.weight * d;
            squares += s.weight * (s.covariance() + d * d.transpose());
        }
        if weight == 0.0 {
            return Sample { at: first, weight, spread: [0.0; 6] };
        }
        let mean = sum / weight;
        let c = squares / weight - mean * mean.transpose();
        let spread = [c.m11, c.m22, c.m33, c.m12, c.m23, c.m31].map(|x| x as f32);
        Sample { at: first + mean, weight, spread }
    }

    fn covariance(&self) -> Matrix3<f64> {
        let [xx, yy, zz, xy, yz, zx] = self.spread.map(f64::from);
        Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
    }
}

impl Cloud {
    /// A cloud of points with approximately known unit normals.
    pub(crate) fn new(points: Vec<Point>, normals: Vec<Vector>) -> Self {
        let near = Neighbours::new(&points);
        Cloud { points, normals, near }
    }

    /// The cloud of a mesh's vertices.
    pub(crate) fn of(mesh: &Mesh, rings: &VertexRings) -> Self {
        let normals = || smoothed_normals(mesh, rings);
        let (near, normals) = rayon::join(|| Neighbours::new(&mesh.points), normals);
        Cloud { points: mesh.points.clone(), normals, near }
    }

    /// The unit normal of the cloud's `i`-th point.
    pub(crate) fn normal(&self, i: usize) -> Vector {
        self.normals[i]
    }

    /// The distance from `p` to the nearest point of the cloud.
    pub(crate) fn nearest_distance(&self, p: Point) -> f64 {
        (self.points[self.near.nearest(p)] - p).norm()
    }

    /// Appends the points within `radius` of `r` to `around`. Points whose normal faces the
    /// opposite way lie on another sheet and are left out.
    pub(crate) fn gather(&self, r: Point, normal: Vector, radius: f64, around: &mut Vec<Sample>) {
        let mut found = Vec::new();
        self.near.within(r, radius, &mut found);
        let same_sheet = found.iter().filter(|&&i| self.normals[i as usize].dot(&normal) > 0.0);
        around.extend(same_sheet.map(|&i| Sample::from(self.points[i as usize])));
    }
}

/// Vertex normals averaged over two rings of neighbours. Noise as large as the distance between
/// points does not flip such a normal.
pub(crate) fn smoothed_normals(mesh: &Mesh, rings: &VertexRings) -> Vec<Vector> {
    let mut normals = mesh.vertex_normals();
    for _ in 0..2 {
        let mean = |i: usize| {
            let around = rings.neighbours(mesh, VertexId::from(i)).map(|v| normals[v.index()]);
            let sum = around.fold(normals[i], |sum, n| sum + n);
            sum.try_normalize(ROUNDING).unwrap_or(normals[i])
        };
        normals = (0..normals.len()).into_par_iter().map(mean).collect();
    }
    normals
}

#[cfg(test)]
mod tests {
    use super::plane::energy;
    use super::*;
    use crate::geometry::plane_axes;

    /// A grid of points on z = f(x, y), 21 × 21 over [-1, 1]².
    fn sheet(f: impl Fn(f64, f64) -> f64) -> Cloud {
        let at = |i: i32| f64::from(i) / 10.0;
        let grid = (-10..=10).flat_map(|i| (-10..=10).map(move |j| (at(i), at(j))));
        let points: Vec<Point> = grid.map(|(x, y)| Point::new(x, y, f(x, y))).collect();
        let normals = vec![Vector::z(); points.len()];
        Cloud::new(points, normals)
    }

    fn project(around: &[Sample], r: Point, h: f64) -> Projection {
        let plane = reference_plane(r, Vector::z(), around, h).unwrap();
        let (point, normal) = Polynomial::fit(&plane, around, h).unwrap().at(plane.origin);
        Projection { point, normal }
    }

    fn near(cloud: &Cloud, r: Point, h: f64) -> Vec<Sample> {
        let mut around = Vec::new();
        cloud.gather(r, Vector::z(), REACH * h, &mut around);
        around
    }

    #[test]
    fn a_quadric_in_its_own_frame_is_reproduced() {
        let cloud = sheet(|x, y| 0.3 * x * x - 0.2 * y * y);
        let r = Point::new(0.0, 0.0, 0.02);
        let foot = project(&near(&cloud, r, 0.3), r, 0.3);
        assert!(foot.point.coords.norm() < 1e-6, "{foot:?}");
        assert!((foot.normal - Vector::z()).norm() < 1e-6);
    }

    #[test]
    fn the_plane_is_a_stationary_point_of_the_energy() {
        let cloud = sheet(|x, y| 0.3 * (2.0 * x).sin() + 0.2 * x * y);
        let r = Point::new(0.2, -0.1, 0.15);
        let h = 0.35;
        let around = near(&cloud, r, h);
        let plane = reference_plane(r, Vector::z(), &around, h).unwrap();
        let t = (plane.origin - r).dot(&plane.normal);
        let (x, y) = plane_axes(plane.normal);
        let value = |dt: f64, a: f64, b: f64| {
            let n = (plane.normal + a * x + b * y).normalize();
            energy(r, n, t + dt, &around, h).value
        };
        let least = value(0.0, 0.0, 0.0);
        for step in [1e-3, -1e-3] {
            assert!(least <= value(step, 0.0, 0.0) + 1e-12);
            assert!(least <= value(0.0, step, 0.0) + 1e-12);
            assert!(least <= value(0.0, 0.0, step) + 1e-12);
        }
    }

    #[test]
    fn the_other_side_of_a_thin_wall_is_not_seen() {
        let mut points = sheet(|_, _| 0.0).points;
        let mut normals = vec![Vector::z(); points.len()];
        points.extend(sheet(|_, _| -0.05).points);
        normals.extend(vec![-Vector::z(); points.len() - normals.len()]);
        let cloud = Cloud::new(points, normals);
        let r = Point::new(0.1, 0.1, 0.01);
        let foot = project(&near(&cloud, r, 0.3), r, 0.3);
        assert!(foot.point.z.abs() < 1e-9);
    }
}
