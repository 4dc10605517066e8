//! A mesh in a picture, every triangle flat so that noise shows.

use super::camera::Camera;
use super::canvas::{Canvas, shows_front};
use super::colour::{Rgb, brightness};
use super::lines::{Lines, Pen};
use super::scale;
use crate::geometry::{Vector, VertexId};
use crate::mesh::Mesh;

/// Draws a mesh. `paint` has a triangle's number, the barycentric coordinates in
/// it, its normal in camera coordinates, and whether the outer side is seen.
pub fn draw(
    canvas: &mut Canvas,
    mesh: &Mesh,
    camera: &Camera,
    paint: impl Fn(usize, [f64; 3], Vector, bool) -> Rgb,
) {
    for (number, &t) in mesh.triangles.iter().enumerate() {
        let places = mesh.corners(t).map(|p| camera.project(&p));
        let front = shows_front(places);
        let Some(normal) = camera.turn(&mesh.area_vector(t)).try_normalize(0.0) else { continue };
        canvas.triangle(places, |w| Some(paint(number, w, normal, front)));
    }
}

/// Light on the inner side.
const BACK: f64 = 0.5;

/// Draws a mesh coloured by a number that every vertex has: its share of the
/// `colours`, from 0 to 1.
pub fn draw_coloured(
    canvas: &mut Canvas,
    mesh: &Mesh,
    camera: &Camera,
    colours: &[u32; 9],
    share: impl Fn(VertexId) -> f64,
) {
    draw(canvas, mesh, camera, |number, w, normal, front| {
        let [a, b, c] = mesh.triangles[number].map(&share);
        let (n, light) = if front { (normal, 1.0) } else { (-normal, BACK) };
        // Much shade would change the colours that the legend explains.
        let shade = (light * (0.6 + 0.4 * brightness(&n))) as f32;
        scale::colour(colours, w[0] * a + w[1] * b + w[2] * c).map(|c| c * shade)
    });
}

/// Draws a mesh with a colour for each triangle.
pub(crate) fn draw_tinted(
    canvas: &mut Canvas,
    mesh: &Mesh,
    camera: &Camera,
    colour: impl Fn(usize) -> (Rgb, [Vector; 3]),
) {
    draw(canvas, mesh, camera, |number, w, normal, front| {
        let (colour, normals) = colour(number);
        // Curved faces look smooth, although their triangles are flat.
        let smooth: Vector = w.iter().zip(normals).map(|(w, n)| *w * camera.turn(&n)).sum();
        let smooth = smooth.try_normalize(0.0).unwrap_or(normal);
        let (n, light) = if front { (smooth, 1.0) } else { (-normal, BACK) };
        let shade = (light * (0.45 + 0.55 * brightness(&n))) as f32;
        colour.map(|c| c * shade)
    });
}

/// The boundary loops of a mesh.
pub fn rims<'a>(
    canvas: &Canvas,
    mesh: &Mesh,
    loops: impl Iterator<Item = &'a Vec<VertexId>>,
    camera: &Camera,
    pen: Pen,
) -> Lines {
    let mut lines = Lines::over(canvas);
    for rim in loops {
        let closed = rim.iter().chain(rim.first());
        lines.polyline(canvas, closed.map(|&v| camera.project(&mesh.point(v))), pen);
    }
    lines
}
