//! Where to look from, chosen from the data.

use super::canvas::{Canvas, shows_front};
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

/// The angle for what is only seen from nearly straight on: enough for relief to show.
const STRAIGHT_TILT: f64 = 0.2;

/// The share of the outer side among what is seen with which a view is taken. Where a sheet
/// curls, some of its inner side may show.
const MOSTLY: f64 = 0.75;

/// Pixels of the small picture in which the outer side is counted.
const PREVIEW: [usize; 2] = [120, 90];

/// How far pictures from aside are turned from the large one: an eighth of a turn, less a little.
const TURN: f64 = 0.7;

/// The shares of that turn that are tried.
const TURN_SHARES: [f64; 3] = [1.0, 0.6, 0.3];

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
        Camera::of(best_view(mesh, size), extent, size)
    }

    /// An isometric camera for parts, as in drawings: from the front, the right and above, where z points up.
    pub(crate) fn isometric(extent: impl Iterator<Item = Point>, size: [usize; 2]) -> Camera {
        let eye = Vector::new(1.0, -1.0, 1.0).normalize();
        let right = Vector::z().cross(&eye).normalize();
        Camera::of(View { right, up: eye.cross(&right), eye }, extent, size)
    }

    fn of(view: View, extent: impl Iterator<Item = Point>, size: [usize; 2]) -> Camera {
        let (low, high) = view.bounds(extent);
        Camera { view, scale: scale(high - low, size), middle: 0.5 * (low + high), size }
    }

    /// Two cameras in pictures of `size` pixels, to the left and to the right of this one, that have
    /// `extent`. They are turned less where they would see the inner side of the mesh.
    pub(crate) fn asides(&self, mesh: &Mesh, extent: &[Point], size: [usize; 2]) -> [Camera; 2] {
        [-1.0, 1.0].map(|side| {
            let turned = |share: f64| self.aside(side * share * TURN, extent, size);
            let outer = |camera: &Camera| {
                outer_share(mesh, &Camera::of(camera.view, extent.iter().copied(), PREVIEW))
            };
            let mut tries = TURN_SHARES.map(turned).into_iter();
            tries.find(|camera| outer(camera) > MOSTLY).unwrap_or_else(|| turned(1.0))
        })
    }

    /// The same camera from aside, turned by an angle around what is upright in
    /// the picture, and with `extent` in a picture of `size` pixels.
    fn aside(&self, angle: f64, extent: &[Point], size: [usize; 2]) -> Camera {
        let View { right, up, eye } = self.view;
        let eye = angle.cos() * eye + angle.sin() * right;
        let view = View { right: up.cross(&eye), up, eye };
        Camera::of(view, extent.iter().copied(), size)
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
    fn new(normal: Vector, flatness: f64) -> Facing {
        let tilt = TILT + CURLED_TILT * (1.0 - flatness).powi(2);
        // What stands is best seen in three-quarter view, what lies from the
        // front; nearest to lying is what faces up.
        let sideways = 0.7 - 0.45 * normal.y.abs();
        Facing { normal, tilt, sideways }
    }

    /// The directions to look from in turn: that of the mean normal with the tilt that suits it,
    /// then nearly straight on, as into a bowl, then from the other sides.
    fn in_turn(mesh: &Mesh) -> Vec<Facing> {
        let (normal, flatness) = mean_normal(mesh);
        let straight = |normal| Facing { tilt: STRAIGHT_TILT, ..Facing::new(normal, flatness) };
        let axes = [normal, Vector::x(), Vector::y(), Vector::z()];
        let sides = axes.into_iter().flat_map(|axis| [axis, -axis]).map(straight);
        [normal, -normal].map(|n| Facing::new(n, flatness)).into_iter().chain(sides).collect()
    }
}

/// Pixels for a millimetre at which a box fits the picture.
fn scale(extent: Vector, size: [usize; 2]) -> f64 {
    let [width, height] = size.map(|n| n as f64);
    let margin = 2.0 * MARGIN * width.min(height);
    let fit = ((width - margin) / extent.x).min((height - margin) / extent.y);
    if fit.is_finite() { fit } else { 1.0 }
}

/// The view from the first direction that mostly shows the outer side of the mesh, or else from the
/// one that shows most of it.
fn best_view(mesh: &Mesh, size: [usize; 2]) -> View {
    let step = mesh.points.len().div_ceil(PROBES).max(1);
    let probes: Vec<Point> = mesh.points.iter().copied().step_by(step).collect();
    let mut best: Option<(f64, View)> = None;
    for facing in Facing::in_turn(mesh) {
        let view = best_turn(&facing, &probes, size);
        let share = outer_share(mesh, &Camera::of(view, mesh.points.iter().copied(), PREVIEW));
        if share > MOSTLY {
            return view;
        }
        if best.is_none_or(|(most, _)| share > most) {
            best = Some((share, view));
        }
    }
    best.map_or_else(|| best_turn(&Facing::new(Vector::z(), 1.0), &probes, size), |(_, view)| view)
}

/// The share of what is seen of a mesh that is its outer side.
fn outer_share(mesh: &Mesh, camera: &Camera) -> f64 {
    let mut canvas = Canvas::new(camera.size);
    let (outer, inner) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    for &t in &mesh.triangles {
        let places = mesh.corners(t).map(|p| camera.project(&p));
        let paint = if shows_front(places) { outer } else { inner };
        canvas.triangle(places, |_| Some(paint));
    }
    let count = |paint| canvas.colour.iter().filter(|c| **c == paint).count() as f64;
    count(outer) / (count(outer) + count(inner)).max(1.0)
}

/// The turn of the picture that shows the mesh largest, with a bonus for one in which up is
/// up. Sides of its smallest rectangle, or axes of the scan's coordinates,
/// stand vertical in it: a diagonal view would fit more, but look fallen over.
fn best_turn(facing: &Facing, probes: &[Point], size: [usize; 2]) -> View {
    let upright = upright(facing.normal);
    let world = upright - upright.dot(&facing.normal) * facing.normal;
    let mut best = (f64::NEG_INFINITY, View::onto(facing, world.normalize()));
    for side in [world.normalize(), rectangle_side(probes, facing.normal)] {
        let across = facing.normal.cross(&side);
        for north in [side, across, -side, -across] {
            let view = View::onto(facing, north);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::VertexId;

    /// A part of a sphere around z: from the pole to an angle. Its normals point away from the middle.
    fn bowl(angle: f64) -> Mesh {
        const ROWS: usize = 20;
        const COLUMNS: usize = 40;
        let place = |k: usize| {
            let down = angle * ((k / COLUMNS) as f64 + 0.01) / ROWS as f64;
            let around = std::f64::consts::TAU * (k % COLUMNS) as f64 / COLUMNS as f64;
            Point::new(down.sin() * around.cos(), down.sin() * around.sin(), -down.cos())
        };
        let triangles = (0..ROWS * COLUMNS).flat_map(|k| {
            let next = k / COLUMNS * COLUMNS + (k + 1) % COLUMNS;
            let [a, b, c, d] = [k, next, next + COLUMNS, k + COLUMNS].map(VertexId::from);
            [[a, b, c], [a, c, d]]
        });
        let triangles: Vec<_> = triangles.collect();
        Mesh { points: (0..(ROWS + 1) * COLUMNS).map(place).collect(), triangles }
    }

    fn outer_share_of(mesh: &Mesh) -> f64 {
        let camera = Camera::facing(mesh, mesh.points.iter().copied(), [600, 400]);
        outer_share(mesh, &Camera::of(camera.view, mesh.points.iter().copied(), PREVIEW))
    }

    #[test]
    fn pictures_from_aside_show_the_same_side() {
        // A sheet that is seen from far aside, as one that curls is.
        let mesh = bowl(0.1);
        let camera = Camera::of(
            View::onto(&Facing { normal: -Vector::z(), tilt: 1.1, sideways: 1.0 }, Vector::y()),
            mesh.points.iter().copied(),
            PREVIEW,
        );
        let plain = [-TURN, TURN].map(|turn| camera.aside(turn, &mesh.points, PREVIEW));
        assert!(plain.iter().any(|camera| outer_share(&mesh, camera) < 0.1));
        for camera in camera.asides(&mesh, &mesh.points, PREVIEW) {
            assert!(outer_share(&mesh, &camera) > MOSTLY);
        }
    }

    #[test]
    fn a_sheet_is_seen_from_the_side_that_its_normals_face() {
        for angle in [0.3, 1.5, 2.0, 2.6] {
            let mut mesh = bowl(angle);
            assert!(outer_share_of(&mesh) > MOSTLY, "onto a hill to {angle}");
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            // Little of the inside of a nearly closed bowl can be seen.
            let most = if angle > 2.0 { 0.2 } else { MOSTLY };
            assert!(outer_share_of(&mesh) > most, "into a bowl to {angle}");
        }
    }
}
