//! A progressive mesh: a mesh that is simplified by half-edge collapses, in passes that can be
//! undone by vertex splits (Hoppe, "Progressive meshes", 1996). Praun and Hoppe ("Spherical
//! parametrization and remeshing", 2003) map a surface from coarse to fine in this way.

use rayon::prelude::*;

use super::one_rings::{HalfEdgeCollapse, OneRings};
use crate::error::Result;
use crate::geometry::{Point, Vector};
use crate::progress::Progress;

/// A mesh with the record of its collapses.
pub(crate) struct ProgressiveMesh {
    /// The connectivity of the present mesh.
    pub rings: OneRings,
    /// The vertices of the present mesh, in ascending order.
    pub remaining: Vec<u32>,
    /// The collapses of each pass. Collapses of one pass do not touch each other.
    passes: Vec<Vec<HalfEdgeCollapse>>,
    /// Whether collapses are kept, so that they can be undone.
    keeps: bool,
}

/// Which vertices are collapsed, and in which order.
pub(crate) struct Collapsing<'a, L> {
    /// The points of the full mesh.
    pub points: &'a [Point],
    /// The vertices that stay.
    pub kept: &'a [bool],
    /// What is lost with a vertex of the present mesh. The vertices with the smallest loss go first.
    pub loss: L,
}

/// A pass that removes less than this share of the vertices is the last one.
const MIN_PASS_SHARE: f64 = 0.01;

/// The largest number of neighbours that the apex of a fan should have.
const MAX_VALENCE: usize = 14;

/// A vertex with more neighbours than this is collapsed once it has fewer, as the time of its collapse grows with the
/// square of their number. Collapses around it do not wait for each other: only their own ring and that of their
/// apex decide on them, and otherwise each would take a batch. No scan has such a vertex.
const MOST_NEIGHBOURS: usize = 1000;

impl ProgressiveMesh {
    /// The full mesh, without collapses.
    pub(crate) fn new(rings: OneRings) -> Self {
        let remaining = (0..rings.len() as u32).collect();
        ProgressiveMesh { rings, remaining, passes: Vec::new(), keeps: true }
    }

    /// The same for collapses that are never undone.
    pub(crate) fn for_good(rings: OneRings) -> Self {
        ProgressiveMesh { keeps: false, ..ProgressiveMesh::new(rings) }
    }

    /// Collapses vertices until at most `target` are left or none can be collapsed. Vertices with a
    /// small loss go first. Vertices with `kept` set stay. Each collapse is passed to `show`.
    pub(crate) fn coarsen(
        &mut self,
        collapsing: &Collapsing<impl Fn(&OneRings, u32) -> f64 + Sync>,
        target: usize,
        mut show: impl FnMut(&HalfEdgeCollapse),
        progress: &mut Progress,
    ) -> Result<()> {
        while self.remaining.len() > target {
            progress(1.0 - self.remaining.len() as f64 / self.rings.len() as f64)?;
            let pass = self.pass(collapsing, target);
            let idle = (pass.len() as f64) < MIN_PASS_SHARE * self.remaining.len() as f64;
            let stays = |v: &u32| !self.rings.ring(*v).is_empty();
            self.remaining = self.remaining.par_iter().copied().filter(stays).collect();
            pass.iter().for_each(&mut show);
            if self.keeps {
                self.passes.push(pass);
            }
            if idle {
                break;
            }
        }
        Ok(())
    }

    fn pass(
        &mut self,
        collapsing: &Collapsing<impl Fn(&OneRings, u32) -> f64 + Sync>,
        target: usize,
    ) -> Vec<HalfEdgeCollapse> {
        let &Collapsing { points, kept, ref loss } = collapsing;
        let rings = &self.rings;
        let loose = |v: &&u32| !kept[**v as usize];
        let mut order: Vec<(f64, u32)> =
            self.remaining.par_iter().filter(loose).map(|&v| (loss(rings, v), v)).collect();
        order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // The vertices late in the order have a large loss. They are considered in a later pass,
        // when more vertices around them are collapsed.
        order.truncate((order.len() * 3 / 4).max(8));
        let mut pass = CollapsePass {
            most: self.remaining.len() - target,
            collapses: Vec::new(),
            locked: vec![0; points.len()],
        };
        let mut order = order.into_iter().map(|(_, v)| v);
        let mut deferred = Vec::new();
        for number in 1.. {
            deferred.extend(order.by_ref().take(BATCH));
            if deferred.is_empty() || pass.is_full() {
                break;
            }
            deferred = pass.collapse(points, &mut self.rings, number, &deferred);
        }
        pass.collapses
    }

    /// Undoes the last pass. All its collapses are first passed to `show`, in the order in which
    /// they were made. Returns `false` if no collapse is left.
    pub(crate) fn refine(&mut self, show: impl FnOnce(&[HalfEdgeCollapse])) -> bool {
        let Some(pass) = self.passes.pop() else { return false };
        show(&pass);
        self.rings.split(&pass);
        self.remaining.extend(pass.iter().map(|collapse| collapse.vertex));
        self.remaining.par_sort_unstable();
        true
    }
}

/// The number of vertices whose collapses are searched in parallel before any of them is made.
/// Vertices deferred from the last batch are added. In a larger batch more vertices have to be
/// deferred; in a smaller one the synchronization of the threads costs too much.
const BATCH: usize = 1 << 13;

/// A pass in progress.
struct CollapsePass {
    /// The largest number of collapses.
    most: usize,
    collapses: Vec<HalfEdgeCollapse>,
    /// For each vertex the number of the batch in which a collapse touched it, or 0.
    locked: Vec<u32>,
}

impl CollapsePass {
    fn is_full(&self) -> bool {
        self.collapses.len() >= self.most
    }

    fn is_free(&self, v: u32) -> bool {
        self.locked[v as usize] == 0
    }

    /// Collapses the vertices of a batch that no earlier collapse of the pass touches, in their
    /// order. If a collapse of the same batch touches a neighbour of a vertex, its best collapse
    /// may have changed. Such vertices are returned.
    fn collapse(
        &mut self,
        points: &[Point],
        rings: &mut OneRings,
        number: u32,
        batch: &[u32],
    ) -> Vec<u32> {
        let find = |&v: &u32| if self.is_free(v) { best_collapse(points, rings, v) } else { None };
        let found: Vec<Option<HalfEdgeCollapse>> =
            batch.par_iter().with_min_len(64).map(find).collect();
        let first = self.collapses.len();
        let mut deferred = Vec::new();
        for collapse in found.into_iter().flatten() {
            let v = collapse.vertex;
            if self.is_full() {
                break;
            }
            if !self.is_free(v) {
                continue;
            }
            let apex = collapse.fan().0;
            let is_changed = |&w: &u32| {
                let is_near = w == apex || rings.ring(w).len() <= MOST_NEIGHBOURS;
                is_near && self.locked[w as usize] == number
            };
            if collapse.ring.iter().any(is_changed) {
                deferred.push(v);
                continue;
            }
            collapse.ring.iter().for_each(|&w| self.locked[w as usize] = number);
            self.collapses.push(collapse);
        }
        rings.apply(&self.collapses[first..]);
        deferred
    }
}

/// What the shape loses by a collapse, in mm: the distance of the vertex from the mean plane of its
/// ring, plus a share of the edge length, so that vertices in flat regions become evenly distributed.
pub(crate) fn shape_loss(points: &[Point], rings: &OneRings, v: u32) -> f64 {
    let p = points[v as usize];
    let ring = rings.ring(v);
    let away = |&w: &u32| points[w as usize] - p;
    let n = ring.len().max(1) as f64;
    let edge = mean_edge(points, rings, v);
    if rings.on_boundary(v) {
        let ends = ring.first().zip(ring.last());
        let bend = ends.map_or(0.0, |(a, b)| (away(a) + away(b)).norm());
        return 0.5 * bend + 0.05 * edge;
    }
    let mean = ring.iter().map(away).sum::<Vector>() / n;
    let normal = normal(points, rings, v);
    mean.dot(&normal).abs() + 0.05 * edge
}

/// The mean length of the edges of a vertex.
pub(crate) fn mean_edge(points: &[Point], rings: &OneRings, v: u32) -> f64 {
    let (p, ring) = (points[v as usize], rings.ring(v));
    ring.iter().map(|&w| (points[w as usize] - p).norm()).sum::<f64>() / ring.len().max(1) as f64
}

/// The unit normal at a vertex.
pub(crate) fn normal(points: &[Point], rings: &OneRings, v: u32) -> Vector {
    let p = points[v as usize];
    let areas =
        rings.sides(v).map(|(a, b)| (points[a as usize] - p).cross(&(points[b as usize] - p)));
    areas.sum::<Vector>().try_normalize(0.0).unwrap_or_else(Vector::zeros)
}

/// The collapse whose worst triangle is best. Collapses that leave no triangle upside down are
/// preferred.
fn best_collapse(points: &[Point], rings: &OneRings, v: u32) -> Option<HalfEdgeCollapse> {
    let n = rings.ring(v).len();
    if n > MOST_NEIGHBOURS {
        return None;
    }
    let up = normal(points, rings, v);
    let rate = |k: usize| (worst_of_fan(points, rings, v, k, up), k);
    let mut rated: Vec<(f64, usize)> = (0..n).map(rate).collect();
    rated.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    rated.into_iter().find_map(|(_, k)| rings.collapse(v, k))
}

/// The smallest quality of the triangles that replace the star of v if it is collapsed to its
/// `k`-th neighbour. The quality is the area divided by the sum of the squared sides.
fn worst_of_fan(points: &[Point], rings: &OneRings, v: u32, k: usize, up: Vector) -> f64 {
    let ring = rings.ring(v);
    let n = ring.len();
    let apex = points[ring[k] as usize];
    let away = |j: usize| points[ring[(k + j) % n] as usize] - apex;
    let shape = |j: usize| {
        let (d, e) = (away(j), away(j + 1));
        let area = d.cross(&e);
        let sides = d.norm_squared() + e.norm_squared() + (e - d).norm_squared();
        let upright = if area.dot(&up) > 0.0 { area.norm() } else { area.dot(&up) };
        upright / sides.max(f64::MIN_POSITIVE)
    };
    let worst = (2..n).map(|j| shape(j - 1)).fold(f64::INFINITY, f64::min);
    let crowded = rings.ring(ring[k]).len() + n > MAX_VALENCE + 4;
    if crowded { worst - 1.0 } else { worst }
}
