//! Rolled rims: bands that continue a sheet beyond its outer boundary and turn to its back.
//!
//! A cap over the outer boundary of a sheet meets the sheet at an edge like that of a knife, and no
//! smooth surface follows both. Therefore a half tube is added first, which leaves the sheet in the
//! direction of its tangent planes. The hole that is left behind the sheet is filled as others are.

use std::f64::consts::PI;

use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{Disk, Mesh, boundary};

/// A rim is rolled if on average the cosine of the angle between the direction in which the surface
/// leaves it and the direction away from the middle of the rim exceeds this value (60°). It is 1
/// for a flat sheet, 0 for the end of a pipe, and −1 for a hole in a flat sheet.
const AWAY: f64 = 0.5;

/// The radius of the tube as a share of the length of the rim: a third of a tenth of the radius of a
/// round sheet. The fitted surface has to turn around it, so it must not be much narrower than the
/// quads of the layout.
const RADIUS: f64 = 0.01;

/// The least and the largest number of steps around the tube.
const STEPS: [usize; 2] = [6, 24];

/// A disk whose sheet-like rims are rolled.
pub(super) struct Rolled {
    /// The disk with the tubes.
    pub disk: Disk,
    /// For each hole the number of triangles of its tube, which come last, in the order of the holes.
    pub triangles: Vec<usize>,
}

/// Rolls the rims that leave their surface outwards.
pub(super) fn rolled(mut disk: Disk) -> Rolled {
    let normals = disk.mesh.vertex_normals();
    let mut triangles = Vec::with_capacity(disk.holes.len());
    for hole in 0..disk.holes.len() {
        let before = disk.mesh.triangles.len();
        let frame = RimFrame::new(&disk.mesh, &disk.holes[hole], &normals);
        if frame.leaves_outwards() {
            disk.holes[hole] = frame.add_tube(&mut disk.mesh, &disk.holes[hole]);
        }
        triangles.push(disk.mesh.triangles.len() - before);
    }
    Rolled { disk, triangles }
}

/// A rim with the directions of a tube along it.
struct RimFrame {
    points: Vec<Point>,
    /// The unit normals of the surface, smoothed along the rim.
    normals: Vec<Vector>,
    /// The unit directions in which the surface leaves the rim.
    away: Vec<Vector>,
    radius: f64,
    edge: f64,
}

impl RimFrame {
    fn new(mesh: &Mesh, rim: &[VertexId], normals: &[Vector]) -> Self {
        let n = rim.len();
        let points: Vec<Point> = rim.iter().map(|&v| mesh.point(v)).collect();
        let length = boundary::length(mesh, rim);
        let (radius, edge) = (RADIUS * length, length / n as f64);
        let side = |i: usize| points[(i + 1) % n] - points[(i + n - 1) % n];
        let reach = ((radius / edge).ceil() as usize).clamp(1, n / 2);
        let tangents = smoothed(&(0..n).map(side).collect::<Vec<_>>(), reach);
        let of_rim: Vec<Vector> = rim.iter().map(|v| normals[v.index()]).collect();
        let normals = smoothed(&of_rim, reach);
        // The surface is to the left of the rim.
        let away = tangents.iter().zip(&normals).map(|(t, n)| unit(t.cross(n))).collect();
        RimFrame { points, normals, away, radius, edge }
    }

    fn leaves_outwards(&self) -> bool {
        let n = self.points.len() as f64;
        let middle = self.points.iter().map(|p| p.coords).sum::<Vector>() / n;
        let cosine = |(p, away): (&Point, &Vector)| unit(p.coords - middle).dot(away);
        self.points.iter().zip(&self.away).map(cosine).sum::<f64>() / n > AWAY
    }

    /// Adds the tube to the mesh, and returns the rim that it leaves.
    fn add_tube(&self, mesh: &mut Mesh, rim: &[VertexId]) -> Vec<VertexId> {
        let n = rim.len();
        let steps = ((PI * self.radius / self.edge).ceil() as usize).clamp(STEPS[0], STEPS[1]);
        let mut inner = rim.to_vec();
        for step in 1..=steps {
            let (sine, cosine) = (PI * step as f64 / steps as f64).sin_cos();
            let place = |i: usize| {
                let by = sine * self.away[i] - (1.0 - cosine) * self.normals[i];
                self.points[i] + self.radius * by
            };
            let first = mesh.points.len();
            mesh.points.extend((0..n).map(place));
            let outer: Vec<VertexId> = (first..first + n).map(VertexId::from).collect();
            for (i, k) in (0..n).map(|i| (i, (i + 1) % n)) {
                mesh.triangles.push([inner[k], inner[i], outer[i]]);
                mesh.triangles.push([inner[k], outer[i], outer[k]]);
            }
            inner = outer;
        }
        inner
    }
}

fn unit(v: Vector) -> Vector {
    v.try_normalize(0.0).unwrap_or_default()
}

/// The unit means of vectors around a ring over `reach` neighbours on each side.
fn smoothed(vectors: &[Vector], reach: usize) -> Vec<Vector> {
    let n = vectors.len();
    let mean = |i: usize| unit((0..=2 * reach).map(|k| vectors[(i + n + k - reach) % n]).sum());
    (0..n).map(mean).collect()
}
