//! The measured mesh.

use scan2step::picture::camera::Camera;
use scan2step::picture::canvas::Canvas;
use scan2step::picture::colour::plaster;
use scan2step::picture::image::Image;
use scan2step::picture::{occlusion, sheet};

use crate::scene::Scene;

/// The scan in plaster.
pub fn picture(scene: &Scene, camera: &Camera, size: [usize; 2]) -> Image {
    let material = plaster();
    let mut canvas = Canvas::new(size);
    sheet::draw(&mut canvas, &scene.measured.mesh, camera, |_, _, normal, front| {
        material.lit(normal, front)
    });
    occlusion::darken(&mut canvas);
    canvas.image()
}
