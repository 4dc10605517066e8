//! The measured mesh.

use scan2step::geometry::Vector;

use crate::camera::Camera;
use crate::canvas::{Canvas, shows_front};
use crate::colour::{Rgb, plaster};
use crate::image::Image;
use crate::lines::{Lines, Pen};
use crate::occlusion;
use crate::scene::Scene;

/// The scan in plaster, every triangle flat so that noise shows.
pub fn picture(scene: &Scene, camera: &Camera, size: [usize; 2]) -> Image {
    let material = plaster();
    draw(scene, camera, size, |_, _, normal, front| material.lit(normal, front)).image()
}

/// Draws the scan. `paint` has a triangle's number, the barycentric
/// coordinates in it, its normal in camera coordinates, and whether the outer
/// side is seen.
pub fn draw(
    scene: &Scene,
    camera: &Camera,
    size: [usize; 2],
    paint: impl Fn(usize, [f64; 3], Vector, bool) -> Rgb,
) -> Canvas {
    let mesh = &scene.measured.mesh;
    let mut canvas = Canvas::new(size);
    for (number, &t) in mesh.triangles.iter().enumerate() {
        let places = mesh.corners(t).map(|p| camera.project(&p));
        let front = shows_front(places);
        let Some(normal) = camera.turn(&mesh.area_vector(t)).try_normalize(0.0) else { continue };
        canvas.triangle(places, |w| Some(paint(number, w, normal, front)));
    }
    occlusion::darken(&mut canvas);
    canvas
}

/// The mesh's boundary loops.
pub fn rims(canvas: &Canvas, scene: &Scene, camera: &Camera, pen: Pen) -> Lines {
    let mut lines = Lines::over(canvas);
    for rim in scene.measured.loops() {
        let closed = rim.iter().chain(rim.first());
        let places = closed.map(|&v| camera.project(&scene.measured.mesh.point(v)));
        lines.polyline(canvas, places, pen);
    }
    lines
}
