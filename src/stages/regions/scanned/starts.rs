//! Starts of fits to noisy vertices with filtered normals.
//!
//! Distances over a short arc say little about a radius: noise makes an algebraic circle too small. How the normals
//! turn along the points says it without bias. The curvatures of a quadric give further starts.

use nalgebra::{Matrix3, SMatrix, SVector};

use super::scan::NoisyScan;
use crate::geometry::{Point, Vector, plane_axes};
use crate::primitives::{Primitive, PrimitiveKind};

/// A torus is started with its axis at these angles from the surface's tangent plane, in radians, where a quadric gives
/// only the curvatures.
const MERIDIANS: [f64; 3] = [-0.9, 0.0, 0.9];

/// A line complex whose moment is smaller than this has no axis.
const LEAST_AXIS: f64 = 1e-3;

/// The larger of two curvatures is one if it turns by this angle within the data.
const LEAST_CURVATURE: f64 = 1e-6;

/// Points with normals, and their curvatures.
pub(super) struct Neighbourhood {
    points: Vec<Point>,
    normals: Vec<Vector>,
    middle: Point,
    size: f64,
    quadric: Option<Quadric>,
}

/// The principal curvatures at a point of a quadric. Directions and normal are unit vectors.
struct Quadric {
    place: Point,
    normal: Vector,
    /// The curvatures and their directions, the larger first.
    curvatures: [(f64, Vector); 2],
}

impl Neighbourhood {
    pub(super) fn new(scan: &NoisyScan, vertices: impl Iterator<Item = u32>) -> Self {
        let (points, normals): (Vec<Point>, Vec<Vector>) =
            vertices.map(|v| (scan.point(v), scan.normal(v))).unzip();
        let sum: Vector = points.iter().map(|p| p.coords).sum();
        let middle = Point::from(sum / points.len().max(1) as f64);
        let size = points.iter().map(|p| (p - middle).norm()).fold(f64::MIN_POSITIVE, f64::max);
        let quadric = Quadric::new(&points, &normals, middle, size);
        Neighbourhood { points, normals, middle, size, quadric }
    }

    /// Starts of one kind.
    pub(super) fn starts(&self, kind: PrimitiveKind) -> Vec<Primitive> {
        let mut all = Vec::new();
        let bent = self.quadric.as_ref().filter(|q| q.is_bent(self.size));
        match kind {
            PrimitiveKind::Plane => {
                let moments: Matrix3<f64> = self
                    .points
                    .iter()
                    .map(|p| (p - self.middle) * (p - self.middle).transpose())
                    .sum();
                all.push(Primitive::Plane { origin: self.middle, normal: axes_of(moments)[0] });
            }
            PrimitiveKind::Sphere => {
                all.extend(self.sphere());
                if let Some(quadric) = bent {
                    let mean = 0.5 * (quadric.curvatures[0].0 + quadric.curvatures[1].0);
                    let centre = quadric.place + quadric.normal / mean;
                    all.push(Primitive::Sphere { centre, radius: mean.abs().recip() });
                }
            }
            PrimitiveKind::Cylinder => {
                let axis = axes_of(self.second_moments(false))[0];
                all.extend(self.circle(axis).map(|(origin, radius)| Primitive::Cylinder {
                    origin,
                    axis,
                    radius,
                }));
                if let Some(quadric) = bent {
                    let (curvature, _) = quadric.curvatures[0];
                    let origin = quadric.place + quadric.normal / curvature;
                    let (axis, radius) = (quadric.curvatures[1].1, curvature.abs().recip());
                    all.push(Primitive::Cylinder { origin, axis, radius });
                }
            }
            PrimitiveKind::Cone => {
                let level = axes_of(self.second_moments(true))[0];
                let least = axes_of(self.second_moments(false))[0];
                let axes = [level, least].into_iter().chain(bent.map(|q| q.curvatures[1].1));
                for axis in axes {
                    let place = self.circle(axis).map(|(origin, _)| origin);
                    all.extend(place.and_then(|origin| self.cone(origin, axis)));
                }
                all.extend(self.complex_axes().filter_map(|(o, a)| self.cone(o, a)));
            }
            PrimitiveKind::Torus => {
                all.extend(self.complex_axes().filter_map(|(o, a)| self.torus(o, a)));
                if let Some(quadric) = bent {
                    all.extend(quadric.tori());
                }
            }
        }
        let is_finite = |s: &Primitive| s.distance(self.middle).0.is_finite();
        all.retain(is_finite);
        all
    }

    fn second_moments(&self, about_mean: bool) -> Matrix3<f64> {
        let sum: Vector = self.normals.iter().sum();
        let mean = if about_mean { sum / self.normals.len() as f64 } else { Vector::zeros() };
        self.normals.iter().map(|n| (n - mean) * (n - mean).transpose()).sum()
    }

    /// How far the surface's centre of curvature is behind points, from the pairs of coordinates and normals: the
    /// radius, signed along the normals.
    fn radius<const N: usize>(
        pairs: &[(SVector<f64, N>, SVector<f64, N>)],
    ) -> (f64, SVector<f64, N>) {
        let count = pairs.len().max(1) as f64;
        let point = pairs.iter().map(|p| p.0).sum::<SVector<f64, N>>() / count;
        let normal = pairs.iter().map(|p| p.1).sum::<SVector<f64, N>>() / count;
        let both: f64 = pairs.iter().map(|(p, n)| (p - point).dot(&(n - normal))).sum();
        let own: f64 = pairs.iter().map(|(_, n)| (n - normal).norm_squared()).sum();
        let radius = both / own;
        (radius, point - radius * normal)
    }

    /// The point of an axis of this direction, and the radius about it.
    fn circle(&self, axis: Vector) -> Option<(Point, f64)> {
        let (x, y) = plane_axes(axis);
        let flat = |v: Vector| SVector::<f64, 2>::new(v.dot(&x), v.dot(&y));
        let pairs: Vec<_> = self
            .points
            .iter()
            .zip(&self.normals)
            .map(|(p, &n)| (flat(p - self.middle), flat(n)))
            .collect();
        let (radius, centre) = Self::radius(&pairs);
        let origin = self.middle + centre.x * x + centre.y * y;
        (radius.is_finite() && radius != 0.0).then(|| (origin, radius.abs()))
    }

    fn sphere(&self) -> Option<Primitive> {
        let pairs: Vec<_> =
            self.points.iter().zip(&self.normals).map(|(p, &n)| (p - self.middle, n)).collect();
        let (radius, centre) = Self::radius(&pairs);
        (radius.is_finite() && radius != 0.0)
            .then(|| Primitive::Sphere { centre: self.middle + centre, radius: radius.abs() })
    }

    fn cone(&self, origin: Point, axis: Vector) -> Option<Primitive> {
        let origin = origin + (self.middle - origin).dot(&axis) * axis;
        let (mut lean, mut out) = (0.0, 0.0);
        for (p, n) in self.points.iter().zip(&self.normals) {
            let q = p - origin;
            lean += n.dot(&axis);
            out += n.dot(&(q - q.dot(&axis) * axis));
        }
        // The normals lean against the direction in which the cone opens, seen from outside.
        let lean = lean / self.points.len() as f64 * if out > 0.0 { -1.0 } else { 1.0 };
        let axis = if lean < 0.0 { -axis } else { axis };
        let angle = lean.abs().min(0.99).asin();
        let radius = |p: &Point| {
            let q = p - origin;
            let h = q.dot(&axis);
            (q - h * axis).norm() - h * angle.tan()
        };
        let radius = self.points.iter().map(radius).sum::<f64>() / self.points.len() as f64;
        (angle > 0.0 && radius > 0.0).then_some(Primitive::Cone { origin, axis, radius, angle })
    }

    /// Lines that all normals come near to meeting (Pottmann, Randrup, "Rotational and helical surface approximation
    /// for reverse engineering", 1998).
    fn complex_axes(&self) -> impl Iterator<Item = (Point, Vector)> + use<> {
        let mut matrix = SMatrix::<f64, 6, 6>::zeros();
        for (p, n) in self.points.iter().zip(&self.normals) {
            let m = ((p - self.middle) / self.size).cross(n);
            let row = SVector::<f64, 6>::from_column_slice(&[n.x, n.y, n.z, m.x, m.y, m.z]);
            matrix += row * row.transpose();
        }
        let eigen = matrix.symmetric_eigen();
        let mut order = [0, 1, 2, 3, 4, 5];
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let (middle, size) = (self.middle, self.size);
        order.into_iter().take(2).filter_map(move |k| {
            let column = eigen.eigenvectors.column(k);
            let moment = Vector::new(column[0], column[1], column[2]);
            let along = Vector::new(column[3], column[4], column[5]);
            let axis = along.try_normalize(LEAST_AXIS)?;
            Some((middle + along.cross(&moment) * (size / along.norm_squared()), axis))
        })
    }

    fn torus(&self, origin: Point, axis: Vector) -> Option<Primitive> {
        let meridian = |(p, n): (&Point, &Vector)| {
            let q = p - origin;
            let h = q.dot(&axis);
            let out = q - h * axis;
            let rho = out.norm();
            let across = n.dot(&out) / rho.max(f64::MIN_POSITIVE);
            (SVector::<f64, 2>::new(rho, h), SVector::<f64, 2>::new(across, n.dot(&axis)))
        };
        let pairs: Vec<_> = self.points.iter().zip(&self.normals).map(meridian).collect();
        let (radius, centre) = Self::radius(&pairs);
        let minor = radius.abs();
        (minor > 0.0 && centre.x > minor).then(|| Primitive::Torus {
            centre: origin + centre.y * axis,
            axis,
            major: centre.x,
            minor,
        })
    }
}

impl Quadric {
    fn new(points: &[Point], normals: &[Vector], middle: Point, size: f64) -> Option<Self> {
        let normal = normals.iter().sum::<Vector>().try_normalize(0.0)?;
        let (x, y) = plane_axes(normal);
        let mut matrix = SMatrix::<f64, 6, 6>::zeros();
        let mut right = SVector::<f64, 6>::zeros();
        for p in points {
            let q = (p - middle) / size;
            let (u, v) = (q.dot(&x), q.dot(&y));
            let row = SVector::<f64, 6>::from_column_slice(&[1.0, u, v, u * u, u * v, v * v]);
            matrix += row * row.transpose();
            right += q.dot(&normal) * row;
        }
        let c = matrix.cholesky()?.solve(&right);
        let leaning = (normal - c[1] * x - c[2] * y).normalize();
        let along = (x + c[1] * normal).normalize();
        let across = leaning.cross(&along);
        let (xx, xy, yy) = (2.0 * c[3] / size, c[4] / size, 2.0 * c[5] / size);
        let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = turn.sin_cos();
        let first = xx * cos * cos + 2.0 * xy * cos * sin + yy * sin * sin;
        let mut curvatures =
            [(first, along * cos + across * sin), (xx + yy - first, across * cos - along * sin)];
        if curvatures[1].0.abs() > curvatures[0].0.abs() {
            curvatures.swap(0, 1);
        }
        let place = middle + size * c[0] * normal;
        Some(Quadric { place, normal: leaning, curvatures })
    }

    fn is_bent(&self, size: f64) -> bool {
        self.curvatures[0].0.abs() * size > LEAST_CURVATURE
    }

    /// Tori with these curvatures. One is that of the tube, the other fixes the axis' distance but not its direction.
    fn tori(&self) -> Vec<Primitive> {
        let mut all = Vec::new();
        for [tube, ring] in [[0, 1], [1, 0]] {
            let (bend, along) = self.curvatures[tube];
            let other = self.curvatures[ring].0;
            for angle in MERIDIANS {
                let axis = along * angle.cos() + self.normal * angle.sin();
                let middle = self.place + self.normal / bend;
                let on_axis = self.place + self.normal / other;
                let q = middle - on_axis;
                let centre = on_axis + q.dot(&axis) * axis;
                let (major, minor) = ((middle - centre).norm(), bend.abs().recip());
                if major > minor && major.is_finite() {
                    all.push(Primitive::Torus { centre, axis, major, minor });
                }
            }
        }
        all
    }
}

/// The eigenvectors of a symmetric matrix, the least first.
fn axes_of(matrix: Matrix3<f64>) -> [Vector; 3] {
    let eigen = matrix.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    order.map(|i| eigen.eigenvectors.column(i).into_owned())
}
