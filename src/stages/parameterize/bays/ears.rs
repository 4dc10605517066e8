//! Ears of an outer boundary, cut off from the inner ends of its bays outwards.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};

use super::STRAIGHT;
use super::mapped_loop::MappedLoop;
use crate::geometry::{OrderedFloat, Point, Uv, Vector, VertexId, unit_normal};
use crate::mesh::Adjacency;
use crate::mesh::remesh::FOLDED;

/// A leaning ear is cut off only if the map shows a tip angle below this one. The value is 150° in
/// radians.
const SLIT: f64 = 5.0 / 6.0 * PI;

/// A closed loop that is shortened ear by ear.
pub(crate) struct Ears<'a> {
    mesh: Adjacency<'a>,
    ring: &'a [VertexId],
    /// The loop on the map, if there is a map.
    flat: Option<MappedLoop>,
    before: Vec<usize>,
    after: Vec<usize>,
    alive: Vec<bool>,
    /// The angle of the surface at each position of the loop.
    angles: Vec<f64>,
    /// The normal of the surface to the left of the side that leaves each position.
    beside: Vec<Vector>,
    /// The length of the side that leaves each position.
    lengths: Vec<f64>,
    /// The sum of π minus the angles, and the sum of the lengths.
    turning: f64,
    length: f64,
    sides: HashSet<(usize, usize)>,
    /// The ears that were cut off, as the positions before, at and after their tips.
    closed: Vec<[usize; 3]>,
    /// The tips of these ears, by the positions before and after them.
    tips: HashMap<[usize; 2], usize>,
    /// The tips of the ears that lean.
    leaning: Vec<usize>,
}

/// An ear that may be cut off. Ears with short bases that continue the surface beside them come
/// first.
struct EarCandidate {
    cost: f64,
    ear: [usize; 3],
    normal: Vector,
    leans: bool,
}

impl EarCandidate {
    /// The place in a heap that returns the cheapest ear first.
    fn order(&self) -> EarOrder {
        Reverse((OrderedFloat(self.cost), self.ear))
    }
}

/// The cost of an ear, and the ear.
type EarOrder = Reverse<(OrderedFloat, [usize; 3])>;

impl<'a> Ears<'a> {
    pub(super) fn new(mesh: Adjacency<'a>, ring: &'a [VertexId], map: Option<&[Uv]>) -> Self {
        let n = ring.len();
        let angle = |&v: &VertexId| -> f64 {
            let corner = |t: [VertexId; 3]| {
                let k = t.iter().position(|w| *w == v).unwrap_or(0);
                mesh.mesh.angle(t[(k + 1) % 3], t[k], t[(k + 2) % 3])
            };
            mesh.rings.triangles(v).iter().map(|&t| corner(mesh.mesh.triangles[t as usize])).sum()
        };
        let angles: Vec<f64> = ring.iter().map(angle).collect();
        let normals = mesh.mesh.vertex_normals();
        let side = |i: usize| -> Vector {
            let near = (0..10).map(|k| normals[ring[(i + n * 5 + k - 4) % n].index()]);
            near.sum::<Vector>().try_normalize(0.0).unwrap_or_default()
        };
        let mut ears = Ears {
            mesh,
            ring,
            flat: map.map(|map| MappedLoop::new(ring, map)),
            before: (0..n).map(|i| (i + n - 1) % n).collect(),
            after: (0..n).map(|i| (i + 1) % n).collect(),
            alive: vec![true; n],
            turning: angles.iter().map(|a| PI - a).sum(),
            angles,
            beside: (0..n).map(side).collect(),
            lengths: Vec::new(),
            length: 0.0,
            sides: HashSet::new(),
            closed: Vec::new(),
            tips: HashMap::new(),
            leaning: Vec::new(),
        };
        ears.lengths = (0..n).map(|i| ears.distance(i, ears.after[i])).collect();
        ears.length = ears.lengths.iter().sum();
        ears
    }

    fn at(&self, i: usize) -> Point {
        self.mesh.mesh.point(self.ring[i])
    }

    fn distance(&self, i: usize, j: usize) -> f64 {
        (self.at(j) - self.at(i)).norm()
    }

    /// Cuts off ears until the loop turns outwards nowhere more than on average. With a map, it
    /// does so until the loop turns to the right nowhere.
    pub(crate) fn close(&mut self) {
        let order = |ears: &Self, i: usize| ears.candidate(i).map(|candidate| candidate.order());
        let mut heap: BinaryHeap<EarOrder> =
            (0..self.ring.len()).filter_map(|i| order(self, i)).collect();
        let (mut blocked, mut closed) = (Vec::new(), 0);
        // A place that turns outwards no more than the average may do so later, because the average
        // changes.
        while let Some(Reverse((_, ear))) = heap.pop() {
            let [p, v, n] = ear;
            let is_there = self.alive[v] && self.ear(v) == ear;
            let candidate = self.candidate(v).filter(|_| is_there && self.is_new(p, n));
            if let Some(EarCandidate { normal, leans, .. }) = candidate {
                if self.is_free(ear) {
                    self.cut(ear, normal);
                    self.leaning.extend(leans.then_some(v));
                    heap.extend([p, n].into_iter().filter_map(|i| order(self, i)));
                } else {
                    blocked.push(v);
                }
            }
            // The vertices that blocked an ear may have been cut off since.
            if heap.is_empty() && closed < self.closed.len() {
                closed = self.closed.len();
                let unblocked = std::mem::take(&mut blocked).into_iter();
                heap.extend(unblocked.filter(|&v| self.alive[v]).filter_map(|v| order(self, v)));
            }
        }
    }

    fn ear(&self, v: usize) -> [usize; 3] {
        [self.before[v], v, self.after[v]]
    }

    /// The ear at a position. `None` if the loop does not turn outwards there, or if the ear leans
    /// and the map does not show a sharp tip.
    fn candidate(&self, v: usize) -> Option<EarCandidate> {
        let ear = self.ear(v);
        let [p, v, n] = ear;
        if !self.bends(v) {
            return None;
        }
        let normal = unit_normal([p, n, v].map(|i| self.at(i)))?;
        let lean = self.beside[p].dot(&normal).min(self.beside[v].dot(&normal));
        let cost = self.distance(p, n) * (2.0 - lean).powi(2);
        let leans = lean < FOLDED;
        let may = !leans || self.flat.as_ref().is_some_and(|flat| flat.tip(ear) < SLIT);
        may.then_some(EarCandidate { cost, ear, normal, leans })
    }

    /// Whether the loop turns to the right at a position, by more than on average.
    fn bends(&self, v: usize) -> bool {
        if let Some(flat) = &self.flat {
            return flat.bends(self.ear(v));
        }
        let share = (-self.turning).max(0.0) / self.length;
        let around = 0.5 * (self.lengths[self.before[v]] + self.lengths[v]);
        self.angles[v] - PI > STRAIGHT + share * around
    }

    /// Whether no vertex of the loop lies in an ear, as far as a map shows it.
    fn is_free(&self, ear: [usize; 3]) -> bool {
        self.flat.as_ref().is_none_or(|flat| flat.is_free(ear, |i| self.alive[i]))
    }

    /// Whether two positions are not joined yet, and more than a triangle is left of the loop.
    fn is_new(&self, p: usize, n: usize) -> bool {
        let joined = || self.mesh.joined(self.ring[p], self.ring[n]);
        p != n && self.after[n] != p && !self.sides.contains(&(p.min(n), p.max(n))) && !joined()
    }

    /// Cuts off an ear. Its lengths and angles are those of a flat ear that continues the surface.
    /// Chords in space would not do: over a strongly curved surface they are so short that all of
    /// the boundary would appear to be a bay.
    fn cut(&mut self, ear: [usize; 3], normal: Vector) {
        let [p, v, n] = ear;
        let in_space = self.mesh.mesh.angle(self.ring[p], self.ring[v], self.ring[n]);
        // Where the surface overlaps itself, no angle is left.
        let tip = (TAU - self.angles[v]).max(in_space).max(STRAIGHT);
        let [a, b] = [self.lengths[p], self.lengths[v]];
        let chord = (a * a + b * b - 2.0 * a * b * tip.cos()).sqrt();
        let first = (b * tip.sin()).atan2(a - b * tip.cos());
        self.turning += self.angles[v] - PI - (PI - tip);
        self.angles[p] += first;
        self.angles[n] += PI - tip - first;
        self.length += chord - a - b;
        self.lengths[p] = chord;
        self.alive[v] = false;
        self.after[p] = n;
        self.before[n] = p;
        self.beside[p] = normal;
        self.sides.insert((p.min(n), p.max(n)));
        self.closed.push(ear);
        self.tips.insert([p, n], v);
    }

    /// Whether a position lies between two others. Positions continue beyond the end of the loop.
    fn is_between(&self, v: usize, from: usize, to: usize) -> bool {
        let n = self.ring.len();
        (from + 1..to).contains(&v) || from < v + n && v + n < to
    }

    /// The ears whose tips lie between two positions.
    pub(crate) fn within(&self, from: usize, to: usize) -> Vec<[usize; 3]> {
        self.closed.iter().filter(|ear| self.is_between(ear[1], from, to)).copied().collect()
    }

    /// Whether an ear between two positions leans.
    pub(crate) fn lean(&self, from: usize, to: usize) -> bool {
        self.leaning.iter().any(|&v| self.is_between(v, from, to))
    }

    /// The tip of the ear that was cut off between two positions.
    pub(super) fn over(&self, from: usize, to: usize) -> Option<usize> {
        let n = self.ring.len();
        let tip = *self.tips.get(&[from % n, to % n])?;
        Some(if tip < from { tip + n } else { tip })
    }

    /// The remaining positions, in the direction of the loop.
    pub(crate) fn left(&self) -> Vec<usize> {
        (0..self.ring.len()).filter(|&i| self.alive[i]).collect()
    }
}
