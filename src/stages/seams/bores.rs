//! Bores whose walls are missing: two circular rims of one radius and axis in opposite faces. They are closed by a cylinder.

use super::gaps::{ClosedGap, GapClosure, GapFill};
use super::rims::{OFF_RIM, Rim};
use super::stretches::circle_of;
use super::{FacePatch, FacetForm};
use crate::geometry::{Point, Vector, VertexId, plane_axes};
use crate::mesh::boundary;
use crate::primitives::Primitive;

/// Two rims between which a bore goes.
pub(super) struct BoreGap {
    /// Their numbers.
    pub rims: [usize; 2],
    cylinder: Primitive,
}

/// A rim that is a circle in a flat face.
struct CircularRim {
    number: usize,
    centre: Point,
    /// The outer normal of the face.
    normal: Vector,
    radius: f64,
    error: f64,
}

impl GapClosure {
    /// The bores without walls. Each rim belongs to one at the most, and of several to the shortest.
    pub(super) fn bores(&self, rims: &[Rim]) -> Vec<BoreGap> {
        let all = rims.iter().enumerate();
        let circles: Vec<CircularRim> =
            all.filter_map(|(number, rim)| self.circular(number, rim)).collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, a) in circles.iter().enumerate() {
            for (j, b) in circles.iter().enumerate().skip(i + 1) {
                // The material is between the two faces.
                let depth = (a.centre - b.centre).dot(&a.normal);
                if depth > 0.0 && a.is_opposite(b) {
                    pairs.push((depth, i, j));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut found: Vec<BoreGap> = Vec::new();
        for (_, i, j) in pairs {
            let numbers = [circles[i].number, circles[j].number];
            if found.iter().flat_map(|bore| bore.rims).any(|rim| numbers.contains(&rim)) {
                continue;
            }
            let origin = nalgebra::center(&circles[i].centre, &circles[j].centre);
            let radius = 0.5 * (circles[i].radius + circles[j].radius);
            let cylinder = Primitive::Cylinder { origin, axis: circles[i].normal, radius };
            found.push(BoreGap { rims: numbers, cylinder });
        }
        found
    }

    /// The rim as a circle, if it is one, and all its sides belong to one flat face.
    fn circular(&self, number: usize, rim: &Rim) -> Option<CircularRim> {
        let mesh = &self.closed.mesh;
        let patch = self.of_triangle[rim.sides[0] / 3];
        if rim.sides.iter().any(|side| self.of_triangle[side / 3] != patch) {
            return None;
        }
        let FacePatch { surface: Primitive::Plane { normal, .. }, side, .. } =
            *self.closed.patches.get(patch)?
        else {
            return None;
        };
        let error = rim.vertices.iter().map(|v| self.closed.errors[v.index()]).fold(0.0, f64::max);
        // A hole runs the other way round than the border of a face.
        let is_hole = boundary::area(mesh, &rim.vertices).dot(&normal) * side < 0.0;
        let (centre, radius) = circle_of(&rim.points(mesh), normal, error).filter(|_| is_hole)?;
        Some(CircularRim { number, centre, normal: side * normal, radius, error })
    }

    /// Closes a bore with a ring of triangles from one rim to the other.
    pub(super) fn close_bore(&mut self, bore: &BoreGap, rims: &[Rim]) {
        let [a, b] = bore.rims.map(|number| &rims[number]);
        let patch = self.closed.patches.len();
        let triangles = Vec::new();
        let surface = bore.cylinder;
        self.closed.patches.push(FacePatch {
            surface,
            side: -1.0,
            is_facet: false,
            form: FacetForm::Flat,
            triangles,
        });
        let ring = self.ring_between(bore, a, b);
        let gap = |rim: &Rim, added_triangles| ClosedGap {
            rim_vertices: rim.vertices.len(),
            rim_length: boundary::length(&self.closed.mesh, &rim.vertices),
            added_vertices: 0,
            added_triangles,
            place: super::gaps::extent(&rim.points(&self.closed.mesh)).0,
            fill: GapFill::Bore,
        };
        let made = [gap(a, ring.len()), gap(b, 0)];
        self.closed.gaps.extend(made);
        ring.into_iter().for_each(|triangle| self.add(triangle, patch));
    }

    /// Triangles between two rims, in the order of the angles of their vertices about the axis.
    fn ring_between(&self, bore: &BoreGap, a: &Rim, b: &Rim) -> Vec<[VertexId; 3]> {
        let mesh = &self.closed.mesh;
        let (origin, axis) =
            (bore.cylinder.origin(), bore.cylinder.axis().unwrap_or_else(Vector::z));
        let (x, y) = plane_axes(axis);
        let angle = |v: VertexId| {
            let q = mesh.point(v) - origin;
            q.dot(&y).atan2(q.dot(&x))
        };
        let around = |rim: &Rim| {
            let mut all: Vec<(f64, VertexId)> =
                rim.vertices.iter().map(|&v| (angle(v), v)).collect();
            all.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
            all
        };
        let (top, bottom) = (around(a), around(b));
        let (n, m) = (top.len(), bottom.len());
        let turn = std::f64::consts::TAU;
        let at = |all: &[(f64, VertexId)], k: usize| {
            all[k % all.len()].0 + turn * (k / all.len()) as f64
        };
        let (mut i, mut j) = (0, 0);
        let mut made = Vec::with_capacity(n + m);
        while i < n || j < m {
            let (p, q) = (top[i % n].1, bottom[j % m].1);
            // The next vertex by its angle. Both rims end with their first one.
            let is_top = j == m || i < n && at(&top, i + 1) <= at(&bottom, j + 1);
            let next = if is_top { top[(i + 1) % n].1 } else { bottom[(j + 1) % m].1 };
            made.push([p, next, q]);
            if is_top { i += 1 } else { j += 1 }
        }
        made
    }
}

impl CircularRim {
    /// Whether another circle is that of the same bore on the other side.
    fn is_opposite(&self, other: &CircularRim) -> bool {
        let off = OFF_RIM * (self.error + other.error);
        let between = self.centre - other.centre;
        let aside = between - between.dot(&self.normal) * self.normal;
        let turned = self.normal.cross(&other.normal).norm() * self.radius;
        self.normal.dot(&other.normal) < 0.0
            && turned <= off
            && aside.norm() <= off
            && (self.radius - other.radius).abs() <= off
    }
}
