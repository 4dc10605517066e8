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
}

/// A point that takes part in a fit, or several that are taken as one.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Where it is; of several the mean.
    pub at: Point,
    /// How many points it stands for.
    pub weight: f64,
    /// The covariance of these, xx, yy, zz, xy, yz, zx, by which a fit to their
    /// mean stays as exact as one to each of them.
    pub spread: [f32; 6],
}

impl From<Point> for Sample {
    fn from(at: Point) -> Self {
        Sample { at, weight: 1.0, spread: [0.0; 6] }
    }
}

impl Sample {
    /// Several samples as one. Where none has any weight it is at the first's
    /// place.
    pub fn merged(samples: impl Iterator<Item = Sample> + Clone) -> Sample {
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

/// Room for the neighbourhood of one projection, kept between calls.
#[derive(Debug, Default)]
pub struct Scratch {
    found: Vec<u32>,
    around: Vec<Sample>,
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
        let polynomial = Polynomial::fit(&plane, &scratch.around, h)?;
        let (point, normal) = polynomial.at(plane.origin);
        Some(Projection { point, normal })
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
        scratch.around.extend(found.map(|&i| Sample::from(self.points[i as usize])));
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

fn energy(r: Point, n: Vector, t: f64, around: &[Sample], h: f64) -> Energy {
    let (x, y) = plane_axes(n);
    let inverse = 1.0 / (h * h);
    let mut e = Energy { value: 0.0, gradient: Vector3::zeros(), matrix: Matrix3::zeros() };
    for p in around {
        let d = p.at - r;
        let height = d.dot(&n);
        let s = height - t;
        let weight = p.weight * (-(d.norm_squared() - 2.0 * t * height + t * t) * inverse).exp();
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

/// The plane is settled when a step moves it by less than this share of h, and
/// turns it by less than this.
const SETTLED: f64 = 1e-3;

/// The plane of the non-linear minimisation, by Gauss–Newton with the exact
/// gradient from (n, t) = (`normal`, 0), each step shortened until the energy
/// falls. The energy also falls towards infinity, where the weights vanish, so
/// t stays within h.
pub fn reference_plane(r: Point, normal: Vector, around: &[Sample], h: f64) -> Option<Plane> {
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
        let still = (t2 - t).abs() < SETTLED * h && (n2 - n).norm() < SETTLED;
        (n, t, at) = (n2, t2, next);
        if still {
            break;
        }
    }
    Some(Plane { origin: r + t * n, normal: n })
}

/// A polynomial over a plane, around its origin.
#[derive(Debug, Clone, Copy)]
pub struct Polynomial {
    plane: Plane,
    axes: (Vector, Vector),
    /// Of the monomials in units of h, in their order.
    coefficients: [f64; ALL],
    h: f64,
    /// The variance of its value at the origin, where the points' variance is 1.
    pub variance: f64,
}

/// The number of monomials up to the fourth degree.
const ALL: usize = 15;

/// The monomials, as means over a sample's points: the first 3 are linear, the
/// first 6 quadratic, the first 10 cubic, all 15 quartic. `spread` is the
/// covariance xx, xy, yy; moments of higher order are a normal distribution's.
fn monomials(x: f64, y: f64, [xx, xy, yy]: [f64; 3]) -> [f64; ALL] {
    let (x2, y2) = (x * x, y * y);
    [
        1.0,
        x,
        y,
        x2 + xx,
        x * y + xy,
        y2 + yy,
        x * (x2 + 3.0 * xx),
        x2 * y + xx * y + 2.0 * x * xy,
        x * y2 + yy * x + 2.0 * y * xy,
        y * (y2 + 3.0 * yy),
        x2 * (x2 + 6.0 * xx) + 3.0 * xx * xx,
        x2 * x * y + 3.0 * (x2 * xy + x * y * xx + xx * xy),
        x2 * y2 + xx * y2 + yy * x2 + 4.0 * x * y * xy + xx * yy + 2.0 * xy * xy,
        x * y2 * y + 3.0 * (y2 * xy + x * y * yy + yy * xy),
        y2 * (y2 + 6.0 * yy) + 3.0 * yy * yy,
    ]
}

impl Polynomial {
    /// The polynomial of highest degree that the points determine: of total
    /// degree four, which has the bi-quadratic ones among it, else three, two or
    /// one. One is determined when its
    /// value at the origin is steadier than a single point. Where the points lie
    /// to one side, as at a boundary, the fourth degree would swing freely.
    pub fn fit(plane: &Plane, around: &[Sample], h: f64) -> Option<Polynomial> {
        Some(Self::fitted(plane, around, h, false)?.0)
    }

    /// The same with its scatter: the mean square of the points' distances from
    /// it along the normal, as free of the fit's own freedom as of the weights.
    /// It estimates the noise's variance.
    pub fn fit_with_scatter(plane: &Plane, around: &[Sample], h: f64) -> Option<(Polynomial, f64)> {
        Self::fitted(plane, around, h, true)
    }

    fn fitted(
        plane: &Plane,
        around: &[Sample],
        h: f64,
        with_scatter: bool,
    ) -> Option<(Polynomial, f64)> {
        let axes = plane_axes(plane.normal);
        let rows: Vec<Row> = around.iter().map(|p| Row::new(p, plane, axes, h)).collect();
        let full = if is_one_sided(&rows) { None } else { solve::<15>(&rows, with_scatter) };
        let (coefficients, variance, scatter) = full
            .or_else(|| solve::<10>(&rows, with_scatter))
            .or_else(|| solve::<6>(&rows, with_scatter))
            .or_else(|| solve::<3>(&rows, with_scatter))?;
        let polynomial = Polynomial { plane: *plane, axes, coefficients, h, variance };
        Some((polynomial, scatter * h * h))
    }

    /// The point of the polynomial that lies off `p` along the plane's normal,
    /// and the unit normal there.
    pub fn at(&self, p: Point) -> (Point, Vector) {
        let n = self.plane.normal;
        let (e1, e2) = self.axes;
        let d = (p - self.plane.origin) / self.h;
        let (x, y) = (d.dot(&e1), d.dot(&e2));
        let c = &self.coefficients;
        let row = monomials(x, y, [0.0; 3]);
        let height: f64 = row.iter().zip(c).map(|(m, c)| m * c).sum();
        let (x2, xy, y2) = (x * x, x * y, y * y);
        let by_x = [
            1.0,
            2.0 * x,
            y,
            3.0 * x2,
            2.0 * xy,
            y2,
            4.0 * x * x2,
            3.0 * x * xy,
            2.0 * x * y2,
            y * y2,
        ];
        let by_y = [
            1.0,
            x,
            2.0 * y,
            x2,
            2.0 * xy,
            3.0 * y2,
            x * x2,
            2.0 * x2 * y,
            3.0 * xy * y,
            4.0 * y * y2,
        ];
        let sum = |terms: [f64; 10], which: [usize; 10]| -> f64 {
            terms.iter().zip(which).map(|(t, k)| t * c[k]).sum()
        };
        let dx = sum(by_x, [1, 3, 4, 6, 7, 8, 10, 11, 12, 13]);
        let dy = sum(by_y, [2, 4, 5, 7, 8, 9, 11, 12, 13, 14]);
        let foot = p + self.h * (height - d.dot(&n)) * n;
        (foot, (n - dx * e1 - dy * e2).normalize())
    }
}

/// A sample in the plane's frame, in units of h.
struct Row {
    monomials: [f64; ALL],
    height: f64,
    weight: f64,
    count: f64,
}

impl Row {
    fn new(p: &Sample, plane: &Plane, (e1, e2): (Vector, Vector), h: f64) -> Self {
        let d = (p.at - plane.origin) / h;
        let spread = p.covariance() / (h * h);
        let (s1, s2) = (spread * e1, spread * e2);
        let spread = [s1.dot(&e1), s1.dot(&e2), s2.dot(&e2)];
        Row {
            monomials: monomials(d.dot(&e1), d.dot(&e2), spread),
            height: d.dot(&plane.normal),
            weight: p.weight * (-d.norm_squared()).exp(),
            count: p.weight,
        }
    }
}

/// Whether the points' mean is farther from the origin than a fifth of h.
fn is_one_sided(rows: &[Row]) -> bool {
    let sum = |k: usize| rows.iter().map(|row| row.weight * row.monomials[k]).sum::<f64>();
    sum(1).hypot(sum(2)) > 0.2 * sum(0)
}

/// A fit: its coefficients, its variance at the origin, and its scatter in units
/// of h, if that is wanted.
type Fitted = ([f64; ALL], f64, f64);

/// The weighted least-squares fit of the first N monomials.
fn solve<const N: usize>(rows: &[Row], with_scatter: bool) -> Option<Fitted>
where
    nalgebra::Const<N>: nalgebra::DimName,
{
    if rows.len() < N {
        return None;
    }
    let first = |row: &Row| SVector::<f64, N>::from_fn(|i, _| row.monomials[i]);
    let mut gram = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for row in rows {
        let b = first(row);
        let weighted = row.weight * b;
        for j in 0..N {
            gram.column_mut(j).axpy(b[j], &weighted, 1.0);
        }
        right.axpy(row.height, &weighted, 1.0);
    }
    let damp = 1e-10 * gram.trace();
    gram += SMatrix::<f64, N, N>::identity() * damp;
    let factor = gram.cholesky()?;
    let c = factor.solve(&right);
    let at_origin = factor.solve(&SVector::<f64, N>::from_fn(|i, _| f64::from(i == 0)));
    // A mean of several points has less noise by their number.
    let noise = |row: &Row| row.weight * row.weight / row.count;
    let variance: f64 = rows.iter().map(|r| noise(r) * first(r).dot(&at_origin).powi(2)).sum();
    if variance.is_nan() || variance > 1.0 {
        return None;
    }
    let mut scatter = f64::NAN;
    if with_scatter {
        // Σ w r² has the expectation σ² (Σ w/count − Σ w²/count bᵀ G⁻¹ b).
        let square = |r: &Row| r.weight * (r.height - first(r).dot(&c)).powi(2);
        let free = |r: &Row| {
            let b = first(r);
            r.weight / r.count - noise(r) * b.dot(&factor.solve(&b))
        };
        let total: f64 = rows.iter().map(|r| r.weight / r.count).sum();
        let freedom: f64 = rows.iter().map(free).sum();
        scatter = rows.iter().map(square).sum::<f64>() / freedom.max(1e-3 * total);
    }
    Some((std::array::from_fn(|i| if i < N { c[i] } else { 0.0 }), variance, scatter))
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
