//! A trim loop on the face and the rim that it follows.

use crate::face;
use crate::scene::Scene;
use crate::stages::around_hole;
use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::canvas::Canvas;
use scan2step::report::picture::colour::{linear, srgb};
use scan2step::report::picture::image::Image;
use scan2step::report::picture::lines::{Lines, Pen};

/// The face around a hole with the smoothed vertices of the rim.
pub fn picture(scene: &Scene, size: [usize; 2]) -> Image {
    let camera = around_hole(scene, size, 1.35);
    let mut canvas = Canvas::new(size);
    face::draw(&mut canvas, scene, &camera);
    let dots = rims(&canvas, scene, &camera);
    dots.ink(&mut canvas, linear(srgb(0xb3261e)));
    canvas.image()
}

fn rims(canvas: &Canvas, scene: &Scene, camera: &Camera) -> Lines {
    let mesh = &scene.smoothed.mesh;
    // The tolerance is less than the size of a dot, but vertices may lie below the face.
    let pen = Pen { sunk: 8.0, ..Pen::solid(5.0) };
    let mut lines = Lines::over(canvas);
    for &v in scene.smoothed.holes.iter().flatten() {
        lines.point(canvas, camera.project(&mesh.point(v)), pen);
    }
    lines
}
