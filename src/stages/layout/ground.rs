//! The scan that a layout lies on, places on it, and steps along its surface from triangle to
//! triangle. It may be smoother than the scan: it says only where the quads lie and how they face.

use super::base::TrianglePlace;
use crate::error::Result;
use crate::geometry::{Point, Vector, VertexId, unit_normal};
use crate::mesh::mls::smoothed_normals;
use crate::mesh::remesh::{EQUILATERAL, isotropic};
use crate::mesh::{EdgeMap, Mesh, VertexRings};
use crate::progress::Progress;

/// A scan on which places move.
pub(super) struct Ground {
    pub mesh: Mesh,
    /// Smoothed unit normals of the vertices.
    pub normals: Vec<Vector>,
    edges: EdgeMap,
    rings: VertexRings,
}

/// The number of points of the ground: this multiple of the scan's, between these bounds. With fewer
/// points thin parts of adaptive meshes are lost, and more only take time.
const FINER: usize = 5;
const POINTS: [usize; 2] = [30_000, 100_000];

/// The most triangles that a step crosses. Steps are about as long as a quad.
const MOST_CROSSED: usize = 500;

/// The cosine of the angle between a triangle and the smoothed normals of its corners beyond which the
/// place is smoothed (50°), and the most rounds. No quads can lie on knife edges and on spikes.
const ROUGH: f64 = 0.64;
const ROUNDS: usize = 12;

/// The steps of smoothing in a round, and the shares by which vertices move towards the mean of their
/// neighbours and away from it (Taubin, "A signal processing approach to fair surface design",
/// 1995). The second keeps thin parts from shrinking.
const STEPS: usize = 5;
const TOWARDS: f64 = 0.5;
const AWAY: f64 = -0.53;

impl Ground {
    /// The ground of a scan, whose roughest places are smoothed.
    pub(super) fn new(scan: &Mesh, progress: &mut Progress) -> Result<Self> {
        let [least, most] = POINTS;
        let points = (FINER * scan.points.len()).clamp(least, most) as f64;
        let length = (EQUILATERAL * scan.area() / points).sqrt();
        let mesh = isotropic(scan, length, progress)?;
        let rings = VertexRings::new(&mesh);
        let edges = EdgeMap::new(&mesh);
        let mut ground = Ground { normals: Vec::new(), mesh, edges, rings };
        ground.normals = smoothed_normals(&ground.mesh, &ground.rings);
        for _ in 0..ROUNDS {
            let rough = ground.rough();
            if rough.is_empty() {
                break;
            }
            ground.smooth_around(&rough);
        }
        Ok(ground)
    }

    /// The triangles that face away from the smoothed normals of their corners.
    fn rough(&self) -> Vec<u32> {
        let is_rough = |&t: &u32| {
            let corners = self.mesh.triangles[t as usize];
            let mean: Vector = corners.iter().map(|v| self.normals[v.index()]).sum();
            let normal = unit_normal(self.mesh.corners(corners)).unwrap_or_default();
            normal.dot(&mean) < ROUGH * mean.norm()
        };
        (0..self.mesh.triangles.len() as u32).filter(is_rough).collect()
    }

    /// Smooths the surface in some triangles and in those around them.
    pub(crate) fn smooth_around(&mut self, triangles: &[u32]) {
        let near = self.vertices_around(triangles);
        for step in 0..2 * STEPS {
            let share = if step % 2 == 0 { TOWARDS } else { AWAY };
            let moved = |&v: &VertexId| {
                let around = self.rings.neighbours(&self.mesh, v);
                let around = around.map(|w| self.mesh.point(w).coords);
                let (sum, count) =
                    around.fold((Vector::zeros(), 0.0), |(s, n), p| (s + p, n + 1.0));
                let p = self.mesh.point(v);
                p + share * (sum / f64::max(count, 1.0) - p.coords)
            };
            let places: Vec<Point> = near.iter().map(moved).collect();
            near.iter().zip(places).for_each(|(v, p)| self.mesh.points[v.index()] = p);
        }
        self.normals = smoothed_normals(&self.mesh, &self.rings);
    }

    /// The corners of triangles, and of the triangles around them.
    fn vertices_around(&self, triangles: &[u32]) -> Vec<VertexId> {
        let corners = triangles.iter().flat_map(|&t| self.mesh.triangles[t as usize]);
        let mut near: Vec<VertexId> =
            corners.flat_map(|v| self.rings.neighbours(&self.mesh, v)).collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// The mean length of the sides of a triangle.
    pub(crate) fn edge(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.mesh.corners(self.mesh.triangles[triangle as usize]);
        ((b - a).norm() + (c - b).norm() + (a - c).norm()) / 3.0
    }

    pub(super) fn point(&self, place: &TrianglePlace) -> Point {
        let corners = self.mesh.corners(self.mesh.triangles[place.triangle as usize]);
        let terms = corners.iter().zip(place.weights).map(|(c, w)| c.coords * w);
        Point::from(terms.sum::<Vector>())
    }

    /// The smoothed unit normal of the scan.
    pub(crate) fn normal(&self, place: &TrianglePlace) -> Vector {
        let corners = self.mesh.triangles[place.triangle as usize];
        let terms = corners.iter().zip(place.weights).map(|(v, w)| self.normals[v.index()] * w);
        terms.sum::<Vector>().try_normalize(0.0).unwrap_or_default()
    }

    /// The place that a step along the surface leads to. At each side the direction is turned into
    /// the plane of the next triangle.
    pub(crate) fn walked(&self, start: TrianglePlace, step: Vector) -> TrianglePlace {
        let mut place = start;
        let mut left = step;
        for _ in 0..MOST_CROSSED {
            let t = place.triangle as usize;
            let corners = self.mesh.corners(self.mesh.triangles[t]);
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
