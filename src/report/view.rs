//! What the pictures of a report show of a conversion: meshes and the distances of their points.

use std::collections::HashSet;

#[cfg(feature = "html")]
use super::face_mesh::FaceMesh;
#[cfg(feature = "html")]
use super::plane::PlaneDrawing;
#[cfg(feature = "html")]
use crate::brep::outer_edges;
use crate::deviation::{Deviation, of_network};
use crate::geometry::{Point, VertexId};
use crate::mesh::Disk;
use crate::picture::{Thinned, thin};
#[cfg(feature = "html")]
use crate::picture::{outlines, polyline};
use crate::words::{mm, plural, separated};
use crate::{BodyConversion, Conversion, Error, Result, Stage};

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
    /// The seams between the faces.
    pub(super) seams: Vec<Vec<Point>>,
    /// The vertices at which other than four faces meet.
    pub(super) irregular: Vec<Point>,
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

    /// The view of a conversion of which the recorder has seen every stage: one of `parts` views
    /// that are drawn together.
    ///
    /// # Errors
    /// [`Error::Input`]: the recorder has not seen the mesh of this conversion.
    pub fn view(self, c: &Conversion, parts: usize) -> Result<ReportView> {
        let count = c.fit_deviation.distances.len();
        let disk = self.seen(count)?;
        let distances = [signed(c.vertex_deviation()), signed(&c.fit_deviation)];
        let [m, n] = c.surface.shape();
        let cut = plural(c.trimmed.iter().filter(|t| **t).count(), "hole");
        let figures = ViewFigures {
            vertices: c.input.vertices,
            bounds: c.input.bounds,
            tolerance: c.tolerance,
            measured: c.deviation.clone(),
            vertex_p95: c.vertex_deviation().p95,
            smoothed: c.fit_deviation.clone(),
            beyond: c.missed.points,
            cut_off: c.cut_off(),
            made: format!("{m} × {n} control points, {cut} cut out"),
        };
        let view = ReportView::new(&disk, distances, figures, parts);
        #[cfg(feature = "html")]
        let view = view.with_face(c, parts);
        Ok(view)
    }

    /// The view of a solid or a shell of which the recorder has seen every stage: one of `parts` views
    /// that are drawn together.
    ///
    /// # Errors
    /// [`Error::Input`]: the recorder has not seen the mesh of this conversion.
    pub fn view_of_body(self, body: &BodyConversion, parts: usize) -> Result<ReportView> {
        let disk = self.seen(body.fit_deviation.distances.len())?;
        let of_vertices = of_network(&body.network, &body.cut, &disk.mesh.points);
        let distances = [signed(&of_vertices), signed(&body.fit_deviation)];
        let faces = plural(body.brep.faces.len(), "face");
        let figures = ViewFigures {
            vertices: body.input.vertices,
            bounds: body.input.bounds,
            tolerance: body.tolerance,
            measured: body.deviation.clone(),
            vertex_p95: of_vertices.p95,
            smoothed: body.fit_deviation.clone(),
            beyond: body.fit_deviation.beyond(body.tolerance),
            cut_off: 0,
            made: match body.volume {
                Some(volume) if volume < 0.0 => {
                    format!("a void of {faces}, {}³", separated(&mm(-volume)))
                }
                Some(volume) => format!("a solid of {faces}, {}³", separated(&mm(volume))),
                None => format!("a shell of {faces}"),
            },
        };
        let mut view = ReportView::new(&disk, distances, figures, parts);
        view.seams = seams(body);
        view.irregular = irregular(body);
        #[cfg(feature = "html")]
        {
            view.outer_and_holes = [0, disk.holes.len()];
            view.edges = view.seams.iter().map(|seam| (None, seam.clone())).collect();
            view.face = Some(FaceMesh::of_body(body, parts));
        }
        Ok(view)
    }

    /// The measured mesh, if it has as many points.
    fn seen(self, count: usize) -> Result<Disk> {
        let seen = self.measured.filter(|disk| disk.mesh.points.len() == count);
        seen.ok_or(Error::Input("the recorder must see every stage of a conversion"))
    }
}

/// Distances with their signs, as pictures take them.
fn signed(deviation: &Deviation) -> Vec<f32> {
    deviation.signed().unwrap_or_default().into_iter().map(|d| d as f32).collect()
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
            irregular: Vec::new(),
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

    /// The same with what only a page shows of a face.
    #[cfg(feature = "html")]
    fn with_face(mut self, c: &Conversion, parts: usize) -> Self {
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
        self.outer_and_holes = [1, c.trimmed.len()];
        self.net = Some((c.surface.shape(), c.surface.net.iter().map(|&p| p.into()).collect()));
        self.face = FaceMesh::of_face(c, &outlines, parts);
        self.plane = Some(PlaneDrawing::of(c, &outlines));
        self
    }
}

/// The number of points along a seam.
const SEAM_POINTS: usize = 24;

/// The edges of a body's faces.
fn seams(body: &BodyConversion) -> Vec<Vec<Point>> {
    let formats::Brep { edges, .. } = &body.brep;
    let points = |edge: &formats::brep::Edge| {
        let curve = &edge.curve;
        let (low, high) = curve.range();
        let at = |i: usize| low + (high - low) * i as f64 / SEAM_POINTS as f64;
        (0..=SEAM_POINTS).map(|i| Point::from(curve.point(at(i)))).collect()
    };
    edges.iter().map(points).collect()
}

/// The irregular vertices that the loops leave.
fn irregular(body: &BodyConversion) -> Vec<Point> {
    let left: HashSet<[u64; 3]> = body.brep.vertices.iter().map(|p| p.map(f64::to_bits)).collect();
    let is_left = |p: &Point| left.contains(&<[f64; 3]>::from(*p).map(f64::to_bits));
    body.network.irregular().into_iter().filter(is_left).collect()
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
