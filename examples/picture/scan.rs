//! Pictures of the scan's mesh.

use scan2step::mesh::Mesh;
use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::canvas::Canvas;
use scan2step::report::picture::colour::plaster;
use scan2step::report::picture::{occlusion, sheet};

/// A mesh in the colour of plaster.
pub fn canvas(mesh: &Mesh, camera: &Camera, size: [usize; 2]) -> Canvas {
    let material = plaster();
    let mut canvas = Canvas::new(size);
    sheet::draw(&mut canvas, mesh, camera, |_, _, normal, front| material.lit(normal, front));
    occlusion::darken(&mut canvas);
    canvas
}
