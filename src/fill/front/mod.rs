//! The advancing front of one hole.
//!
//! A front edge runs in the direction of the surface's triangle on its left;
//! the hole is to its right. Closing the ear a b c adds the triangle c b a and
//! puts the edge a c in place of a b and b c; a new point p at the edge a b
//! adds the triangle b a p. What the paper leaves open:
//!
//! - Islands in the hole are bridged to its rim first, by the shortest path,
//!   which then is an edge of the front on both sides.
//! - A new point that comes near another part of the front is not placed; the
//!   edge is joined to the front's vertex there instead, and the front splits
//!   in two.
//! - Where a round does neither, φ is raised until an ear that crosses nothing
//!   is closed; without one, the ring of the front is spanned by least area.
//!
//! The mesh stays a manifold: no edge is made twice. The number of points is
//! bounded and every other step shortens a ring, so it ends.

mod ears;
mod gap;
mod islands;
mod points;

use foldhash::{HashSet, HashSetExt};

use super::Options;
use super::faults::Ground;
use super::ring::Rings;
use crate::geometry::{LocalPlane, Point, Vector, VertexId, segment_distance};
use crate::mesh::Adjacency;
use crate::mesh::mls::Cloud;
use crate::mesh::remesh::Sizes;
use crate::mesh::{self, Mesh};

/// What the fronts of all holes look at.
pub struct Surroundings<'a> {
    pub mesh: &'a Mesh,
    pub rings: &'a mesh::VertexRings,
    pub cloud: &'a Cloud,
    pub ground: &'a Ground,
}

impl Surroundings<'_> {
    /// Does something with all that is around the holes of a mesh.
    pub fn with<T>(mesh: &Mesh, what: impl FnOnce(&Surroundings) -> T) -> T {
        let rings = mesh::VertexRings::new(mesh);
        let (cloud, ground) = rayon::join(|| Cloud::of(mesh, &rings), || Ground::new(mesh));
        what(&Surroundings { mesh, rings: &rings, cloud: &cloud, ground: &ground })
    }

    fn adjacency(&self) -> Adjacency<'_> {
        Adjacency { mesh: self.mesh, rings: self.rings }
    }

    /// Whether the mesh joins two vertices; new ones it does not.
    pub fn joined(&self, v: VertexId, w: VertexId) -> bool {
        self.adjacency().joined(v, w)
    }

    /// The unit normal of a triangle of the mesh between two vertices.
    pub fn normal_at(&self, v: VertexId, w: VertexId) -> Option<Vector> {
        self.adjacency().normal_at(v, w)
    }
}

/// The triangles and points that close a hole. New vertices are numbered from
/// the mesh's vertex count on.
#[derive(Clone)]
pub struct Fill {
    pub points: Vec<Point>,
    pub triangles: Vec<[VertexId; 3]>,
    /// Ears closed although they were wider than φ.
    pub wide_ears: usize,
    /// Rings that were spanned at once.
    pub spanned: usize,
}

/// By which a front is led: a plane in which the hole does not overlap, and the
/// surface over it, by the point next to a place and the unit normal there.
pub struct Lead<'a> {
    pub plane: LocalPlane,
    pub surface: &'a (dyn Fn(Point) -> Option<(Point, Vector)> + Sync),
}

/// A hole, and what is around it.
#[derive(Clone, Copy)]
pub struct Hole<'a> {
    pub around: &'a Surroundings<'a>,
    /// The outer rim, then those of islands.
    pub rims: &'a [&'a [VertexId]],
    pub sizes: &'a Sizes,
}

/// How a front advances.
pub enum Way<'a> {
    /// By MLS; crossings are looked for in local planes.
    Mls(Support),
    /// By a lead, which cannot fail but where the rims cross.
    Led(Lead<'a>),
}

/// Closes a hole by the front. `None` where the front went astray: it grew without
/// closing in, or came to a halt.
pub fn advance(hole: Hole, options: &Options, way: Way) -> Option<Fill> {
    let is_led = matches!(way, Way::Led(_));
    let mut front = Front::new(hole, options, way);
    front.bridge_islands(hole.rims);
    front.close_triangle(0);
    while front.rings.len() > 0 {
        let before = front.fill.triangles.len();
        front.close_ears(options.ear_angle);
        if !is_led && front.is_growing() {
            return None;
        }
        front.rings.renew();
        front.advance();
        if before == front.fill.triangles.len() {
            front.close_wide_ears(options.ear_angle)?;
        }
    }
    Some(front.fill)
}

/// Closes a hole at once, not by a front; `None` where the numbers forbid it.
pub fn span(hole: Hole, options: &Options) -> Option<Fill> {
    let mut front = Front::new(hole, options, Way::Mls(SUPPORTS[0]));
    front.bridge_islands(hole.rims);
    front.span(0)?;
    Some(front.fill)
}

/// The MLS approximations by which a front advances.
#[derive(Debug, Clone, Copy)]
pub struct Support {
    /// Their support, in edge lengths.
    edges: f64,
    /// How many edges in a row share the one at the middle of them.
    shared: usize,
}

/// What a front tries in turn until it does not go astray: a support of two edges
/// is enough for a plane and its bends in the half disk that lies beside a rim;
/// rough rims want an approximation for each edge, or a wider one.
pub const SUPPORTS: [Support; 3] = [
    Support { edges: 2.0, shared: 5 },
    Support { edges: 2.0, shared: 1 },
    Support { edges: 3.0, shared: 1 },
];

/// Edges of the front are looked at, whether a triangle crosses them, within so
/// many times its own reach from its centre.
const NEAR: f64 = 2.5;

struct Front<'a> {
    around: &'a Surroundings<'a>,
    sizes: &'a Sizes,
    way: Way<'a>,
    rings: Rings,
    /// The new vertices, as of the last round, for neighbourhoods.
    placed: Option<Cloud>,
    /// Normals of the new vertices.
    normals: Vec<Vector>,
    /// Edges made here, lower vertex first.
    edges: HashSet<(VertexId, VertexId)>,
    /// The sides of the triangles made here, each in its direction.
    #[cfg(debug_assertions)]
    sides: HashSet<(VertexId, VertexId)>,
    fill: Fill,
    support: f64,
    rim: usize,
    most_points: usize,
}

impl<'a> Front<'a> {
    fn new(Hole { around, rims, sizes }: Hole<'a>, options: &Options, way: Way<'a>) -> Self {
        let rim: usize = rims.iter().map(|r| r.len()).sum();
        // About what edges that grow from the rim leave room for in a disk, and
        // as much again.
        let most_points = 64 + 12 * rim + rim * rim / 128;
        let located = |v: &VertexId| (*v, around.mesh.point(*v));
        let loops: Vec<Vec<_>> = rims.iter().map(|r| r.iter().map(located).collect()).collect();
        Front {
            around,
            sizes,
            way,
            rings: Rings::new(&loops),
            placed: None,
            normals: Vec::new(),
            edges: HashSet::new(),
            #[cfg(debug_assertions)]
            sides: HashSet::new(),
            fill: Fill { points: vec![], triangles: vec![], wide_ears: 0, spanned: 0 },
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

    /// The plane in which to look for crossings around a place.
    fn plane(&self, at: Point, normal: Vector) -> LocalPlane {
        match &self.way {
            Way::Mls(_) => LocalPlane::new(at, normal),
            Way::Led(lead) => lead.plane,
        }
    }

    /// Whether a triangle is upright in the plane at a place, and crosses no edge
    /// of the front that is near and faces the same way.
    fn is_free(&self, corners: [Point; 3], at: Point, normal: Vector) -> bool {
        let centre = Point::from(corners.iter().map(|p| p.coords).sum::<Vector>() / 3.0);
        let reach = corners.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        let radius = NEAR * reach;
        let facing = |node: usize| {
            matches!(self.way, Way::Led(_))
                || self.normal(self.rings.vertex(node)).dot(&normal) > 0.0
        };
        let near = self.rings.near(centre, radius).into_iter();
        let edges: Vec<_> = near
            .filter(|&node| facing(node) || facing(self.rings.after(node)))
            .map(|node| self.rings.edge(node))
            .filter(|&(p, q)| segment_distance(centre, p, q) < radius)
            .collect();
        self.plane(at, normal).is_free(corners, &edges)
    }

    /// Whether two vertices are one, or joined by the mesh or the fill so far.
    fn joined(&self, v: VertexId, w: VertexId) -> bool {
        v == w || self.edges.contains(&(v.min(w), v.max(w))) || self.around.joined(v, w)
    }

    /// Adds a triangle and remembers its edges.
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

    /// Whether the front is not closing in: it has used up its points, or is a
    /// good deal longer than the rim.
    fn is_growing(&self) -> bool {
        self.fill.points.len() >= self.most_points
            || self.rings.len() > self.rim + self.rim / 3 + 16
    }
}

#[cfg(test)]
mod tests {
    use std::cmp::Reverse;
    use std::collections::HashMap;

    use super::*;
    use crate::mesh::EdgeMap;

    /// A bumpy square of n × n cells, without those that `is_cut`.
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

    /// Fills the hole between all loops but the longest, and counts triangles
    /// by directed side over mesh and fill.
    fn filled(mesh: &Mesh) -> (Fill, usize) {
        let edges = EdgeMap::new(mesh);
        let mut loops = mesh::boundary::boundary_loops(mesh, &edges);
        loops.sort_by_key(|l| Reverse(l.len()));
        let rims: Vec<&[VertexId]> = loops[1..].iter().map(Vec::as_slice).collect();
        let points = |r: &&[VertexId]| r.iter().map(|&v| mesh.point(v)).collect::<Vec<_>>();
        let sizes = Sizes::new(&rims.iter().map(points).collect::<Vec<_>>());
        let rings = mesh::VertexRings::new(mesh);
        let cloud = Cloud::of(mesh, &rings);
        let ground = Ground::new(mesh);
        let around = Surroundings { mesh, rings: &rings, cloud: &cloud, ground: &ground };
        let hole = Hole { around: &around, rims: &rims, sizes: &sizes };
        let fill =
            advance(hole, &Options::default(), Way::Mls(SUPPORTS[0])).expect("the front closes");
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
        assert_eq!((open, fill.spanned), (4 * 24, 0));
        assert_eq!(fill.triangles.len(), 2 * fill.points.len() + 46 - 2);
    }

    #[test]
    fn an_island_is_bridged() {
        let mesh = sheet(24, |i, j| {
            let inside = |low, high| (low..high).contains(&i) && (low..high).contains(&j);
            inside(5, 19) && !inside(9, 15)
        });
        let (fill, open) = filled(&mesh);
        assert_eq!((open, fill.spanned), (4 * 24, 0));
        // An annulus: no more triangles than corners in all.
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
