//! Pictures of the parameter plane.

use scan2step::geometry::{Uv, Vector};
use scan2step::mesh::FaceOrigin;

use crate::scene::Scene;
use crate::stages::FILLED;
use scan2step::report::picture::canvas::Canvas;
use scan2step::report::picture::colour::{linear, srgb};
use scan2step::report::picture::image::Image;
use scan2step::report::picture::lines::{Lines, Pen};

/// The margin on every side as a share of the picture's shorter side.
const MARGIN: f64 = 0.05;

/// Maps parameter points to the picture: u to the right, v upwards.
struct Plane {
    low: Uv,
    middle: [f64; 2],
    /// The number of pixels for the whole range of u and of v.
    side: f64,
    range: [f64; 2],
}

impl Plane {
    fn new(scene: &Scene, size: [usize; 2]) -> Plane {
        let ((u0, u1), (v0, v1)) = (scene.surface().u.range(), scene.surface().v.range());
        let [width, height] = size.map(|n| n as f64);
        Plane {
            low: Uv::new(u0, v0),
            middle: [0.5 * width, 0.5 * height],
            side: (1.0 - 2.0 * MARGIN) * width.min(height),
            range: [u1 - u0, v1 - v0],
        }
    }

    fn place(&self, at: Uv) -> Vector {
        let u = (at.x - self.low.x) / self.range[0] - 0.5;
        let v = (at.y - self.low.y) / self.range[1] - 0.5;
        Vector::new(self.middle[0] + self.side * u, self.middle[1] - self.side * v, 0.0)
    }
}

/// Knot lines, mesh, filled regions and trim loops in the parameter plane.
pub fn picture(scene: &Scene, size: [usize; 2]) -> Image {
    let plane = Plane::new(scene, size);
    let mut canvas = map_on(scene, &plane, size);
    let layers =
        [(knot_lines(&canvas, scene, &plane), 0x1f5fae), (loops(&canvas, scene, &plane), 0x1c2430)];
    for (lines, colour) in layers {
        lines.ink(&mut canvas, linear(srgb(colour)));
    }
    canvas.image()
}

/// The mesh in the parameter plane.
pub fn map(scene: &Scene, size: [usize; 2]) -> Image {
    map_on(scene, &Plane::new(scene, size), size).image()
}

fn map_on(scene: &Scene, plane: &Plane, size: [usize; 2]) -> Canvas {
    let mut canvas = Canvas::new(size);
    triangles(&mut canvas, scene, plane);
    sides(&canvas, scene, plane).ink(&mut canvas, linear(srgb(0x5f6b78)));
    canvas
}

/// The mesh: measured triangles are white, and filled ones are tinted.
fn triangles(canvas: &mut Canvas, scene: &Scene, plane: &Plane) {
    let (white, tint) = (linear(srgb(0xffffff)), linear(FILLED));
    for (t, origin) in scene.map.patch.mesh.triangles.iter().zip(&scene.map.patch.origin) {
        let colour = if *origin == FaceOrigin::Measured { white } else { tint };
        canvas.triangle(t.map(|v| plane.place(scene.map.uv[v.index()])), |_| Some(colour));
    }
}

/// The sides of the triangles. Smaller triangles have fainter sides.
fn sides(canvas: &Canvas, scene: &Scene, plane: &Plane) -> Lines {
    let mesh = &scene.map.patch.mesh;
    let mean = plane.side / (0.5 * mesh.triangles.len() as f64).sqrt();
    let pen = Pen::flat(0.5, (0.07 * mean).clamp(0.15, 0.5) as f32);
    let mut lines = Lines::over(canvas);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|v| plane.place(scene.map.uv[v.index()]));
        lines.polyline(canvas, [a, b, c, a].into_iter(), pen);
    }
    lines
}

fn knot_lines(canvas: &Canvas, scene: &Scene, plane: &Plane) -> Lines {
    let surface = scene.surface();
    let ((u0, u1), (v0, v1)) = (surface.u.range(), surface.v.range());
    let spans = surface.u.breaks().len().max(surface.v.breaks().len());
    let width = (0.12 * plane.side / spans as f64).clamp(0.4, 1.2);
    let pen = Pen::flat(width, 0.85);
    let mut lines = Lines::over(canvas);
    for u in surface.u.breaks() {
        lines.polyline(
            canvas,
            [Uv::new(u, v0), Uv::new(u, v1)].map(|p| plane.place(p)).into_iter(),
            pen,
        );
    }
    for v in surface.v.breaks() {
        lines.polyline(
            canvas,
            [Uv::new(u0, v), Uv::new(u1, v)].map(|p| plane.place(p)).into_iter(),
            pen,
        );
    }
    lines
}

/// The trim loops and the sides of the domain.
fn loops(canvas: &Canvas, scene: &Scene, plane: &Plane) -> Lines {
    let pen = Pen::flat(2.2, 1.0);
    let mut lines = Lines::over(canvas);
    for outline in scene.loops() {
        let closed = outline.iter().chain(outline.first());
        lines.polyline(canvas, closed.map(|&uv| plane.place(uv)), pen);
    }
    let ((u0, u1), (v0, v1)) = (scene.surface().u.range(), scene.surface().v.range());
    let corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1), (u0, v0)];
    lines.polyline(canvas, corners.into_iter().map(|(u, v)| plane.place(Uv::new(u, v))), pen);
    lines
}
