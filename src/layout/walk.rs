//! Places on a scan, and steps along its surface from triangle to triangle.

use super::base::TrianglePlace;
use crate::geometry::{Point, Vector};
use crate::mesh::{EdgeMap, Mesh};

/// A scan on which places move.
pub(super) struct Ground<'a> {
    scan: &'a Mesh,
    edges: EdgeMap,
    /// Smoothed unit normals of the vertices.
    normals: &'a [Vector],
}

/// The most triangles that a step crosses. Steps are about as long as a quad.
const MOST_CROSSED: usize = 500;

impl<'a> Ground<'a> {
    pub fn new(scan: &'a Mesh, normals: &'a [Vector]) -> Self {
        Ground { scan, edges: EdgeMap::new(scan), normals }
    }

    pub fn point(&self, place: &TrianglePlace) -> Point {
        let corners = self.scan.corners(self.scan.triangles[place.triangle as usize]);
        let terms = corners.iter().zip(place.weights).map(|(c, w)| c.coords * w);
        Point::from(terms.sum::<Vector>())
    }

    /// The smoothed unit normal of the scan.
    pub fn normal(&self, place: &TrianglePlace) -> Vector {
        let corners = self.scan.triangles[place.triangle as usize];
        let terms = corners.iter().zip(place.weights).map(|(v, w)| self.normals[v.index()] * w);
        terms.sum::<Vector>().try_normalize(0.0).unwrap_or_default()
    }

    /// The place that a step along the surface leads to. At each side the direction is turned into
    /// the plane of the next triangle.
    pub fn walked(&self, start: TrianglePlace, step: Vector) -> TrianglePlace {
        let mut place = start;
        let mut left = step;
        for _ in 0..MOST_CROSSED {
            let t = place.triangle as usize;
            let corners = self.scan.corners(self.scan.triangles[t]);
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a));
            let area = normal.norm_squared();
            if area <= 0.0 {
                return place;
            }
            let flat = left - normal * (left.dot(&normal) / area);
            let length = flat.norm();
            if length <= 0.0 {
                return place;
            }
            let along = flat * (left.norm() / length);
            // The change of the weights by the whole step.
            let change =
                [(c - b), (a - c), (b - a)].map(|side| normal.cross(&side).dot(&along) / area);
            let mut share = 1.0;
            let mut side = None;
            for (k, (change, weight)) in change.into_iter().zip(place.weights).enumerate() {
                if change < 0.0 && weight + share * change < 0.0 {
                    share = weight / -change;
                    side = Some(k);
                }
            }
            (0..3).for_each(|k| place.weights[k] = (place.weights[k] + share * change[k]).max(0.0));
            let Some(k) = side else { return place };
            left = along * (1.0 - share);
            // Corner k is opposite to the side that leaves corner k + 1.
            let Some(other) = self.edges.across(3 * t + (k + 1) % 3) else { return place };
            let (from, to) = (place.weights[(k + 1) % 3], place.weights[(k + 2) % 3]);
            let sum = (from + to).max(f64::MIN_POSITIVE);
            let (next, side) = (other / 3, other % 3);
            let mut weights = [0.0; 3];
            weights[side] = to / sum;
            weights[(side + 1) % 3] = from / sum;
            place = TrianglePlace { triangle: next as u32, weights };
        }
        place
    }
}
