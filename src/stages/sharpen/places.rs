//! The places of the vertices on their surfaces.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use super::borders::Border;
use super::{Riser, Work};
use crate::geometry::{NONE, Point, Vector, VertexId};
use crate::mesh::{EdgeMap, Mesh, VertexRings, caps};
use crate::primitives::Primitive;
use crate::primitives::contact::{contact, crossing};

/// A vertex moves at most so many edges. No vertex of a scan lies on an edge of the part, so that borders are off by one or two. Surfaces that
/// meet farther away than 3.5 do so at a small angle, and make spikes.
const FARTHEST: f64 = 3.5;

/// What is on its surfaces is off them by less than this share of an edge.
const ON: f64 = 1e-8;

/// The steps of Newton's method, and the step of its derivatives as a share of an edge.
const STEPS: usize = 25;
const STEP: f64 = 1e-5;

/// Directions in which surfaces hold a point less than this do not move it.
const HELD: f64 = 1e-4;

/// Vertices so many rings from a border are spread evenly, in so many steps.
const RELAXED: u32 = 6;
const RELAXATIONS: usize = 20;

/// The direction of a border is that between vertices so many steps away: borders that go to and fro do so over two or three.
const AHEAD: isize = 4;

/// The mesh with its vertices on their surfaces.
pub(super) struct Placed {
    pub mesh: Mesh,
    /// For each triangle its surface, and [`NONE`] of a riser.
    pub of: Vec<u32>,
    /// For each triangle that has no surface the number of its facet.
    pub facet: Vec<u32>,
    pub risers: Vec<Riser>,
}

/// A triangle has no area if its height is below this share of its longest side, as its vertices are on their surfaces to [`ON`].
const CAP: f64 = 1e-6;

/// The most rounds of flips. Caps that lie side by side take one each.
const FLIPS: usize = 64;

/// A vertex that has no place on all of its surfaces.
pub(super) struct Tear {
    /// The reason.
    pub why: &'static str,
    /// The pairs of surfaces whose curve through the vertex is not the border.
    pub apart: Vec<[u32; 2]>,
}

/// Where between two vertices their edge is compared with its curve.
const BETWEEN: [f64; 3] = [0.25, 0.5, 0.75];

impl Work<'_> {
    /// Moves all vertices. Where surfaces around a vertex have no common point, each keeps a vertex of its own, and risers join
    /// them.
    pub(super) fn place(&self, touching: &BTreeSet<[u32; 2]>) -> Placed {
        let (points, torn) = self.move_all(touching);
        let opened = self.opened(touching, &torn, points);
        let whole = Work {
            mesh: &opened.mesh,
            edges: EdgeMap::new(&opened.mesh),
            rings: VertexRings::new(&opened.mesh),
            edge: self.edge,
            noise: self.noise,
            correlation: self.correlation,
            bias: self.bias,
            surfaces: self.surfaces.clone(),
            of: opened.of,
        };
        let mut points = opened.mesh.points.clone();
        whole.relax(&mut points);
        let mesh = Mesh { points, triangles: opened.mesh.triangles.clone() };
        let (mut mesh, kept) = joined(mesh, ON * self.edge);
        let mut of: Vec<u32> = kept.iter().map(|&t| whole.of[t as usize]).collect();
        let mut facet: Vec<u32> = kept.iter().map(|&t| opened.facet[t as usize]).collect();
        self.flip_caps(&mut mesh, &mut of, &mut facet);
        Placed { mesh, of, facet, risers: opened.risers }
    }

    /// The places of the vertices, and those that have none on all of their surfaces, with the reason.
    fn move_all(&self, touching: &BTreeSet<[u32; 2]>) -> (Vec<Point>, BTreeMap<u32, Tear>) {
        let mut points = self.mesh.points.clone();
        let mut torn = BTreeMap::new();
        for (v, at) in points.iter_mut().enumerate() {
            match self.placed(&self.around(v as u32), touching, *at) {
                Ok(place) => *at = place,
                Err(why) => {
                    torn.insert(v as u32, Tear { why, apart: Vec::new() });
                }
            }
        }
        for border in self.borders().iter().filter(|border| border.pair[1] != NONE) {
            for part in border.without(&torn) {
                self.put_in_order(&part, touching, &mut points);
                for v in self.strays(&part, touching, &points) {
                    let why = "its two surfaces do not meet along a curve there";
                    let tear = || Tear { why, apart: Vec::new() };
                    torn.entry(v).or_insert_with(tear).apart.push(border.pair);
                }
            }
        }
        for v in self.pinched(&points) {
            let around = self.around(v);
            let pairs = around.iter().flat_map(|&a| around.iter().map(move |&b| [a, b]));
            let apart = pairs.filter(|pair| pair[0] < pair[1]).collect();
            torn.insert(v, Tear { why: "a region beside it has no width there", apart });
        }
        (points, torn)
    }

    /// Flips triangles without area, which lie on the curve between two surfaces or are facets. Facets that were flipped get numbers of
    /// their own.
    fn flip_caps(&self, mesh: &mut Mesh, of: &mut [u32], facet: &mut [u32]) {
        let mut count = facet.iter().max().map_or(0, |last| last + 1);
        for _ in 0..FLIPS {
            let points = mesh.points.clone();
            let corners = mesh.triangles.clone();
            // A cap on a border belongs to both surfaces.
            let is_on = |v: &VertexId, region: u32| {
                self.surface(region).distance(points[v.index()]).0.abs() <= ON * self.edge
            };
            let may =
                |t: usize, o: usize| of[o] == NONE || corners[t].iter().all(|v| is_on(v, of[o]));
            let (flipped, _) = caps::round(mesh, &EdgeMap::new(mesh), CAP, may);
            if flipped.is_empty() {
                break;
            }
            for [t, o] in flipped {
                of[t] = of[o];
                for own in [t, o].into_iter().filter(|&own| of[own] == NONE) {
                    facet[own] = count;
                    count += 1;
                }
            }
        }
    }

    /// The vertices of edges without a length that cannot become a point.
    fn pinched(&self, points: &[Point]) -> Vec<u32> {
        let mut found = Vec::new();
        for side in 0..3 * self.of.len() {
            let (a, b) = self.mesh.side(side);
            let apart = (points[a.index()] - points[b.index()]).norm();
            if a < b && apart <= ON * self.edge {
                let of_b: Vec<VertexId> = self.rings.neighbours(self.mesh, b).collect();
                let common = || self.rings.neighbours(self.mesh, a).filter(|v| of_b.contains(v));
                let is_thin = |v: VertexId| self.rings.triangles(v).len() <= 3;
                if common().count() != 2 || common().any(is_thin) {
                    found.extend([a.0, b.0]);
                }
            }
        }
        found
    }

    /// The vertices of a border between which its curve runs elsewhere.
    fn strays(
        &self,
        border: &Border,
        touching: &BTreeSet<[u32; 2]>,
        points: &[Point],
    ) -> BTreeSet<u32> {
        let [a, b] = border.pair;
        let is_touching = self.is_touching(a, b, touching);
        let (a, b) = (self.surface(a), self.surface(b));
        let strays = border.vertices.windows(2).filter(|ends| {
            let [p, q] = [ends[0], ends[1]].map(|v| points[v as usize]);
            BETWEEN.iter().any(|share| {
                let chord = p + *share * (q - p);
                let at = on_two(a, b, is_touching, chord);
                let off = a.distance(at).0.abs().max(b.distance(at).0.abs());
                // The curve of an edge turns by less than half a circle.
                let is_near = (at - chord).norm() <= 0.5 * (q - p).norm() + ON * self.edge;
                !(is_near && off <= ON * self.edge)
            })
        });
        strays.flatten().copied().collect()
    }

    /// Spreads the vertices inside of the regions evenly next to their borders, so that no triangle is turned over.
    fn relax(&self, points: &mut [Point]) {
        let mut depth: Vec<u32> = vec![u32::MAX; points.len()];
        let mut region: Vec<u32> = vec![NONE; points.len()];
        let mut queue: Vec<VertexId> = Vec::new();
        for v in 0..points.len() {
            match self.around(v as u32)[..] {
                [r] if self
                    .rings
                    .triangles(VertexId(v as u32))
                    .iter()
                    .all(|&t| self.of[t as usize] == r) =>
                {
                    region[v] = r;
                }
                _ => {
                    depth[v] = 0;
                    queue.push(VertexId(v as u32));
                }
            }
        }
        let mut at = 0;
        while let Some(&v) = queue.get(at) {
            at += 1;
            if depth[v.index()] == RELAXED {
                continue;
            }
            for w in self.rings.neighbours(self.mesh, v) {
                if depth[w.index()] == u32::MAX {
                    depth[w.index()] = depth[v.index()] + 1;
                    queue.push(w);
                }
            }
        }
        for _ in 0..RELAXATIONS {
            for &v in queue.iter().filter(|v| region[v.index()] != NONE) {
                let beside = self.rings.neighbours(self.mesh, v);
                let (sum, count) = beside.fold((Vector::zeros(), 0.0), |(sum, count), w| {
                    (sum + points[w.index()].coords, count + 1.0)
                });
                points[v.index()] =
                    self.surface(region[v.index()]).closest(Point::from(sum / count));
            }
        }
    }

    fn is_touching(&self, a: u32, b: u32, touching: &BTreeSet<[u32; 2]>) -> bool {
        touching.contains(&[a.min(b), a.max(b)])
    }

    /// The point of some surfaces next to a point.
    pub(super) fn placed(
        &self,
        regions: &[u32],
        touching: &BTreeSet<[u32; 2]>,
        start: Point,
    ) -> Result<Point, &'static str> {
        let at = match *regions {
            [] => return Ok(start),
            [a] => self.surface(a).closest(start),
            [a, b] => {
                let is_touching = self.is_touching(a, b, touching);
                on_two(self.surface(a), self.surface(b), is_touching, start)
            }
            _ => {
                let mut pairs = Vec::new();
                for (n, &a) in regions.iter().enumerate() {
                    for &b in &regions[n + 1..] {
                        if self.is_touching(a, b, touching) {
                            pairs.push((self.surface(a), self.surface(b)));
                        }
                    }
                }
                let all: Vec<&Primitive> = regions.iter().map(|&r| self.surface(r)).collect();
                on_all(&all, &pairs, start, self.edge)
            }
        };
        let off = regions.iter().map(|&r| self.surface(r).distance(at).0.abs()).fold(0.0, f64::max);
        if !at.coords.iter().all(|x| x.is_finite()) || off > ON * self.edge {
            return Err(match regions.len() {
                2 => "its two surfaces do not meet there",
                _ => "its surfaces have no common point there",
            });
        }
        if (at - start).norm() > FARTHEST * self.edge {
            return Err("its surfaces meet too far from the scan");
        }
        Ok(at)
    }

    /// Makes the vertices of a border follow each other along its curve.
    fn put_in_order(&self, border: &Border, touching: &BTreeSet<[u32; 2]>, points: &mut [Point]) {
        let [a, b] = border.pair;
        let is_touching = self.is_touching(a, b, touching);
        let (x, y) = (self.surface(a), self.surface(b));
        let mut vertices = border.vertices.clone();
        let n = vertices.len() - 1;
        if n < 2 {
            return;
        }
        let along = steps_along(&vertices, border.is_closed, points);
        let total: f64 = along.iter().sum();
        if along.iter().all(|&step| step > 0.0) || total <= 0.0 {
            return;
        }
        let mut places: Vec<f64> = vec![0.0];
        along.iter().for_each(|step| places.push(places[places.len() - 1] + step));
        if border.is_closed {
            // A closed border starts at a vertex that none passes.
            let Some(start) = (0..n).find(|&k| {
                places[..k].iter().all(|&at| at < places[k])
                    && places[k + 1..=n].iter().all(|&at| at > places[k])
            }) else {
                return;
            };
            let rest = places[start..n].iter().map(|at| at - places[start]);
            let first = places[..=start].iter().map(|at| at + total - places[start]);
            places = rest.chain(first).collect();
            vertices.pop();
            vertices.rotate_left(start);
            vertices.push(vertices[0]);
        }
        let own: Vec<Point> = vertices.iter().map(|&v| points[v as usize]).collect();
        // Those that do not pass a vertex before or behind them stay.
        let mut kept: Vec<usize> = vec![0];
        for k in 1..n {
            let last = kept[kept.len() - 1];
            if places[k] > places[last] && places[k] < total {
                kept.push(k);
            }
        }
        kept.push(n);
        for pair in kept.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            for k in from + 1..to {
                let share = (k - from) as f64 / (to - from) as f64;
                let between = own[from] + share * (own[to] - own[from]);
                points[vertices[k] as usize] = on_two(x, y, is_touching, between);
            }
        }
    }
}

/// For each step of a border how far it goes along the border as a whole: negative where it goes back.
fn steps_along(vertices: &[u32], is_closed: bool, points: &[Point]) -> Vec<f64> {
    let n = vertices.len() - 1;
    let at = |k: isize| {
        let k = if is_closed { k.rem_euclid(n as isize) } else { k.clamp(0, n as isize) };
        points[vertices[k as usize] as usize]
    };
    let step = |k: usize| {
        let k = k as isize;
        let (step, whole) = (at(k + 1) - at(k), at(k + 1 + AHEAD) - at(k - AHEAD));
        if step.dot(&whole) < 0.0 { -step.norm() } else { step.norm() }
    };
    (0..n).map(step).collect()
}

/// The point next to a point on the curve in which two surfaces cross or touch.
fn on_two(a: &Primitive, b: &Primitive, is_touching: bool, start: Point) -> Point {
    if is_touching { contact(a, b, start) } else { crossing(a, b, start) }
}

/// The point of several surfaces next to a point, by steps of least length.
fn on_all(
    surfaces: &[&Primitive],
    touching: &[(&Primitive, &Primitive)],
    start: Point,
    edge: f64,
) -> Point {
    let residual = |p: Point| {
        let mut rows: Vec<f64> = surfaces.iter().map(|s| s.distance(p).0).collect();
        for (a, b) in touching {
            let off = p - contact(a, b, p);
            rows.extend([off.x, off.y, off.z]);
        }
        DVector::from_vec(rows)
    };
    let h = STEP * edge;
    let mut at = start;
    for _ in 0..STEPS {
        let rows = residual(at);
        let columns = [Vector::x(), Vector::y(), Vector::z()]
            .map(|e| (residual(at + h * e) - residual(at - h * e)) / (2.0 * h));
        let svd = DMatrix::from_columns(&columns).svd(true, true);
        let Ok(step) = svd.solve(&-rows, HELD * svd.singular_values.max()) else { break };
        at += Vector::new(step[0], step[1], step[2]);
        if step.norm() < f64::EPSILON * at.coords.norm() {
            break;
        }
    }
    at
}

/// The mesh with one vertex for those that moved to one place, and the numbers that its triangles had. An edge stays if the
/// mesh would not be manifold without it.
fn joined(mesh: Mesh, reach: f64) -> (Mesh, Vec<u32>) {
    let Mesh { points, mut triangles } = mesh;
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for (t, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|v| around[v.index()].push(t as u32));
    }
    let mut is_gone = vec![false; triangles.len()];
    let mut is_done = false;
    while !is_done {
        is_done = true;
        for t in 0..triangles.len() {
            for k in 0..3 {
                let [a, b] = [triangles[t][k], triangles[t][(k + 1) % 3]];
                let apart = (points[a.index()] - points[b.index()]).norm();
                if is_gone[t] || apart > reach || !is_free(&triangles, &around, a, b) {
                    continue;
                }
                is_done = false;
                for o in std::mem::take(&mut around[b.index()]) {
                    let corners = &mut triangles[o as usize];
                    if corners.contains(&a) {
                        is_gone[o as usize] = true;
                        for v in corners.iter().filter(|&&v| v != b) {
                            around[v.index()].retain(|&other| other != o);
                        }
                    } else {
                        corners.iter_mut().filter(|v| **v == b).for_each(|v| *v = a);
                        around[a.index()].push(o);
                    }
                }
            }
        }
    }
    let kept: Vec<u32> = (0..triangles.len() as u32).filter(|&t| !is_gone[t as usize]).collect();
    let whole = Mesh { points, triangles };
    (whole.part(kept.iter().map(|&t| t as usize)).0, kept)
}

/// Whether an edge can become a point: its ends have no neighbours in common but those of its own triangles, and enough is left.
fn is_free(triangles: &[[VertexId; 3]], around: &[Vec<u32>], a: VertexId, b: VertexId) -> bool {
    let beside = |v: VertexId| {
        let corners = around[v.index()].iter().flat_map(|&t| triangles[t as usize]);
        let mut all: Vec<VertexId> = corners.filter(|&w| w != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (of_a, of_b) = (beside(a), beside(b));
    let common = of_a.iter().filter(|v| of_b.binary_search(v).is_ok());
    common.clone().count() == 2 && common.copied().all(|v| around[v.index()].len() > 3)
}
