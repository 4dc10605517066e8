//! Repair of folded triangles. Projections move vertices by about the size of the noise. Where this
//! is near the distance between points, or where a boundary was drawn in over its neighbours,
//! triangles end upside down. Their vertices are moved along the surface until the triangles are
//! upright; the surface itself does not change.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::surface::MlsSurface;
use crate::geometry::{MOST_ROUNDS, Point, Vector, VertexId};
use crate::mesh::{Disk, VertexRings};

/// After this number of rounds, boundary vertices move back as well, for the same number of rounds.
/// The two kinds of rounds then alternate, because the positions to which boundary vertices return
/// may be the cause of a fold.
const PATIENCE: usize = 8;

/// A triangle that was folded counts as repaired if it is at least as upright as a triangle whose
/// height is a twentieth of its side.
const MIN_UPRIGHTNESS: f64 = 0.05;

/// The data of a disk whose vertices move along the surface.
struct TangentialSmoothing<'a> {
    surface: &'a MlsSurface,
    rings: VertexRings,
    /// For each boundary vertex its two neighbours on the loop.
    beside: Vec<Option<[VertexId; 2]>>,
    /// Which vertices are fixed.
    pinned: Vec<bool>,
    /// The normals of the surface at the vertices.
    normals: Vec<Vector>,
}

/// The reference for the repair.
pub(crate) struct UnfoldReference<'a> {
    /// The positions of the vertices after the projection onto the surface.
    pub projected: Vec<Point>,
    /// The unit normals of the surface at these positions.
    pub normals: Vec<Vector>,
    /// The corners of the boundary, which are fixed.
    pub corners: &'a [VertexId],
    /// Whether the user named the corners. Corners that were found automatically are released if a
    /// fold persists.
    pub named: bool,
}

/// Unfolds triangles. Inner vertices move towards the middle of their neighbours, and boundary
/// vertices along their loop. Where a fold persists, boundary vertices move half the way back to
/// their projected positions, for some rounds.
pub(crate) fn unfold(disk: &mut Disk, surface: &MlsSurface, by: UnfoldReference) {
    let projected = by.projected;
    let mut smoothing = TangentialSmoothing::new(disk, surface, by.normals, by.corners);
    let stays = |t: u32| disk.mesh.triangles[t as usize].iter().all(|&v| surface.keeps(v));
    let mut folded: Vec<u32> = (0..disk.mesh.triangles.len() as u32)
        .into_par_iter()
        .filter(|&t| !stays(t) && smoothing.uprightness(disk, t) <= 0.0)
        .collect();
    let vertices = Marks::new(disk.mesh.points.len());
    let triangles = Marks::new(disk.mesh.triangles.len());
    // Vertices that may have left the surface since they were last projected.
    let mut moved_off = Vec::new();
    for round in 0..MOST_ROUNDS {
        if folded.is_empty() || round % PATIENCE == PATIENCE - 1 {
            moved_off = vertices.unique(moved_off.into_par_iter());
            smoothing.project_back(disk, &moved_off);
            folded = smoothing.still_folded(disk, folded, &moved_off, &triangles);
            moved_off.clear();
        }
        if folded.is_empty() {
            return;
        }
        let corners = folded.par_iter().flat_map_iter(|&t| disk.mesh.triangles[t as usize]);
        let corners = vertices.unique(corners.map(|v| v.0));
        let is_inner = |v: &u32| smoothing.beside[*v as usize].is_none();
        let around = |&v: &u32| smoothing.rings.neighbours(&disk.mesh, VertexId(v)).map(|v| v.0);
        let inner = corners.par_iter().flat_map_iter(around).filter(is_inner);
        let mut moving = vertices.unique(corners.par_iter().copied().chain(inner));
        moving.retain(|&v| !smoothing.pinned[v as usize]);
        if round == 2 * PATIENCE && !by.named {
            corners.iter().for_each(|&v| smoothing.pinned[v as usize] = surface.keeps(VertexId(v)));
        }
        if round / PATIENCE % 2 == 1 {
            for &v in corners.iter().filter(|v| !is_inner(v)) {
                let p = &mut disk.mesh.points[v as usize];
                *p = nalgebra::center(p, &projected[v as usize]);
            }
        }
        smoothing.smooth_tangentially(disk, &moving);
        folded = smoothing.still_folded(disk, folded, &moving, &triangles);
        moved_off.extend(moving);
    }
    smoothing.project_back(disk, &vertices.unique(moved_off.into_par_iter()));
}

/// Marks for finding repeated numbers. All are false between calls.
struct Marks(Vec<AtomicBool>);

impl Marks {
    /// Marks for numbers below `count`.
    fn new(count: usize) -> Self {
        Marks((0..count).map(|_| AtomicBool::new(false)).collect())
    }

    /// The distinct numbers, in ascending order.
    fn unique(&self, numbers: impl ParallelIterator<Item = u32>) -> Vec<u32> {
        let is_new = |n: &u32| !self.0[*n as usize].swap(true, Ordering::Relaxed);
        let mut numbers: Vec<u32> = numbers.filter(is_new).collect();
        numbers.par_iter().for_each(|&n| self.0[n as usize].store(false, Ordering::Relaxed));
        numbers.par_sort_unstable();
        numbers
    }
}

impl<'a> TangentialSmoothing<'a> {
    fn new(
        disk: &Disk,
        surface: &'a MlsSurface,
        normals: Vec<Vector>,
        corners: &[VertexId],
    ) -> Self {
        let mut beside = vec![None; disk.mesh.points.len()];
        for ring in disk.loops() {
            let n = ring.len();
            for (i, v) in ring.iter().enumerate() {
                beside[v.index()] = Some([ring[(i + n - 1) % n], ring[(i + 1) % n]]);
            }
        }
        let mut pinned: Vec<bool> =
            (0..disk.mesh.points.len()).map(|v| surface.keeps(VertexId::from(v))).collect();
        corners.iter().for_each(|&v| pinned[v.index()] = true);
        TangentialSmoothing {
            surface,
            rings: VertexRings::new(&disk.mesh),
            beside,
            pinned,
            normals,
        }
    }

    /// How far a triangle is from being folded: its area projected along the normal of the surface,
    /// as a share of the squares of its sides. It is negative for a folded triangle.
    fn uprightness(&self, disk: &Disk, t: u32) -> f64 {
        let t = disk.mesh.triangles[t as usize];
        let up: Vector = t.iter().map(|v| self.normals[v.index()]).sum();
        let [a, b, c] = disk.mesh.corners(t);
        let squares = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
        disk.mesh.area_vector(t).dot(&up) / (up.norm() * squares).max(f64::MIN_POSITIVE)
    }

    /// The triangles of `folded` that are not upright yet, and the triangles around moved vertices
    /// that are folded now.
    fn still_folded(
        &self,
        disk: &Disk,
        folded: Vec<u32>,
        moved: &[u32],
        triangles: &Marks,
    ) -> Vec<u32> {
        let lying = folded.into_par_iter().filter(|&t| self.uprightness(disk, t) < MIN_UPRIGHTNESS);
        let mut all: Vec<u32> = lying.collect();
        let around = |&v: &u32| self.rings.triangles(VertexId(v)).iter().copied();
        let around = moved.par_iter().flat_map_iter(around);
        let around = triangles.unique(around);
        all.par_extend(around.into_par_iter().filter(|&t| self.uprightness(disk, t) <= 0.0));
        triangles.unique(all.into_par_iter())
    }

    /// Moves the vertices half the way to the middle of their neighbours, perpendicular to the
    /// surface normals.
    fn smooth_tangentially(&self, disk: &mut Disk, vertices: &[u32]) {
        let target = |&v: &u32| {
            let v = VertexId(v);
            let (p, n) = (disk.mesh.point(v), self.normals[v.index()]);
            let (mut sum, mut count) = (Vector::zeros(), 0.0);
            let mut add = |w: VertexId| {
                sum += disk.mesh.point(w) - p;
                count += 1.0;
            };
            match self.beside[v.index()] {
                Some(beside) => beside.into_iter().for_each(&mut add),
                None => self.rings.neighbours(&disk.mesh, v).for_each(&mut add),
            }
            let step = 0.5 * sum / count;
            p + (step - step.dot(&n) * n)
        };
        let targets: Vec<Point> = vertices.par_iter().map(target).collect();
        vertices.iter().zip(targets).for_each(|(&v, p)| disk.mesh.points[v as usize] = p);
    }

    /// Projects the vertices back onto the surface.
    fn project_back(&mut self, disk: &mut Disk, vertices: &[u32]) {
        let foot = |&v: &u32| self.surface.project(VertexId(v), disk.mesh.point(VertexId(v)));
        let feet: Vec<_> = vertices.par_iter().map(foot).collect();
        for (&v, foot) in vertices.iter().zip(feet) {
            if let Some(foot) = foot {
                disk.mesh.points[v as usize] = foot.point;
                self.normals[v as usize] = foot.normal;
            }
        }
    }
}
