//! Moving least squares: what surface the points around a place lie on
//! (Tekumalla & Cohen 2005, "MLS Projection Procedure").
//!
//! Two steps. The reference plane through q = r + t n minimises
//! Σ ⟨n, pᵢ − r − t n⟩² θ(‖pᵢ − r − t n‖) over n and t, a non-linear problem
//! since the weights move with the plane; then a bi-quadratic polynomial is
//! fitted over that plane with weights θ(‖pᵢ − q‖). The projection of r is the
//! polynomial's value at q. θ(x) = exp(−x²/h²).

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::{Mesh, Neighbours, Rings};
use crate::geometry::{Point, Vector, VertexId, plane_axes};

/// Beyond this many h the weight is below 0.7% and the point is left out.
pub const REACH: f64 = 2.25;

/// Points with normals, ready for projections onto the surface they sample.
#[derive(Debug)]
pub struct Cloud {
    points: Vec<Point>,
    normals: Vec<Vector>,
    near: Neighbours,
}

/// The foot of a projection.
#[derive(Debug, Clone, Copy)]
pub struct Projection {
    /// The point on the local polynomial.
    pub point: Point,
    /// The local polynomial's unit normal there.
    pub normal: Vector,
    /// How much the projection follows its own point, if that is one of the
    /// cloud: ∂(foot)/∂(point), 0 to 1.
    pub leverage: f64,
    /// The variance of the foot where the points' variance is 1.
    pub variance: f64,
}

/// Room for the neighbourhood of one projection, kept between calls.
#[derive(Debug, Default)]
pub struct Scratch {
    found: Vec<u32>,
    around: Vec<Point>,
}

impl Cloud {
    /// A cloud of points with (roughly) known unit normals.
    pub fn new(points: Vec<Point>, normals: Vec<Vector>) -> Self {
        let near = Neighbours::new(&points);
        Cloud { points, normals, near }
    }

    /// The cloud of a mesh's vertices.
    pub fn of(mesh: &Mesh) -> Self {
        Cloud::new(mesh.points.clone(), steady_normals(mesh))
    }

    /// The unit normal of the cloud's `i`-th point.
    pub fn normal(&self, i: usize) -> Vector {
        self.normals[i]
    }

    /// Projects `r` along about `normal` with support `h`. Points whose normal
    /// looks the other way lie on another sheet and are left out. `None` where
    /// too few points are near.
    pub fn project(
        &self,
        r: Point,
        normal: Vector,
        h: f64,
        scratch: &mut Scratch,
    ) -> Option<Projection> {
        self.gather(r, normal, h, scratch);
        let plane = reference_plane(r, normal, &scratch.around, h)?;
        polynomial(&plane, &scratch.around, h)
    }

    /// The reference plane at `r` alone.
    pub fn plane(&self, r: Point, normal: Vector, h: f64, scratch: &mut Scratch) -> Option<Plane> {
        self.gather(r, normal, h, scratch);
        reference_plane(r, normal, &scratch.around, h)
    }

    /// The distance from `p` to the nearest point of the cloud.
    pub fn nearest_distance(&self, p: Point) -> f64 {
        (self.points[self.near.nearest(p)] - p).norm()
    }

    /// The points within `radius` of any of `places`, ascending.
    pub fn around(&self, places: impl Iterator<Item = Point>, radius: f64) -> Vec<VertexId> {
        let mut found = Vec::new();
        let mut all: Vec<u32> = Vec::new();
        for place in places {
            self.near.within(place, radius, &mut found);
            all.extend(&found);
        }
        all.sort_unstable();
        all.dedup();
        all.into_iter().map(VertexId).collect()
    }

    fn gather(&self, r: Point, normal: Vector, h: f64, scratch: &mut Scratch) {
        self.near.within(r, REACH * h, &mut scratch.found);
        let same_sheet = |&&i: &&u32| self.normals[i as usize].dot(&normal) > 0.0;
        scratch.around.clear();
        let found = scratch.found.iter().filter(same_sheet);
        scratch.around.extend(found.map(|&i| self.points[i as usize]));
    }
}

/// Vertex normals, averaged over two rings so that noise near the point
/// spacing does not turn them around.
pub fn steady_normals(mesh: &Mesh) -> Vec<Vector> {
    let rings = Rings::new(mesh);
    let mut normals = mesh.vertex_normals();
    for _ in 0..2 {
        let mean = |i: usize| {
            let around = rings.neighbours(mesh, VertexId::from(i)).map(|v| normals[v.index()]);
            let sum = around.fold(normals[i], |sum, n| sum + n);
            sum.try_normalize(1e-12).unwrap_or(normals[i])
        };
        normals = (0..normals.len()).map(mean).collect();
    }
    normals
}

/// A plane with a frame.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// The foot of r on the plane.
    pub origin: Point,
    /// Unit normal.
    pub normal: Vector,
}

/// Value, half gradient and Gauss–Newton matrix of the plane's energy in the
/// unknowns (t, tilt towards x, tilt towards y).
struct Energy {
    value: f64,
    gradient: Vector3<f64>,
    matrix: Matrix3<f64>,
}

fn energy(r: Point, n: Vector, t: f64, around: &[Point], h: f64) -> Energy {
    let (x, y) = plane_axes(n);
    let inverse = 1.0 / (h * h);
    let mut e = Energy { value: 0.0, gradient: Vector3::zeros(), matrix: Matrix3::zeros() };
    for p in around {
        let d = p - r;
        let height = d.dot(&n);
        let s = height - t;
        let weight = (-(d.norm_squared() - 2.0 * t * height + t * t) * inverse).exp();
        let side = Vector3::new(-1.0, d.dot(&x), d.dot(&y));
        // The second terms are those of the moving weights.
        let by_t = s - s * s * s * inverse;
        let by_tilt = s + s * s * t * inverse;
        e.value += weight * s * s;
        e.gradient += weight * Vector3::new(-by_t, by_tilt * side.y, by_tilt * side.z);
        e.matrix += weight * side * side.transpose();
    }
    e
}

/// The plane of the non-linear minimisation, by Gauss–Newton with the exact
/// gradient from (n, t) = (`normal`, 0), each step shortened until the energy
/// falls. The energy also falls towards infinity, where the weights vanish, so
/// t stays within h.
pub fn reference_plane(r: Point, normal: Vector, around: &[Point], h: f64) -> Option<Plane> {
    if around.len() < 3 || normal.norm_squared() < 0.5 {
        return None;
    }
    let (mut n, mut t) = (normal, 0.0);
    let mut at = energy(r, n, t, around, h);
    for _ in 0..20 {
        let damped = at.matrix + Matrix3::identity() * (1e-12 * at.matrix.trace());
        let step = -damped.cholesky()?.solve(&at.gradient);
        let (x, y) = plane_axes(n);
        let mut share = 1.0;
        let accepted = loop {
            let t2 = (t + share * step.x).clamp(-h, h);
            let n2 = (n + share * (step.y * x + step.z * y)).normalize();
            let next = energy(r, n2, t2, around, h);
            if next.value <= at.value {
                break Some((n2, t2, next));
            }
            share *= 0.5;
            if share < 1e-3 {
                break None;
            }
        };
        let Some((n2, t2, next)) = accepted else { break };
        let still = (t2 - t).abs() < 1e-5 * h && (n2 - n).norm() < 1e-5;
        (n, t, at) = (n2, t2, next);
        if still {
            break;
        }
    }
    Some(Plane { origin: r + t * n, normal: n })
}

/// The polynomial of highest degree that the points determine: bi-quadratic,
/// else quadratic, else linear. One is determined when its value at the origin
/// is steadier than a single point.
fn polynomial(plane: &Plane, around: &[Point], h: f64) -> Option<Projection> {
    let local = Local::new(plane, around, h);
    local.fit::<9>(plane).or_else(|| local.fit::<6>(plane)).or_else(|| local.fit::<3>(plane))
}

/// Weighted points in the plane's frame, in units of h.
struct Local {
    frame: (Vector, Vector),
    points: Vec<[f64; 4]>,
    h: f64,
}

impl Local {
    fn new(plane: &Plane, around: &[Point], h: f64) -> Self {
        let frame = plane_axes(plane.normal);
        let local = |p: &Point| {
            let d = (p - plane.origin) / h;
            let weight = (-d.norm_squared()).exp();
            [d.dot(&frame.0), d.dot(&frame.1), d.dot(&plane.normal), weight]
        };
        Local { frame, points: around.iter().map(local).collect(), h }
    }

    /// The monomials: the first 3 are linear, the first 6 quadratic, all 9
    /// bi-quadratic.
    fn monomials<const N: usize>(x: f64, y: f64) -> SVector<f64, N> {
        let all = [1.0, x, y, x * x, x * y, y * y, x * x * y, x * y * y, x * x * y * y];
        SVector::from_fn(|i, _| all[i])
    }

    fn fit<const N: usize>(&self, plane: &Plane) -> Option<Projection>
    where
        nalgebra::Const<N>: nalgebra::DimName,
    {
        if self.points.len() < N {
            return None;
        }
        let mut gram = SMatrix::<f64, N, N>::zeros();
        let mut right = SVector::<f64, N>::zeros();
        for &[x, y, f, w] in &self.points {
            let b = Self::monomials::<N>(x, y);
            gram.ger(w, &b, &b, 1.0);
            right.axpy(w * f, &b, 1.0);
        }
        let damp = 1e-10 * gram.trace();
        gram += SMatrix::<f64, N, N>::identity() * damp;
        let factor = gram.cholesky()?;
        let c = factor.solve(&right);
        let row = factor.solve(&SVector::<f64, N>::from_fn(|i, _| f64::from(i == 0)));
        let share = |&[x, y, _, w]: &[f64; 4]| w * Self::monomials::<N>(x, y).dot(&row);
        let variance: f64 = self.points.iter().map(|p| share(p).powi(2)).sum();
        if variance.is_nan() || variance > 1.0 {
            return None;
        }
        let normal = plane.normal - c[1] * self.frame.0 - c[2] * self.frame.1;
        Some(Projection {
            point: plane.origin + self.h * c[0] * plane.normal,
            normal: normal.normalize(),
            leverage: row[0],
            variance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of points on z = f(x, y), 21 × 21 over [-1, 1]².
    fn sheet(f: impl Fn(f64, f64) -> f64) -> Cloud {
        let at = |i: i32| f64::from(i) / 10.0;
        let grid = (-10..=10).flat_map(|i| (-10..=10).map(move |j| (at(i), at(j))));
        let points: Vec<Point> = grid.map(|(x, y)| Point::new(x, y, f(x, y))).collect();
        let normals = vec![Vector::z(); points.len()];
        Cloud::new(points, normals)
    }

    #[test]
    fn a_quadric_in_its_own_frame_is_reproduced() {
        let cloud = sheet(|x, y| 0.3 * x * x - 0.2 * y * y);
        let r = Point::new(0.0, 0.0, 0.02);
        let foot = cloud.project(r, Vector::z(), 0.3, &mut Scratch::default()).unwrap();
        assert!(foot.point.coords.norm() < 1e-6, "{foot:?}");
        assert!((foot.normal - Vector::z()).norm() < 1e-6);
    }

    #[test]
    fn the_plane_is_a_stationary_point_of_the_energy() {
        let cloud = sheet(|x, y| 0.3 * (2.0 * x).sin() + 0.2 * x * y);
        let r = Point::new(0.2, -0.1, 0.15);
        let mut scratch = Scratch::default();
        let h = 0.35;
        let plane = cloud.plane(r, Vector::z(), h, &mut scratch).unwrap();
        let t = (plane.origin - r).dot(&plane.normal);
        let (x, y) = plane_axes(plane.normal);
        let value = |dt: f64, a: f64, b: f64| {
            let n = (plane.normal + a * x + b * y).normalize();
            energy(r, n, t + dt, &scratch.around, h).value
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
        let foot = cloud.project(r, Vector::z(), 0.3, &mut Scratch::default()).unwrap();
        assert!(foot.point.z.abs() < 1e-9);
    }
}
