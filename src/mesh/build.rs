//! From a soup of polygons to an oriented, edge-manifold mesh.
//!
//! The steps are as follows, and [`Repairs`] counts what each of them changes:
//!
//! - Vertices that are not finite are removed, with their faces.
//! - Vertices at the same place are merged.
//! - Polygons are cut into triangles.
//! - Degenerate and duplicate triangles are removed.
//! - Every component is oriented consistently.
//! - Edges with more than two triangles, and vertices with more than one fan, are opened.
//! - Spikes are removed, and triangles without area are flipped away.

use std::collections::BTreeMap;

use foldhash::{HashSet, HashSetExt};
use formats::Soup;
use rayon::prelude::*;

use super::edge_map::Buckets;
use super::{EdgeMap, Mesh, SeamWidth, caps, polygons, scale, seam, spikes, weld};
use crate::error::{Error, Result, of};
use crate::geometry::sets::Sets;
use crate::geometry::{NONE, Point, ROUNDING, SAMPLE, VertexId, bounds};
use crate::rules;
use crate::statistics::quantile;

/// The repairs that were made, as kind and count. A kind that did not occur is absent.
pub type Repairs = BTreeMap<&'static str, usize>;

/// A mesh made from a soup. Every component is edge-manifold, and every vertex has one fan of
/// triangles. The orientation is consistent, except across the sides of the triangles listed in
/// `twisted`.
#[derive(Debug)]
pub struct Build {
    /// All components. One unit of length is `mm` millimetres.
    pub mesh: Mesh,
    /// For each vertex, the place that it had before vertices were opened. Vertices with the same
    /// number are copies of one vertex of the scan.
    pub place: Vec<u32>,
    /// For each point of the soup its number in `place`, or `u32::MAX` for one of no use.
    pub vertices: Vec<u32>,
    /// Triangles whose orientation cannot agree with that of a neighbour.
    pub twisted: Vec<usize>,
    /// The repairs that were made.
    pub repairs: Repairs,
    /// The length in mm of one unit of `mesh`. It is the unit of the scan times the power of two
    /// that gives every scan the same size.
    pub mm: f64,
    /// The length of the scan's unit in that of `mesh`: a power of two.
    pub unit: f64,
    /// The adjacency of `mesh`.
    pub(super) edges: EdgeMap,
}

/// Builds the mesh; `mm` is the length of the soup's unit in mm. The coordinates of the mesh are
/// those of the soup times a power of two, and [`Build::mm`] is the length of their unit.
///
/// # Errors
/// - [`Error::Empty`] if no triangle is left, if the mesh is too small or too large in mm, or if a few points are so
///   far away that the others are one.
/// - [`Error::Option`] if the unit is not a length.
/// - [`Error::Input`] if a polygon has a corner that is not among the points.
pub fn from_soup(soup: &Soup, mm: f64) -> Result<Build> {
    from_soup_joined(soup, mm, SeamWidth::Fixed(0.0), 0.0)
}

/// The same with blocks joined along their common rims, whose points are no farther from each other than
/// `width`. The largest numbers of the file are in steps of `step` ([`FileRounding::largest_step`](super::FileRounding::largest_step)).
///
/// # Errors
/// Those of [`from_soup`].
pub(crate) fn from_soup_joined(soup: &Soup, mm: f64, width: SeamWidth, step: f64) -> Result<Build> {
    rules::length(mm).map_err(of("unit"))?;
    if soup.polygons.iter().flatten().any(|&corner| corner as usize >= soup.points.len()) {
        return Err(Error::Input("a polygon has a corner that is not among the points"));
    }
    if !is_told_apart(soup) {
        return Err(Error::Empty(
            "a few points are so far away that numbers of their size do not tell the others apart"
                .into(),
        ));
    }
    let mut repairs = Repairs::new();
    let factor = scale::to_size(soup, mm);
    let mut welded = weld::weld(soup, mm, factor, &mut repairs);
    let mut triangles = polygons::triangulate(soup, &welded, &mut repairs);
    drop_degenerate(&mut triangles, &mut repairs);
    drop_duplicates(welded.points.len(), &mut triangles, &mut repairs);
    let width = (width, step * factor, mm / factor);
    let place = (0..welded.points.len() as u32).collect();
    let mut build = Build::new(Mesh { points: welded.points, triangles }, place, mm / factor);
    let Build { mesh, edges, .. } = &mut build;
    if seam::join_rims(mesh, edges, &mut welded.number, width, &mut repairs) {
        drop_duplicates(mesh.points.len(), &mut mesh.triangles, &mut repairs);
        *edges = EdgeMap::new(mesh);
    }
    build.unit = factor;
    build.vertices = welded.number;
    build.repairs = repairs;
    build.make_manifold();
    while spikes::drop(&mut build) {
        build.make_manifold();
    }
    if caps::flip(&mut build) {
        build.make_manifold();
    }
    build.drop_unused_vertices();
    forget_joined(&mut build.repairs);
    if build.mesh.triangles.is_empty() {
        return Err(Error::Empty("every face is degenerate or has a non-finite vertex".into()));
    }
    if !build.mm.is_normal() {
        return Err(Error::Empty(
            "its size in mm exceeds the range of floating-point numbers".into(),
        ));
    }
    Ok(build)
}

/// A mesh of which this share of the polygons is as small as the rounding of its largest numbers is no scan.
const MOST_LOST: f64 = 0.1;

/// Whether nearly all polygons with an extent are larger than the rounding of numbers as large as the mesh.
fn is_told_apart(soup: &Soup) -> bool {
    let step = soup.polygons.len().div_ceil(SAMPLE).max(1);
    let at = |&v: &u32| Point::from(soup.points[v as usize]);
    let used = soup.polygons.iter().step_by(step);
    let extents = used.map(|corners| {
        let [low, high] = bounds(corners.iter().map(at));
        (high - low).amax()
    });
    let mut extents: Vec<f64> = extents.filter(|x| *x > 0.0 && x.is_finite()).collect();
    let all = soup.polygons.iter().flatten().map(at);
    let [low, high] = bounds(all.filter(|p| p.iter().all(|x| x.is_finite())));
    let smallest = quantile(&mut extents, MOST_LOST);
    smallest.is_none_or(|smallest| smallest > ROUNDING * (high - low).amax())
}

/// Takes the points that were joined with others off the count of those that no face uses.
fn forget_joined(repairs: &mut Repairs) {
    let joined = repairs.get("joined_rim_vertices").copied().unwrap_or(0);
    if let Some(unused) = repairs.get_mut("unused_vertices") {
        *unused = unused.saturating_sub(joined);
        if *unused == 0 {
            repairs.remove("unused_vertices");
        }
    }
}

/// Adds to the count of a repair.
pub(super) fn count(repairs: &mut Repairs, kind: &'static str, n: usize) {
    if n > 0 {
        *repairs.entry(kind).or_default() += n;
    }
}

/// Drops triangles that repeat a vertex.
fn drop_degenerate(triangles: &mut Vec<[VertexId; 3]>, repairs: &mut Repairs) {
    let before = triangles.len();
    triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
    count(repairs, "degenerate_faces", before - triangles.len());
}

/// Drops triangles that repeat an earlier one in either orientation.
fn drop_duplicates(points: usize, triangles: &mut Vec<[VertexId; 3]>, repairs: &mut Repairs) {
    let sorted = |t: u32| {
        let mut corners = triangles[t as usize];
        corners.sort_unstable();
        corners
    };
    let buckets = Buckets::new(points, triangles.len(), |t| sorted(t)[0].0);
    let repeated = |bucket: &mut Vec<_>, v: usize| {
        bucket.clear();
        bucket.extend(buckets.of(v).iter().map(|&t| (sorted(t), t)));
        bucket.sort_unstable();
        let pairs = bucket.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        pairs.map(|pair| pair[1].1 as usize).collect::<Vec<_>>()
    };
    let of_vertices = (0..points).into_par_iter().map_init(Vec::new, repeated);
    let repeated: Vec<usize> = of_vertices.flatten_iter().collect();
    let mut dropped = vec![false; triangles.len()];
    repeated.into_iter().for_each(|t| dropped[t] = true);
    let before = triangles.len();
    let mut at = dropped.iter();
    triangles.retain(|_| at.next() == Some(&false));
    count(repairs, "duplicate_faces", before - triangles.len());
}

/// Turns triangles so that neighbours agree, most of each component as they were. Returns the triangles that
/// cannot agree with all of their neighbours, in ascending order.
pub(crate) fn orient(mesh: &mut Mesh) -> Vec<usize> {
    let mut build = Build::new(std::mem::take(mesh), Vec::new(), 1.0);
    build.orient();
    *mesh = build.mesh;
    build.twisted
}

impl Build {
    /// A mesh without any repairs, whose unit is `mm` millimetres long.
    pub(super) fn new(mesh: Mesh, place: Vec<u32>, mm: f64) -> Self {
        let edges = EdgeMap::new(&mesh);
        let (vertices, twisted, repairs) = (Vec::new(), Vec::new(), Repairs::new());
        Build { mesh, place, vertices, twisted, repairs, mm, unit: 1.0, edges }
    }

    /// Orients the triangles and opens what is not manifold, until everything is. The edge map must
    /// be up to date before the call and is up to date after it.
    pub(super) fn make_manifold(&mut self) {
        count(&mut self.repairs, "opened_edges", self.edges.overfull().len());
        loop {
            self.orient();
            if !(self.open_fans() || self.drop_at_overfull_edges()) {
                return;
            }
            self.edges = EdgeMap::new(&self.mesh);
        }
    }

    /// Traverses every component and flips triangles to agree with the first one. The orientation
    /// that most triangles of a component have is kept.
    fn orient(&mut self) {
        self.twisted.clear();
        if self.edges.is_oriented(&self.mesh) {
            return;
        }
        let n = self.mesh.triangles.len();
        let mut turned: Vec<Option<bool>> = vec![None; n];
        let mut twisted = HashSet::new();
        let mut flips: Vec<usize> = Vec::new();
        let mut members = Vec::new();
        for first in 0..n {
            if turned[first].is_some() {
                continue;
            }
            members.clear();
            members.push(first);
            turned[first] = Some(false);
            let mut done = 0;
            while let Some(&t) = members.get(done) {
                done += 1;
                for side in 3 * t..3 * t + 3 {
                    let Some(other) = self.edges.across(side) else { continue };
                    let same_way = self.from(side) == self.from(other);
                    let wanted = turned[t].map(|turn| turn ^ same_way);
                    if turned[other / 3].is_none() {
                        turned[other / 3] = wanted;
                        members.push(other / 3);
                    } else if turned[other / 3] != wanted {
                        twisted.insert(t);
                    }
                }
            }
            let turns = members.iter().filter(|&&t| turned[t] == Some(true)).count();
            let fewer = turns * 2 <= members.len();
            flips.extend(members.iter().filter(|&&t| turned[t] == Some(fewer)));
        }
        for &t in &flips {
            self.mesh.triangles[t].swap(1, 2);
            self.edges.turn_over(t);
        }
        count(&mut self.repairs, "flipped_faces", flips.len());
        self.twisted = twisted.into_iter().collect();
        self.twisted.sort_unstable();
    }

    fn from(&self, side: usize) -> VertexId {
        self.mesh.triangles[side / 3][side % 3]
    }

    /// Gives every fan of triangles around a vertex its own vertex. Returns whether any vertex had
    /// more than one fan.
    pub(super) fn open_fans(&mut self) -> bool {
        if self.twisted.is_empty() && self.edges.has_single_fans(&self.mesh) {
            return false;
        }
        let next = |s: usize| s / 3 * 3 + (s % 3 + 1) % 3;
        let mut fans = Sets::new(3 * self.mesh.triangles.len());
        for side in 0..3 * self.mesh.triangles.len() {
            let Some(other) = self.edges.across(side).filter(|&other| side < other) else {
                continue;
            };
            // Across a twisted side both triangles run in the same direction.
            if self.from(side) == self.from(other) {
                fans.join(side, other);
                fans.join(next(side), next(other));
            } else {
                fans.join(side, next(other));
                fans.join(next(side), other);
            }
        }
        // The fan that keeps the vertex, and the new vertices of the other fans.
        let mut owner: Vec<u32> = vec![NONE; self.mesh.points.len()];
        let mut copies = BTreeMap::new();
        for corner in 0..3 * self.mesh.triangles.len() {
            let v = self.from(corner);
            let fan = fans.find(corner) as u32;
            if owner[v.index()] == NONE {
                owner[v.index()] = fan;
            }
            if owner[v.index()] != fan {
                let copy = *copies.entry(fan).or_insert_with(|| {
                    self.mesh.points.push(self.mesh.points[v.index()]);
                    self.place.push(self.place[v.index()]);
                    VertexId::from(self.mesh.points.len() - 1)
                });
                self.mesh.triangles[corner / 3][corner % 3] = copy;
            }
        }
        count(&mut self.repairs, "opened_vertices", copies.len());
        !copies.is_empty()
    }

    /// Drops the smallest triangle at every edge that has more than two triangles although its
    /// vertices have one fan each. Only triangles that run along the edge in the more frequent
    /// direction are candidates, so that the last two run in opposite directions. Returns whether
    /// any was dropped.
    fn drop_at_overfull_edges(&mut self) -> bool {
        let area = |t: usize| self.mesh.area_vector(self.mesh.triangles[t]).norm();
        let mut dropped = HashSet::new();
        for sides in self.edges.overfull() {
            let low = sides.iter().map(|&side| self.from(side as usize)).min();
            let (with, against): (Vec<usize>, Vec<usize>) =
                sides.iter().map(|&s| s as usize).partition(|&s| Some(self.from(s)) == low);
            let most = if with.len() >= against.len() { with } else { against };
            let smallest = most
                .iter()
                .map(|side| side / 3)
                .min_by(|&x, &y| area(x).total_cmp(&area(y)).then(x.cmp(&y)));
            dropped.extend(smallest);
        }
        self.drop_triangles(&dropped);
        count(&mut self.repairs, "faces_dropped_at_non_manifold_edges", dropped.len());
        !dropped.is_empty()
    }

    /// Drops the triangles with the given numbers. The edge map is out of date after the call.
    pub(super) fn drop_triangles(&mut self, dropped: &HashSet<usize>) {
        let mut t = 0;
        self.mesh.triangles.retain(|_| {
            t += 1;
            !dropped.contains(&(t - 1))
        });
    }

    /// Extracts complete components, given by their triangles.
    pub(super) fn part(&self, triangles: &[usize]) -> Build {
        let (mesh, old) = self.mesh.part(triangles.iter().copied());
        let place = old.into_iter().map(|v| self.place[v]).collect();
        let edges = self.edges.part(triangles);
        let (vertices, twisted, repairs) = (Vec::new(), Vec::new(), Repairs::new());
        Build { mesh, place, vertices, twisted, repairs, mm: self.mm, unit: self.unit, edges }
    }

    /// Drops vertices that no triangle uses. The others keep their order.
    fn drop_unused_vertices(&mut self) {
        let mut used = vec![false; self.mesh.points.len()];
        self.mesh.triangles.iter().flatten().for_each(|v| used[v.index()] = true);
        let unused = used.iter().filter(|used| !**used).count();
        count(&mut self.repairs, "unused_vertices", unused);
        if unused > 0 {
            let (mesh, old) = self.mesh.part(0..self.mesh.triangles.len());
            self.place = old.into_iter().map(|v| self.place[v]).collect();
            self.mesh = mesh;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn soup(points: &[[f64; 3]], polygons: &[&[u32]]) -> Soup {
        let mut soup = Soup { points: points.to_vec(), ..Soup::default() };
        for p in polygons {
            soup.polygons.push(p.iter().copied());
        }
        soup
    }

    const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

    #[test]
    fn welds_scales_and_orients() {
        let mut points = SQUARE.to_vec();
        points.extend([[1., 1., 0.], [f64::NAN, 0., 0.]]);
        let b = from_soup(&soup(&points, &[&[0, 1, 2], &[0, 4, 3], &[0, 3, 1], &[5, 1, 2]]), 10.0)
            .unwrap();
        assert_eq!(b.repairs["welded_vertices"], 1);
        assert_eq!(b.repairs["non_finite_vertices"], 1);
        assert!(b.mesh.points.iter().any(|p| p * b.mm == Point::new(10., 10., 0.)));
    }

    #[test]
    fn a_vertex_with_two_fans_is_opened() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
        let b = from_soup(&soup(&points, &[&[0, 1, 2], &[0, 3, 4]]), 1.0).unwrap();
        assert_eq!(b.mesh.points.len(), 6);
        assert_eq!(b.repairs["opened_vertices"], 1);
    }

    #[test]
    fn an_edge_with_three_triangles_is_opened() {
        let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]];
        let b = from_soup(&soup(&points, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]), 1.0).unwrap();
        assert_eq!(b.edges.open_sides().count(), 3 * b.mesh.triangles.len());
        assert_eq!(b.repairs["opened_edges"], 1);
    }

    #[test]
    fn a_flipped_triangle_is_turned() {
        let b = from_soup(&soup(&SQUARE, &[&[0, 1, 2], &[0, 3, 2]]), 1.0).unwrap();
        assert_eq!(b.repairs["flipped_faces"], 1);
        assert_eq!(b.edges.open_sides().count(), 4);
    }

    #[test]
    fn a_moebius_strip_is_twisted() {
        let n = 8;
        let mut points = Vec::new();
        for i in 0..n {
            let a = std::f64::consts::TAU * i as f64 / n as f64;
            for w in [-0.3, 0.3] {
                let r = 1.0 + w * (a / 2.0).cos();
                points.push([r * a.cos(), r * a.sin(), w * (a / 2.0).sin()]);
            }
        }
        let mut polygons: Vec<Vec<u32>> = Vec::new();
        for i in 0..n {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i + 1 < n { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
            polygons.push(vec![a, c, d, b]);
        }
        let polygons: Vec<&[u32]> = polygons.iter().map(|p| p.as_slice()).collect();
        assert!(!from_soup(&soup(&points, &polygons), 1.0).unwrap().twisted.is_empty());
    }
}
