//! The edges of exact faces: sharp ones, and those at which the faces run smoothly into each other.

use formats::brep::{Brep, Edge};

use crate::convert::ExactFit;
use crate::geometry::Point;

/// Faces that turn by more make a sharp edge. Tangent faces turn by nothing but rounding, and the smallest
/// chamfers that people make turn by more.
const SHARP_DEG: f64 = 5.0;

/// The same for two facets. Those of a curved face turn by up to the angle to which CAD programs divide it.
const SHARP_FACETS_DEG: f64 = 30.0;

/// Where along an edge the faces are compared: not at its ends, where a cone may have its apex.
const PLACES: [f64; 3] = [0.25, 0.5, 0.75];

/// The number of steps along a drawn edge.
const STEPS: usize = 24;

/// The edges of exact faces as polylines. Seam edges, at which a face meets itself, are none of the part.
#[derive(Debug, Default)]
pub(super) struct ExactEdges {
    pub sharp: Vec<Vec<Point>>,
    pub smooth: Vec<Vec<Point>>,
}

impl ExactEdges {
    pub(super) fn of(brep: &Brep, fit: &ExactFit) -> Self {
        let mut faces: Vec<Vec<usize>> = vec![Vec::new(); brep.edges.len()];
        for (number, face) in brep.faces.iter().enumerate() {
            face.loops.iter().flatten().for_each(|part| faces[part.edge.0].push(number));
        }
        let mut edges = ExactEdges::default();
        for (edge, faces) in brep.edges.iter().zip(faces) {
            match faces[..] {
                [one, other] if one == other => {}
                [one, other] if !is_sharp(edge, fit, [one, other]) => {
                    edges.smooth.push(polyline(edge));
                }
                _ => edges.sharp.push(polyline(edge)),
            }
        }
        edges
    }
}

/// Whether two faces turn at their edge.
fn is_sharp(edge: &Edge, fit: &ExactFit, faces: [usize; 2]) -> bool {
    let most =
        if faces.iter().all(|&k| fit.faces[k].is_facet) { SHARP_FACETS_DEG } else { SHARP_DEG };
    let least = most.to_radians().cos();
    PLACES.into_iter().any(|share| {
        let at = point(edge, share);
        let [a, b] = faces.map(|k| fit.faces[k].side * fit.faces[k].surface.normal(at));
        a.dot(&b) < least
    })
}

/// The point of an edge at a share of its range.
fn point(edge: &Edge, share: f64) -> Point {
    let (low, high) = edge.curve.range();
    edge.curve.point(low + (high - low) * share).into()
}

/// An edge as a polyline.
pub(super) fn polyline(edge: &Edge) -> Vec<Point> {
    (0..=STEPS).map(|i| point(edge, i as f64 / STEPS as f64)).collect()
}
