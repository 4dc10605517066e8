//! Pictures of the first stages: the mesh with its rims, smoothed, filled, and mapped.

use scan2step::geometry::Point;
use scan2step::mesh::{Disk, FaceOrigin, Mesh};

use crate::scan;
use crate::scene::Scene;
use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::canvas::Canvas;
use scan2step::report::picture::colour::{INK, linear, srgb};
use scan2step::report::picture::image::Image;
use scan2step::report::picture::lines::{Lines, Pen};
use scan2step::report::picture::{occlusion, sheet};

const OUTER: [u8; 3] = srgb(0x1f5fae);
const HOLE: [u8; 3] = srgb(0xb3261e);
const MEASURED: [u8; 3] = srgb(0xe9e4da);
/// The colour of fills.
pub const FILLED: [u8; 3] = srgb(0xf2b36b);

const RIM: Pen = Pen::solid(3.0);

/// The measured mesh. Its outer boundary is blue, and the rims of holes are red.
pub fn mesh(scene: &Scene, size: [usize; 2]) -> Image {
    let disk = &scene.measured;
    let camera = Camera::facing(&disk.mesh, scene.extent(), size);
    let mut canvas = scan::canvas(&disk.mesh, &camera, size);
    let rims = |loops: Vec<_>| sheet::rims(&canvas, &disk.mesh, loops.into_iter(), &camera, RIM);
    let (holes, outer) = (rims(disk.holes.iter().collect()), rims(vec![&disk.outer]));
    holes.ink(&mut canvas, linear(HOLE));
    outer.ink(&mut canvas, linear(OUTER));
    canvas.image()
}

/// The measured mesh on the left and the smoothed mesh on the right, around a hole.
pub fn smooth(scene: &Scene, [width, height]: [usize; 2]) -> Image {
    let half = [width / 2, height];
    let camera = around_hole(scene, half, 2.5);
    let picture = |disk: &Disk| scan::canvas(&disk.mesh, &camera, half).image();
    picture(&scene.measured).beside(picture(&scene.smoothed))
}

/// A filled hole with the sides of all triangles.
pub fn fill(scene: &Scene, size: [usize; 2]) -> Image {
    let patch = &scene.map.patch;
    let camera = around_hole(scene, size, 1.35);
    let paint = [MEASURED, FILLED].map(linear);
    let mut canvas = Canvas::new(size);
    sheet::draw(&mut canvas, &patch.mesh, &camera, |number, _, normal, _| {
        let filled = patch.origin[number] != FaceOrigin::Measured;
        let light = 0.45 + 0.55 * normal.z.abs() as f32;
        paint[usize::from(filled)].map(|c| c * light)
    });
    let sides = sides(&canvas, &patch.mesh, &camera);
    let rims = sheet::rims(&canvas, &patch.mesh, patch.rims.iter(), &camera, RIM);
    occlusion::darken(&mut canvas);
    sides.ink(&mut canvas, linear(INK));
    rims.ink(&mut canvas, linear(HOLE));
    canvas.image()
}

fn sides(canvas: &Canvas, mesh: &Mesh, camera: &Camera) -> Lines {
    let pen = Pen { seen: 0.55, ..Pen::solid(1.0) };
    let mut lines = Lines::over(canvas);
    for &t in &mesh.triangles {
        let [a, b, c] = mesh.corners(t).map(|p| camera.project(&p));
        lines.polyline(canvas, [a, b, c, a].into_iter(), pen);
    }
    lines
}

/// A camera that shows the longest rim and `times` its size around it, or the whole mesh if there
/// is no hole.
pub fn around_hole(scene: &Scene, size: [usize; 2], times: f64) -> Camera {
    let disk = &scene.measured;
    let Some(rim) = disk.holes.iter().max_by_key(|rim| rim.len()) else {
        return Camera::facing(&disk.mesh, scene.extent(), size);
    };
    let points = || rim.iter().map(|&v| disk.mesh.point(v));
    let middle = points().fold(Point::origin(), |sum, p| sum + p.coords / rim.len() as f64);
    Camera::facing(&disk.mesh, points().map(|p| middle + times * (p - middle)), size)
}
