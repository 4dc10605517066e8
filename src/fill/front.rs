//! The front of one hole.
//!
//! A front edge runs in the direction of the surface's triangle on its left;
//! the hole is to its right. Closing the ear a b c adds the triangle c b a and
//! puts the edge a c in place of a b and b c; a new point p at the edge a b
//! adds the triangle b a p.
//!
//! What the paper leaves open: where a round neither closes an ear nor places
//! a point, the narrowest ear that crosses nothing is closed although it is
//! wider than φ. Where there is none, or fronts that extrapolate a wide hole
//! miss each other and grow, the fill is given up for a membrane. The mesh
//! stays a manifold: no edge is made twice. The number of points is bounded,
//! and every ear shortens the front, so it ends.

use std::collections::HashSet;

use super::plane::LocalPlane;
use super::{Method, Options, membrane};
use crate::geometry::{Point, Vector, VertexId, segment_distance};
use crate::mesh::mls::{Cloud, Scratch};
use crate::mesh::{Mesh, Rings, boundary};

/// The triangles and points that close a hole. New vertices are numbered from
/// the mesh's vertex count on.
pub struct Fill {
    pub points: Vec<Point>,
    pub triangles: Vec<[VertexId; 3]>,
    pub method: Method,
}

/// Closes the hole with rim `rim`; `None` if even a membrane cannot.
pub fn fill_hole(
    mesh: &Mesh,
    rings: &Rings,
    cloud: &Cloud,
    rim: &[VertexId],
    options: &Options,
) -> Option<Fill> {
    let mut front = Front::new(mesh, rings, cloud, rim, options);
    let mut forced = 0;
    while front.ring.len() > 3 {
        let closed = front.close_ears(options.ear_angle);
        if front.ring.len() <= 3 {
            break;
        }
        if front.is_growing(rim.len()) {
            return front.membrane(rim);
        }
        if front.place_points() > 0 || closed > 0 {
            continue;
        }
        forced += 1;
        if forced > 8 + rim.len() / 4 || !front.close_narrowest_ear() {
            return front.membrane(rim);
        }
    }
    if front.ring.len() < 3 {
        return None;
    }
    let last = [front.ring[2], front.ring[1], front.ring[0]];
    front.fill.triangles.push(last);
    Some(front.fill)
}

/// A new point is at least this far from every other, in mean rim edges.
const APART: f64 = 0.55;

/// And this far from the front edge that it is joined to: flatter triangles
/// are left to ears.
const LOWEST: f64 = 0.4;

struct Front<'a> {
    mesh: &'a Mesh,
    rings: &'a Rings,
    cloud: &'a Cloud,
    /// Measured vertices near the hole.
    context: Vec<VertexId>,
    /// The front, in the direction of the rim.
    ring: Vec<VertexId>,
    /// Normals of the new vertices.
    normals: Vec<Vector>,
    /// Edges made here, lower vertex first.
    edges: HashSet<(VertexId, VertexId)>,
    fill: Fill,
    /// Mean edge length of the rim: a in the paper.
    a: f64,
    h: f64,
    most_points: usize,
}

impl<'a> Front<'a> {
    fn new(
        mesh: &'a Mesh,
        rings: &'a Rings,
        cloud: &'a Cloud,
        rim: &[VertexId],
        options: &Options,
    ) -> Self {
        let length = boundary::length(mesh, rim);
        let a = length / rim.len() as f64;
        let h = options.support.max(2.5 * a);
        // A disk of the rim's length has length² / 4π of area, and a point for
        // every √3/2 a² of it; a surface in it that bulges has more.
        let disk = length * length / (4.0 * std::f64::consts::PI);
        let most_points = 32 + (3.0 * disk / (a * a)) as usize;
        let fill = Fill { points: Vec::new(), triangles: Vec::new(), method: Method::Front };
        let context = cloud.around(rim.iter().map(|&v| mesh.point(v)), 3.0 * h);
        Front {
            mesh,
            rings,
            cloud,
            context,
            ring: rim.to_vec(),
            normals: Vec::new(),
            edges: HashSet::new(),
            fill,
            a,
            h,
            most_points,
        }
    }

    fn point(&self, v: VertexId) -> Point {
        match v.index().checked_sub(self.mesh.points.len()) {
            None => self.mesh.point(v),
            Some(i) => self.fill.points[i],
        }
    }

    fn normal(&self, v: VertexId) -> Vector {
        match v.index().checked_sub(self.mesh.points.len()) {
            None => self.cloud.normal(v.index()),
            Some(i) => self.normals[i],
        }
    }

    /// The ring's vertices before, at and after position `i`.
    fn ear(&self, i: usize) -> [VertexId; 3] {
        let n = self.ring.len();
        [self.ring[(i + n - 1) % n], self.ring[i], self.ring[(i + 1) % n]]
    }

    /// The hole's angle at position `i`, in the plane across the normal there.
    fn angle(&self, i: usize) -> f64 {
        let [a, b, c] = self.ear(i);
        let plane = LocalPlane::new(self.point(b), self.normal(b));
        plane.angle(self.point(a), self.point(b), self.point(c))
    }

    /// The front's edges that may come within `radius` of `centre` and face
    /// the same way.
    fn edges_near(&self, centre: Point, normal: Vector, radius: f64) -> Vec<(Point, Point)> {
        let n = self.ring.len();
        let pairs = (0..n).map(|i| (self.ring[i], self.ring[(i + 1) % n]));
        pairs
            .filter(|&(v, w)| {
                self.normal(v).dot(&normal) > 0.0 || self.normal(w).dot(&normal) > 0.0
            })
            .map(|(v, w)| (self.point(v), self.point(w)))
            .filter(|&(p, q)| segment_distance(centre, p, q) < radius)
            .collect()
    }

    /// Whether the mesh, or the fill so far, already joins two vertices.
    fn joined(&self, v: VertexId, w: VertexId) -> bool {
        let measured = v.index().max(w.index()) < self.mesh.points.len();
        self.edges.contains(&(v.min(w), v.max(w)))
            || (measured && self.rings.neighbours(self.mesh, v).any(|x| x == w))
    }

    /// Whether the ear at position `i` may be closed.
    fn may_close(&self, i: usize) -> bool {
        let [a, b, c] = self.ear(i);
        if self.joined(a, c) {
            return false;
        }
        let corners = [c, b, a].map(|v| self.point(v));
        let longest = (corners[0] - corners[1]).norm().max((corners[2] - corners[1]).norm());
        let normal = self.normal(b);
        let near = self.edges_near(corners[1], normal, 2.0 * longest);
        LocalPlane::new(corners[1], normal).is_free(corners, &near)
    }

    fn close(&mut self, i: usize) {
        let [a, b, c] = self.ear(i);
        self.fill.triangles.push([c, b, a]);
        self.edges.insert((a.min(c), a.max(c)));
        self.ring.remove(i);
    }

    /// Closes ears below `angle`, the narrowest first, until none is left;
    /// returns how many.
    fn close_ears(&mut self, angle: f64) -> usize {
        let mut angles: Vec<f64> = (0..self.ring.len()).map(|i| self.angle(i)).collect();
        let mut barred = vec![false; self.ring.len()];
        let mut closed = 0;
        while self.ring.len() > 3 {
            let open = (0..angles.len()).filter(|&i| !barred[i] && angles[i] < angle);
            let Some(i) = open.min_by(|&i, &j| angles[i].total_cmp(&angles[j])) else { break };
            if !self.may_close(i) {
                barred[i] = true;
                continue;
            }
            self.close(i);
            angles.remove(i);
            barred.remove(i);
            closed += 1;
            let n = self.ring.len();
            for j in [(i + n - 1) % n, i % n] {
                angles[j] = self.angle(j);
                barred[j] = false;
            }
        }
        closed
    }

    /// One candidate an edge; returns how many became vertices.
    fn place_points(&mut self) -> usize {
        let support = self.local_cloud();
        let mut scratch = Scratch::default();
        let n = self.ring.len();
        let edges: Vec<_> = (0..n).map(|i| (self.ring[i], self.ring[(i + 1) % n])).collect();
        let candidates: Vec<_> =
            edges.iter().filter_map(|&e| self.candidate(e, &support, &mut scratch)).collect();
        let before = self.fill.points.len();
        for (p, normal) in candidates {
            if self.fill.points.len() < self.most_points {
                self.try_point(p, normal, &support);
            }
        }
        self.fill.points.len() - before
    }

    /// The measured points around the hole and the new ones.
    fn local_cloud(&self) -> Cloud {
        let measured = self.context.iter().map(|&v| (self.mesh.point(v), self.normal(v)));
        let new = self.fill.points.iter().copied().zip(self.normals.iter().copied());
        let (points, normals) = measured.chain(new).unzip();
        Cloud::new(points, normals)
    }

    /// The point at d(e) = √(4a² − e²) / 2 from the edge on the bisector in the
    /// MLS plane at its midpoint, projected by a local MLS approximation. One
    /// that the approximation throws farther than its distance from the edge
    /// stays on the plane.
    fn candidate(
        &self,
        (v, w): (VertexId, VertexId),
        support: &Cloud,
        scratch: &mut Scratch,
    ) -> Option<(Point, Vector)> {
        let (p, q) = (self.point(v), self.point(w));
        let guess = (self.normal(v) + self.normal(w)).try_normalize(1e-6)?;
        let middle = nalgebra::center(&p, &q);
        let normal = support.plane(middle, guess, self.h, scratch).map_or(guess, |f| f.normal);
        let into = (q - p).cross(&normal).try_normalize(1e-12)?;
        let side = (q - p).norm().min(3f64.sqrt() * self.a);
        let distance = 0.5 * (4.0 * self.a * self.a - side * side).sqrt();
        let flat = middle + distance * into;
        let foot = support.project(flat, normal, self.h, scratch);
        let near = foot.filter(|f| (f.point - flat).norm() < distance);
        Some(near.map_or((flat, normal), |f| (f.point, f.normal)))
    }

    /// Joins `p` to the nearest front edge, if it keeps its distance from all
    /// other points (a front that has turned around would grow back over the
    /// measured surface) and the triangle crosses nothing.
    fn try_point(&mut self, p: Point, normal: Vector, support: &Cloud) {
        let crowded = |v: &VertexId| (self.point(*v) - p).norm() < APART * self.a;
        if support.nearest_distance(p) < APART * self.a || self.ring.iter().any(crowded) {
            return;
        }
        let n = self.ring.len();
        let ends = |i: usize| (self.point(self.ring[i]), self.point(self.ring[(i + 1) % n]));
        let distance = |i: usize| segment_distance(p, ends(i).0, ends(i).1);
        let nearest = (0..n).map(|i| (i, distance(i))).min_by(|x, y| x.1.total_cmp(&y.1));
        let Some((i, d)) = nearest else { return };
        let (e1, e2) = ends(i);
        if d < LOWEST * self.a {
            return;
        }
        let corners = [e2, e1, p];
        let reach = (e1 - p).norm().max((e2 - p).norm());
        let near = self.edges_near(p, normal, 2.0 * reach);
        if !LocalPlane::new(p, normal).is_free(corners, &near) {
            return;
        }
        let new = VertexId::from(self.mesh.points.len() + self.fill.points.len());
        let (v, w) = (self.ring[i], self.ring[(i + 1) % n]);
        self.fill.points.push(p);
        self.normals.push(normal);
        self.fill.triangles.push([w, v, new]);
        self.edges.extend([(v, new), (w, new)]);
        self.ring.insert(i + 1, new);
    }

    /// Whether the front is not closing in: it has used up its points, or is a
    /// good deal longer than the rim.
    fn is_growing(&self, rim: usize) -> bool {
        self.fill.points.len() >= self.most_points || self.ring.len() > rim + rim / 3 + 16
    }

    /// Closes the narrowest ear that may be closed; says whether there was one.
    fn close_narrowest_ear(&mut self) -> bool {
        self.fill.method = Method::WideEars;
        let angles: Vec<f64> = (0..self.ring.len()).map(|i| self.angle(i)).collect();
        let mut order: Vec<usize> = (0..self.ring.len()).collect();
        order.sort_by(|&i, &j| angles[i].total_cmp(&angles[j]));
        let Some(&i) = order.iter().find(|&&i| self.may_close(i)) else { return false };
        self.close(i);
        true
    }

    /// Gives up the front for a membrane over the whole hole.
    fn membrane(&self, rim: &[VertexId]) -> Option<Fill> {
        // The hole lies to the right of its rim.
        let ring: Vec<_> = rim.iter().rev().map(|&v| (v, self.mesh.point(v))).collect();
        let joined = |v, w| self.rings.neighbours(self.mesh, v).any(|x| x == w);
        let membrane = membrane::span(&ring, joined)?;
        let first = self.mesh.points.len();
        let vertex = |i: usize| {
            i.checked_sub(ring.len()).map_or_else(|| ring[i].0, |k| VertexId::from(first + k))
        };
        let triangles = membrane.triangles.into_iter().map(|t| t.map(vertex)).collect();
        Some(Fill { points: membrane.points, triangles, method: Method::Membrane })
    }
}
