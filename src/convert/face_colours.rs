//! The colours of faces: those of the triangles that they were made of.

use formats::brep::FaceId;
use formats::scene::SceneMesh;
use rayon::prelude::*;

use super::{Body, BodyFit, Part};
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{Mesh, Triangles};

/// The colours of a part (sRGB).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PartColours {
    /// The colour of the part: the only one, or that of most of its area if all of it has a colour.
    pub part: Option<[u8; 3]>,
    /// The faces that have another colour.
    pub faces: Vec<(FaceId, [u8; 3])>,
    /// The number of faces whose triangles have several colours. Such a face has that of most of its area.
    pub mixed: usize,
}

/// A colour of triangles, or none.
type TriangleColour = Option<[u8; 3]>;

impl PartColours {
    /// The colours of the faces of a part that was made of a mesh. The mesh has so many `mm` to its unit.
    pub fn of(mesh: &SceneMesh, mm: f64, part: &Part) -> Self {
        let only = mesh.colour.or(mesh.soup.colour);
        if mesh.colours.is_empty() {
            return PartColours { part: only, ..PartColours::default() };
        }
        let (painted, colours) = painted(mesh, mm);
        let whole = most(
            colours
                .iter()
                .zip(&painted.triangles)
                .map(|(colour, &triangle)| (*colour, painted.area_vector(triangle).norm())),
        );
        // A face cannot take the colour of its part away.
        let whole = whole.0.filter(|_| !colours.contains(&None));
        let triangles = Triangles::new(&painted);
        let mut found = PartColours { part: whole, ..PartColours::default() };
        let mut first = 0;
        for body in &part.bodies {
            let samples = samples(body);
            let each: Vec<(TriangleColour, bool)> = samples
                .par_iter()
                .map(|samples| {
                    let colour = |(at, weight): &(Point, f64)| {
                        (colours[triangles.nearest(body.in_scan(*at)).1], *weight)
                    };
                    most(samples.iter().map(colour))
                })
                .collect();
            for (number, (colour, is_mixed)) in each.into_iter().enumerate() {
                found.mixed += usize::from(is_mixed);
                let own = colour.filter(|_| colour != whole);
                found.faces.extend(own.map(|colour| (FaceId(first + number), colour)));
            }
            first += body.brep.faces.len();
        }
        found
    }
}

/// The triangles of a mesh in mm, and the colour of each.
fn painted(mesh: &SceneMesh, mm: f64) -> (Mesh, Vec<TriangleColour>) {
    let mut of_polygon = vec![None; mesh.soup.polygons.len()];
    for (run, value) in mesh.colours.iter() {
        of_polygon[run].fill(mesh.colours.values()[value]);
    }
    let points = mesh.soup.points.iter().map(|p| Point::from(p.map(|x| mm * x))).collect();
    let (mut triangles, mut colours) = (Vec::new(), Vec::new());
    for (polygon, colour) in mesh.soup.polygons.iter().zip(of_polygon) {
        let vertex = |corner: u32| VertexId::from(corner as usize);
        for pair in polygon.windows(2).skip(1) {
            let triangle = [polygon[0], pair[0], pair[1]].map(vertex);
            triangles.push(triangle);
            colours.push(colour);
        }
    }
    let mut mesh = Mesh { points, triangles };
    // What is not finite has no place.
    let is_finite: Vec<bool> = (mesh.triangles.iter())
        .map(|&t| mesh.corners(t).iter().all(|p| p.iter().all(|x| x.is_finite())))
        .collect();
    let mut kept = is_finite.iter();
    mesh.triangles.retain(|_| kept.next().copied().unwrap_or(false));
    let mut kept = is_finite.iter();
    colours.retain(|_| kept.next().copied().unwrap_or(false));
    (mesh, colours)
}

/// The value with the largest weight, and whether there are others. Of equal ones it is the least.
fn most(all: impl Iterator<Item = (TriangleColour, f64)>) -> (TriangleColour, bool) {
    let mut weights = std::collections::BTreeMap::<TriangleColour, f64>::new();
    all.for_each(|(colour, weight)| *weights.entry(colour).or_default() += weight);
    let mut best: Option<(TriangleColour, f64)> = None;
    for (&colour, &weight) in &weights {
        if best.is_none_or(|(_, most)| weight > most) {
            best = Some((colour, weight));
        }
    }
    (best.and_then(|(colour, _)| colour), weights.len() > 1)
}

/// Places on each face of a body, with their share of it.
fn samples(body: &Body) -> Vec<Vec<(Point, f64)>> {
    let mut samples = vec![Vec::new(); body.brep.faces.len()];
    if let BodyFit::Exact(fit) = &body.fit {
        for (&face, &triangle) in fit.of_triangle.iter().zip(&fit.mesh.triangles) {
            let [a, b, c] = fit.mesh.corners(triangle);
            let middle = a + ((b - a) + (c - a)) / 3.0;
            if let Some(of_face) = samples.get_mut(face as usize) {
                of_face.push((middle, fit.mesh.area_vector(triangle).norm()));
            }
        }
        return samples;
    }
    // Free-form faces are near their corners and edges: places between these and their mean.
    for (face, samples) in body.brep.faces.iter().zip(&mut samples) {
        let ends = face.loops.iter().take(1).flatten();
        let corner = |edge: &formats::brep::EdgeUse| {
            let [from, _] = body.brep.edges[edge.edge.0].ends;
            Point::from(body.brep.vertices[from.0])
        };
        let corners: Vec<Point> = ends.map(corner).collect();
        let count = corners.len().max(1) as f64;
        let mean = corners.iter().fold(Vector::zeros(), |sum, p| sum + p.coords) / count;
        samples.push((Point::from(mean), count));
        samples.extend(corners.iter().map(|p| (Point::from(0.5 * (p.coords + mean)), 1.0)));
    }
    samples
}
