//! New points: a candidate an edge, which becomes a vertex, or shows where the
//! front meets itself.

use foldhash::{HashSet, HashSetExt};
use rayon::prelude::*;

use super::{Front, Way};
use crate::geometry::{Point, Vector, segment_distance};
use crate::mesh::mls::{self, Cloud, Polynomial, Sample};

/// A new point is at least this far from every other, in edge lengths wanted
/// there.
const APART: f64 = 0.55;

/// And this far from the front edge that it is joined to: flatter triangles
/// are left to ears.
const LOWEST: f64 = 0.4;

/// Nor farther than this.
const HIGHEST: f64 = 1.25;

/// A front vertex this near to where a point would be placed takes its part.
const MEETING: f64 = 0.75;

/// The sine of the least angle of a triangle that joins the front to itself.
const SHARPEST: f64 = 0.3;

/// Edges share no approximation from farther away than so many edge lengths
/// wanted there, …
const FARTHEST: f64 = 2.2;

/// … nor one whose plane is turned from theirs, by the cosine of the angle.
const FACING: f64 = 0.95;

/// Rows of edges whose candidates one thread looks for.
const AT_ONCE: usize = 8;

/// The MLS approximation at an edge.
#[derive(Clone, Copy)]
struct Local {
    middle: Point,
    plane: mls::ReferencePlane,
    polynomial: Option<Polynomial>,
    /// The edge length wanted there.
    reach: f64,
}

impl Front<'_> {
    /// One candidate an edge: it becomes a vertex, or the front meets itself
    /// there, or neither.
    pub(super) fn advance(&mut self) {
        let new = self.fill.points.clone();
        self.placed = (!new.is_empty()).then(|| Cloud::new(new, self.normals.clone()));
        for (edge, (p, normal)) in self.candidates() {
            let size = self.sizes.at(p);
            if self.fill.points.len() < self.most_points {
                let near = self.rings.near(p, HIGHEST.max(MEETING) * size);
                if !self.meet(edge, p, size, normal, &near) {
                    self.try_point(p, size, normal, &near);
                }
            }
        }
    }

    /// The candidates of all edges, ring by ring.
    fn candidates(&self) -> Vec<((usize, usize), (Point, Vector))> {
        let mut seen = HashSet::new();
        let shared = match self.way {
            Way::Mls(support) => support.shared,
            Way::Led(_) => 1,
        };
        let mut rows: Vec<Vec<usize>> = Vec::new();
        for first in self.rings.all() {
            if seen.contains(&first) {
                continue;
            }
            let ring = self.rings.ring(first);
            seen.extend(ring.iter().copied());
            rows.extend(ring.chunks(shared).map(<[usize]>::to_vec));
        }
        rows.par_iter()
            .with_min_len(AT_ONCE)
            .map_init(Vec::new, |around, nodes| self.of_row(nodes, around))
            .flatten_iter()
            .collect()
    }

    /// The candidates of edges in a row, by the approximation at the middle one of them
    /// where it serves.
    fn of_row(
        &self,
        nodes: &[usize],
        around: &mut Vec<Sample>,
    ) -> Vec<((usize, usize), (Point, Vector))> {
        let middle = nodes[nodes.len() / 2];
        let shared = self.local(middle, around);
        let candidate = |&node: &usize| {
            let serves = |l: &Local| node == middle || self.is_shared(l, node);
            let local = match shared.filter(serves) {
                None if node != middle => self.local(node, around),
                local => local,
            };
            let candidate = self.candidate(node, local.as_ref())?;
            Some(((node, self.rings.after(node)), candidate))
        };
        nodes.iter().filter_map(candidate).collect()
    }

    /// The middle of the edge that leaves a node, and the mean normal of its
    /// ends.
    fn middle(&self, node: usize) -> Option<(Point, Vector)> {
        let after = self.rings.after(node);
        let [n, m] = [node, after].map(|node| self.normal(self.rings.vertex(node)));
        let middle = nalgebra::center(&self.rings.at(node), &self.rings.at(after));
        Some((middle, (n + m).try_normalize(1e-6)?))
    }

    /// The MLS approximation at the middle of the edge that leaves a node;
    /// `None` for a led front, or where there is no plane.
    fn local(&self, node: usize, around: &mut Vec<Sample>) -> Option<Local> {
        let Way::Mls(support) = self.way else { return None };
        let (middle, guess) = self.middle(node)?;
        let a = self.sizes.at(middle);
        let (p, q) = self.rings.edge(node);
        let h = (support.edges * a.max((q - p).norm())).max(self.support.min(4.0 * a));
        self.gather(middle, guess, h, around);
        let plane = mls::reference_plane(middle, guess, around, h)?;
        Some(Local { middle, plane, polynomial: Polynomial::fit(&plane, around, h), reach: a })
    }

    /// Whether the approximation at one edge serves for another, too.
    fn is_shared(&self, local: &Local, node: usize) -> bool {
        self.middle(node).is_some_and(|(middle, normal)| {
            (middle - local.middle).norm() <= FARTHEST * local.reach
                && normal.dot(&local.plane.normal) > FACING
        })
    }

    /// The point at d(e) = √(4a² − e²) / 2 from the edge on the bisector in the
    /// MLS plane, then on the local MLS approximation over that
    /// plane. One that the approximation throws farther than its distance from
    /// the edge stays on the plane.
    fn candidate(&self, node: usize, local: Option<&Local>) -> Option<(Point, Vector)> {
        let (middle, guess) = self.middle(node)?;
        let (p, q) = self.rings.edge(node);
        let a = self.sizes.at(middle);
        let normal = local.map_or(guess, |l| l.plane.normal);
        let into = (q - p).cross(&normal).try_normalize(1e-12)?;
        let side = (q - p).norm().min(3f64.sqrt() * a);
        let distance = 0.5 * (4.0 * a * a - side * side).sqrt();
        let flat = middle + distance * into;
        if let Way::Led(lead) = &self.way {
            return (lead.surface)(flat);
        }
        let foot = local.and_then(|l| l.polynomial.as_ref()).map(|polynomial| polynomial.at(flat));
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
    /// edge to it; says whether it did. `near` are the nodes around `p`.
    fn meet(
        &mut self,
        (v, w): (usize, usize),
        p: Point,
        size: f64,
        normal: Vector,
        near: &[usize],
    ) -> bool {
        if !self.rings.is_alive(v) || self.rings.after(v) != w {
            return false;
        }
        let reach = MEETING * size;
        let own = [v, w, self.rings.before(v), self.rings.after(w)];
        let distance = |node: usize| (self.rings.at(node) - p).norm();
        let nearest = near
            .iter()
            .copied()
            .filter(|node| !own.contains(node) && distance(*node) < reach)
            .min_by(|x, y| distance(*x).total_cmp(&distance(*y)));
        let apex = nearest.filter(|&apex| self.may_join(v, apex, normal));
        apex.inspect(|&apex| self.join(v, apex)).is_some()
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
        let plane = self.plane(c, normal);
        // The apex sees the edge through its own gap.
        let [before, after] = [self.rings.before(apex), self.rings.after(apex)];
        let [before, after] = [before, after].map(|n| self.rings.at(n));
        let gap = plane.angle(before, c, after);
        let between = |p: Point| plane.angle(before, c, p) < gap;
        between(a) && between(b) && self.is_free(corners, c, normal)
    }

    fn join(&mut self, node: usize, apex: usize) {
        let w = self.rings.after(node);
        self.add([w, node, apex].map(|n| self.rings.vertex(n)));
        self.rings.pinch(node, apex);
        self.close_triangle(node);
        if self.rings.is_alive(w) {
            self.close_triangle(w);
        }
    }

    /// Joins `p` to the nearest front edge, if it keeps its distance from all
    /// other points (a front that has turned around would grow back over the
    /// measured surface) and the triangle crosses nothing. `near` are the nodes
    /// around `p`.
    fn try_point(&mut self, p: Point, size: f64, normal: Vector, near: &[usize]) {
        let crowded = |node: &usize| (self.rings.at(*node) - p).norm() < APART * size;
        if near.iter().any(crowded) || self.around.cloud.nearest_distance(p) < APART * size {
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
        if !self.is_free([b, a, p], p, normal) {
            return;
        }
        let new = self.add_point(p, normal);
        let ends = [node, self.rings.after(node)].map(|n| self.rings.vertex(n));
        self.add([ends[1], ends[0], new]);
        self.rings.insert(node, new, p);
    }
}
