//! The trimmed face with and without its control net.

use rayon::prelude::*;
use scan2step::geometry::{Point, Uv, Vector};

use crate::scene::Scene;
use crate::trimmed::CutOut;
use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::canvas::{Canvas, SAMPLES, shows_front};
use scan2step::report::picture::colour::{INK, lacquer, linear, srgb};
use scan2step::report::picture::image::Image;
use scan2step::report::picture::lines::{Lines, Pen};
use scan2step::report::picture::occlusion;

/// The number of cells of the tessellation in u and in v.
const CELLS: usize = 640;

const EDGE: Pen = Pen::solid(2.1);

/// The net is drawn in front of the face if it is behind it by less than this share of the
/// picture's height. It stays near the face on both sides and would be visible only in pieces
/// otherwise.
const SUNK: f64 = 0.04;

/// The face with its edges.
pub fn picture(scene: &Scene, camera: &Camera, size: [usize; 2]) -> Image {
    let mut canvas = Canvas::new(size);
    draw(&mut canvas, scene, camera);
    canvas.image()
}

/// The face with its edges and its control net.
pub fn picture_with_net(scene: &Scene, camera: &Camera, size: [usize; 2]) -> Image {
    let mut canvas = Canvas::new(size);
    draw(&mut canvas, scene, camera);
    net(&canvas, scene, camera).ink(&mut canvas, linear(srgb(0xb3261e)));
    canvas.image()
}

/// Draws the face with its edges.
pub fn draw(canvas: &mut Canvas, scene: &Scene, camera: &Camera) {
    sheet(canvas, scene, camera);
    occlusion::darken(canvas);
    edges(canvas, scene, camera).ink(canvas, linear(INK));
}

/// A corner of the tessellation.
struct Corner {
    uv: Uv,
    at: Vector,
    normal: Vector,
}

fn sheet(canvas: &mut Canvas, scene: &Scene, camera: &Camera) {
    let cut = CutOut::new(&scene.loops(), scene.surface().v.range());
    let corners = tessellation(scene, camera);
    let material = lacquer();
    for i in 0..CELLS {
        for j in 0..CELLS {
            let at = |di: usize, dj: usize| &corners[(i + di) * (CELLS + 1) + j + dj];
            for t in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                let places = t.map(|c| c.at);
                let front = shows_front(places);
                canvas.triangle(places, |w| {
                    // The loop decides which points are omitted, not the ends of triangles.
                    if cut.contains(Uv::from(blend(w, t.map(|c| c.uv.coords)))) {
                        return None;
                    }
                    let normal = blend(w, t.map(|c| c.normal));
                    let normal = normal.try_normalize(0.0).unwrap_or_else(Vector::z);
                    Some(material.lit(normal, front))
                });
            }
        }
    }
}

fn tessellation(scene: &Scene, camera: &Camera) -> Vec<Corner> {
    let surface = scene.surface();
    let along = |(from, to): (f64, f64), i: usize| from + (to - from) * i as f64 / CELLS as f64;
    let corner = |n: usize| {
        let (i, j) = (n / (CELLS + 1), n % (CELLS + 1));
        let uv = Uv::new(along(surface.u.range(), i), along(surface.v.range(), j));
        let jet = surface.jet(uv);
        let normal = jet.su.cross(&jet.sv).try_normalize(0.0).unwrap_or_else(Vector::zeros);
        Corner { uv, at: camera.project(&jet.s), normal: camera.turn(&normal) }
    };
    (0..(CELLS + 1) * (CELLS + 1)).into_par_iter().map(corner).collect()
}

fn blend<const D: usize>(
    w: [f64; 3],
    of: [nalgebra::SVector<f64, D>; 3],
) -> nalgebra::SVector<f64, D> {
    of[0] * w[0] + of[1] * w[1] + of[2] * w[2]
}

/// The four sides of the patch and the trim curves.
fn edges(canvas: &Canvas, scene: &Scene, camera: &Camera) -> Lines {
    let mut lines = Lines::over(canvas);
    for edge in scene.edges() {
        lines.polyline(canvas, edge.iter().map(|p| camera.project(p)), EDGE);
    }
    for outline in scene.loops() {
        let closed = outline.iter().chain(outline.first());
        let on_face = closed.map(|&uv| camera.project(&scene.surface().point(uv)));
        lines.polyline(canvas, on_face, EDGE);
    }
    lines
}

/// The control net, which is faint behind the face.
fn net(canvas: &Canvas, scene: &Scene, camera: &Camera) -> Lines {
    let surface = scene.surface();
    let [m, n] = surface.shape();
    let at = |i: usize, j: usize| camera.project(&Point::from(surface.control(i, j)));
    // Full lines of a net with hundreds of rows would hide everything.
    let width = (80.0 / m.max(n) as f64).clamp(0.4, 1.5);
    let sunk = SUNK * (canvas.height / SAMPLES) as f64;
    let pen = Pen { width, seen: 0.95, hidden: 0.12, sunk };
    let mut lines = Lines::over(canvas);
    for i in 0..m {
        lines.polyline(canvas, (0..n).map(|j| at(i, j)), pen);
    }
    for j in 0..n {
        lines.polyline(canvas, (0..m).map(|i| at(i, j)), pen);
    }
    for k in 0..m * n {
        lines.point(canvas, at(k / n, k % n), Pen { width: 3.0 * width, ..pen });
    }
    lines
}
