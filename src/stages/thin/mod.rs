//! Thinning of a dense scan before it is smoothed. A disk goes in, and a disk with the same holes and rims comes out.
//!
//! Smoothing leaves nothing that is much smaller than its support h. If the vertices are far closer to
//! each other than h, neighbours tell the same, and every stage takes longer for nothing. Inner
//! vertices are removed by half-edge collapses (Hoppe, "Progressive meshes", 1996) until the
//! edges have about a fixed share of the support. Rims and what is beside them stay. Each vertex remembers how many
//! vertices of the scan it stands for, so that the fit weights it accordingly.

mod average;

pub use average::{Averaged, average};

use crate::error::{Error, Result};
use crate::geometry::{EQUILATERAL, NONE, Point, VertexId};
use crate::mesh::boundary::Loop;
use crate::mesh::one_rings::{HalfEdgeCollapse, OneRings};
use crate::mesh::progressive_mesh::{Collapsing, ProgressiveMesh, mean_edge};
use crate::mesh::{Disk, Mesh, StandIns};
use crate::progress::Progress;

/// The usual [`Options::spacing`]. Thinning after smoothing had shown that with 0.1 almost half of the vertices of a
/// virtual scan of a million are left for the same accuracy, and that with 0.3 its face is 6 % farther from the true surface.
const SPACING: f64 = 0.15;

/// The usual [`Options::fewest`]. The map of so many vertices and the fit take only a few seconds. A fit over far fewer
/// vertices can be worse: scans of 40,000 vertices that were thinned had up to 8 % more rms.
const FEWEST: usize = 100_000;

/// Thinning that would leave more than this share of the vertices is not done. It takes a third of the
/// time of the map that it shortens.
const MOST_LEFT: f64 = 0.5;

/// What is left of a disk.
#[derive(Debug, Clone)]
pub struct Options {
    /// The length of the edges that are left, as a share of the support. A small value leaves more vertices
    /// than the smoothing lets differ. A large one coarsens the surface. The default is 0.15.
    pub spacing: f64,
    /// The number of vertices that are left at least. The default is 100,000.
    pub fewest: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { spacing: SPACING, fewest: FEWEST }
    }
}

impl Options {
    /// Whether a scan with so many vertices may be thinned.
    pub(crate) fn may_thin(&self, vertices: usize) -> bool {
        self.fewest as f64 <= MOST_LEFT * vertices as f64
    }
}

/// What thinning did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Report {
    /// The number of measured vertices that are left.
    pub vertices: usize,
    /// The number of measured vertices that were removed.
    pub removed: usize,
    /// The distance of the places whose means stand for the vertices, if these are much denser than their noise lets tell.
    pub averaged: Option<f64>,
}

impl Report {
    /// The report where nothing was removed.
    pub(crate) fn none(vertices: usize) -> Self {
        Report { vertices, removed: 0, averaged: None }
    }

    /// The report with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Report { averaged: self.averaged.map(|distance| factor * distance), ..self }
    }
}

/// A disk with fewer vertices.
#[derive(Debug)]
#[non_exhaustive]
pub struct ThinnedDisk {
    /// The disk.
    pub disk: Disk,
    /// The numbers that its vertices had, in ascending order.
    pub left: Vec<u32>,
    /// Which of its vertices stands for each vertex that there was.
    pub stand_ins: StandIns,
}

impl ThinnedDisk {
    /// What was done.
    pub fn report(&self) -> Report {
        let vertices = self.left.len();
        let removed = self.stand_ins.vertex_of().len() - vertices;
        Report { vertices, removed, averaged: None }
    }
}

/// Thins a disk whose vertices will be smoothed with the given supports, which are 0 where vertices will
/// not move. `places` are near their smoothed places, so that noise decides nothing. `None` if the disk has few
/// vertices for its supports.
///
/// # Errors
/// [`Error::Input`]: there is not one support and one place for each vertex. The errors of `progress`.
pub fn thin(
    disk: &Disk,
    (places, supports): (&[Point], &[f64]),
    options: &Options,
    progress: &mut Progress,
) -> Result<Option<ThinnedDisk>> {
    let count = disk.mesh.points.len();
    if supports.len() != count || places.len() != count {
        return Err(Error::Input("there are not as many supports and places as vertices"));
    }
    let kept = kept(disk);
    let width = |v: usize| options.spacing * supports[v];
    let target = target(&disk.mesh, (places, &width), &kept).max(options.fewest);
    if target as f64 > MOST_LEFT * count as f64 {
        return Ok(None);
    }
    let loss = |rings: &OneRings, v: u32| mean_edge(places, rings, v) / supports[v as usize];
    let collapsing = Collapsing { points: places, kept: &kept, loss };
    coarser(disk, one_rings(disk), &collapsing, target, progress).map(Some)
}

fn one_rings(disk: &Disk) -> OneRings {
    let rims: Vec<VertexId> = disk.loops().flatten().copied().collect();
    OneRings::new(&disk.mesh, &rims)
}

/// Collapses vertices of a disk until so many are left.
fn coarser(
    disk: &Disk,
    rings: OneRings,
    collapsing: &Collapsing<impl Fn(&OneRings, u32) -> f64 + Sync>,
    target: usize,
    progress: &mut Progress,
) -> Result<ThinnedDisk> {
    let mut hierarchy = ProgressiveMesh::for_good(rings);
    let counts = vec![1.0; disk.mesh.points.len()];
    let mut collapses = CollapseRecord { apex_of: Vec::new(), counts };
    let record = |collapse: &HalfEdgeCollapse| collapses.add(collapse);
    hierarchy.coarsen(collapsing, target, record, progress)?;
    Ok(thinned(disk, hierarchy, collapses))
}

/// How many edges from a rim vertices stay. The triangles beside a rim say how the surface goes on there.
const BESIDE_RIM: usize = 2;

/// The vertices that stay: those of all rims, and those beside them.
fn kept(disk: &Disk) -> Vec<bool> {
    let mut kept = vec![false; disk.mesh.points.len()];
    disk.loops().flatten().for_each(|v| kept[v.index()] = true);
    for _ in 0..BESIDE_RIM {
        let is_beside = |t: &&[VertexId; 3]| {
            let near = t.iter().filter(|v| kept[v.index()]).count();
            (1..3).contains(&near)
        };
        let beside: Vec<VertexId> =
            disk.mesh.triangles.iter().filter(is_beside).flatten().copied().collect();
        beside.into_iter().for_each(|v| kept[v.index()] = true);
    }
    kept
}

/// The number of vertices that are left where edges have the `width` at each vertex. Where that is 0, all vertices stay:
/// half as many as there are triangles.
fn target(mesh: &Mesh, (places, width): (&[Point], &dyn Fn(usize) -> f64), kept: &[bool]) -> usize {
    let share = |corners: &[VertexId; 3]| {
        let least = corners.iter().map(|v| width(v.index())).fold(f64::INFINITY, f64::min);
        (area(places, corners) / (EQUILATERAL * least.powi(2))).min(0.5)
    };
    let inside: f64 = mesh.triangles.iter().map(share).sum();
    inside as usize + kept.iter().filter(|kept| **kept).count()
}

/// The area of a triangle whose vertices have these places.
fn area(places: &[Point], corners: &[VertexId; 3]) -> f64 {
    let [a, b, c] = corners.map(|v| places[v.index()]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// What the collapses did to the vertices.
struct CollapseRecord {
    /// Each collapsed vertex with its apex, in the order of the collapses.
    apex_of: Vec<[u32; 2]>,
    /// How many vertices of the scan each vertex stands for. Those of a collapsed vertex are divided
    /// among the vertices around it.
    counts: Vec<f64>,
}

impl CollapseRecord {
    fn add(&mut self, collapse: &HalfEdgeCollapse) {
        let v = collapse.vertex as usize;
        self.apex_of.push([collapse.vertex, collapse.fan().0]);
        let share = self.counts[v] / collapse.ring.len().max(1) as f64;
        collapse.ring.iter().for_each(|&w| self.counts[w as usize] += share);
    }
}

/// The disk of the vertices that remain.
fn thinned(disk: &Disk, hierarchy: ProgressiveMesh, collapses: CollapseRecord) -> ThinnedDisk {
    let ProgressiveMesh { rings, remaining: left, .. } = hierarchy;
    let mut number = vec![NONE; disk.mesh.points.len()];
    left.iter().zip(0..).for_each(|(&v, new)| number[v as usize] = new);
    let of_loop = |ring: &Loop| {
        let numbers = ring.iter().map(|v| VertexId(number[v.index()]));
        numbers.filter(|v| v.0 != NONE).collect::<Loop>()
    };
    let triangles = triangles(&rings, &left, &number);
    let mut islands = disk.islands.clone();
    // The triangles and the vertices of the islands are the last ones, in their order.
    let (mut from, mut to) = (disk.mesh.triangles.len(), triangles.len());
    for island in islands.iter_mut().rev() {
        island.rim = of_loop(&island.rim);
        let own = &disk.mesh.triangles[from - island.triangles..from];
        from -= island.triangles;
        let first = own.iter().flatten().map(|v| v.0).min().unwrap_or(0);
        let first = left.partition_point(|&v| v < first);
        let before = triangles[..to].partition_point(|t| t[0].index() < first);
        island.triangles = to - before;
        to = before;
    }
    let (outer, holes) = (of_loop(&disk.outer), disk.holes.iter().map(of_loop).collect());
    // A later collapse may have removed the apex of an earlier one.
    for &[v, apex] in collapses.apex_of.iter().rev() {
        number[v as usize] = number[apex as usize];
    }
    let counts = left.iter().map(|&v| collapses.counts[v as usize]).collect();
    let points = left.iter().map(|&v| disk.mesh.points[v as usize]).collect();
    ThinnedDisk {
        disk: Disk { mesh: Mesh { points, triangles }, outer, holes, islands },
        left,
        stand_ins: StandIns::new(number, counts),
    }
}

/// The triangles of the vertices that remain.
fn triangles(rings: &OneRings, left: &[u32], number: &[u32]) -> Vec<[VertexId; 3]> {
    let of_vertex = |&v: &u32| {
        let least = move |(a, b): &(u32, u32)| v < *a && v < *b;
        rings.sides(v).filter(least).map(move |(a, b)| [v, a, b])
    };
    let all = left.iter().flat_map(of_vertex);
    all.map(|t| t.map(|v| VertexId(number[v as usize]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Island;
    use crate::mesh::one_rings::tests::grid;
    use crate::progress;

    /// A sheet of 41 × 41 vertices at distances of 1 with a hole of one quad in its middle.
    fn sheet() -> Disk {
        let patch = grid(41);
        let is_middle =
            |v: &VertexId| [20, 21].contains(&(v.0 / 41)) && [20, 21].contains(&(v.0 % 41));
        let mut mesh = patch.mesh;
        mesh.triangles.retain(|t| !t.iter().all(is_middle));
        let hole = [840, 841, 882, 881].map(VertexId).to_vec();
        Disk { mesh, outer: patch.outer, holes: vec![hole], islands: Vec::new() }
    }

    fn thinned(disk: &Disk, supports: &[f64], fewest: usize) -> Option<ThinnedDisk> {
        let options = Options { fewest, ..Options::default() };
        let outlook = (disk.mesh.points.as_slice(), supports);
        thin(disk, outlook, &options, &mut progress::ignore).unwrap()
    }

    #[test]
    fn rims_stay_and_every_vertex_is_stood_for() {
        let sheet = sheet();
        let ThinnedDisk { disk, left, stand_ins } = thinned(&sheet, &[20.0; 1681], 0).unwrap();
        assert!((400..700).contains(&left.len()), "{}", left.len());
        assert_eq!(disk.outer.len(), sheet.outer.len());
        let at = |disk: &Disk, ring: &[VertexId]| -> Vec<Point> {
            ring.iter().map(|&v| disk.mesh.point(v)).collect()
        };
        assert_eq!(at(&disk, &disk.holes[0]), at(&sheet, &sheet.holes[0]));
        // A disk with a hole has as many triangles as two for each vertex, less one for each rim vertex.
        let rims = disk.outer.len() + disk.holes[0].len();
        assert_eq!(disk.mesh.triangles.len(), 2 * left.len() - rims);
        assert!((stand_ins.counts().iter().sum::<f64>() - 1681.0).abs() < 1e-6);
        // The vertex that stands for another one is near it.
        let of_scan = stand_ins.of_scan(&disk.mesh.points);
        let off = of_scan.iter().zip(&sheet.mesh.points).map(|(p, q)| (p - q).norm());
        assert!(off.fold(0.0, f64::max) < 10.0);
    }

    #[test]
    fn an_island_keeps_its_rim_and_counts_its_triangles() {
        let mut disk = sheet();
        let (points, all) = (disk.mesh.points.len() as u32, disk.mesh.triangles.len());
        let other = sheet();
        let moved = |v: VertexId| VertexId(v.0 + points);
        let far = other.mesh.points.iter().map(|p| Point::new(p.x, p.y, 9.0));
        disk.mesh.points.extend(far);
        disk.mesh.triangles.extend(other.mesh.triangles.iter().map(|t| t.map(moved)));
        disk.islands.push(Island {
            component: 1,
            hole: 0,
            rim: other.outer.iter().map(|&v| moved(v)).collect(),
            holes: 1..2,
            triangles: all,
        });
        disk.holes.push(other.holes[0].iter().map(|&v| moved(v)).collect());
        let thinned = thinned(&disk, &[20.0; 2 * 1681], 0).unwrap().disk;
        let is_far = |t: &&[VertexId; 3]| t.iter().all(|&v| thinned.mesh.point(v).z == 9.0);
        let far = thinned.mesh.triangles.iter().filter(is_far).count();
        assert_eq!(thinned.islands[0].triangles, far);
        assert!(far < all / 2 && thinned.islands[0].rim.len() == other.outer.len());
        assert!(thinned.holes[1].iter().all(|&v| thinned.mesh.point(v).z == 9.0));
    }

    #[test]
    fn a_sheet_with_few_vertices_for_its_supports_stays() {
        let sheet = sheet();
        for (h, fewest) in [(2.0, 0), (0.0, 0), (20.0, 1000)] {
            assert!(thinned(&sheet, &[h; 1681], fewest).is_none());
        }
        let wrong = thin(&sheet, (&[], &[1.0]), &Options::default(), &mut progress::ignore);
        assert!(matches!(wrong, Err(Error::Input(_))));
    }
}
