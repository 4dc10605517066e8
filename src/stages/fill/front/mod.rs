//! The advancing front of one hole.
//!
//! An edge of the front has the direction of the triangle on its left; the hole is to its
//! right. Closing the ear a b c adds the triangle c b a and replaces the edges a b and b c by
//! a c. A new point p at the edge a b adds the triangle b a p. The paper leaves three cases
//! open:
//!
//! - Islands in the hole are first bridged to the rim by the shortest path. The front passes
//!   this path on both sides.
//! - A new point near another part of the front is not placed. Instead the edge is joined to
//!   the vertex of the front that is there, and the front splits in two.
//! - If a round adds no triangle, φ is raised until an ear can be closed. If no ear can be
//!   closed, a guided front closes its loop by least area; any other front has failed.
//!
//! The mesh stays a manifold, because no edge is made twice. The front comes to an end, because
//! the number of points is bounded and every other step shortens a loop.

mod ears;
mod gap;
mod islands;
mod loops;
mod plane;
mod points;

use foldhash::{HashSet, HashSetExt};

use super::Options;
use super::faults::Obstacles;
use crate::geometry::{LocalPlane, Point, Vector, VertexId, segment_distance};
use crate::mesh::Adjacency;
use crate::mesh::mls::Cloud;
use crate::mesh::remesh::Sizes;
use crate::mesh::{self, Mesh};
use loops::FrontLoops;

/// The mesh around the holes, and what all fronts need to know of it.
pub(crate) struct Surroundings<'a> {
    pub mesh: &'a Mesh,
    pub rings: &'a mesh::VertexRings,
    pub cloud: &'a Cloud,
    pub obstacles: &'a Obstacles,
}

impl Surroundings<'_> {
    /// Calls `what` with the surroundings of the holes of a mesh.
    pub(crate) fn with<T>(mesh: &Mesh, what: impl FnOnce(&Surroundings) -> T) -> T {
        let rings = mesh::VertexRings::new(mesh);
        let (cloud, obstacles) = rayon::join(|| Cloud::of(mesh, &rings), || Obstacles::new(mesh));
        what(&Surroundings { mesh, rings: &rings, cloud: &cloud, obstacles: &obstacles })
    }

    fn adjacency(&self) -> Adjacency<'_> {
        Adjacency { mesh: self.mesh, rings: self.rings }
    }

    /// Whether an edge of the mesh joins two vertices. It never joins new ones.
    pub(crate) fn joined(&self, v: VertexId, w: VertexId) -> bool {
        self.adjacency().joined(v, w)
    }

    /// The unit normal of a triangle of the mesh between two vertices.
    pub(crate) fn normal_at(&self, v: VertexId, w: VertexId) -> Option<Vector> {
        self.adjacency().normal_at(v, w)
    }
}

/// The triangles and points that close a hole. The numbers of new vertices follow those of the
/// vertices of the mesh.
#[derive(Clone)]
pub(crate) struct Fill {
    pub points: Vec<Point>,
    pub triangles: Vec<[VertexId; 3]>,
    /// Ears closed although they were wider than φ.
    pub wide_ears: usize,
}

/// The guide of a front: a plane in which the hole does not overlap, and a surface over it, as a
/// function from a point to the point of the surface above or below it and the unit normal there.
pub(crate) struct Guide<'a> {
    pub plane: LocalPlane,
    pub surface: &'a (dyn Fn(Point) -> Option<(Point, Vector)> + Sync),
}

/// A hole and its surroundings.
#[derive(Clone, Copy)]
pub(crate) struct OpenHole<'a> {
    pub around: &'a Surroundings<'a>,
    /// The outer rim, then the rims of islands.
    pub rims: &'a [&'a [VertexId]],
    pub sizes: &'a Sizes,
}

/// How a front advances.
pub(crate) enum Advance<'a> {
    /// Over local MLS approximations. Crossings are looked for in local planes.
    Mls(FrontSupport),
    /// Over a given surface. Crossings are looked for in one plane, so a guided front ends
    /// unless the rims cross each other in this plane.
    Guided(Guide<'a>),
}

/// Closes a hole by the front. `None` if the front fails: it grows instead of closing in, or no
/// triangle can be added.
pub(crate) fn advance(hole: OpenHole, options: &Options, by: Advance) -> Option<Fill> {
    let is_guided = matches!(by, Advance::Guided(_));
    let mut front = Front::new(hole, options, by);
    front.bridge_islands(hole.rims);
    front.close_triangle(0);
    while front.loops.len() > 0 {
        let before = front.fill.triangles.len();
        front.close_ears(options.ear_angle);
        if !is_guided && front.is_growing() {
            return None;
        }
        front.loops.renew();
        front.advance();
        if before == front.fill.triangles.len() {
            front.close_wide_ears(options.ear_angle)?;
        }
    }
    Some(front.fill)
}

/// Closes a hole by the triangulation of least area alone. `None` if that would join two
/// vertices twice, or a number is not finite.
pub(crate) fn least_area(hole: OpenHole, options: &Options) -> Option<Fill> {
    let mut front = Front::new(hole, options, Advance::Mls(SUPPORTS[0]));
    front.bridge_islands(hole.rims);
    front.close_by_least_area(0)?;
    Some(front.fill)
}

/// The MLS approximations of a front.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrontSupport {
    /// Their support radius, in edge lengths.
    edges: f64,
    /// The number of consecutive edges that share the approximation at the middle one.
    shared: usize,
}

/// The approximations that are tried until a front comes to an end. A support of two edges has
/// enough points beside a rim for a plane and its curvature. Rough rims need an approximation
/// for each edge, or a wider one.
pub(crate) const SUPPORTS: [FrontSupport; 3] = [
    FrontSupport { edges: 2.0, shared: 5 },
    FrontSupport { edges: 2.0, shared: 1 },
    FrontSupport { edges: 3.0, shared: 1 },
];

/// An edge of the front can cross a triangle in the projection only if it comes this near to its
/// centre in space, in radii of the triangle. With less the front can pass under itself where
/// its points are rough; with more, edges on another layer of the surface count. Half and twice
/// as much change no fill of the hole bench.
const NEAR: f64 = 2.5;

struct Front<'a> {
    around: &'a Surroundings<'a>,
    sizes: &'a Sizes,
    by: Advance<'a>,
    loops: FrontLoops,
    /// The new vertices at the beginning of this round.
    placed: Option<Cloud>,
    /// Normals of the new vertices.
    normals: Vec<Vector>,
    /// The edges of the new triangles, the lower vertex first.
    edges: HashSet<(VertexId, VertexId)>,
    /// The directed edges of the new triangles.
    #[cfg(debug_assertions)]
    sides: HashSet<(VertexId, VertexId)>,
    fill: Fill,
    support: f64,
    rim: usize,
    most_points: usize,
}

impl<'a> Front<'a> {
    fn new(
        OpenHole { around, rims, sizes }: OpenHole<'a>,
        options: &Options,
        by: Advance<'a>,
    ) -> Self {
        let rim: usize = rims.iter().map(|r| r.len()).sum();
        // About twice the number of vertices in a disk whose edges grow from its rim.
        let most_points = 64 + 12 * rim + rim * rim / 128;
        let located = |v: &VertexId| (*v, around.mesh.point(*v));
        let loops: Vec<Vec<_>> = rims.iter().map(|r| r.iter().map(located).collect()).collect();
        Front {
            around,
            sizes,
            by,
            loops: FrontLoops::new(&loops),
            placed: None,
            normals: Vec::new(),
            edges: HashSet::new(),
            #[cfg(debug_assertions)]
            sides: HashSet::new(),
            fill: Fill { points: vec![], triangles: vec![], wide_ears: 0 },
            support: options.support,
            rim,
            most_points,
        }
    }

    fn normal(&self, v: VertexId) -> Vector {
        match v.index().checked_sub(self.around.mesh.points.len()) {
            None => self.around.cloud.normal(v.index()),
            Some(i) => self.normals[i],
        }
    }

    /// The plane in which to look for crossings around `at`.
    fn plane(&self, at: Point, normal: Vector) -> LocalPlane {
        match &self.by {
            Advance::Mls(_) => LocalPlane::new(at, normal),
            Advance::Guided(guide) => guide.plane,
        }
    }

    /// Whether a triangle is counter-clockwise in the plane at `at`, and crosses no near edge of
    /// the front that faces the same side.
    fn is_free(&self, corners: [Point; 3], at: Point, normal: Vector) -> bool {
        let centre = Point::from(corners.iter().map(|p| p.coords).sum::<Vector>() / 3.0);
        let reach = corners.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let radius = NEAR * reach;
        let facing = |node: usize| {
            matches!(self.by, Advance::Guided(_))
                || self.normal(self.loops.vertex(node)).dot(&normal) > 0.0
        };
        let near = self.loops.near(centre, radius).into_iter();
        let edges: Vec<_> = near
            .filter(|&node| facing(node) || facing(self.loops.after(node)))
            .map(|node| self.loops.edge(node))
            .filter(|&(p, q)| segment_distance(centre, p, q) < radius)
            .collect();
        self.plane(at, normal).is_free(corners, &edges)
    }

    /// Whether two vertices are the same, or joined by an edge of the mesh or of the fill.
    fn joined(&self, v: VertexId, w: VertexId) -> bool {
        v == w || self.edges.contains(&(v.min(w), v.max(w))) || self.around.joined(v, w)
    }

    /// Adds a triangle and its edges.
    fn add(&mut self, t: [VertexId; 3]) {
        self.fill.triangles.push(t);
        for (v, w) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            self.edges.insert((v.min(w), v.max(w)));
            #[cfg(debug_assertions)]
            assert!(self.sides.insert((v, w)), "an edge has one triangle on each side");
        }
    }

    fn add_point(&mut self, p: Point, normal: Vector) -> VertexId {
        let new = VertexId::from(self.around.mesh.points.len() + self.fill.points.len());
        self.fill.points.push(p);
        self.normals.push(normal);
        new
    }

    /// Whether the front is not closing in: it has used up its points, or is a third longer
    /// than the rim.
    fn is_growing(&self) -> bool {
        self.fill.points.len() >= self.most_points
            || self.loops.len() > self.rim + self.rim / 3 + 16
    }
}

#[cfg(test)]
mod tests {
    use std::cmp::Reverse;
    use std::collections::HashMap;

    use super::*;
    use crate::mesh::EdgeMap;

    /// A bumpy square of n × n cells without those for which `is_cut` is true.
    fn sheet(n: usize, is_cut: impl Fn(usize, usize) -> bool) -> Mesh {
        let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let triangles = cells.filter(|&(i, j)| !is_cut(i, j)).flat_map(|(i, j)| {
            let k = i * (n + 1) + j;
            [[k, k + n + 1, k + n + 2], [k, k + n + 2, k + 1]].map(|t| t.map(VertexId::from))
        });
        let triangles: Vec<_> = triangles.collect();
        let at = |k: usize| {
            let (x, y) = ((k / (n + 1)) as f64, (k % (n + 1)) as f64);
            Point::new(x, y, (0.3 * x).sin() * (0.2 * y).cos())
        };
        let all = Mesh { points: (0..(n + 1) * (n + 1)).map(at).collect(), triangles };
        all.part(0..all.triangles.len()).0
    }

    /// Fills the hole that all boundary loops but the longest enclose. Returns the fill, and the
    /// number of boundary edges that are left.
    fn filled(mesh: &Mesh) -> (Fill, usize) {
        let edges = EdgeMap::new(mesh);
        let mut loops = mesh::boundary::boundary_loops(mesh, &edges);
        loops.sort_by_key(|l| Reverse(l.len()));
        let rims: Vec<&[VertexId]> = loops[1..].iter().map(Vec::as_slice).collect();
        let points = |r: &&[VertexId]| r.iter().map(|&v| mesh.point(v)).collect::<Vec<_>>();
        let sizes = Sizes::new(&rims.iter().map(points).collect::<Vec<_>>());
        let rings = mesh::VertexRings::new(mesh);
        let cloud = Cloud::of(mesh, &rings);
        let obstacles = Obstacles::new(mesh);
        let around = Surroundings { mesh, rings: &rings, cloud: &cloud, obstacles: &obstacles };
        let hole = OpenHole { around: &around, rims: &rims, sizes: &sizes };
        let fill = advance(hole, &Options::default(), Advance::Mls(SUPPORTS[0]))
            .expect("the front closes");
        let mut sides: HashMap<(VertexId, VertexId), usize> = HashMap::new();
        for t in mesh.triangles.iter().chain(&fill.triangles) {
            (0..3).for_each(|k| *sides.entry((t[k], t[(k + 1) % 3])).or_default() += 1);
        }
        assert!(sides.values().all(|&n| n == 1), "a side of two triangles");
        let open = sides.keys().filter(|s| !sides.contains_key(&(s.1, s.0))).count();
        (fill, open)
    }

    #[test]
    fn a_slit_makes_the_front_split() {
        let mesh = sheet(24, |i, j| (2..22).contains(&i) && (10..13).contains(&j));
        let (fill, open) = filled(&mesh);
        assert_eq!(open, 4 * 24);
        assert_eq!(fill.triangles.len(), 2 * fill.points.len() + 46 - 2);
    }

    #[test]
    fn an_island_is_bridged() {
        let mesh = sheet(24, |i, j| {
            let inside = |low, high| (low..high).contains(&i) && (low..high).contains(&j);
            inside(5, 19) && !inside(9, 15)
        });
        let (fill, open) = filled(&mesh);
        assert_eq!(open, 4 * 24);
        // By Euler's formula for an annulus.
        assert_eq!(fill.triangles.len(), 2 * fill.points.len() + 4 * 14 + 4 * 6);
    }

    #[test]
    fn a_hole_of_one_triangle_takes_no_point() {
        let mut mesh = sheet(6, |_, _| false);
        mesh.triangles.remove(31);
        let (fill, open) = filled(&mesh);
        assert_eq!((open, fill.triangles.len(), fill.points.len()), (24, 1, 0));
    }
}
