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
//! - Where a round does neither, the narrowest ear that crosses nothing is
//!   closed although it is wider than φ; without one, the ring of the front is
//!   left to a membrane.
//!
//! The mesh stays a manifold: no edge is made twice. The number of points is
//! bounded and every other step shortens a ring, so it ends.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use foldhash::{HashSet, HashSetExt};

use super::plane::LocalPlane;
use super::ring::Rings;
use super::size::Sizes;
use super::{Options, membrane};
use crate::geometry::{Point, Vector, VertexId, segment_distance};
use crate::mesh::mls::{self, Cloud, Polynomial, Sample};
use crate::mesh::{self, Mesh};

/// What the fronts of all holes look at.
pub struct Surroundings<'a> {
    pub mesh: &'a Mesh,
    pub rings: &'a mesh::Rings,
    pub cloud: &'a Cloud,
}

/// The triangles and points that close a hole. New vertices are numbered from
/// the mesh's vertex count on.
#[derive(Clone)]
pub struct Fill {
    pub points: Vec<Point>,
    pub triangles: Vec<[VertexId; 3]>,
    /// Ears closed although they were wider than φ.
    pub wide_ears: usize,
    /// Rings that were left to a membrane.
    pub membranes: usize,
}

/// By which a front is led: a plane in which the hole does not overlap, and the
/// surface over it, by the point next to a place and the unit normal there.
pub struct Lead<'a> {
    pub plane: LocalPlane,
    pub surface: &'a dyn Fn(Point) -> Option<(Point, Vector)>,
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
    /// By MLS, with a support in edge lengths; crossings are looked for in local
    /// planes.
    Mls(f64),
    /// By a lead, which cannot fail but where the rims cross.
    Led(Lead<'a>),
}

/// Closes a hole by the front. `None` where the front went astray: it grew without closing in.
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
        front.advance();
        if before == front.fill.triangles.len() {
            front.close_wide_ears(options.ear_angle)?;
        }
    }
    Some(front.fill)
}

/// Closes a hole by a membrane alone; `None` where the numbers forbid it.
pub fn span(hole: Hole, options: &Options) -> Option<Fill> {
    let mut front = Front::new(hole, options, Way::Mls(SUPPORTS[0]));
    front.bridge_islands(hole.rims);
    front.span(0)?;
    Some(front.fill)
}

/// A new point is at least this far from every other, in edge lengths wanted
/// there.
const APART: f64 = 0.55;

/// And this far from the front edge that it is joined to: flatter triangles
/// are left to ears.
const LOWEST: f64 = 0.4;

/// A front vertex this near to where a point would be placed takes its part.
const MEETING: f64 = 0.75;

/// Supports of the MLS approximations, in edge lengths: the first is enough for
/// a plane and its bends in the half disk that lies beside a rim; a front that
/// it leads astray, on rough rims, tries again with the second.
pub const SUPPORTS: [f64; 2] = [2.0, 3.0];

/// The sine of the least angle of a triangle that joins the front to itself.
const SHARPEST: f64 = 0.3;

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
            rings: Rings::new(&loops, 3.0 * sizes.mean),
            placed: None,
            normals: Vec::new(),
            edges: HashSet::new(),
            #[cfg(debug_assertions)]
            sides: HashSet::new(),
            fill: Fill { points: vec![], triangles: vec![], wide_ears: 0, membranes: 0 },
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

    /// The nodes before, at and after `node`.
    fn ear(&self, node: usize) -> [usize; 3] {
        [self.rings.before(node), node, self.rings.after(node)]
    }

    /// The hole's angle at a node, in the plane across the normal there.
    fn angle(&self, node: usize) -> f64 {
        let [a, b, c] = self.ear(node).map(|n| self.rings.at(n));
        self.plane(b, self.normal(self.rings.vertex(node))).angle(a, b, c)
    }

    /// The front's edges that may come within `radius` of `centre` and face
    /// the same way.
    fn edges_near(&self, centre: Point, normal: Vector, radius: f64) -> Vec<(Point, Point)> {
        let facing = |node: usize| {
            matches!(self.way, Way::Led(_))
                || self.normal(self.rings.vertex(node)).dot(&normal) > 0.0
        };
        let near = self.rings.near(centre, radius).into_iter();
        near.filter(|&node| facing(node) || facing(self.rings.after(node)))
            .map(|node| self.rings.edge(node))
            .filter(|&(p, q)| segment_distance(centre, p, q) < radius)
            .collect()
    }

    /// Whether two vertices are one, or joined by the mesh or the fill so far.
    fn joined(&self, v: VertexId, w: VertexId) -> bool {
        let Surroundings { mesh, rings, .. } = self.around;
        let measured = v.index().max(w.index()) < mesh.points.len();
        v == w
            || self.edges.contains(&(v.min(w), v.max(w)))
            || (measured && rings.neighbours(mesh, v).any(|x| x == w))
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

    /// Joins every island to the rim or to an island that is joined already.
    fn bridge_islands(&mut self, rims: &[&[VertexId]]) {
        let starts: Vec<usize> =
            rims.iter().scan(0, |end, r| Some(std::mem::replace(end, *end + r.len()))).collect();
        let nodes = |ring: usize| starts[ring]..starts[ring] + rims[ring].len();
        let mut joined: Vec<usize> = nodes(0).collect();
        let mut left: Vec<usize> = (1..rims.len()).collect();
        while !left.is_empty() {
            let pairs = left.iter().flat_map(|&ring| {
                let to = nodes(ring);
                joined.iter().flat_map(move |&from| to.clone().map(move |to| (from, to, ring)))
            });
            let distance =
                |from: usize, to: usize| (self.rings.at(to) - self.rings.at(from)).norm();
            let Some((from, to, ring)) =
                pairs.min_by(|x, y| distance(x.0, x.1).total_cmp(&distance(y.0, y.1)))
            else {
                return;
            };
            self.bridge(from, to);
            joined.extend(nodes(ring));
            left.retain(|&r| r != ring);
        }
    }

    /// Bridges two rings by a straight path with vertices at the edge length
    /// wanted.
    fn bridge(&mut self, from: usize, to: usize) {
        let ends =
            [from, to].map(|node| (self.rings.at(node), self.normal(self.rings.vertex(node))));
        let [(p, n), (q, m)] = ends;
        let size = self.sizes.at(nalgebra::center(&p, &q)).max(0.1 * self.sizes.mean);
        let steps = (((q - p).norm() / size).round() as usize).clamp(1, self.most_points.max(2));
        let mut path = Vec::new();
        for k in 1..steps {
            let share = k as f64 / steps as f64;
            let normal = n.lerp(&m, share).try_normalize(1e-6).unwrap_or(n);
            let at = p + share * (q - p);
            path.push((self.add_point(at, normal), at));
        }
        let ends = [self.rings.vertex(from), self.rings.vertex(to)];
        let chain: Vec<VertexId> =
            [ends[0]].into_iter().chain(path.iter().map(|p| p.0)).chain([ends[1]]).collect();
        self.edges.extend(chain.windows(2).map(|e| (e[0].min(e[1]), e[0].max(e[1]))));
        self.rings.bridge(from, to, &path);
    }

    /// Whether the ear at a node may be closed.
    fn may_close(&self, node: usize) -> bool {
        let ear = self.ear(node);
        let [a, _, c] = ear.map(|n| self.rings.vertex(n));
        if self.joined(a, c) {
            return false;
        }
        let [a, b, c] = ear.map(|n| self.rings.at(n));
        let longest = (a - b).norm().max((c - b).norm());
        let normal = self.normal(self.rings.vertex(node));
        let near = self.edges_near(b, normal, 2.0 * longest);
        self.plane(b, normal).is_free([c, b, a], &near)
    }

    /// Closes an ear; returns the nodes whose angle it changed.
    fn close(&mut self, node: usize) -> Vec<usize> {
        let [a, b, c] = self.ear(node);
        let [u, v, w] = [a, b, c].map(|n| self.rings.vertex(n));
        self.add([w, v, u]);
        self.rings.cut(b);
        if self.close_triangle(a) { vec![] } else { vec![a, c] }
    }

    /// Fills the ring of a node if it is a triangle.
    fn close_triangle(&mut self, node: usize) -> bool {
        let is_triangle = self.rings.is_triangle(node);
        if is_triangle {
            let [a, b, c] = self.ear(node).map(|n| self.rings.vertex(n));
            self.add([c, b, a]);
            self.rings.drop_ring(node);
        }
        is_triangle
    }

    /// Closes ears below `angle`, the narrowest first, until none is left;
    /// returns how many.
    fn close_ears(&mut self, angle: f64) -> usize {
        let before = self.fill.triangles.len();
        let mut order: BinaryHeap<Reverse<Ear>> =
            self.rings.all().map(|node| Reverse(Ear { angle: self.angle(node), node })).collect();
        while let Some(Reverse(ear)) = order.pop() {
            let node = ear.node;
            if ear.angle >= angle {
                break;
            }
            // Angles that have changed since were entered anew.
            if !self.rings.is_alive(node) || self.angle(node) != ear.angle {
                continue;
            }
            if self.close_triangle(node) || !self.may_close(node) {
                continue;
            }
            for changed in self.close(node) {
                order.push(Reverse(Ear { angle: self.angle(changed), node: changed }));
            }
        }
        self.fill.triangles.len() - before
    }

    /// One candidate an edge: it becomes a vertex, or the front meets itself
    /// there, or neither.
    fn advance(&mut self) {
        let new = self.fill.points.clone();
        self.placed = (!new.is_empty()).then(|| Cloud::new(new, self.normals.clone()));
        let mut around = Vec::new();
        let edges: Vec<_> = self.rings.all().map(|n| (n, self.rings.after(n))).collect();
        let candidates: Vec<_> = edges
            .into_iter()
            .filter_map(|edge| Some((edge, self.candidate(edge, &mut around)?)))
            .collect();
        for (edge, (p, normal)) in candidates {
            if self.fill.points.len() < self.most_points && !self.meet(edge, p, normal) {
                self.try_point(p, normal);
            }
        }
    }

    /// The point at d(e) = √(4a² − e²) / 2 from the edge on the bisector in the
    /// MLS plane at its midpoint, then on the local MLS approximation over that
    /// plane. One that the approximation throws farther than its distance from
    /// the edge stays on the plane.
    fn candidate(
        &self,
        (v, w): (usize, usize),
        around: &mut Vec<Sample>,
    ) -> Option<(Point, Vector)> {
        let (p, q) = (self.rings.at(v), self.rings.at(w));
        let [n, m] = [v, w].map(|node| self.normal(self.rings.vertex(node)));
        let guess = (n + m).try_normalize(1e-6)?;
        let middle = nalgebra::center(&p, &q);
        let a = self.sizes.at(middle);
        let support = match self.way {
            Way::Mls(support) => Some(support),
            Way::Led(_) => None,
        };
        let h = support.map_or(0.0, |s| (s * a.max((q - p).norm())).max(self.support.min(4.0 * a)));
        let plane = support.and_then(|_| {
            self.gather(middle, guess, h, around);
            mls::reference_plane(middle, guess, around, h)
        });
        let normal = plane.map_or(guess, |f| f.normal);
        let into = (q - p).cross(&normal).try_normalize(1e-12)?;
        let side = (q - p).norm().min(3f64.sqrt() * a);
        let distance = 0.5 * (4.0 * a * a - side * side).sqrt();
        let flat = middle + distance * into;
        if let Way::Led(lead) = &self.way {
            return (lead.surface)(flat);
        }
        let foot = plane.and_then(|plane| Polynomial::fit(&plane, around, h));
        let foot = foot.map(|polynomial| polynomial.at(flat));
        Some(foot.filter(|f| (f.0 - flat).norm() < distance).unwrap_or((flat, normal)))
    }

    /// The measured and the new points around a place. Deep in a hole, where
    /// edges are long, no more of the fine measured ones than next to the rim.
    fn gather(&self, at: Point, normal: Vector, h: f64, around: &mut Vec<Sample>) {
        let radius = mls::REACH * h;
        let beyond_rim = self.sizes.depth(at) + 4.0 * self.sizes.mean;
        around.clear();
        self.around.cloud.gather(at, normal, radius.min(beyond_rim.max(h)), around);
        if let Some(placed) = &self.placed {
            placed.gather(at, normal, radius, around);
        }
    }

    /// Where a front vertex is near `p`, the candidate of `edge`, joins the
    /// edge to it; says whether it did.
    fn meet(&mut self, (v, w): (usize, usize), p: Point, normal: Vector) -> bool {
        if !self.rings.is_alive(v) || self.rings.after(v) != w {
            return false;
        }
        let reach = MEETING * self.sizes.at(p);
        let own = [v, w, self.rings.before(v), self.rings.after(w)];
        let near = self.rings.near(p, reach).into_iter();
        let distance = |node: usize| (self.rings.at(node) - p).norm();
        let nearest = near
            .filter(|node| !own.contains(node) && distance(*node) < reach)
            .min_by(|x, y| distance(*x).total_cmp(&distance(*y)));
        nearest.is_some_and(|apex| self.may_join(v, apex, normal) && self.join(v, apex))
    }

    /// Whether the edge that leaves `node` may be joined to the vertex of
    /// `apex`.
    fn may_join(&self, node: usize, apex: usize, normal: Vector) -> bool {
        let w = self.rings.after(node);
        let [v, x, y] = [node, w, apex].map(|n| self.rings.vertex(n));
        if self.joined(v, y) || self.joined(x, y) || self.normal(y).dot(&normal) <= 0.0 {
            return false;
        }
        let corners = [w, node, apex].map(|n| self.rings.at(n));
        let [a, b, c] = corners;
        let sides = [b - a, c - b, a - c].map(|d| d.norm());
        let area = (b - a).cross(&(c - a)).norm();
        let sharp = |k: usize| area < SHARPEST * sides[k] * sides[(k + 1) % 3];
        if (0..3).any(sharp) {
            return false;
        }
        let reach = (c - a).norm().max((c - b).norm());
        let near = self.edges_near(c, normal, 2.0 * reach);
        let plane = self.plane(c, normal);
        // The apex sees the edge through its own gap.
        let [before, after] = [self.rings.before(apex), self.rings.after(apex)];
        let [before, after] = [before, after].map(|n| self.rings.at(n));
        let gap = plane.angle(before, c, after);
        let between = |p: Point| plane.angle(before, c, p) < gap;
        plane.is_free(corners, &near) && between(a) && between(b)
    }

    fn join(&mut self, node: usize, apex: usize) -> bool {
        let w = self.rings.after(node);
        self.add([w, node, apex].map(|n| self.rings.vertex(n)));
        self.rings.pinch(node, apex);
        self.close_triangle(node);
        if self.rings.is_alive(w) {
            self.close_triangle(w);
        }
        true
    }

    /// Joins `p` to the nearest front edge, if it keeps its distance from all
    /// other points (a front that has turned around would grow back over the
    /// measured surface) and the triangle crosses nothing.
    fn try_point(&mut self, p: Point, normal: Vector) {
        let size = self.sizes.at(p);
        let near = self.rings.near(p, 2.0 * size);
        let crowded = |node: &usize| (self.rings.at(*node) - p).norm() < APART * size;
        if self.around.cloud.nearest_distance(p) < APART * size || near.iter().any(crowded) {
            return;
        }
        let distance = |node: usize| {
            let (a, b) = self.rings.edge(node);
            segment_distance(p, a, b)
        };
        let nearest = near.iter().map(|&node| (node, distance(node)));
        let nearest = nearest.min_by(|x, y| x.1.total_cmp(&y.1));
        let Some((node, _)) = nearest.filter(|n| n.1 >= LOWEST * size) else { return };
        let (a, b) = self.rings.edge(node);
        let reach = (a - p).norm().max((b - p).norm());
        let edges = self.edges_near(p, normal, 2.0 * reach);
        if !self.plane(p, normal).is_free([b, a, p], &edges) {
            return;
        }
        let new = self.add_point(p, normal);
        let ends = [node, self.rings.after(node)].map(|n| self.rings.vertex(n));
        self.add([ends[1], ends[0], new]);
        self.rings.insert(node, new, p);
    }

    /// Whether the front is not closing in: it has used up its points, or is a
    /// good deal longer than the rim.
    fn is_growing(&self) -> bool {
        self.fill.points.len() >= self.most_points
            || self.rings.len() > self.rim + self.rim / 3 + 16
    }

    /// For a front that has come to a halt: raises φ until an ear can be closed,
    /// or else leaves a ring to a membrane.
    fn close_wide_ears(&mut self, angle: f64) -> Option<()> {
        const STEPS: i32 = 6;
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let closed = self.close_ears(angle + share * (std::f64::consts::PI - angle));
            self.fill.wide_ears += closed;
            if closed > 0 {
                return Some(());
            }
        }
        let node = self.rings.all().next();
        self.span(node?)
    }

    /// Closes the ring of a node by a membrane.
    fn span(&mut self, node: usize) -> Option<()> {
        if self.close_triangle(node) {
            return Some(());
        }
        // The hole lies to the right of its rim.
        let nodes = self.rings.ring(node);
        let ring: Vec<_> =
            nodes.iter().rev().map(|&n| (self.rings.vertex(n), self.rings.at(n))).collect();
        let membrane = membrane::span(&ring, |v, w| self.joined(v, w))?;
        let mean = nodes.iter().map(|&n| self.normal(self.rings.vertex(n))).sum::<Vector>();
        let normal = mean.try_normalize(1e-12).unwrap_or(Vector::z());
        let first: Vec<_> = ring.iter().map(|r| r.0).collect();
        let new: Vec<_> = membrane.points.into_iter().map(|p| self.add_point(p, normal)).collect();
        let vertices = [first, new].concat();
        for t in membrane.triangles {
            self.add(t.map(|i| vertices[i]));
        }
        self.rings.drop_ring(node);
        self.fill.membranes += 1;
        Some(())
    }
}

/// An ear in the order of its angle.
struct Ear {
    angle: f64,
    node: usize,
}

impl Ord for Ear {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.angle.total_cmp(&other.angle).then(self.node.cmp(&other.node))
    }
}

impl PartialOrd for Ear {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ear {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ear {}

#[cfg(test)]
mod tests {
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
        let (rings, cloud) = (mesh::Rings::new(mesh), Cloud::of(mesh));
        let around = Surroundings { mesh, rings: &rings, cloud: &cloud };
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
        assert_eq!((open, fill.membranes), (4 * 24, 0));
        assert_eq!(fill.triangles.len(), 2 * fill.points.len() + 46 - 2);
    }

    #[test]
    fn an_island_is_bridged() {
        let mesh = sheet(24, |i, j| {
            let inside = |low, high| (low..high).contains(&i) && (low..high).contains(&j);
            inside(5, 19) && !inside(9, 15)
        });
        let (fill, open) = filled(&mesh);
        assert_eq!((open, fill.membranes), (4 * 24, 0));
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
