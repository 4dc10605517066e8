//! Where to look from, chosen from the data.

use crate::geometry::{Point, Vector, plane_axes};
use crate::mesh::Mesh;
use nalgebra::SymmetricEigen;

/// An orthographic camera.
#[derive(Debug, Clone)]
pub struct Camera {
    view: View,
    /// Pixels for a millimetre.
    scale: f64,
    /// What stands in the middle of the picture, in camera coordinates.
    middle: Vector,
    size: [usize; 2],
}

/// A right-handed frame: to the right, up, and towards the eye.
#[derive(Debug, Clone, Copy)]
struct View {
    right: Vector,
    up: Vector,
    eye: Vector,
}

/// Angle between the direction of view and the mean normal of a flat sheet.
/// Seen straight on, relief is flat; seen from far aside, it hides itself.
const TILT: f64 = 0.47;

/// What the angle grows by for a sheet that curls around the eye: straight on,
/// only the crown of a bust would be seen.
const CURLED_TILT: f64 = 0.5;

/// Share of the picture's shorter side that stays free on every side.
const MARGIN: f64 = 0.05;

/// How much of the picture's scale an upright view is worth.
const UPRIGHT_BONUS: f64 = 0.35;

/// Points that the choice of the view looks at.
const PROBES: usize = 3000;

impl Camera {
    /// A camera that faces the mesh and has `extent` in a picture of `size`
    /// pixels.
    pub fn facing(mesh: &Mesh, extent: impl Iterator<Item = Point>, size: [usize; 2]) -> Camera {
        let view = best_view(mesh, size);
        let (low, high) = view.bounds(extent);
        Camera { view, scale: scale(high - low, size), middle: 0.5 * (low + high), size }
    }

    /// The same camera from aside, turned by an angle around what is upright in
    /// the picture, and with `extent` in a picture of `size` pixels.
    pub fn aside(
        &self,
        angle: f64,
        extent: impl Iterator<Item = Point>,
        size: [usize; 2],
    ) -> Camera {
        let View { right, up, eye } = self.view;
        let eye = angle.cos() * eye + angle.sin() * right;
        let view = View { right: up.cross(&eye), up, eye };
        let (low, high) = view.bounds(extent);
        Camera { view, scale: scale(high - low, size), middle: 0.5 * (low + high), size }
    }

    /// To the right, up, and towards the eye: unit vectors.
    pub fn axes(&self) -> [Vector; 3] {
        [self.view.right, self.view.up, self.view.eye]
    }

    /// A vector in camera coordinates: x to the right, y up, z towards the eye.
    pub fn turn(&self, v: &Vector) -> Vector {
        self.view.turn(v)
    }

    /// Where a point is in the picture: x to the right, y down, depth away from
    /// the eye, all in pixels.
    pub fn project(&self, p: &Point) -> Vector {
        let at = self.scale * (self.turn(&p.coords) - self.middle);
        let [width, height] = self.size.map(|n| 0.5 * n as f64);
        Vector::new(width + at.x, height - at.y, -at.z)
    }
}

impl View {
    fn turn(&self, v: &Vector) -> Vector {
        Vector::new(v.dot(&self.right), v.dot(&self.up), v.dot(&self.eye))
    }

    fn bounds(&self, points: impl Iterator<Item = Point>) -> (Vector, Vector) {
        let start = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
        points
            .map(|p| self.turn(&p.coords))
            .fold(start, |(low, high), p| (low.inf(&p), high.sup(&p)))
    }

    /// The view from the direction `facing` in which its direction `north`
    /// points upwards.
    fn onto(facing: &Facing, north: Vector) -> View {
        let n = facing.normal;
        let west = n.cross(&north);
        let aside = (facing.sideways * west - (1.0 - facing.sideways) * north).normalize();
        let eye = facing.tilt.cos() * n + facing.tilt.sin() * aside;
        let right = north.cross(&eye).normalize();
        View { right, up: eye.cross(&right), eye }
    }
}

/// From where a mesh is looked at, but for the turn of the picture.
struct Facing {
    normal: Vector,
    tilt: f64,
    /// Which share of the tilt is sideways; the rest is downwards.
    sideways: f64,
}

impl Facing {
    fn new(mesh: &Mesh) -> Facing {
        let (normal, flatness) = mean_normal(mesh);
        let tilt = TILT + CURLED_TILT * (1.0 - flatness).powi(2);
        // What stands is best seen in three-quarter view, what lies from the
        // front; nearest to lying is what faces up.
        let sideways = 0.7 - 0.45 * normal.y.abs();
        Facing { normal, tilt, sideways }
    }
}

/// Pixels for a millimetre at which a box fits the picture.
fn scale(extent: Vector, size: [usize; 2]) -> f64 {
    let [width, height] = size.map(|n| n as f64);
    let margin = 2.0 * MARGIN * width.min(height);
    let fit = ((width - margin) / extent.x).min((height - margin) / extent.y);
    if fit.is_finite() { fit } else { 1.0 }
}

/// The view that shows the mesh largest, with a bonus for one in which up is
/// up. Sides of its smallest rectangle, or axes of the scan's coordinates,
/// stand vertical in it: a diagonal view would fit more, but look fallen over.
fn best_view(mesh: &Mesh, size: [usize; 2]) -> View {
    let facing = Facing::new(mesh);
    let step = mesh.points.len().div_ceil(PROBES).max(1);
    let probes: Vec<Point> = mesh.points.iter().copied().step_by(step).collect();
    let upright = upright(facing.normal);
    let world = upright - upright.dot(&facing.normal) * facing.normal;
    let mut best = (f64::NEG_INFINITY, View::onto(&facing, world.normalize()));
    for side in [world.normalize(), rectangle_side(&probes, facing.normal)] {
        let across = facing.normal.cross(&side);
        for north in [side, across, -side, -across] {
            let view = View::onto(&facing, north);
            let (low, high) = view.bounds(probes.iter().copied());
            let score = scale(high - low, size) * (1.0 + UPRIGHT_BONUS * north.dot(&upright));
            if score > best.0 {
                best = (score, view);
            }
        }
    }
    best.1
}

/// Direction of a side of the smallest rectangle around the points, seen along
/// `n`, to a degree.
fn rectangle_side(points: &[Point], n: Vector) -> Vector {
    let (x, y) = plane_axes(n);
    let mut best = (f64::INFINITY, y);
    for degree in 0..90 {
        let angle = f64::from(degree).to_radians();
        let up = angle.cos() * x + angle.sin() * y;
        let (low, high) = View { right: up.cross(&n), up, eye: n }.bounds(points.iter().copied());
        let area = (high.x - low.x) * (high.y - low.y);
        if area < best.0 {
            best = (area, up);
        }
    }
    best.1
}

/// The mean normal and, from 0 to 1, how much the normals agree. For a mesh
/// that closes so far that they cancel, the direction in which it extends least.
fn mean_normal(mesh: &Mesh) -> (Vector, f64) {
    let areas = mesh.triangles.iter().map(|&t| mesh.area_vector(t));
    let (sum, total) =
        areas.fold((Vector::zeros(), 0.0), |(sum, total), a| (sum + a, total + a.norm()));
    if sum.norm() > 0.1 * total {
        return (sum.normalize(), sum.norm() / total);
    }
    let count = mesh.points.len().max(1) as f64;
    let mean = mesh.points.iter().fold(Vector::zeros(), |sum, p| sum + p.coords) / count;
    let spread = mesh.points.iter().map(|p| p.coords - mean).map(|d| d * d.transpose()).sum();
    let axes = SymmetricEigen::<f64, nalgebra::Const<3>>::new(spread);
    let least = axes.eigenvalues.imin();
    (axes.eigenvectors.column(least).into(), 0.0)
}

/// The direction that most likely is up in a view along `n`: y, as most scans
/// have it; for one along y, z or its opposite.
fn upright(n: Vector) -> Vector {
    match n.y {
        y if y > 0.8 => -Vector::z(),
        y if y < -0.8 => Vector::z(),
        _ => Vector::y(),
    }
}
