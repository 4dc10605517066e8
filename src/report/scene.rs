//! The scene that the page's script draws: arrays of little-endian numbers in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::FaceView;
use super::scale::Ends;
use crate::Conversion;
use crate::brep::outer_edges;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::Mesh;
use crate::picture::{Camera, polyline, scale};

/// The scene as JSON. Points are mm from `middle`, so that single precision suffices for a scan
/// far from the origin.
pub fn scene(faces: &[(&Conversion, &FaceView)], ends: &Ends) -> Value {
    let extent = || faces.iter().flat_map(|(_, s)| s.scan.mesh.points.iter().copied());
    let [low, high] = crate::geometry::bounds(extent());
    let middle = low + 0.5 * (high - low);
    let axes = faces.first().map(|(_, s)| {
        Camera::facing(&s.scan.mesh, extent(), [1000, 800]).axes().map(<[f64; 3]>::from)
    });
    json!({
        "middle": <[f64; 3]>::from(middle.coords),
        "radius": 0.5 * (high - low).norm(),
        "axes": axes,
        "end": { "measured": ends.measured, "smoothed": ends.smoothed },
        "signed": scale::SIGNED,
        "distance": scale::DISTANCE,
        "parts": faces.iter().map(|(c, s)| part(c, s, middle)).collect::<Vec<_>>(),
    })
}

fn part(c: &Conversion, shown: &FaceView, middle: Point) -> Value {
    let values = |all: &[f32]| floats(shown.scan.old.iter().map(|&v| all[v]));
    let loops = c.loops.iter().zip(&shown.outlines).map(|(ring, outline)| {
        let points = outline.iter().chain(outline.first()).map(|&uv| c.surface.point(uv));
        json!({ "hole": ring.of.hole(), "points": places(points, middle) })
    });
    let sides =
        c.outer.map(|_| outer_edges(&c.surface)).into_iter().flatten().map(|(edge, _, _)| {
            let points = polyline(&edge).into_iter().map(Point::from);
            json!({ "points": places(points, middle) })
        });
    let [m, n] = c.surface.shape();
    let mut scan = mesh(&shown.scan.mesh, middle);
    scan["measured"] = values(&shown.measured).into();
    scan["smoothed"] = values(&shown.smoothed).into();
    let face = shown.face.as_ref().map(|face| mesh(face, middle));
    // The first loop is the outer one; holes follow.
    let rims = shown.rims.iter().enumerate().map(|(k, ring)| {
        let hole = k.checked_sub(1).filter(|&hole| hole < c.trimmed.len());
        let closed = ring.iter().chain(ring.first());
        let points = closed.map(|v: &VertexId| shown.scan.mesh.point(*v));
        json!({ "hole": hole, "points": places(points, middle) })
    });
    let at = |p: [f64; 3]| <[f64; 3]>::from(Point::from(p) - middle);
    json!({
        "scan": scan,
        "face": face,
        "rims": rims.collect::<Vec<_>>(),
        "edges": sides.chain(loops).collect::<Vec<_>>(),
        "net": { "rows": m, "columns": n,
            "points": places(c.surface.net.iter().map(|&p| p.into()), middle) },
        "tolerance": c.tolerance,
        "worst": {
            "measured": { "at": at(c.deviation.max_at), "mm": c.deviation.max },
            "smoothed": { "at": at(c.fit_deviation.max_at), "mm": c.fit_deviation.max },
        },
    })
}

fn mesh(mesh: &Mesh, middle: Point) -> Value {
    let corners = mesh.triangles.iter().flatten();
    json!({
        "points": places(mesh.points.iter().copied(), middle),
        "triangles": STANDARD.encode(corners.flat_map(|v| v.0.to_le_bytes()).collect::<Vec<u8>>()),
    })
}

fn single(v: &Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn places(points: impl Iterator<Item = Point>, middle: Point) -> String {
    floats(points.flat_map(|p| single(&(p - middle))))
}

fn floats(numbers: impl Iterator<Item = f32>) -> String {
    STANDARD.encode(numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}
