//! The scene that the page's script draws: arrays of little-endian numbers in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::ReportView;
use super::face_mesh::curvature_end;
use super::far_places::far_places;
use super::scale::Ends;
use crate::deviation::Deviation;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::Mesh;
use crate::report::picture::colour::TINTS;
use crate::report::picture::{Camera, scale};

/// The scene as JSON. Points are mm from `middle`, so that single precision suffices for a scan
/// far from the origin.
pub(crate) fn scene(views: &[ReportView], ends: &Ends) -> Value {
    let extent = || views.iter().flat_map(|view| view.scan.mesh.points.iter().copied());
    let [low, high] = crate::geometry::bounds(extent());
    let middle = low + 0.5 * (high - low);
    let axes = views.first().map(|view| {
        let camera = match view.exact {
            Some(_) => Camera::isometric(extent(), [1000, 800]),
            None => Camera::facing(&view.scan.mesh, extent(), [1000, 800]),
        };
        camera.axes().map(<[f64; 3]>::from)
    });
    json!({
        "middle": <[f64; 3]>::from(middle.coords),
        "radius": 0.5 * (high - low).norm(),
        "axes": axes,
        "end": { "measured": ends.measured, "smoothed": ends.smoothed,
            "curvature": curvature_end(views) },
        "tints": TINTS,
        "signed": scale::SIGNED,
        "distance": scale::DISTANCE,
        "parts": views.iter().map(|view| part(view, middle)).collect::<Vec<_>>(),
    })
}

fn part(view: &ReportView, middle: Point) -> Value {
    let values = |all: &[f32]| floats(view.scan.old.iter().map(|&v| all[v]));
    let edges = view.edges.iter().map(
        |(hole, points)| json!({ "hole": hole, "points": places(points.iter().copied(), middle) }),
    );
    let mut scan = mesh(&view.scan.mesh, middle);
    scan["measured"] = values(&view.measured).into();
    scan["smoothed"] = values(&view.smoothed).into();
    let face = view.face.as_ref().map(|face| {
        let tints = face.face_of.iter().map(|face| (face % TINTS.len()) as u8);
        let mut drawn = mesh(&face.mesh, middle);
        drawn["tints"] = STANDARD.encode(tints.collect::<Vec<u8>>()).into();
        drawn["tinted"] = view.plane.is_none().into();
        drawn["normals"] = short_vectors(&face.normals).into();
        drawn["curvatures"] = floats(face.curvatures.iter().copied()).into();
        drawn
    });
    let [outer, holes] = view.outer_and_holes;
    let rims = view.rims.iter().enumerate().map(|(k, ring)| {
        let hole = k.checked_sub(outer).filter(|&hole| hole < holes);
        let closed = ring.iter().chain(ring.first());
        let points = closed.map(|v: &VertexId| view.scan.mesh.point(*v));
        json!({ "hole": hole, "points": places(points, middle) })
    });
    let ([rows, columns], net) = view.net.as_ref().map_or(([0, 0], &[][..]), |n| (n.0, &n.1));
    let at = |p: [f64; 3]| <[f64; 3]>::from(Point::from(p) - middle);
    let worst = |d: &Deviation| json!({ "at": at(d.max_at), "mm": d.max });
    json!({
        "scan": scan,
        "face": face,
        "rims": rims.collect::<Vec<_>>(),
        "edges": edges.collect::<Vec<_>>(),
        "smooth": view.smooth_edges.iter().map(|edge| places(edge.iter().copied(), middle))
            .collect::<Vec<_>>(),
        "spots": view.exact.iter().flat_map(|exact| exact.spots())
            .map(|(p, text)| json!({ "at": at(p), "text": text })).collect::<Vec<_>>(),
        "irregular": places(view.irregular.iter().copied(), middle),
        "net": { "rows": rows, "columns": columns,
            "points": places(net.iter().copied(), middle) },
        "places": far_places(view).iter().map(|place| json!({
            "at": at(place.at.into()), "mm": place.measured,
        })).collect::<Vec<_>>(),
        "tolerance": view.figures.tolerance,
        "worst": {
            "measured": worst(&view.figures.measured),
            "smoothed": worst(&view.figures.smoothed),
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

/// Vectors of length 1 at the most, with the numbers from −1 to 1 as 16-bit integers.
fn short_vectors(vectors: &[Vector]) -> String {
    let numbers = vectors.iter().flat_map(|v| [v.x, v.y, v.z]);
    let short = numbers.map(|x| (x * f64::from(i16::MAX)).round() as i16);
    STANDARD.encode(short.flat_map(i16::to_le_bytes).collect::<Vec<u8>>())
}

fn floats(numbers: impl Iterator<Item = f32>) -> String {
    STANDARD.encode(numbers.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
}
