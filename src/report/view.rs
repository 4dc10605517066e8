//! What the pictures of a report show of a conversion: meshes and the distances of their points.

use std::collections::HashSet;

use super::exact_edges::{ExactEdges, polyline as edge_line};
use super::exact_view::ExactView;
#[cfg(feature = "html")]
use super::face_mesh::FaceMesh;
#[cfg(feature = "html")]
use super::plane::PlaneDrawing;
use crate::convert::{Body, BodyFit, NetworkFit, Stage};
#[cfg(feature = "html")]
use crate::convert::{ExactFit, SurfaceFit};
use crate::deviation::{Deviation, of_network};
use crate::error::{Error, Result};
use crate::geometry::{Point, VertexId};
use crate::mesh::Disk;
use crate::report::picture::{Thinned, thin};
#[cfg(feature = "html")]
use crate::report::picture::{outlines, polyline};
#[cfg(feature = "html")]
use crate::stages::brep::outer_edges;
use crate::words::{mm, plural, separated};

/// The largest number of triangles of all the scans that a page shows together. A page with more
/// is too large to be mailed, and browsers turn it slowly.
const MOST_TRIANGLES: usize = 300_000;

/// Keeps what the stages of one conversion make, until its view can be made.
#[derive(Debug, Default)]
pub struct ViewRecorder {
    measured: Option<Disk>,
}

/// What pictures show of one conversion. Distances are mm, positive above the face.
#[derive(Debug)]
pub struct ReportView {
    /// The scan, thinned if it has too many triangles.
    pub(super) scan: Thinned,
    /// Triangles of the scan before it was thinned.
    pub(super) triangles: usize,
    /// The boundary loops: of a face the outer one, the rims of the holes, the rims of the islands.
    pub(super) rims: Vec<Vec<VertexId>>,
    /// Whether the first boundary loop is the outer one, and how many rims of holes follow.
    #[cfg(feature = "html")]
    pub(super) outer_and_holes: [usize; 2],
    /// Distances of all points of the scan as measured.
    pub(super) measured: Vec<f32>,
    /// Distances of the same points, smoothed.
    #[cfg(feature = "html")]
    pub(super) smoothed: Vec<f32>,
    /// The figures beside the pictures.
    pub(super) figures: ViewFigures,
    /// The seams between the faces. Of exact faces: the sharp edges.
    pub(super) seams: Vec<Vec<Point>>,
    /// The edges at which exact faces run smoothly into each other.
    pub(super) smooth_edges: Vec<Vec<Point>>,
    /// The vertices at which other than four faces meet.
    pub(super) irregular: Vec<Point>,
    /// The exact faces.
    pub(super) exact: Option<ExactView>,
    /// The faces as triangles; `None` if they could not be triangulated.
    #[cfg(feature = "html")]
    pub(super) face: Option<FaceMesh>,
    /// The edges of the faces, each with the number of its hole.
    #[cfg(feature = "html")]
    pub(super) edges: Vec<(Option<usize>, Vec<Point>)>,
    /// The rows, the columns and the points of the control net of a single face.
    #[cfg(feature = "html")]
    pub(super) net: Option<([usize; 2], Vec<Point>)>,
    /// The parameter plane of a single face.
    #[cfg(feature = "html")]
    pub(super) plane: Option<PlaneDrawing>,
}

/// The figures of one conversion that stand beside pictures.
#[derive(Debug)]
pub(super) struct ViewFigures {
    /// Vertices of the component.
    pub vertices: usize,
    /// The lowest and the highest coordinates of the component.
    pub bounds: [[f64; 3]; 2],
    pub tolerance: f64,
    /// The deviation of the points as measured.
    pub measured: Deviation,
    /// The 95th percentile of the deviation of the vertices as measured.
    pub vertex_p95: f64,
    /// The deviation of the smoothed points.
    pub smoothed: Deviation,
    /// The number of smoothed points that miss the tolerance.
    pub beyond: usize,
    /// The number of those that keep it only because a trim loop cuts them off.
    pub cut_off: usize,
    /// What the scan became.
    pub made: String,
}

impl ViewRecorder {
    /// Keeps what a stage made. A conversion shows every stage to its `watch`.
    pub fn see(&mut self, stage: &Stage) {
        if let Stage::Mesh(disk) = stage {
            self.measured = Some((*disk).clone());
        }
    }

    /// The view of a body of which the recorder has seen every stage: one of `parts` views that are drawn
    /// together.
    ///
    /// # Errors
    /// [`Error::Input`]: the recorder has not seen the mesh of this body.
    pub fn view(self, body: &Body, parts: usize) -> Result<ReportView> {
        let smoothed = body.smoothed_distances();
        let disk = self.seen(smoothed.len())?;
        let of_vertices = match &body.fit {
            BodyFit::Face(_) | BodyFit::Exact(_) => body.vertex_deviation(),
            BodyFit::Network(fit) => &of_network(&fit.network, &fit.cut, &disk.mesh.points),
        };
        let distances = [of_vertices.signed().unwrap_or_default(), smoothed].map(single);
        let figures = ViewFigures {
            vertices: body.input.vertices,
            bounds: body.input.bounds,
            tolerance: body.tolerance,
            measured: body.deviation.clone(),
            vertex_p95: of_vertices.p95,
            smoothed: body.fit_deviation.clone(),
            beyond: body.missed.points,
            cut_off: body.cut_off(),
            made: made(body),
        };
        let mut view = ReportView::new(&disk, distances, figures, parts);
        match &body.fit {
            BodyFit::Network(fit) => {
                view.seams = seams(&body.brep);
                view.irregular = irregular(&body.brep, fit);
                #[cfg(feature = "html")]
                view.show_network(fit, disk.holes.len(), parts);
            }
            BodyFit::Exact(fit) => {
                let edges = ExactEdges::of(&body.brep, fit);
                (view.seams, view.smooth_edges) = (edges.sharp, edges.smooth);
                view.exact = Some(ExactView::of(fit));
                #[cfg(feature = "html")]
                view.show_exact(fit, parts);
            }
            #[cfg(feature = "html")]
            BodyFit::Face(face) => view.show_face(face, body.trimmed.len(), parts),
            #[cfg(not(feature = "html"))]
            BodyFit::Face(_) => {}
        }
        Ok(view)
    }

    /// The measured mesh, if it has as many points.
    fn seen(self, count: usize) -> Result<Disk> {
        let seen = self.measured.filter(|disk| disk.mesh.points.len() == count);
        seen.ok_or(Error::Input("the recorder must see every stage of a conversion"))
    }
}

/// What became of the scan.
fn made(body: &Body) -> String {
    let faces = plural(body.brep.faces.len(), "face");
    match (body.face(), body.volume()) {
        (Some(face), _) => {
            let [m, n] = face.surface.shape();
            let cut = plural(body.trimmed.iter().filter(|t| **t).count(), "hole");
            format!("{m} × {n} control points, {cut} cut out")
        }
        (None, Some(volume)) => {
            let shape = body.shape.word();
            format!("a {shape} of {faces}, {}³", separated(&mm(volume.abs())))
        }
        (None, None) => format!("a shell of {faces}"),
    }
}

/// Distances as pictures take them.
fn single(distances: Vec<f64>) -> Vec<f32> {
    distances.into_iter().map(|d| d as f32).collect()
}

impl ReportView {
    fn new(
        disk: &Disk,
        [measured, smoothed]: [Vec<f32>; 2],
        figures: ViewFigures,
        parts: usize,
    ) -> Self {
        let worst = [&measured, &smoothed].map(|d| worst(d));
        let scan = thin(&disk.mesh, MOST_TRIANGLES / parts.max(1), &worst);
        ReportView {
            triangles: disk.mesh.triangles.len(),
            rims: disk.loops().map(|ring| moved(ring, &scan)).collect(),
            measured,
            figures,
            seams: Vec::new(),
            smooth_edges: Vec::new(),
            irregular: Vec::new(),
            exact: None,
            scan,
            #[cfg(feature = "html")]
            outer_and_holes: [0, 0],
            #[cfg(feature = "html")]
            smoothed,
            #[cfg(feature = "html")]
            face: None,
            #[cfg(feature = "html")]
            edges: Vec::new(),
            #[cfg(feature = "html")]
            net: None,
            #[cfg(feature = "html")]
            plane: None,
        }
    }

    /// Adds what only a page shows of exact faces.
    #[cfg(feature = "html")]
    fn show_exact(&mut self, fit: &ExactFit, parts: usize) {
        self.edges = self.seams.iter().map(|seam| (None, seam.clone())).collect();
        self.face = (fit.mesh.triangles.len() <= MOST_TRIANGLES / parts.max(1))
            .then(|| FaceMesh::of_exact(fit));
    }

    /// Adds what only a page shows of a network.
    #[cfg(feature = "html")]
    fn show_network(&mut self, fit: &NetworkFit, holes: usize, parts: usize) {
        self.outer_and_holes = [0, holes];
        self.edges = self.seams.iter().map(|seam| (None, seam.clone())).collect();
        self.face = Some(FaceMesh::of_network(fit, parts));
    }

    /// Adds what only a page shows of a face.
    #[cfg(feature = "html")]
    fn show_face(&mut self, c: &SurfaceFit, holes: usize, parts: usize) {
        let outlines = outlines(&c.loops);
        let sides = c.outer.map(|_| outer_edges(&c.surface)).into_iter().flatten();
        let sides = sides.map(|(edge, _, _)| {
            (None, polyline(&edge).into_iter().map(Point::from).collect::<Vec<_>>())
        });
        let loops = c.loops.iter().zip(&outlines).map(|(ring, outline)| {
            let points = outline.iter().chain(outline.first()).map(|&uv| c.surface.point(uv));
            (ring.of.hole(), points.collect())
        });
        self.edges = sides.chain(loops).collect();
        self.outer_and_holes = [1, holes];
        self.net = Some((c.surface.shape(), c.surface.net.iter().map(|&p| p.into()).collect()));
        self.face = FaceMesh::of_face(c, &outlines, parts);
        self.plane = Some(PlaneDrawing::of(c, &outlines));
    }
}

/// The edges of a body's faces.
fn seams(brep: &formats::Brep) -> Vec<Vec<Point>> {
    brep.edges.iter().map(edge_line).collect()
}

/// The irregular vertices that the loops leave.
fn irregular(brep: &formats::Brep, fit: &NetworkFit) -> Vec<Point> {
    let left: HashSet<[u64; 3]> = brep.vertices.iter().map(|p| p.map(f64::to_bits)).collect();
    let is_left = |p: &Point| left.contains(&<[f64; 3]>::from(*p).map(f64::to_bits));
    fit.network.irregular().into_iter().filter(is_left).collect()
}

/// The farthest point.
fn worst(distances: &[f32]) -> usize {
    let far = |i: &usize, j: &usize| distances[*i].abs().total_cmp(&distances[*j].abs());
    (0..distances.len()).max_by(far).unwrap_or(0)
}

/// A loop over the vertices that are left.
fn moved(ring: &[VertexId], scan: &Thinned) -> Vec<VertexId> {
    let mut moved: Vec<VertexId> = ring.iter().map(|v| scan.new[v.index()]).collect();
    moved.dedup();
    moved
}
