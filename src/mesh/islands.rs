//! Islands: components that lie in a hole of another component. A scanner often sees a patch in the
//! middle of a region that it missed.
//!
//! Each hole is projected along its normal. A component lies in the hole if the rim surrounds it in
//! this projection, if it has about the height of the rim, and if its normal agrees with that of
//! the hole. An island that faces the opposite way is turned over.

use std::collections::HashMap;

use foldhash::HashSet;

use super::boundary::{self, Loop};
use super::build::{Build, Repairs, count};
use super::components::clean;
use super::disk::{self, Disk, Outer};
use super::{EdgeMap, Mesh};
use crate::geometry::{LocalPlane, Point, SAMPLE, Uv, Vector, is_inside, uv_bounds};

/// A component that may be an island.
#[derive(Debug)]
pub(super) struct IslandCandidate {
    /// The number of the component; the largest one is 0.
    pub component: usize,
    /// Its triangles and points.
    pub build: Build,
}

/// The share of an island's vertices that must lie in its hole. The value is less than 1 because a
/// hole in a curved surface may look narrower in projection than it is.
const MIN_INSIDE_SHARE: f64 = 0.95;

/// The smallest cosine of the angle between the mean normals of an island and of its hole. The
/// value is low because both may be curved.
const MIN_NORMAL_COSINE: f64 = 0.2;

/// Puts the candidates that lie in holes of the disk, or in holes of its islands, into these holes.
/// Where two candidates overlap, the first one is kept. The places on the boundaries of the islands
/// are added to `taken`.
pub(super) fn add(
    disk: &mut Disk,
    candidates: Vec<IslandCandidate>,
    taken: &mut HashSet<u32>,
    repairs: &mut Repairs,
) {
    if candidates.is_empty() {
        return;
    }
    let own = hole_projections(disk);
    let mut islands: Vec<PlacedIsland> = Vec::new();
    for IslandCandidate { component, mut build } in candidates {
        let Some(projection) = narrowest(&own, &build.mesh) else { continue };
        let mut done = Repairs::new();
        if projection.normal_cosine(&build.mesh) < 0.0 {
            turn_over(&mut build);
            count(&mut done, "flipped_faces", build.mesh.triangles.len());
        }
        let Ok(island) = clean(build, Outer::Auto, taken, &mut done) else { continue };
        // Islands in different holes are not compared: one may lie behind the other in projection.
        let mut beside = islands.iter().filter(|other| other.hole == projection.hole);
        if !beside.any(|other| overlap(projection, &other.disk, &island)) {
            done.into_iter().for_each(|(kind, n)| count(repairs, kind, n));
            let hole_projections = hole_projections(&island);
            islands.push(PlacedIsland {
                component,
                hole: projection.hole,
                disk: island,
                hole_projections,
            });
        }
    }
    place_islands(disk, &own, islands);
}

/// A candidate that lies in a hole of the disk.
struct PlacedIsland {
    component: usize,
    hole: usize,
    disk: Disk,
    hole_projections: Vec<HoleProjection>,
}

/// Puts each island into the narrowest hole that contains it. The hole belongs to the disk or to an
/// island that was placed before.
fn place_islands(disk: &mut Disk, own: &[HoleProjection], islands: Vec<PlacedIsland>) {
    let parent = |island: &PlacedIsland| {
        let of_main = own.iter().map(|w| (None, w));
        let of_islands =
            islands.iter().flat_map(|i| i.hole_projections.iter().map(|w| (Some(i.component), w)));
        let holding = of_main.chain(of_islands).filter(|(_, w)| w.holds(&island.disk.mesh));
        let narrowest = holding.min_by(|x, y| x.1.area.total_cmp(&y.1.area));
        narrowest.map(|(around, projection)| (around, projection.hole))
    };
    let parents: Vec<_> = islands.iter().map(parent).collect();
    let mut left: Vec<_> =
        islands.into_iter().zip(parents).filter_map(|(i, p)| Some((i, p?))).collect();
    // For the disk and for each placed island, the position of its first hole among the disk's
    // holes.
    let mut first = HashMap::from([(None, 0)]);
    loop {
        let (ready, rest): (Vec<_>, Vec<_>) =
            left.into_iter().partition(|(_, (around, _))| first.contains_key(around));
        if ready.is_empty() {
            return;
        }
        for (island, (around, hole)) in ready {
            let hole = first[&around] + hole;
            first.insert(Some(island.component), disk.holes.len());
            disk.add_island(island.component, hole, island.disk);
        }
        left = rest;
    }
}

/// A hole, projected along its normal.
struct HoleProjection {
    /// The position of the hole among the holes of its piece.
    hole: usize,
    view: LocalPlane,
    outline: Vec<Uv>,
    low: Uv,
    high: Uv,
    /// The lowest and the highest position of an island along the normal.
    heights: [f64; 2],
    area: f64,
}

/// The holes of a piece. Holes without a clear normal and loops that run around the piece are left
/// out.
fn hole_projections(piece: &Disk) -> Vec<HoleProjection> {
    if piece.holes.is_empty() {
        return Vec::new();
    }
    let normals = disk::open_side_normals(&piece.mesh, &EdgeMap::new(&piece.mesh));
    let rims = piece.holes.iter().enumerate();
    rims.filter(|(_, rim)| disk::turn(&piece.mesh, &normals, rim) <= 0)
        .filter_map(|(hole, rim)| HoleProjection::new(&piece.mesh, hole, rim))
        .collect()
}

/// The narrowest of the holes that contain a mesh.
fn narrowest<'a>(holes: &'a [HoleProjection], mesh: &Mesh) -> Option<&'a HoleProjection> {
    holes.iter().filter(|w| w.holds(mesh)).min_by(|x, y| x.area.total_cmp(&y.area))
}

impl HoleProjection {
    fn new(mesh: &Mesh, hole: usize, rim: &Loop) -> Option<Self> {
        // The hole lies to the right of its rim.
        let area = -boundary::area(mesh, rim);
        let view = LocalPlane::new(mesh.point(rim[0]), area.try_normalize(0.0)?);
        let outline = outline(&view, mesh, rim);
        let [low, high] = uv_bounds(&outline);
        let half_width = 2.0 * area.norm() / boundary::length(mesh, rim);
        let heights = || rim.iter().map(|&v| view.height(mesh.point(v)));
        let heights = [
            heights().fold(f64::INFINITY, f64::min) - half_width,
            heights().fold(f64::NEG_INFINITY, f64::max) + half_width,
        ];
        Some(HoleProjection { hole, view, outline, low, high, heights, area: area.norm() })
    }

    /// Whether almost all of a mesh lies in the hole at about the height of its rim, and its mean
    /// normal is nearly parallel or anti-parallel to that of the hole.
    fn holds(&self, mesh: &Mesh) -> bool {
        let sample: Vec<Point> = sample(mesh).collect();
        let mut may_miss = ((1.0 - MIN_INSIDE_SHARE) * sample.len() as f64) as usize;
        for p in sample {
            if !self.has(p) {
                let Some(left) = may_miss.checked_sub(1) else { return false };
                may_miss = left;
            }
        }
        self.normal_cosine(mesh).abs() > MIN_NORMAL_COSINE
    }

    fn has(&self, p: Point) -> bool {
        let (uv, height) = (self.view.flat(p), self.view.height(p));
        let boxed = self.low.inf(&uv) == self.low && self.high.sup(&uv) == self.high;
        boxed
            && (self.heights[0]..=self.heights[1]).contains(&height)
            && is_inside(uv, &self.outline)
    }

    /// The cosine of the angle between the mean normals of the hole and of a mesh.
    fn normal_cosine(&self, mesh: &Mesh) -> f64 {
        let area: Vector = mesh.triangles.iter().map(|&t| mesh.area_vector(t)).sum();
        area.try_normalize(0.0).map_or(0.0, |normal| normal.dot(&self.view.normal))
    }
}

/// Whether one of two islands covers a vertex of the other in the projection of a hole.
fn overlap(projection: &HoleProjection, one: &Disk, other: &Disk) -> bool {
    let covers = |piece: &Disk, mesh: &Mesh| {
        let outlines: Vec<Vec<Uv>> =
            piece.loops().map(|ring| outline(&projection.view, &piece.mesh, ring)).collect();
        let around = |uv: Uv| outlines.iter().filter(|o| is_inside(uv, o)).count();
        sample(mesh).any(|p| around(projection.view.flat(p)) % 2 == 1)
    };
    covers(one, &other.mesh) || covers(other, &one.mesh)
}

/// The projection of a loop.
fn outline(view: &LocalPlane, mesh: &Mesh, ring: &Loop) -> Vec<Uv> {
    ring.iter().map(|&v| view.flat(mesh.point(v))).collect()
}

/// Some of the vertices, spread evenly over the vertex numbers.
fn sample(mesh: &Mesh) -> impl Iterator<Item = Point> + '_ {
    mesh.points.iter().copied().step_by((mesh.points.len() / SAMPLE).max(1))
}

/// Reverses the orientation of all triangles.
fn turn_over(build: &mut Build) {
    build.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    build.edges = EdgeMap::new(&build.mesh);
}
