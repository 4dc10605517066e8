//! Starts of fits: surfaces that come near a few points with normals.

use nalgebra::{SMatrix, SVector};

use super::{Primitive, PrimitiveKind};
use crate::geometry::{Point, Uv, Vector, plane_axes};

/// A piece of the data with a normal: a facet, or the surroundings of a vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OrientedPoint {
    /// Its middle.
    pub centre: Point,
    /// Its unit normal.
    pub normal: Vector,
    /// Its area.
    pub area: f64,
}

type Matrix3 = nalgebra::Matrix3<f64>;

/// A cone whose normals lean less against its plane of symmetry starts as a cylinder.
const LEAST_LEAN: f64 = 1e-4;

/// A torus whose tube is wider than this many major radii is not started.
const WIDEST_TUBE: f64 = 5.0;

/// Starts of one kind from points and faces of the data. `axes` are directions of axes that are known
/// already. An empty list means that the kind does not come near.
pub(crate) fn starts(
    kind: PrimitiveKind,
    points: &[Point],
    faces: &[OrientedPoint],
    axes: &[Vector],
) -> Vec<Primitive> {
    match kind {
        PrimitiveKind::Plane => plane(points, faces).into_iter().collect(),
        PrimitiveKind::Sphere => sphere(points).into_iter().collect(),
        PrimitiveKind::Cylinder => {
            let axis = [principal(faces, false)[0]];
            axis.iter().chain(axes).filter_map(|&a| cylinder(points, a)).collect()
        }
        PrimitiveKind::Cone => {
            let axis = [principal(faces, true)[0]];
            axis.iter().chain(axes).filter_map(|&a| cone(points, faces, a)).collect()
        }
        PrimitiveKind::Torus => torus(points, faces, axes),
    }
}

/// The surface of revolution of a kind about a known line that comes near the data.
pub(crate) fn with_axis(
    kind: PrimitiveKind,
    points: &[Point],
    origin: Point,
    axis: Vector,
) -> Option<Primitive> {
    let meridian: Vec<Uv> = points
        .iter()
        .map(|&p| {
            let (h, rho, _) = super::primitive::cylindrical(origin, axis, p);
            Uv::new(rho, h)
        })
        .collect();
    let mean = |f: fn(&Uv) -> f64| meridian.iter().map(f).sum::<f64>() / meridian.len() as f64;
    let [rho, h] = [mean(|m| m.x), mean(|m| m.y)];
    match kind {
        PrimitiveKind::Cylinder => Some(Primitive::Cylinder { origin, axis, radius: rho }),
        PrimitiveKind::Cone => {
            let (mut a, mut b) = (0.0, 0.0);
            for m in &meridian {
                a += (m.x - rho) * (m.y - h);
                b += (m.y - h) * (m.y - h);
            }
            let slope = a / b;
            let up = if slope < 0.0 { -axis } else { axis };
            let angle = slope.abs().atan();
            let origin = origin + h * axis;
            (angle > 0.0 && angle.is_finite()).then_some(Primitive::Cone {
                origin,
                axis: up,
                radius: rho,
                angle,
            })
        }
        PrimitiveKind::Torus => {
            let (middle, minor) = circle_through(&meridian)?;
            let centre = origin + middle.y * axis;
            (middle.x > 0.0).then_some(Primitive::Torus { centre, axis, major: middle.x, minor })
        }
        PrimitiveKind::Plane | PrimitiveKind::Sphere => None,
    }
}

fn plane(points: &[Point], faces: &[OrientedPoint]) -> Option<Primitive> {
    let origin = middle(points);
    let normal = faces.iter().map(|f| f.area * f.normal).sum::<Vector>().try_normalize(0.0)?;
    Some(Primitive::Plane { origin, normal })
}

fn middle(points: &[Point]) -> Point {
    let sum: Vector = points.iter().map(|p| p.coords).sum();
    Point::from(sum / points.len().max(1) as f64)
}

/// The eigenvectors of the normals' second moments, the least first; `about_mean` takes off the mean.
fn principal(faces: &[OrientedPoint], about_mean: bool) -> [Vector; 3] {
    let area: f64 = faces.iter().map(|f| f.area).sum();
    let mean = faces.iter().map(|f| f.area * f.normal).sum::<Vector>() / area;
    let mut moments = Matrix3::zeros();
    for f in faces {
        let n = if about_mean { f.normal - mean } else { f.normal };
        moments += f.area * n * n.transpose();
    }
    let eigen = moments.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    order.map(|i| eigen.eigenvectors.column(i).into_owned())
}

/// The circle that comes nearest to points of the plane in the algebraic sense.
fn circle_through(points: &[Uv]) -> Option<(Uv, f64)> {
    let n = points.len() as f64;
    let centre = points.iter().fold(Uv::origin(), |sum, p| sum + p.coords / n);
    let mut matrix = Matrix3::zeros();
    let mut right = Vector::zeros();
    let size = points.iter().map(|p| (p - centre).norm()).fold(f64::MIN_POSITIVE, f64::max);
    for p in points {
        let q = (p - centre) / size;
        let row = Vector::new(2.0 * q.x, 2.0 * q.y, 1.0);
        matrix += row * row.transpose();
        right += q.norm_squared() * row;
    }
    let s = matrix.lu().solve(&right)?;
    let square = s.z + s.x * s.x + s.y * s.y;
    let middle = centre + size * s.xy();
    (square > 0.0 && square.is_finite()).then(|| (middle, size * square.sqrt()))
}

fn sphere(points: &[Point]) -> Option<Primitive> {
    let centre = middle(points);
    let size = points.iter().map(|p| (p - centre).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let mut matrix = SMatrix::<f64, 4, 4>::zeros();
    let mut right = SVector::<f64, 4>::zeros();
    for p in points {
        let q = (p - centre) / size;
        let row = SVector::<f64, 4>::new(2.0 * q.x, 2.0 * q.y, 2.0 * q.z, 1.0);
        matrix += row * row.transpose();
        right += q.norm_squared() * row;
    }
    let s = matrix.lu().solve(&right)?;
    let square = s[3] + s.x * s.x + s.y * s.y + s.z * s.z;
    let centre = centre + size * Vector::new(s.x, s.y, s.z);
    (square > 0.0 && square.is_finite())
        .then(|| Primitive::Sphere { centre, radius: size * square.sqrt() })
}

fn cylinder(points: &[Point], axis: Vector) -> Option<Primitive> {
    let base = middle(points);
    let (x, y) = plane_axes(axis);
    let flat = |p: &Point| Uv::new((p - base).dot(&x), (p - base).dot(&y));
    let (c, radius) = circle_through(&points.iter().map(flat).collect::<Vec<_>>())?;
    Some(Primitive::Cylinder { origin: base + c.x * x + c.y * y, axis, radius })
}

/// The cone about a direction whose apex lies nearest to the planes of all faces.
fn cone(points: &[Point], faces: &[OrientedPoint], axis: Vector) -> Option<Primitive> {
    let base = middle(points);
    let area: f64 = faces.iter().map(|f| f.area).sum();
    let lean = faces.iter().map(|f| f.area * f.normal.dot(&axis)).sum::<f64>() / area;
    // The normals lean against the direction in which the cone opens, seen from outside.
    let (axis, angle) = (if lean > 0.0 { -axis } else { axis }, lean.abs().min(1.0).asin());
    if angle < LEAST_LEAN {
        return None;
    }
    let mut matrix = Matrix3::zeros();
    let mut right = Vector::zeros();
    for f in faces {
        matrix += f.normal * f.normal.transpose();
        right += f.normal.dot(&(f.centre - base)) * f.normal;
    }
    let apex = base + matrix.lu().solve(&right)?;
    // A bore's normals point to the axis: it opens the other way.
    let height = (base - apex).dot(&axis);
    let axis = if height < 0.0 { -axis } else { axis };
    let height = height.abs();
    let radius = height * angle.tan();
    (radius > 0.0 && radius.is_finite()).then(|| Primitive::Cone {
        origin: apex + height * axis,
        axis,
        radius,
        angle,
    })
}

/// The direction of the line that all normals come nearest to meeting (Pottmann and Wallner's linear line
/// complex).
fn complex_axis(faces: &[OrientedPoint], base: Point, size: f64) -> Option<Vector> {
    let mut matrix = SMatrix::<f64, 6, 6>::zeros();
    for f in faces {
        let m = ((f.centre - base) / size).cross(&f.normal);
        let row = SVector::<f64, 6>::from_column_slice(&[
            f.normal.x, f.normal.y, f.normal.z, m.x, m.y, m.z,
        ]);
        matrix += f.area * row * row.transpose();
    }
    let eigen = matrix.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let v = eigen.eigenvectors.column(least);
    Vector::new(v[3], v[4], v[5]).try_normalize(LEAST_LEAN)
}

fn torus(points: &[Point], faces: &[OrientedPoint], axes: &[Vector]) -> Vec<Primitive> {
    let base = middle(points);
    let size = points.iter().map(|p| (p - base).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let [least, _, most] = principal(faces, false);
    let [level, ..] = principal(faces, true);
    let complex = complex_axis(faces, base, size);
    let all = complex.into_iter().chain(axes.iter().copied()).chain([least, level, most]);
    all.filter_map(|axis| torus_about(points, faces, base, axis)).collect()
}

fn torus_about(
    points: &[Point],
    faces: &[OrientedPoint],
    base: Point,
    axis: Vector,
) -> Option<Primitive> {
    let (x, y) = plane_axes(axis);
    // The axis lies where the normals meet, seen along it.
    let mut matrix = nalgebra::Matrix2::zeros();
    let mut right = nalgebra::Vector2::zeros();
    for f in faces {
        let n = nalgebra::Vector2::new(-f.normal.dot(&y), f.normal.dot(&x));
        let c = nalgebra::Vector2::new((f.centre - base).dot(&x), (f.centre - base).dot(&y));
        matrix += f.area * n * n.transpose();
        right += f.area * n.dot(&c) * n;
    }
    let c = matrix.lu().solve(&right)?;
    let origin = base + c.x * x + c.y * y;
    let found = with_axis(PrimitiveKind::Torus, points, origin, axis)?;
    let Primitive::Torus { major, minor, .. } = found else { return None };
    (minor < WIDEST_TUBE * major && major.is_finite()).then_some(found)
}
