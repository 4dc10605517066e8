//! The rims of an open mesh, divided into stretches. Each becomes a free edge: a line, an arc, or the curve in which a
//! plane cuts the face.

use std::collections::BTreeMap;

use nalgebra::Vector2;

use super::FacePatch;
use super::curves::circle;
use super::rims::{OFF_RIM, Rim, directions, rims};
use crate::geometry::{Point, Vector, plane_axes, segment_distance};
use crate::mesh::{EdgeMap, Mesh};
use crate::primitives::Primitive;

/// A plane cuts a surface if the sine of the angle between their normals is at least so large.
const CUTS: f64 = 0.1;

/// A curve turns by less than this from one chord to the next: no program takes fewer than nine chords for a turn (40°).
pub(super) const MOST_TURN: f64 = 0.707;

/// So many points on one circle are an arc: three points always are, and two more are not there by chance.
const FEWEST_ON_ARC: usize = 5;

/// So many points in one plane are a curve in it: three points always are.
const FEWEST_IN_PLANE: usize = 4;

/// What a stretch lies on besides its face.
#[derive(Debug, Clone, Copy)]
pub(super) enum WallKind {
    /// The plane of the whole rim. It holds the vertices at the ends.
    Planar(Primitive),
    /// A cylinder that stands on the face. The edge is an arc.
    Arc(Primitive),
    /// A plane through the ends. If the stretch is straight, it stands on the face.
    Bow,
}

/// The stretches of all rims.
#[derive(Debug, Default)]
pub(super) struct RimStretches {
    /// For each boundary side its stretch.
    pub of_side: BTreeMap<usize, usize>,
    /// What each stretch is.
    pub kinds: Vec<WallKind>,
}

/// The sides of a rim along one patch.
struct RimRun<'a> {
    surface: &'a Primitive,
    sides: Vec<usize>,
    /// The ends of the sides, one more than there are sides. Of a closed run the last one is the first one.
    points: Vec<Point>,
    /// The largest error of the points.
    error: f64,
    is_closed: bool,
}

impl RimStretches {
    /// Divides the rims of a mesh. `of_triangle` has the patch of each triangle.
    pub(super) fn of(
        mesh: &Mesh,
        edges: &EdgeMap,
        errors: &[f64],
        patches: &[FacePatch],
        of_triangle: &[usize],
    ) -> Self {
        let likely = directions(patches.iter().map(|patch| &patch.surface));
        let mut all = RimStretches::default();
        for rim in rims(mesh, edges) {
            let plane = rim.plane(mesh, errors, &likely);
            for run in runs(mesh, errors, patches, of_triangle, &rim) {
                let mut sides = run.sides.iter();
                for (count, kind) in run.divided(plane.as_ref()) {
                    let number = all.kinds.len();
                    all.kinds.push(kind);
                    all.of_side.extend(sides.by_ref().take(count).map(|&side| (side, number)));
                }
            }
        }
        all
    }
}

/// The runs of a rim along its patches.
fn runs<'a>(
    mesh: &Mesh,
    errors: &[f64],
    patches: &'a [FacePatch],
    of_triangle: &[usize],
    rim: &Rim,
) -> Vec<RimRun<'a>> {
    let n = rim.sides.len();
    let make = |from: usize, count: usize, is_closed: bool| {
        let sides: Vec<usize> = (from..from + count).map(|k| rim.sides[k % n]).collect();
        let vertices = (from..=from + count).map(|k| rim.vertices[k % n]);
        let error = vertices.clone().map(|v| errors[v.index()]).fold(0.0, f64::max);
        let points = vertices.map(|v| mesh.point(v)).collect();
        let surface = &patches[of_triangle[rim.sides[from % n] / 3]].surface;
        RimRun { surface, sides, points, error, is_closed }
    };
    let found = rim.runs(of_triangle);
    if found.is_empty() {
        return vec![make(0, n, true).begun_at_corner()];
    }
    found.into_iter().map(|(from, to, _)| make(from, to - from, false)).collect()
}

impl RimRun<'_> {
    fn count(&self) -> usize {
        self.sides.len()
    }

    /// A closed run from its sharpest corner on, or from the end of its longest side if it has none.
    fn begun_at_corner(mut self) -> Self {
        let n = self.count();
        let turn = |k: usize| if k == 0 { self.closing_turn() } else { self.turn(k) };
        let long = |k: usize| (self.points[k + 1] - self.points[k]).norm();
        let sharpest = (0..n).max_by(|&a, &b| turn(a).total_cmp(&turn(b))).unwrap_or(0);
        let longest = (0..n).max_by(|&a, &b| long(a).total_cmp(&long(b))).unwrap_or(0);
        let start = if turn(sharpest) > MOST_TURN { sharpest } else { (longest + 1) % n };
        self.sides.rotate_left(start);
        self.points.pop();
        self.points.rotate_left(start);
        self.points.push(self.points[0]);
        self
    }

    /// The angle by which a closed run turns where it begins.
    fn closing_turn(&self) -> f64 {
        between(self.points[self.count() - 1], self.points[0], self.points[1])
    }

    /// The angle by which the run turns at a point between its ends.
    fn turn(&self, k: usize) -> f64 {
        between(self.points[k - 1], self.points[k], self.points[k + 1])
    }

    /// The stretches of the run, each with the number of its sides. `plane` is that of the whole rim.
    fn divided(&self, plane: Option<&Primitive>) -> Vec<(usize, WallKind)> {
        let flat = match (self.surface, plane) {
            (Primitive::Plane { normal, .. }, _) | (_, Some(Primitive::Plane { normal, .. })) => {
                Some(*normal)
            }
            _ => None,
        };
        if let Some(plane @ Primitive::Plane { normal, .. }) = plane
            && self.sines(*normal).all(|sine| sine >= CUTS)
            && (1..self.count()).all(|k| self.turn(k) <= MOST_TURN)
            && !(self.is_closed && self.closing_turn() > MOST_TURN)
        {
            return vec![(self.count(), WallKind::Planar(*plane))];
        }
        match flat.filter(|&normal| self.sines(normal).all(|sine| sine < CUTS)) {
            Some(normal) => self.arcs_and_lines(normal),
            None => self.bows(),
        }
    }

    /// The sines of the angles between a direction and the normals of the surface at all points.
    fn sines(&self, normal: Vector) -> impl Iterator<Item = f64> + '_ {
        self.points.iter().map(move |&p| self.surface.normal(p).cross(&normal).norm())
    }

    /// The stretches of a run in a plane that is tangent to the surface.
    fn arcs_and_lines(&self, normal: Vector) -> Vec<(usize, WallKind)> {
        let last = self.count();
        let ring = self.is_closed.then(|| self.arc(normal, 0, last)).flatten();
        if let Some(arc) = ring.filter(|_| (1..last).all(|k| self.turn(k) <= MOST_TURN)) {
            return vec![(last, WallKind::Arc(arc))];
        }
        let mut found = Vec::new();
        let mut from = 0;
        while from < last {
            let (to, kind) = match self.end_of_arc(normal, from) {
                Some((to, arc)) => (to, WallKind::Arc(arc)),
                None => (self.end_of_line(from), WallKind::Bow),
            };
            found.push((to - from, kind));
            from = to;
        }
        found
    }

    /// The longest arc from a point on, if there is one.
    fn end_of_arc(&self, normal: Vector, from: usize) -> Option<(usize, Primitive)> {
        let mut found = None;
        for to in from + 2..=self.count() {
            if self.turn(to - 1) > MOST_TURN {
                break;
            }
            // Three points always lie on a circle.
            let arc = self.arc(normal, from, to);
            if arc.is_none() && to > from + 2 {
                break;
            }
            found = arc.filter(|_| to - from + 1 >= FEWEST_ON_ARC).map(|arc| (to, arc)).or(found);
        }
        found
    }

    /// The cylinder along a direction that has all points between two.
    fn arc(&self, normal: Vector, from: usize, to: usize) -> Option<Primitive> {
        let (origin, radius) = arc_of(&self.points[from..=to], normal, self.error)?;
        Some(Primitive::Cylinder { origin, axis: normal, radius })
    }

    fn is_straight(&self, from: usize, to: usize) -> bool {
        let [a, b] = [from, to].map(|k| self.points[k]);
        let off = |p: &Point| segment_distance(*p, a, b);
        self.points[from..=to].iter().all(|p| off(p) <= OFF_RIM * self.error)
    }

    fn end_of_line(&self, from: usize) -> usize {
        let straight = |to: &usize| self.is_straight(from, *to);
        (from + 2..=self.count()).take_while(straight).last().unwrap_or(from + 1)
    }

    /// The stretches of a run on a curved surface, each in a plane.
    fn bows(&self) -> Vec<(usize, WallKind)> {
        let mut found = Vec::new();
        let mut from = 0;
        while from < self.count() {
            let to = self.end_of_bow(from);
            found.push((to - from, WallKind::Bow));
            from = to;
        }
        found
    }

    /// The end of the longest stretch in a plane.
    fn end_of_bow(&self, from: usize) -> usize {
        let mut best = from + 1;
        for to in from + 2..=self.count() {
            if self.turn(to - 1) > MOST_TURN {
                break;
            }
            if self.is_straight(from, to) {
                best = to;
                continue;
            }
            let Some(normal) = self.normal_of(from, to) else { break };
            let start = self.points[from];
            let is_in = |p: &Point| (p - start).dot(&normal).abs() <= OFF_RIM * self.error;
            if !self.points[from..=to].iter().all(is_in) {
                break;
            }
            let is_cut = self.points[from..=to]
                .iter()
                .all(|&p| self.surface.normal(p).cross(&normal).norm() >= CUTS);
            if to - from + 1 >= FEWEST_IN_PLANE && is_cut && to < from + self.most_of_closed() {
                best = to;
            }
        }
        best
    }

    /// The most sides of a stretch: one that closes has no ends for its plane.
    fn most_of_closed(&self) -> usize {
        if self.is_closed { self.count() } else { self.count() + 1 }
    }

    /// The direction across which points are flattest.
    fn normal_of(&self, from: usize, to: usize) -> Option<Vector> {
        let start = self.points[from];
        let spokes = self.points[from + 1..=to].windows(2);
        let area: Vector = spokes.map(|w| (w[0] - start).cross(&(w[1] - start))).sum();
        area.try_normalize(f64::MIN_POSITIVE)
    }
}

/// The centre and the radius of the circle across a direction that has some points.
fn arc_of(points: &[Point], normal: Vector, error: f64) -> Option<(Point, f64)> {
    let middle = nalgebra::center(&points[0], &points[points.len() / 2]);
    let (x, y) = plane_axes(normal);
    let flat = |p: &Point| Vector2::new((p - middle).dot(&x), (p - middle).dot(&y));
    let flats: Vec<Vector2<f64>> = points.iter().map(flat).collect();
    let found = circle(&flats, OFF_RIM * error)?;
    let (centre, radius) = (middle + found.centre.x * x + found.centre.y * y, found.radii[0]);
    let chord = (points[1] - points[0]).norm();
    // A line lies on a circle whose radius is only bounded by rounding.
    let is_line = chord * chord < OFF_RIM * error * radius;
    (!is_line).then_some((centre, radius))
}

/// The centre and the radius of the circle that a closed line of points is, across a direction.
pub(super) fn circle_of(points: &[Point], normal: Vector, error: f64) -> Option<(Point, f64)> {
    let n = points.len();
    let turn = |k: usize| between(points[(k + n - 1) % n], points[k], points[(k + 1) % n]);
    (0..n).all(|k| turn(k) <= MOST_TURN).then(|| arc_of(points, normal, error)).flatten()
}

/// The angle between the direction to a point and that away from it.
fn between(before: Point, at: Point, after: Point) -> f64 {
    let (a, b) = (at - before, after - at);
    a.cross(&b).norm().atan2(a.dot(&b))
}
