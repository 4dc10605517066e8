//! Triangles that the stars agree on.
//!
//! A triangle on which the stars of all three corners agree is taken. Any edge is in at most two of
//! these, because each star has a neighbour once. Then come triangles with two votes and with one,
//! those with the least circumradius first. Such a triangle is taken if it overlaps no other one
//! around any of its corners.

use foldhash::HashMap;
use foldhash::HashMapExt;
use nalgebra::Vector2;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::project::SurfacePoint;
use super::voronoi::VoronoiStars;
use crate::geometry::{OrderedFloat, Point, plane_axes};
use crate::mesh::Buckets;

type NumberedTriangle = [u32; 3];

/// Elects the triangles.
pub(super) fn elect(stars: &VoronoiStars, vertices: &[SurfacePoint]) -> Vec<NumberedTriangle> {
    let proposed: Vec<(NumberedTriangle, usize)> =
        (0..stars.len() as u32).into_par_iter().flat_map_iter(|i| proposals(i, stars)).collect();
    let (agreed, mut candidates): (Vec<_>, Vec<_>) = proposed.into_iter().partition(|p| p.1 == 3);
    let radius = |t: &NumberedTriangle| circumradius(t.map(|v| vertices[v as usize].place));
    candidates.sort_by_cached_key(|(t, votes)| (3 - votes, OrderedFloat(radius(t)), *t));
    let mut elected = Elected::new(vertices, agreed.into_iter().map(|p| p.0).collect());
    for (triangle, _) in candidates {
        if elected.has_room(triangle) {
            elected.add(triangle);
        }
    }
    elected.triangles
}

/// The triangles of which vertex `i` is the lowest that votes for them, each with its votes.
fn proposals(i: u32, stars: &VoronoiStars) -> impl Iterator<Item = (NumberedTriangle, usize)> + '_ {
    stars.triangles(i).filter_map(move |[j, k]| {
        let [by_j, by_k] = [stars.has(j, [k, i]), stars.has(k, [i, j])];
        let is_lowest = !(by_j && j < i || by_k && k < i);
        is_lowest.then_some(([i, j, k], 1 + usize::from(by_j) + usize::from(by_k)))
    })
}

/// The radius of the circle through the corners of a triangle; infinite without an area.
pub(super) fn circumradius([a, b, c]: [Point; 3]) -> f64 {
    let (u, v, w) = (b - a, c - b, a - c);
    let area = u.cross(&v).norm();
    if area > 0.0 { u.norm() * v.norm() * w.norm() / (2.0 * area) } else { f64::INFINITY }
}

/// The triangles that are elected, and those around each vertex.
struct Elected<'a> {
    vertices: &'a [SurfacePoint],
    triangles: Vec<NumberedTriangle>,
    /// The triangles with three votes around each vertex.
    agreed: Buckets,
    /// The others.
    added: HashMap<u32, SmallVec<[u32; 4]>>,
}

impl<'a> Elected<'a> {
    fn new(vertices: &'a [SurfacePoint], triangles: Vec<NumberedTriangle>) -> Self {
        let corner = |c: u32| triangles[c as usize / 3][c as usize % 3];
        let agreed = Buckets::new(vertices.len(), 3 * triangles.len(), corner);
        Elected { vertices, triangles, agreed, added: HashMap::new() }
    }

    fn add(&mut self, triangle: NumberedTriangle) {
        let number = self.triangles.len() as u32;
        triangle.into_iter().for_each(|v| self.added.entry(v).or_default().push(number));
        self.triangles.push(triangle);
    }

    /// Whether a triangle overlaps none of those around its corners.
    fn has_room(&self, t: NumberedTriangle) -> bool {
        (0..3).all(|k| {
            let (tip, a, b) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            let Some(own) = self.sector(tip, [a, b]) else { return false };
            let others = self.around(tip).filter_map(|other| self.sector(tip, other));
            { others }.all(|other| !own.overlaps(&other))
        })
    }

    /// The other two corners of each triangle around a vertex.
    fn around(&self, tip: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        let agreed = self.agreed.of(tip as usize).iter().map(|&corner| corner / 3);
        let added = self.added.get(&tip).into_iter().flatten().copied();
        agreed.chain(added).map(move |t| {
            let t = self.triangles[t as usize];
            let k = t.iter().position(|&v| v == tip).unwrap_or(0);
            [t[(k + 1) % 3], t[(k + 2) % 3]]
        })
    }

    /// The angle of a triangle at one of its corners, in the tangent plane there. `None` if
    /// it is flat.
    fn sector(&self, tip: u32, ends: [u32; 2]) -> Option<Sector> {
        let own = &self.vertices[tip as usize];
        let (x, y) = plane_axes(own.normal);
        let arms = ends.map(|v| {
            let d = self.vertices[v as usize].place - own.place;
            Vector2::new(d.dot(&x), d.dot(&y))
        });
        match arms[0].perp(&arms[1]) {
            turn if turn > 0.0 => Some(Sector { ends, arms }),
            turn if turn < 0.0 => {
                Some(Sector { ends: [ends[1], ends[0]], arms: [arms[1], arms[0]] })
            }
            _ => None,
        }
    }
}

/// The angle between two edges of a vertex, counter-clockwise and less than half a turn.
struct Sector {
    ends: [u32; 2],
    arms: [Vector2<f64>; 2],
}

impl Sector {
    fn overlaps(&self, other: &Sector) -> bool {
        let holds_any = |s: &Sector, o: &Sector| (0..2).any(|k| s.holds(o.ends[k], &o.arms[k]));
        self.ends == other.ends || holds_any(self, other) || holds_any(other, self)
    }

    /// Whether an edge runs inside the sector.
    fn holds(&self, end: u32, arm: &Vector2<f64>) -> bool {
        !self.ends.contains(&end) && self.arms[0].perp(arm) > 0.0 && arm.perp(&self.arms[1]) > 0.0
    }
}
