//! Thin blends: what rounds the edge between two regions is found as a property of that edge.
//!
//! A blend of two or three edges of the scan is too narrow to grow. But a ball that rolls along two known surfaces has
//! one parameter, its radius, and all vertices along the edge tell it.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Matrix3;

use super::division::Division;
use super::growth::Room;
use super::model::{LEAST_RADIUS, MORE_STEPS, MOST_OFF, MOST_SAMPLES, SurfaceModel, is_sane};
use super::scan::{CREASE, NoisyScan};
use super::seeds::FEWEST;
use crate::geometry::{NONE, Point, Vector};
use crate::primitives::Primitive;

/// The vertices of a strip are within so many rings of both regions.
const STRIP_RINGS: usize = 2;

/// The most regions that are kept for a vertex.
const MOST_NEAR: usize = 4;

/// So many radii are tried, each larger than the one before by this factor.
const RADIUS_FACTOR: f64 = 1.15;
const RADII: usize = 24;

/// A blend is at least so many edges wide; narrower ones are sharp edges for a scan.
const LEAST_WIDTH: f64 = 1.5;

/// A vertex seen across an edge: outward distances from both surfaces, and the cosine between their normals.
struct SeenAcross {
    vertex: u32,
    distances: [f64; 2],
    normals: [Vector; 2],
    deviation: f64,
}

impl SeenAcross {
    /// The direction from the centre of a ball of a radius to the vertex, in shares of both normals.
    fn shares(&self, radius: f64, bend: f64) -> [f64; 2] {
        let [a, b] = self.distances.map(|d| bend * d + radius);
        let c = self.normals[0].dot(&self.normals[1]);
        let square = (1.0 - c * c).max(f64::MIN_POSITIVE);
        [(a - c * b) / square, (b - c * a) / square]
    }

    fn is_on_ball(&self, radius: f64, bend: f64) -> bool {
        self.shares(radius, bend).iter().all(|&share| share > 0.0)
    }

    fn offset(&self, radius: f64, bend: f64) -> Vector {
        let [alpha, beta] = self.shares(radius, bend);
        bend * (alpha * self.normals[0] + beta * self.normals[1])
    }

    /// The squared distance from a blend in variances, bounded. `bend` is 1 for a convex edge, -1 for a concave one.
    fn cost(&self, radius: f64, bend: f64) -> f64 {
        let [alpha, beta] = self.shares(radius, bend);
        let d = if alpha <= 0.0 {
            self.distances[1]
        } else if beta <= 0.0 {
            self.distances[0]
        } else {
            self.offset(radius, bend).norm() - radius
        };
        (d / self.deviation).powi(2).min(MOST_OFF * MOST_OFF)
    }
}

/// Finds the blends along all edges between regions.
pub(super) fn find(scan: &NoisyScan, room: &mut Room, division: &mut Division) {
    let mut strips = strips(scan, division).into_iter().collect::<Vec<_>>();
    let size = |label: u32| division.parts[label as usize].vertices.len();
    strips.sort_by_key(|(pair, _)| (std::cmp::Reverse(size(pair[0]).min(size(pair[1]))), *pair));
    let mut is_used = vec![false; scan.len()];
    let mut is_gone = vec![false; division.parts.len()];
    for (pair, vertices) in strips {
        if pair.iter().any(|&label| is_gone[label as usize]) {
            continue;
        }
        let free: Vec<u32> = vertices.into_iter().filter(|&v| !is_used[v as usize]).collect();
        for piece in pieces(scan, free) {
            let Some((model, claimed)) = blend(scan, room, division, pair, &piece, &mut is_gone)
            else {
                continue;
            };
            claimed.iter().for_each(|&v| is_used[v as usize] = true);
            division.add(model, claimed);
            is_gone.push(false);
        }
    }
    division.list();
}

/// The vertices near two regions.
fn strips(scan: &NoisyScan, division: &Division) -> BTreeMap<[u32; 2], Vec<u32>> {
    let mut near: Vec<Vec<u32>> =
        division.labels.iter().map(|&l| if l == NONE { vec![] } else { vec![l] }).collect();
    for _ in 0..STRIP_RINGS {
        let next = |v: u32| {
            let mut all = near[v as usize].clone();
            for &w in scan.near(v) {
                for &label in &near[w as usize] {
                    if all.len() < MOST_NEAR && !all.contains(&label) {
                        all.push(label);
                    }
                }
            }
            all
        };
        near = (0..scan.len() as u32).map(next).collect();
    }
    let mut strips: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (v, labels) in near.iter().enumerate() {
        for (k, &a) in labels.iter().enumerate() {
            for &b in &labels[..k] {
                strips.entry([a.min(b), a.max(b)]).or_default().push(v as u32);
            }
        }
    }
    strips
}

/// The connected pieces of some vertices.
fn pieces(scan: &NoisyScan, vertices: Vec<u32>) -> Vec<Vec<u32>> {
    let mut left: BTreeSet<u32> = vertices.into_iter().collect();
    let mut all = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut found, mut done) = (vec![first], 0);
        while let Some(&v) = found.get(done) {
            done += 1;
            for &w in scan.near(v) {
                if left.remove(&w) {
                    found.push(w);
                }
            }
        }
        if found.len() >= FEWEST {
            all.push(found);
        }
    }
    all
}

/// The blend along one piece of an edge, if it explains the strip at a lower cost than what is there.
fn blend(
    scan: &NoisyScan,
    room: &mut Room,
    division: &Division,
    pair: [u32; 2],
    strip: &[u32],
    is_gone: &mut [bool],
) -> Option<(SurfaceModel, Vec<u32>)> {
    let supports = pair.map(|label| division.parts[label as usize].model);
    let across = |&v: &u32| {
        let seen = supports.map(|m| m.surface.distance(scan.point(v)));
        let sides = supports.map(|m| m.side);
        SeenAcross {
            vertex: v,
            distances: [0, 1].map(|k| sides[k] * seen[k].0),
            normals: [0, 1].map(|k| sides[k] * seen[k].1),
            deviation: scan.noise.at(v),
        }
    };
    let strip: Vec<SeenAcross> = strip
        .iter()
        .map(across)
        // The blends of other edges are not visible.
        .filter(|a| a.normals[0].dot(&a.normals[1]).abs() < CREASE.cos())
        .collect();
    if strip.len() < FEWEST {
        return None;
    }
    let cost = |radius: f64, bend: f64| strip.iter().map(|a| a.cost(radius, bend)).sum::<f64>();
    let radii = (0..RADII).map(|k| LEAST_RADIUS * scan.edge * RADIUS_FACTOR.powi(k as i32));
    let tried = radii.flat_map(|radius| [1.0, -1.0].map(|bend| (cost(radius, bend), radius, bend)));
    let (_, radius, bend) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let radius = refined(radius, |radius| cost(radius, bend));
    let turn =
        strip.iter().map(|a| a.normals[0].dot(&a.normals[1])).sum::<f64>() / strip.len() as f64;
    if radius * turn.clamp(-1.0, 1.0).acos() < LEAST_WIDTH * scan.edge {
        return None;
    }
    // Vertices at the ends of the edge may belong to other faces.
    let most = MOST_OFF * MOST_OFF;
    let is_on = |a: &&SeenAcross| a.is_on_ball(radius, bend) && a.cost(radius, bend) < most;
    let on_ball: Vec<&SeenAcross> = strip.iter().filter(is_on).collect();
    let claimed: Vec<u32> = on_ball.iter().map(|a| a.vertex).collect();
    if claimed.len() < FEWEST {
        return None;
    }
    let centres: Vec<Point> =
        on_ball.iter().map(|a| scan.point(a.vertex) - a.offset(radius, bend)).collect();
    let starts = along_line(&centres, radius).into_iter().chain(along_circle(&centres, radius));
    let models = starts.filter(|s| is_sane(scan, s)).flat_map(|surface| {
        let start = SurfaceModel { surface, side: bend };
        let fitted = start.refitted(scan, &claimed, MOST_SAMPLES, MORE_STEPS);
        fitted.into_iter().chain([start])
    });
    let rated = models.map(|model| (model.total(scan, &claimed), model));
    let (total, model) = rated.min_by(|a, b| a.0.total_cmp(&b.0))?;
    // The supports are known, so the radius is the only parameter.
    let own = model.description(scan, claimed.len());
    let parameter = own / model.kind().parameters() as f64;
    let total = total - own + parameter;
    // What is there: the regions that have the vertices now, of which those go that lie in the strip.
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    let mut now = 0.0;
    for &v in &claimed {
        let label = division.labels[v as usize];
        if label == NONE {
            now += most;
        } else {
            *counts.entry(label).or_default() += 1;
            now += division.parts[label as usize].model.cost_at(scan, v);
        }
    }
    let mut now = now / scan.common;
    let mut eaten = Vec::new();
    for (&label, &count) in counts.iter().filter(|(label, _)| !pair.contains(label)) {
        let part = &division.parts[label as usize];
        if 2 * count > part.vertices.len() {
            now += part.model.description(scan, part.vertices.len());
            eaten.push(label);
        }
    }
    if total >= now || !model.is_accepted(scan, &claimed, &mut room.off) {
        return None;
    }
    eaten.into_iter().for_each(|label| is_gone[label as usize] = true);
    Some((model, claimed))
}

/// The radius with the least cost within one step of a rough one (golden section).
fn refined(radius: f64, cost: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (radius / RADIUS_FACTOR, radius * RADIUS_FACTOR);
    while high - low > 1e-3 * radius {
        let [a, b] = [high - golden * (high - low), low + golden * (high - low)];
        if cost(a) < cost(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}

fn moments(points: &[Point]) -> (Point, [Vector; 3]) {
    let sum: Vector = points.iter().map(|p| p.coords).sum();
    let middle = Point::from(sum / points.len() as f64);
    let moments: Matrix3<f64> =
        points.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
    let eigen = moments.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    (middle, order.map(|i| eigen.eigenvectors.column(i).into_owned()))
}

/// The pipe of a radius along the line through some points.
fn along_line(points: &[Point], radius: f64) -> Option<Primitive> {
    let (origin, [.., axis]) = moments(points);
    Some(Primitive::Cylinder { origin, axis, radius })
}

/// The pipe of a radius along the circle through some points.
fn along_circle(points: &[Point], radius: f64) -> Option<Primitive> {
    let (middle, [axis, x, y]) = moments(points);
    let mut matrix = Matrix3::zeros();
    let mut right = Vector::zeros();
    for p in points {
        let q = p - middle;
        let row = Vector::new(2.0 * q.dot(&x), 2.0 * q.dot(&y), 1.0);
        matrix += row * row.transpose();
        right += q.norm_squared() * row;
    }
    let s = matrix.lu().solve(&right)?;
    let major = (s.z + s.x * s.x + s.y * s.y).sqrt();
    let centre = middle + s.x * x + s.y * y;
    (major > radius && major.is_finite()).then_some(Primitive::Torus {
        centre,
        axis,
        major,
        minor: radius,
    })
}
