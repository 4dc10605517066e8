//! The distances of points from the faces of a network, and of the faces from a mesh.

use rayon::prelude::*;

use super::{Deviation, FaceToScan, FaceTree, TrimmedFace};
use crate::geometry::{Point, Uv, Vector, VertexId};
use crate::mesh::{Mesh, QuadMesh, Triangles, nearest_on};
use crate::spline::{KeptFace, KeptPlaces, Network, NetworkCut, SAMPLES_PER_SPAN};

/// The deviation of points from the faces that a cut leaves of a network, the sides of the faces that they
/// are on, and the face nearest to each.
pub fn of_network(network: &Network, cut: &NetworkCut, points: &[Point]) -> Deviation {
    NetworkFaces::new(network, cut).deviation_and_places(points, None).0
}

/// A place on one of several faces: the number of the face, and its parameter point.
pub(crate) type PlaceOnFaces = (usize, Uv);

/// The faces that a cut leaves of a network.
pub(crate) struct NetworkFaces<'a>(FaceTree<'a, crate::spline::Surface>);

impl<'a> NetworkFaces<'a> {
    pub(crate) fn new(network: &'a Network, cut: &NetworkCut) -> Self {
        let face = |face: &KeptFace| {
            let surface = &network.surfaces[face.surface];
            let natural = face.is_whole();
            let loops = if natural { Vec::new() } else { cut.boundary(network, face) };
            TrimmedFace::new(surface, loops.iter().map(Vec::as_slice), natural)
        };
        NetworkFaces(FaceTree::new(cut.faces.iter().map(face).collect()))
    }

    /// The deviation of points, and the nearest place of each. `starts` are places near these.
    pub(crate) fn deviation_and_places(
        &self,
        points: &[Point],
        starts: Option<&[PlaceOnFaces]>,
    ) -> (Deviation, Vec<PlaceOnFaces>) {
        let NetworkFaces(tree) = self;
        let each = points.par_iter().enumerate().map(|(i, &p)| {
            let (distance, number, at) = tree.nearest_from(p, starts.map(|starts| starts[i]));
            ((distance, number), ((number, at), tree.is_above(p, number, at)))
        });
        let (found, sides): (Vec<_>, Vec<_>) = each.unzip();
        let (distances, faces) = found.into_iter().unzip();
        let (places, above) = sides.into_iter().unzip();
        (Deviation { faces, ..Deviation::of(points, distances).with_sides(above) }, places)
    }
}

/// How far samples of a network are from the triangles of a mesh, and how they face.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub(crate) struct NetworkToScan {
    /// The distances of the samples whose nearest triangle was measured.
    pub deviation: Deviation,
    /// The chord error of the triangle at the largest of them.
    pub chord_error: f64,
    /// The largest of these distances on each face.
    pub largest: Vec<f64>,
    /// The number of these samples that are farther away than the tolerance and the chord error of the
    /// triangle.
    pub beyond: usize,
    /// These samples.
    pub misses: Vec<FaceMiss>,
    /// The samples whose normal points against those of the nearest triangle and of its corners, and
    /// against that of the layout. On a thin wall the nearest triangle may be on the other side.
    /// Each has the number of its face.
    pub inverted: Vec<(usize, Point)>,
}

/// A place of a network that is farther from the scan than the tolerance and the chord error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceMiss {
    /// The face.
    pub face: usize,
    /// The place on it.
    pub at: Uv,
    /// The point where the surface could be instead: as far from the nearest triangle as its chord error.
    pub wanted: Point,
}

impl NetworkToScan {
    /// The figures of all samples together.
    pub(crate) fn report(&self) -> FaceToScan {
        let Deviation { rms, p95, max, max_at, ref distances, .. } = self.deviation;
        let (chord_error, beyond, places) = (self.chord_error, self.beyond, distances.len());
        FaceToScan { rms, p95, max, max_at, chord_error, beyond, places }
    }
}

/// Compares samples of the kept places of a network with a mesh. `quads` is the mesh from whose blocks the
/// faces were made. `is_measured` says which triangles were measured; samples near others count only for how they face.
pub(crate) fn network_to_scan(
    network: &Network,
    kept: &KeptPlaces,
    quads: &QuadMesh,
    mesh: &Mesh,
    is_measured: &[bool],
    tolerance: f64,
) -> NetworkToScan {
    let triangles = Triangles::new(mesh);
    let normals = mesh.vertex_normals();
    let of_face = |(face, surface): (usize, &crate::spline::Surface)| {
        let sample = |at: Uv| {
            let jet = surface.jet(at);
            let (off, t) = triangles.nearest(jet.s);
            let facing: Vector = mesh.triangles[t].iter().map(|v| normals[v.index()]).sum();
            let normal = jet.su.cross(&jet.sv);
            let facings =
                [quads.block_normal(face, at), facing, mesh.area_vector(mesh.triangles[t])];
            let inverted = facings.iter().all(|facing| normal.dot(facing) < 0.0);
            let corners = mesh.triangles[t];
            let is_beyond =
                off > tolerance && off > tolerance + mesh.chord_error(&normals, corners);
            let wanted = is_beyond.then(|| {
                let chord = mesh.chord_error(&normals, corners);
                let nearest = nearest_on(corners.map(|v| mesh.point(v)), jet.s);
                nearest + (jet.s - nearest) * (chord / off)
            });
            let is_measured = is_measured[t];
            NetworkSample { face, uv: at, at: jet.s, off, corners, is_measured, wanted, inverted }
        };
        let places = surface.middles(SAMPLES_PER_SPAN).into_iter();
        places.filter(|&at| kept.contains(face, at)).map(sample).collect::<Vec<_>>()
    };
    let faces = network.surfaces.par_iter().enumerate();
    let samples: Vec<_> = faces.map(of_face).flatten_iter().collect();
    let measured = || samples.iter().filter(|s| s.is_measured);
    let mut largest = vec![0.0; network.surfaces.len()];
    measured().for_each(|s| largest[s.face] = f64::max(largest[s.face], s.off));
    let miss = |s: &NetworkSample| Some(FaceMiss { face: s.face, at: s.uv, wanted: s.wanted? });
    let misses: Vec<FaceMiss> = measured().filter_map(miss).collect();
    let (points, distances): (Vec<Point>, Vec<f64>) = measured().map(|s| (s.at, s.off)).unzip();
    let worst = measured().max_by(|a, b| a.off.total_cmp(&b.off));
    NetworkToScan {
        deviation: Deviation::of(&points, distances),
        chord_error: worst.map_or(0.0, |s| mesh.chord_error(&normals, s.corners)),
        largest,
        beyond: misses.len(),
        misses,
        inverted: samples.iter().filter(|s| s.inverted).map(|s| (s.face, s.at)).collect(),
    }
}

/// A place on a face of a network.
struct NetworkSample {
    face: usize,
    uv: Uv,
    at: Point,
    /// The distance from the nearest triangle.
    off: f64,
    /// The corners of this triangle.
    corners: [VertexId; 3],
    /// Whether it was measured.
    is_measured: bool,
    /// Where the place could be instead, if the distance exceeds the tolerance.
    wanted: Option<Point>,
    inverted: bool,
}
