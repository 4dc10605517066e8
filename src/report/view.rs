//! What the pictures of a report show of a conversion: meshes and the distances of their points.

use crate::deviation::Deviation;
use crate::geometry::{Point, Uv, VertexId};
use crate::mesh::Disk;
#[cfg(feature = "html")]
use crate::mesh::Mesh;
use crate::picture::{Thinned, signed, thin};
#[cfg(feature = "html")]
use crate::picture::{outlines, tessellate};
use crate::{Conversion, Error, Result, Stage};

/// The largest number of triangles of all the scans that a page shows together. A page with more
/// is too large to be mailed, and browsers turn it slowly.
const MOST_TRIANGLES: usize = 300_000;

/// The largest number of points inside all the faces that a page shows together, for the same
/// reason.
#[cfg(feature = "html")]
const MOST_FACE_POINTS: usize = 60_000;

/// Keeps what the stages of one conversion make, until its view can be made.
#[derive(Debug, Default)]
pub struct ViewRecorder {
    measured: Option<Disk>,
    smoothed: Vec<Point>,
    uv: Vec<Uv>,
}

/// What pictures show of one conversion. Distances are mm, positive above the face.
#[derive(Debug)]
pub struct FaceView {
    /// The scan, thinned if it has too many triangles.
    pub(super) scan: Thinned,
    /// Triangles of the scan before it was thinned.
    pub(super) triangles: usize,
    /// The boundary loops: the outer one, the rims of the holes, the rims of the islands.
    pub(super) rims: Vec<Vec<VertexId>>,
    /// Distances of all points of the scan as measured.
    pub(super) measured: Vec<f32>,
    /// Distances of the same points, smoothed.
    #[cfg(feature = "html")]
    pub(super) smoothed: Vec<f32>,
    /// The face as triangles; `None` if it could not be triangulated.
    #[cfg(feature = "html")]
    pub(super) face: Option<Mesh>,
    /// The trim loops in the parameter plane.
    #[cfg(feature = "html")]
    pub(super) outlines: Vec<Vec<Uv>>,
}

impl ViewRecorder {
    /// Keeps what a stage made. A conversion shows every stage to its `watch`.
    pub fn see(&mut self, stage: &Stage) {
        match stage {
            Stage::Mesh(disk) => self.measured = Some((*disk).clone()),
            Stage::Smooth(disk) => self.smoothed.clone_from(&disk.mesh.points),
            Stage::Parameterize(map, _) => self.uv.clone_from(&map.uv),
            _ => {}
        }
    }

    /// The view of a conversion of which the recorder has seen every stage: one of `parts` views
    /// that are drawn together.
    ///
    /// # Errors
    /// [`Error::Input`]: the recorder has not seen the mesh, the smoothed mesh and the parameters
    /// of this conversion.
    pub fn view(self, c: &Conversion, parts: usize) -> Result<FaceView> {
        let ViewRecorder { measured: disk, smoothed, uv } = self;
        let count = c.fit_deviation.distances.len();
        let has_all = |disk: &Disk| {
            disk.mesh.points.len() == count && smoothed.len() == count && uv.len() >= count
        };
        let disk = disk.filter(has_all);
        let disk = disk.ok_or(Error::Input("the recorder must see every stage of a conversion"))?;
        let signs = |points: &[Point], d: &Deviation| {
            signed(&c.surface, points, &uv[..count], &d.distances)
        };
        let measured = signs(&disk.mesh.points, c.vertex_deviation());
        let smoothed = signs(&smoothed, &c.fit_deviation);
        let worst = [&measured, &smoothed].map(|d| worst(d));
        let scan = thin(&disk.mesh, MOST_TRIANGLES / parts.max(1), &worst);
        let rims = disk.loops().map(|ring| moved(ring, &scan)).collect();
        #[cfg(feature = "html")]
        let outlines = outlines(&c.loops);
        Ok(FaceView {
            triangles: disk.mesh.triangles.len(),
            rims,
            measured,
            #[cfg(feature = "html")]
            smoothed,
            #[cfg(feature = "html")]
            face: triangulated(c, &outlines, &uv, &scan, parts),
            #[cfg(feature = "html")]
            outlines,
            scan,
        })
    }
}

/// The face as triangles, with vertices inside it at the parameters of the scan's. Fills that
/// belong to the face have vertices of their own.
#[cfg(feature = "html")]
fn triangulated(
    c: &Conversion,
    outlines: &[Vec<Uv>],
    uv: &[Uv],
    scan: &Thinned,
    parts: usize,
) -> Option<Mesh> {
    let mut inner: Vec<Uv> = scan.old.iter().filter_map(|&v| uv.get(v).copied()).collect();
    if c.trimmed.contains(&false) {
        inner.extend(uv.get(c.fit_deviation.distances.len()..).unwrap_or_default());
    }
    let step = (inner.len() * parts).div_ceil(MOST_FACE_POINTS).max(1);
    let inner: Vec<Uv> = inner.into_iter().step_by(step).collect();
    tessellate(&c.surface, c.outer.is_some(), outlines, &inner)
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
