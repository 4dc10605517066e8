//! A scaffold around a ragged outer boundary, so that the boundary need not lie on the sides of the
//! domain.
//!
//! Tongues and bays that are pressed onto straight sides stretch the map beyond what a spline can
//! follow. Rings of vertices are therefore put around the boundary. Each ring has fewer vertices
//! than the one before and follows the mean of the boundary over a wider window; the outermost ring
//! can be mapped to four sides. The scaffold affects only the map. Its triangles have little
//! weight, so the boundary takes the form that suits the surface. No scaffold triangle may be
//! inverted, so the boundary cannot cross itself (Jiang, Schaefer, Panozzo, "Simplicial complex
//! augmentation framework for bijective maps", 2017).

use nalgebra::SVector;

use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::boundary::Loop;
use crate::mesh::{Mesh, Patch};

/// The largest number of vertices of the outermost ring.
const OUTERMOST: usize = 64;

/// The width of the window for the mean, in distances between vertices of the ring.
const WINDOW: f64 = 3.0;

/// A boundary is ragged if its length exceeds that of its mean over nine vertices by this factor.
/// Square corners give 1.02 to 1.07.
const RAGGED: f64 = 1.07;

/// A point of the boundary or of its mean, followed by the normal of the surface there.
type Station = SVector<f64, 6>;

/// Whether the outer boundary has teeth, tongues or bays that four smooth sides cannot follow.
pub(crate) fn is_ragged(mesh: &Mesh, outer: &[VertexId]) -> bool {
    let n = outer.len();
    let at = |i: usize| mesh.point(outer[i % n]).coords;
    let mean = |i: usize| (0..9).map(|k| at(i + k)).sum::<Vector>() / 9.0;
    let length =
        |at: &dyn Fn(usize) -> Vector| -> f64 { (0..n).map(|i| (at(i + 1) - at(i)).norm()).sum() };
    // The smooth course of a boundary with fewer vertices is unknown.
    n >= OUTERMOST && length(&at) > RAGGED * length(&mean)
}

/// The mesh of the patch with a scaffold, and the new outer boundary. The vertices and triangles of
/// the scaffold follow those of the patch.
pub(crate) fn surround(patch: &Patch) -> (Mesh, Loop) {
    let mut mesh = patch.mesh.clone();
    let polyline = BoundaryPolyline::new(patch);
    let (mut rim, mut places) = (patch.outer.clone(), polyline.shares());
    let mut out = 0.0;
    loop {
        let count = (rim.len() / 2).max(OUTERMOST / 2);
        let first = mesh.points.len();
        mesh.points.extend(polyline.ring(count, &mut out));
        let ring: Loop = (first..first + count).map(VertexId::from).collect();
        let shares: Vec<f64> = (0..count).map(|j| j as f64 / count as f64).collect();
        mesh.triangles.extend(triangles_between(&rim, &places, &ring, &shares));
        (rim, places) = (ring, shares);
        if count <= OUTERMOST {
            return (mesh, rim);
        }
    }
}

/// The boundary as a closed polyline, parameterized by length, with its integral.
struct BoundaryPolyline {
    stations: Vec<Station>,
    /// The length from the first station to each station. The last entry is the total length.
    lengths: Vec<f64>,
    /// The integral over the length from the first station to each station.
    integrals: Vec<Station>,
}

impl BoundaryPolyline {
    fn new(patch: &Patch) -> Self {
        let normals = patch.mesh.vertex_normals();
        let station = |v: &VertexId| {
            let (p, n) = (patch.mesh.point(*v), normals[v.index()]);
            Station::new(p.x, p.y, p.z, n.x, n.y, n.z)
        };
        let stations: Vec<Station> = patch.outer.iter().map(station).collect();
        let (mut lengths, mut integrals) = (vec![0.0], vec![Station::zeros()]);
        for i in 0..stations.len() {
            let (a, b) = (stations[i], stations[(i + 1) % stations.len()]);
            let length = (b - a).fixed_rows::<3>(0).norm();
            lengths.push(lengths[i] + length);
            integrals.push(integrals[i] + 0.5 * length * (a + b));
        }
        BoundaryPolyline { stations, lengths, integrals }
    }

    fn whole(&self) -> f64 {
        self.lengths[self.stations.len()]
    }

    /// The positions of the stations as shares of the total length.
    fn shares(&self) -> Vec<f64> {
        self.lengths[..self.stations.len()].iter().map(|l| l / self.whole()).collect()
    }

    /// The integral from the first station up to a length, which may lie outside one round.
    fn integral(&self, length: f64) -> Station {
        let n = self.stations.len();
        let (turns, rest) = ((length / self.whole()).floor(), length.rem_euclid(self.whole()));
        let i = self.lengths.partition_point(|&l| l <= rest).clamp(1, n) - 1;
        let (a, b) = (self.stations[i], self.stations[(i + 1) % n]);
        let (done, step) = (rest - self.lengths[i], self.lengths[i + 1] - self.lengths[i]);
        let here = if step > 0.0 { a + (b - a) * (done / step) } else { a };
        turns * self.integrals[n] + self.integrals[i] + 0.5 * done * (a + here)
    }

    /// `count` points along the mean of the boundary. They are moved outwards in the surface, by
    /// the spacing of the points more than the ring before, whose offset was `out` mm.
    fn ring(&self, count: usize, out: &mut f64) -> Vec<Point> {
        let window = WINDOW * self.whole() / count as f64;
        let mean = |j: usize| {
            let middle = self.whole() * j as f64 / count as f64;
            (self.integral(middle + 0.5 * window) - self.integral(middle - 0.5 * window)) / window
        };
        let means: Vec<Station> = (0..count).map(mean).collect();
        let point = |j: usize| -> Vector { means[j % count].fixed_rows::<3>(0).into() };
        let length: f64 = (0..count).map(|j| (point(j + 1) - point(j)).norm()).sum();
        *out += length / count as f64;
        let pushed = |j: usize| {
            let along = point(j + 1) - point(j + count - 1);
            let normal: Vector = means[j].fixed_rows::<3>(3).into();
            let outwards = along.cross(&normal).try_normalize(0.0).unwrap_or_default();
            Point::from(point(j) + *out * outwards)
        };
        (0..count).map(pushed).collect()
    }
}

/// The triangles between two closed loops with the same direction, where `outer` lies to the right
/// of `inner`. The positions of the vertices are given as shares of the length of their loop.
fn triangles_between(
    inner: &[VertexId],
    inner_at: &[f64],
    outer: &[VertexId],
    outer_at: &[f64],
) -> Vec<[VertexId; 3]> {
    let (n, m) = (inner.len(), outer.len());
    let end = |at: &[f64], i: usize| if i + 1 < at.len() { at[i + 1] } else { 1.0 };
    let (mut i, mut j) = (0, 0);
    let mut triangles = Vec::with_capacity(n + m);
    while i < n || j < m {
        let (a, b) = (inner[i % n], outer[j % m]);
        if j == m || i < n && end(inner_at, i) <= end(outer_at, j) {
            triangles.push([inner[(i + 1) % n], a, b]);
            i += 1;
        } else {
            triangles.push([b, outer[(j + 1) % m], a]);
            j += 1;
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::FaceOrigin;
    use crate::mesh::one_rings::tests::grid;

    #[test]
    fn a_skirt_makes_a_larger_disk() {
        for n in [4, 9, 40, 120] {
            let patch = grid(n);
            let (mesh, outer) = surround(&patch);
            let origin = vec![FaceOrigin::Measured; mesh.triangles.len()];
            let whole = Patch { mesh, outer, origin, ..patch.clone() };
            assert!(whole.is_disk(), "{n}");
            let Patch { mesh, outer, .. } = whole;
            assert!(outer.iter().all(|v| v.index() >= patch.mesh.points.len()), "{n}");
            assert!((OUTERMOST / 2..=OUTERMOST).contains(&outer.len()), "{n}");
            assert!(mesh.points.iter().all(|p| p.coords.norm().is_finite()), "{n}");
        }
    }

    #[test]
    fn a_square_is_not_ragged_and_teeth_are() {
        let mut patch = grid(40);
        assert!(!is_ragged(&patch.mesh, &patch.outer));
        for (k, v) in patch.outer.clone().into_iter().enumerate() {
            let p = &mut patch.mesh.points[v.index()];
            p.z += if k % 4 < 2 { 0.5 } else { -0.5 };
        }
        assert!(is_ragged(&patch.mesh, &patch.outer));
    }
}
