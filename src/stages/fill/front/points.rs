//! New points of the front. Each edge has a candidate, which becomes a vertex, or shows that
//! the edge is to be joined to another part of the front.

use foldhash::{HashSet, HashSetExt};
use rayon::prelude::*;

use super::{Advance, Front};
use crate::geometry::{FEW, NEGLIGIBLE, Point, ROUNDING, Vector, segment_distance};
use crate::mesh::mls::{self, Cloud, Polynomial, Sample};

/// The least distance of a new point from every other point, in target edge lengths. Half of it
/// changes little over the hole bench. With twice as much, more than `MEETING`, points find no
/// room, and the 5th percentile of the least angles falls from 37° to 7°.
const APART: f64 = 0.55;

/// The least height of a new triangle over its edge, in target edge lengths: its base angles are
/// then about 39° or more. Flatter places are left to ears. Half of it
/// changes little; with twice as much good triangles are refused, and the 5th percentile of the
/// least angles falls from 37° to 19°.
const LOWEST: f64 = 0.4;

/// The greatest distance of a new point from the edge that it is joined to, in target edge
/// lengths. A candidate is at most one edge length from its own edge in the plane, and a little
/// farther on a curved surface. With less some candidates are lost; twice as much changes no
/// fill of the hole bench.
const HIGHEST: f64 = 1.25;

/// A vertex of the front that is this near to a candidate, in target edge lengths, is taken
/// instead of it. Half of it changes little. With twice as much the front joins vertices that it
/// should still pass: the rms over the hole bench grows by 3 %.
const MEETING: f64 = 0.75;

/// The sine of the least angle of a triangle that joins the front to itself: 17°. Half of
/// it changes no fill of the hole bench, twice as much changes the rms by less than 1 %.
const SHARPEST: f64 = 0.3;

/// The greatest distance of an edge from the approximation that it shares, in target edge
/// lengths. The last of five edges is two edge lengths from the middle one. With less fewer
/// edges share, which costs time.
const FARTHEST: f64 = 2.2;

/// The cosine of the greatest angle, 18°, between an edge's normal and the plane of the
/// approximation that it shares. At larger angles the edge is extrapolated across a bend.
const FACING: f64 = 0.95;

/// The MLS approximation at the middle of an edge.
#[derive(Clone, Copy)]
struct EdgeApproximation {
    middle: Point,
    plane: mls::ReferencePlane,
    polynomial: Option<Polynomial>,
    /// The target edge length there.
    reach: f64,
}

impl Front<'_> {
    /// Advances the whole front by one round: the candidate of each edge becomes a vertex, or
    /// the edge is joined to a vertex of the front, or neither.
    pub(super) fn advance(&mut self) {
        let new = self.fill.points.clone();
        self.placed = (!new.is_empty()).then(|| Cloud::new(new, self.normals.clone()));
        for (edge, (p, normal)) in self.candidates() {
            let size = self.sizes.at(p);
            if self.fill.points.len() < self.most_points {
                let near = self.loops.near(p, HIGHEST * size);
                if !self.meet(edge, p, size, normal, &near) {
                    self.try_point(p, size, normal, &near);
                }
            }
        }
    }

    /// The candidates of all edges, loop by loop.
    fn candidates(&self) -> Vec<((usize, usize), (Point, Vector))> {
        let mut seen = HashSet::new();
        let shared = match self.by {
            Advance::Mls(support) => support.shared,
            Advance::Guided(_) => 1,
        };
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for first in self.loops.all() {
            if seen.contains(&first) {
                continue;
            }
            let nodes = self.loops.loop_from(first);
            seen.extend(nodes.iter().copied());
            rows.extend(nodes.chunks(shared).map(<[usize]>::to_vec));
        }
        rows.par_iter()
            .with_min_len(FEW)
            .map_init(Vec::new, |around, nodes| self.of_row(nodes, around))
            .flatten_iter()
            .collect()
    }

    /// The candidates of consecutive edges. They share the approximation at the middle one of
    /// them where this is near enough.
    fn of_row(
        &self,
        nodes: &[usize],
        around: &mut Vec<Sample>,
    ) -> Vec<((usize, usize), (Point, Vector))> {
        let middle = nodes[nodes.len() / 2];
        let shared = self.local(middle, around);
        let candidate = |&node: &usize| {
            let serves = |l: &EdgeApproximation| node == middle || self.is_shared(l, node);
            let local = match shared.filter(serves) {
                None if node != middle => self.local(node, around),
                local => local,
            };
            let candidate = self.candidate(node, local.as_ref())?;
            Some(((node, self.loops.after(node)), candidate))
        };
        nodes.iter().filter_map(candidate).collect()
    }

    /// The middle of the edge after a node, and the mean normal of its ends.
    fn middle(&self, node: usize) -> Option<(Point, Vector)> {
        let after = self.loops.after(node);
        let [n, m] = [node, after].map(|node| self.normal(self.loops.vertex(node)));
        let middle = nalgebra::center(&self.loops.at(node), &self.loops.at(after));
        Some((middle, (n + m).try_normalize(NEGLIGIBLE)?))
    }

    /// The MLS approximation at an edge. `None` for a guided front, or if there is no plane.
    fn local(&self, node: usize, around: &mut Vec<Sample>) -> Option<EdgeApproximation> {
        let Advance::Mls(support) = self.by else { return None };
        let (middle, guess) = self.middle(node)?;
        let a = self.sizes.at(middle);
        let (p, q) = self.loops.edge(node);
        let h = (support.edges * a.max((q - p).norm())).max(self.support.min(4.0 * a));
        self.gather(middle, guess, h, around);
        let plane = mls::reference_plane(middle, guess, around, h)?;
        Some(EdgeApproximation {
            middle,
            plane,
            polynomial: Polynomial::fit(&plane, around, h),
            reach: a,
        })
    }

    /// Whether another edge can share an approximation.
    fn is_shared(&self, local: &EdgeApproximation, node: usize) -> bool {
        self.middle(node).is_some_and(|(middle, normal)| {
            (middle - local.middle).norm() <= FARTHEST * local.reach
                && normal.dot(&local.plane.normal) > FACING
        })
    }

    /// The point at the distance d(e) = √(4a² − e²) / 2 from an edge of length e, on its
    /// bisector in the MLS plane, moved onto the local MLS approximation. If that moves it by
    /// more than d(e), it stays on the plane.
    fn candidate(&self, node: usize, local: Option<&EdgeApproximation>) -> Option<(Point, Vector)> {
        let (middle, guess) = self.middle(node)?;
        let (p, q) = self.loops.edge(node);
        let a = self.sizes.at(middle);
        let normal = local.map_or(guess, |l| l.plane.normal);
        let into = (q - p).cross(&normal).try_normalize(ROUNDING)?;
        let side = (q - p).norm().min(3f64.sqrt() * a);
        let distance = 0.5 * (4.0 * a * a - side * side).sqrt();
        let flat = middle + distance * into;
        if let Advance::Guided(guide) = &self.by {
            return (guide.surface)(flat);
        }
        let foot = local.and_then(|l| l.polynomial.as_ref()).map(|polynomial| polynomial.at(flat));
        Some(foot.filter(|f| (f.0 - flat).norm() < distance).unwrap_or((flat, normal)))
    }

    /// The measured and the new points around `at`. Deep in a hole, where edges are long, the
    /// measured points are limited to those next to the rim.
    fn gather(&self, at: Point, normal: Vector, h: f64, around: &mut Vec<Sample>) {
        let radius = mls::REACH * h;
        let beyond_rim = self.sizes.depth(at) + 4.0 * self.sizes.mean;
        around.clear();
        self.around.cloud.gather(at, normal, radius.min(beyond_rim.max(h)), around);
        if let Some(placed) = &self.placed {
            placed.gather(at, normal, radius, around);
        }
    }

    /// If a vertex of the front is near `p`, the candidate of the edge `v w`, joins the edge to
    /// it. Returns whether it did. `near` are the nodes around `p`.
    fn meet(
        &mut self,
        (v, w): (usize, usize),
        p: Point,
        size: f64,
        normal: Vector,
        near: &[usize],
    ) -> bool {
        if !self.loops.is_alive(v) || self.loops.after(v) != w {
            return false;
        }
        let reach = MEETING * size;
        let own = [v, w, self.loops.before(v), self.loops.after(w)];
        let distance = |node: usize| (self.loops.at(node) - p).norm();
        let nearest = near
            .iter()
            .copied()
            .filter(|node| !own.contains(node) && distance(*node) < reach)
            .min_by(|x, y| distance(*x).total_cmp(&distance(*y)));
        let apex = nearest.filter(|&apex| self.may_join(v, apex, normal));
        apex.inspect(|&apex| self.join(v, apex)).is_some()
    }

    /// Whether the edge after `node` may be joined to the vertex of `apex`.
    fn may_join(&self, node: usize, apex: usize, normal: Vector) -> bool {
        let w = self.loops.after(node);
        let [v, x, y] = [node, w, apex].map(|n| self.loops.vertex(n));
        if self.joined(v, y) || self.joined(x, y) || self.normal(y).dot(&normal) <= 0.0 {
            return false;
        }
        let corners = [w, node, apex].map(|n| self.loops.at(n));
        let [a, b, c] = corners;
        let sides = [b - a, c - b, a - c].map(|d| d.norm());
        let area = (b - a).cross(&(c - a)).norm();
        let sharp = |k: usize| area < SHARPEST * sides[k] * sides[(k + 1) % 3];
        if (0..3).any(sharp) {
            return false;
        }
        let plane = self.plane(c, normal);
        // The edge must be within the angle of the gap at the apex.
        let [before, after] = [self.loops.before(apex), self.loops.after(apex)];
        let [before, after] = [before, after].map(|n| self.loops.at(n));
        let gap = plane.angle(before, c, after);
        let between = |p: Point| plane.angle(before, c, p) < gap;
        between(a) && between(b) && self.is_free(corners, c, normal)
    }

    fn join(&mut self, node: usize, apex: usize) {
        let w = self.loops.after(node);
        self.add([w, node, apex].map(|n| self.loops.vertex(n)));
        self.loops.pinch(node, apex);
        self.close_triangle(node);
        if self.loops.is_alive(w) {
            self.close_triangle(w);
        }
    }

    /// Joins `p` to the nearest edge of the front, if `p` is far enough from all other points
    /// and the triangle crosses nothing. The distance to measured points keeps a front that has
    /// turned around from growing back over the measured surface. `near` are the nodes around
    /// `p`.
    fn try_point(&mut self, p: Point, size: f64, normal: Vector, near: &[usize]) {
        let crowded = |node: &usize| (self.loops.at(*node) - p).norm() < APART * size;
        if near.iter().any(crowded) || self.around.cloud.nearest_distance(p) < APART * size {
            return;
        }
        let distance = |node: usize| {
            let (a, b) = self.loops.edge(node);
            segment_distance(p, a, b)
        };
        let nearest = near.iter().map(|&node| (node, distance(node)));
        let nearest = nearest.min_by(|x, y| x.1.total_cmp(&y.1));
        let Some((node, _)) = nearest.filter(|n| n.1 >= LOWEST * size) else { return };
        let (a, b) = self.loops.edge(node);
        if !self.is_free([b, a, p], p, normal) {
            return;
        }
        let new = self.add_point(p, normal);
        let ends = [node, self.loops.after(node)].map(|n| self.loops.vertex(n));
        self.add([ends[1], ends[0], new]);
        self.loops.insert(node, new, p);
    }
}
