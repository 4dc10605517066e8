//! What the pictures of a report show of a conversion.

use scan2step::deviation::Deviation;
use scan2step::geometry::{Point, Uv, VertexId};
use scan2step::mesh::{Disk, Mesh};
use scan2step::picture::{Thinned, outlines, signed, tessellate, thin};
use scan2step::{Conversion, Stage};

/// Triangles of all the scans that a page shows together.
const MOST_TRIANGLES: usize = 300_000;

/// Points inside all the faces that it shows.
const MOST_FACE_POINTS: usize = 60_000;

/// Keeps what stages make until the conversion is done.
#[derive(Default)]
pub struct Watch {
    measured: Option<Disk>,
    smoothed: Vec<Point>,
    uv: Vec<Uv>,
}

/// Meshes and values to show. Distances are mm, positive above the face.
pub struct Shown {
    /// The scan, with fewer triangles where it has too many.
    pub scan: Thinned,
    /// Triangles of the scan as it was.
    pub triangles: usize,
    /// Its boundary loops: the outer one, those of the holes, those of islands.
    pub rims: Vec<Vec<VertexId>>,
    /// Distances of all its points, as measured.
    pub measured: Vec<f32>,
    /// Distances of all its points, smoothed.
    pub smoothed: Vec<f32>,
    /// The face; `None` where it cannot be cut into triangles.
    pub face: Option<Mesh>,
    /// The trim loops in the parameter plane.
    pub outlines: Vec<Vec<Uv>>,
}

impl Watch {
    /// Looks at a stage.
    pub fn see(&mut self, stage: &Stage) {
        match stage {
            Stage::Mesh(disk) => self.measured = Some((*disk).clone()),
            Stage::Smooth(disk) => self.smoothed.clone_from(&disk.mesh.points),
            Stage::Parameterize(map, _) => self.uv.clone_from(&map.uv),
            _ => {}
        }
    }

    /// What there is to show at the end, one of `parts` conversions of a run.
    pub fn shown(self, c: &Conversion, parts: usize) -> Shown {
        let disk = self.measured.unwrap_or_else(|| Disk {
            mesh: Mesh::default(),
            outer: Vec::new(),
            holes: Vec::new(),
            islands: Vec::new(),
        });
        let count = disk.mesh.points.len();
        let signs = |points: &[Point], d: &Deviation| {
            signed(&c.surface, points, &self.uv[..count.min(self.uv.len())], &d.distances)
        };
        let measured = signs(&disk.mesh.points, &c.deviation);
        let smoothed = signs(&self.smoothed, &c.fit_deviation);
        let worst = [&measured, &smoothed].map(|d| worst(d));
        let scan = thin(&disk.mesh, MOST_TRIANGLES / parts.max(1), &worst);
        let rims = disk.loops().map(|ring| moved(ring, &scan)).collect();
        let outlines = outlines(&c.loops);
        let mut inner: Vec<Uv> = scan.old.iter().filter_map(|&v| self.uv.get(v).copied()).collect();
        if c.trimmed.contains(&false) {
            inner.extend(self.uv.get(count..).unwrap_or_default());
        }
        let step = (inner.len() * parts).div_ceil(MOST_FACE_POINTS).max(1);
        let inner: Vec<Uv> = inner.into_iter().step_by(step).collect();
        let face = tessellate(&c.surface, c.outer.is_some(), &outlines, &inner);
        let triangles = disk.mesh.triangles.len();
        Shown { scan, triangles, rims, measured, smoothed, face, outlines }
    }
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
