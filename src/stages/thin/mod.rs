//! Thinning of a filled scan. A patch goes in, and a patch with the same holes and rims comes out.
//!
//! Smoothing leaves nothing that is much smaller than its support h. If the vertices are far closer to
//! each other than h, neighbours tell the same, and every later stage takes longer for nothing. Inner
//! measured vertices are removed by half-edge collapses (Hoppe, "Progressive meshes", 1996) until the
//! edges have about a fixed share of the support. Rims and fills stay. Each vertex remembers how many
//! vertices of the scan it stands for, so that the fit weights it accordingly.

use std::collections::HashMap;

use crate::error::{Error, Result};
use crate::geometry::{EQUILATERAL, NONE, VertexId};
use crate::mesh::one_rings::{HalfEdgeCollapse, OneRings};
use crate::mesh::progressive_mesh::{Collapsing, ProgressiveMesh, mean_edge};
use crate::mesh::{FaceOrigin, Mesh, Patch, StandIns};
use crate::progress::{self, Progress};

/// The usual [`Options::spacing`]. The face of a virtual scan with a
/// million vertices is 0.0032 mm (rms) from the true surface without thinning, and 0.0034 mm with it.
/// With 0.1 it is 0.0033 mm, but almost half of the vertices are left, and the conversion takes 10 %
/// longer. With 0.3 it is 0.0036 mm.
const SPACING: f64 = 0.15;

/// The usual [`Options::fewest`]. The map of so many vertices and the fit take only a few seconds. A fit over far fewer
/// vertices can be worse: scans of 40,000 vertices that were thinned had up to 8 % more rms.
const FEWEST: usize = 200_000;

/// Thinning that would leave more than this share of the vertices is not done. It takes a third of the
/// time of the map that it shortens.
const MOST_LEFT: f64 = 0.5;

/// What is left of a patch.
#[derive(Debug, Clone)]
pub struct Options {
    /// The length of the edges that are left, as a share of the support. A small value leaves more vertices
    /// than the smoothing lets differ. A large one coarsens the surface. The default is 0.15.
    pub spacing: f64,
    /// The number of vertices that are left at least. The default is 200,000.
    pub fewest: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { spacing: SPACING, fewest: FEWEST }
    }
}

/// What thinning did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Report {
    /// The number of measured vertices that are left.
    pub vertices: usize,
    /// The number of measured vertices that were removed.
    pub removed: usize,
}

impl Report {
    fn of(before: usize, patch: Patch) -> (Patch, Report) {
        let vertices = patch.measured;
        (patch, Report { vertices, removed: before - vertices })
    }
}

/// Thins a patch whose measured vertices were smoothed with the given supports, which are 0 where vertices
/// did not move. Without supports, or if the patch has few vertices for them, it is returned as it is.
///
/// # Errors
/// [`Error::Input`]: there are supports, but not one for each measured vertex.
pub fn thin(patch: Patch, supports: &[f64], options: &Options) -> Result<(Patch, Report)> {
    thin_with(patch, supports, options, &mut progress::ignore)
}

/// The same as [`thin`], with reports of progress.
///
/// # Errors
/// Those of [`thin`], and the errors of `progress`.
pub fn thin_with(
    patch: Patch,
    supports: &[f64],
    options: &Options,
    progress: &mut Progress,
) -> Result<(Patch, Report)> {
    let before = patch.measured;
    if supports.is_empty() {
        return Ok(Report::of(before, patch));
    }
    if supports.len() != patch.measured {
        return Err(Error::Input("there are not as many supports as measured vertices"));
    }
    let kept = kept(&patch);
    let target = target(&patch, supports, &kept, options.spacing).max(options.fewest);
    if target as f64 > MOST_LEFT * patch.mesh.points.len() as f64 {
        return Ok(Report::of(before, patch));
    }
    let points = &patch.mesh.points;
    let loss = |rings: &OneRings, v: u32| mean_edge(points, rings, v) / supports[v as usize];
    let mut hierarchy = ProgressiveMesh::new(OneRings::new(&patch.mesh, &patch.outer));
    let mut collapses = CollapseRecord { apex_of: Vec::new(), counts: vec![1.0; patch.measured] };
    let collapsing = Collapsing { points, kept: &kept, loss };
    let record = |collapse: &HalfEdgeCollapse| collapses.add(collapse);
    hierarchy.coarsen(&collapsing, target, record, progress)?;
    Ok(Report::of(before, thinned(&patch, &hierarchy, &collapses)))
}

/// The vertices that stay: those that were not measured, and those of all rims.
fn kept(patch: &Patch) -> Vec<bool> {
    let mut kept = vec![false; patch.measured];
    kept.resize(patch.mesh.points.len(), true);
    let islands = patch.islands.iter().map(|island| &island.rim);
    let rims = patch.rims.iter().chain(islands).chain([&patch.outer]);
    rims.flatten().for_each(|v| kept[v.index()] = true);
    kept
}

/// The number of vertices that the supports leave. Where nothing was smoothed the support is 0, and all
/// vertices stay: half as many as there are triangles.
fn target(patch: &Patch, supports: &[f64], kept: &[bool], spacing: f64) -> usize {
    let area = |t: usize| {
        let corners = patch.mesh.triangles[t];
        let own = corners.iter().filter(|v| patch.is_measured(**v));
        let least = own.map(|v| supports[v.index()]).fold(f64::INFINITY, f64::min);
        let area = 0.5 * patch.mesh.area_vector(corners).norm();
        (area / (EQUILATERAL * (spacing * least).powi(2))).min(0.5)
    };
    let inside: f64 = patch.measured_triangles().map(area).sum();
    inside as usize + kept.iter().filter(|kept| **kept).count()
}

/// What the collapses did to the measured vertices.
struct CollapseRecord {
    /// Each collapsed vertex with its apex, in the order of the collapses.
    apex_of: Vec<[u32; 2]>,
    /// How many vertices of the scan each vertex stands for. Those of a collapsed vertex are divided
    /// among the measured vertices around it.
    counts: Vec<f64>,
}

impl CollapseRecord {
    fn add(&mut self, collapse: &HalfEdgeCollapse) {
        let v = collapse.vertex as usize;
        self.apex_of.push([collapse.vertex, collapse.fan().0]);
        let measured = self.counts.len();
        let around = || collapse.ring.iter().map(|&w| w as usize).filter(|w| *w < measured);
        let share = self.counts[v] / around().count().max(1) as f64;
        around().for_each(|w| self.counts[w] += share);
    }
}

/// The patch of the vertices that remain.
fn thinned(patch: &Patch, hierarchy: &ProgressiveMesh, collapses: &CollapseRecord) -> Patch {
    let left = &hierarchy.remaining;
    let mut number = vec![NONE; patch.mesh.points.len()];
    left.iter().zip(0..).for_each(|(&v, new)| number[v as usize] = new);
    let moved = |v: &VertexId| VertexId(number[v.index()]);
    let measured = left.partition_point(|v| (*v as usize) < patch.measured);
    let (triangles, origin) = triangles(patch, hierarchy, &number);
    let of_loop = |ring: &Vec<VertexId>| ring.iter().map(moved).collect::<Vec<_>>();
    let mut islands = patch.islands.clone();
    islands.iter_mut().for_each(|island| island.rim = of_loop(&island.rim));
    let mut vertex_of = number[..patch.measured].to_vec();
    // A later collapse may have removed the apex of an earlier one.
    for &[v, apex] in collapses.apex_of.iter().rev() {
        vertex_of[v as usize] = vertex_of[apex as usize];
    }
    let counts = left[..measured].iter().map(|&v| collapses.counts[v as usize]).collect();
    Patch {
        outer: of_loop(&patch.outer),
        measured_outer: patch.measured_outer.as_ref().map(of_loop),
        rims: patch.rims.iter().map(of_loop).collect(),
        stand_ins: Some(StandIns::new(vertex_of, counts)),
        mesh: Mesh {
            points: left.iter().map(|&v| patch.mesh.points[v as usize]).collect(),
            triangles,
        },
        measured,
        origin,
        islands,
    }
}

/// The triangles of the vertices that remain, with their origins. Triangles of fills are still there,
/// because none of their corners was removed.
fn triangles(
    patch: &Patch,
    hierarchy: &ProgressiveMesh,
    number: &[u32],
) -> (Vec<[VertexId; 3]>, Vec<FaceOrigin>) {
    let from_least = |t: [u32; 3]| {
        let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
        [0, 1, 2].map(|k| t[(least + k) % 3])
    };
    let of_fills = (patch.mesh.triangles.iter().zip(&patch.origin))
        .filter(|(_, origin)| **origin != FaceOrigin::Measured);
    let of_fills: HashMap<[u32; 3], FaceOrigin> =
        of_fills.map(|(t, origin)| (from_least(t.map(|v| v.0)), *origin)).collect();
    let of_vertex = |&v: &u32| {
        let least = move |(a, b): &(u32, u32)| v < *a && v < *b;
        hierarchy.rings.sides(v).filter(least).map(move |(a, b)| [v, a, b])
    };
    let all = hierarchy.remaining.iter().flat_map(of_vertex);
    let origin = |t: &[u32; 3]| of_fills.get(t).copied().unwrap_or(FaceOrigin::Measured);
    all.map(|t| (t.map(|v| VertexId(number[v as usize])), origin(&t))).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::mesh::one_rings::tests::grid;

    /// A sheet of 41 × 41 vertices at distances of 1. The middle quad is a fill.
    fn sheet() -> Patch {
        let mut patch = grid(41);
        let middle = |t: &[VertexId; 3]| {
            t.iter().all(|v| [20, 21].contains(&(v.0 / 41)) && [20, 21].contains(&(v.0 % 41)))
        };
        for (t, origin) in patch.mesh.triangles.iter().zip(&mut patch.origin) {
            if middle(t) {
                *origin = FaceOrigin::Hole(0);
            }
        }
        patch.rims = vec![[840, 841, 882, 881].map(VertexId).to_vec()];
        patch
    }

    #[test]
    fn rims_and_fills_stay_and_every_vertex_is_stood_for() {
        let sheet = sheet();
        let options = Options { fewest: 0, ..Options::default() };
        let (thinned, report) = thin(sheet.clone(), &[20.0; 1681], &options).unwrap();
        assert_eq!([report.vertices, report.removed], [thinned.measured, 1681 - thinned.measured]);
        assert!(thinned.is_disk());
        assert!((300..400).contains(&thinned.measured), "{}", thinned.measured);
        assert_eq!(thinned.outer.len(), sheet.outer.len());
        let at = |patch: &Patch, ring: &[VertexId]| -> Vec<Point> {
            ring.iter().map(|&v| patch.mesh.point(v)).collect()
        };
        assert_eq!(at(&thinned, &thinned.rims[0]), at(&sheet, &sheet.rims[0]));
        assert_eq!(thinned.origin.iter().filter(|o| **o == FaceOrigin::Hole(0)).count(), 2);
        let counts = thinned.counts();
        assert!((counts.iter().sum::<f64>() - 1681.0).abs() < 1e-6);
        // The vertex that stands for another one is near it.
        let of_scan = thinned.stand_ins.as_ref().unwrap().of_scan(&thinned.mesh.points);
        let off = of_scan.iter().zip(&sheet.mesh.points).map(|(p, q)| (p - q).norm());
        assert!(off.fold(0.0, f64::max) < 10.0);
    }

    #[test]
    fn a_sheet_with_few_vertices_for_its_supports_stays() {
        let sheet = sheet();
        for (supports, fewest) in
            [(vec![], 0), (vec![2.0; 1681], 0), (vec![0.0; 1681], 0), (vec![20.0; 1681], 1000)]
        {
            let options = Options { fewest, ..Options::default() };
            let (patch, report) = thin(sheet.clone(), &supports, &options).unwrap();
            assert!(patch.stand_ins.is_none() && report.removed == 0);
        }
        assert!(matches!(thin(sheet, &[1.0], &Options::default()), Err(Error::Input(_))));
    }
}
