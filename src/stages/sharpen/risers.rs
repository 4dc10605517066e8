//! Risers: strips of triangles between regions whose surfaces have no common curve or point.
//!
//! The two sides of a thin sheet do not meet at its rim, and neither do the surfaces beside a step that is lower than an edge of the
//! mesh. A vertex between them gets a copy on each surface. The triangles between the copies close the mesh again: a
//! riser along each border that was opened, and a facet at each vertex from which more than two risers go out.

use std::collections::{BTreeMap, BTreeSet};

use super::places::Tear;
use super::{Riser, Work};
use crate::geometry::sets::Sets;
use crate::geometry::{NONE, Point, VertexId, faired};
use crate::mesh::Mesh;

/// More regions around a vertex are all parted from each other, since the ways to part them double with each.
const MOST_SECTORS: usize = 10;

/// A mesh whose borders are opened where surfaces do not meet.
pub(super) struct OpenedMesh {
    pub mesh: Mesh,
    /// For each triangle its surface, and [`NONE`] of a riser.
    pub of: Vec<u32>,
    /// For each triangle that has no surface the number of its facet.
    pub facet: Vec<u32>,
    pub risers: Vec<Riser>,
}

/// The copies of a vertex.
struct Copies {
    /// For each side that begins at the vertex its copy. Sides that follow each other counterclockwise have the same one unless a
    /// riser goes out between them.
    of_side: BTreeMap<usize, u32>,
    /// The copies counterclockwise.
    all: Vec<u32>,
    /// Those that lie on one surface only, with that.
    alone: Vec<(u32, u32)>,
}

/// Copies that follow each other along a border on one of its surfaces.
struct Rail {
    region: u32,
    copies: Vec<u32>,
}

/// A way to part the triangles around a vertex.
struct Parting {
    /// For each sector the number of its copy.
    copy: Vec<usize>,
    places: Vec<Point>,
}

impl Work<'_> {
    /// Opens the mesh at the vertices that have no place on all of their surfaces.
    pub(super) fn opened(
        &self,
        touching: &BTreeSet<[u32; 2]>,
        torn: &BTreeMap<u32, Tear>,
        mut points: Vec<Point>,
    ) -> OpenedMesh {
        let copies = self.copies(touching, torn, &mut points);
        let corner = |side: usize| {
            let v = self.mesh.side(side).0;
            let own = copies.get(&v.0).and_then(|of| of.of_side.get(&side));
            VertexId(own.copied().unwrap_or(v.0))
        };
        let alone = copies.values().flat_map(|of| &of.alone).copied().collect();
        for rail in self.rails(&corner) {
            self.smooth_rail(&rail, &alone, &mut points);
        }
        let own = (0..self.of.len()).map(|t| [0, 1, 2].map(|k| corner(3 * t + k)));
        let mut triangles: Vec<[VertexId; 3]> = own.collect();
        let count = triangles.len();
        let mut of = self.of.clone();
        let mut facets = 0;
        // Each triangle without a surface is a facet.
        let mut facet: Vec<u32> = Vec::with_capacity(count);
        for &region in &of {
            facets += u32::from(region == NONE);
            facet.push(facets);
        }
        for piece in self.pieces_of_risers(&copies, &corner, &points) {
            facets += 1;
            facet.extend(piece.iter().map(|_| facets));
            triangles.extend(piece);
        }
        of.resize(triangles.len(), NONE);
        let risers = self.connected(torn, &copies, &triangles[count..], &points);
        OpenedMesh { mesh: Mesh { points, triangles }, of, facet, risers }
    }

    /// The copies of vertices that have no place. Their places are added to the points.
    fn copies(
        &self,
        touching: &BTreeSet<[u32; 2]>,
        torn: &BTreeMap<u32, Tear>,
        points: &mut Vec<Point>,
    ) -> BTreeMap<u32, Copies> {
        let mut copies: BTreeMap<u32, Copies> = BTreeMap::new();
        for (&v, tear) in torn {
            let sides = self.fan(v);
            if sides.len() != self.rings.triangles(VertexId(v)).len() {
                continue;
            }
            let sectors = self.sectors(&sides);
            let parting =
                self.parting(&sectors, &tear.apart, touching, self.mesh.points[v as usize]);
            points[v as usize] = parting.places[0];
            let mut all = vec![v];
            for &place in &parting.places[1..] {
                all.push(points.len() as u32);
                points.push(place);
            }
            let mut alone = Vec::new();
            for (k, &copy) in all.iter().enumerate() {
                let own = sectors.iter().zip(&parting.copy).filter(|of| *of.1 == k);
                let own: BTreeSet<u32> = own.map(|of| of.0.0).filter(|&r| r != NONE).collect();
                alone.extend(own.first().filter(|_| own.len() == 1).map(|&r| (copy, r)));
            }
            let number = sectors.iter().zip(&parting.copy);
            let of_side = number.flat_map(|(of, &k)| of.1.iter().map(move |&side| (side, k)));
            let of_side = of_side.map(|(side, k)| (side, all[k])).collect();
            copies.insert(v, Copies { of_side, all, alone });
        }
        copies
    }

    /// The triangles of risers, one or two for each edge of a border, and of the facets between risers.
    fn pieces_of_risers(
        &self,
        copies: &BTreeMap<u32, Copies>,
        corner: &impl Fn(usize) -> VertexId,
        points: &[Point],
    ) -> Vec<Vec<[VertexId; 3]>> {
        let after = |side: usize| 3 * (side / 3) + (side + 1) % 3;
        let mut pieces = Vec::new();
        for (v, own) in copies {
            let [first, others @ ..] = &own.all[..] else { continue };
            let between = others.windows(2).map(|pair| [*first, pair[0], pair[1]].map(VertexId));
            pieces.extend(between.map(|triangle| vec![triangle]));
            for &side in own.of_side.keys() {
                let Some(twin) = self.edges.across(side) else { continue };
                let w = self.mesh.side(twin).0.0;
                // A riser between two opened vertices is made once.
                if copies.contains_key(&w) && w < *v {
                    continue;
                }
                let around = [corner(after(twin)), corner(twin), corner(after(side)), corner(side)];
                pieces.push(riser(around, points));
            }
        }
        pieces.retain(|piece| !piece.is_empty());
        pieces
    }

    /// The rails of all borders.
    fn rails(&self, corner: &impl Fn(usize) -> VertexId) -> Vec<Rail> {
        let after = |side: usize| 3 * (side / 3) + (side + 1) % 3;
        let mut rails = Vec::new();
        for border in self.borders().iter().filter(|border| border.pair[1] != NONE) {
            for region in border.pair {
                let mut copies: Vec<u32> = Vec::new();
                for ends in border.vertices.windows(2) {
                    let Some(side) = self.side_of(ends[0], ends[1], region) else { continue };
                    let (mut from, mut to) = (corner(side).0, corner(after(side)).0);
                    if self.mesh.side(side).0.0 != ends[0] {
                        std::mem::swap(&mut from, &mut to);
                    }
                    if copies.last().is_some_and(|&last| last != from) {
                        rails.push(Rail { region, copies: std::mem::take(&mut copies) });
                    }
                    if copies.is_empty() {
                        copies.push(from);
                    }
                    copies.push(to);
                }
                rails.push(Rail { region, copies });
            }
        }
        rails
    }

    /// The side between two vertices whose triangle lies on a surface.
    fn side_of(&self, a: u32, b: u32, region: u32) -> Option<usize> {
        let own =
            self.rings.triangles(VertexId(a)).iter().filter(|&&t| self.of[t as usize] == region);
        let mut sides = own.flat_map(|&t| 3 * t as usize..3 * t as usize + 3);
        sides.find(|&side| {
            let (p, q) = self.mesh.side(side);
            [p.0, q.0] == [a, b] || [p.0, q.0] == [b, a]
        })
    }

    /// Smooths the copies of a rail that lie on one surface only.
    fn smooth_rail(&self, rail: &Rail, alone: &BTreeMap<u32, u32>, points: &mut [Point]) {
        let n = rail.copies.len();
        let is_free: Vec<bool> =
            rail.copies.iter().map(|copy| alone.get(copy) == Some(&rail.region)).collect();
        if n < 3 || !is_free.contains(&true) {
            return;
        }
        let own: Vec<Point> = rail.copies.iter().map(|&copy| points[copy as usize]).collect();
        let own = faired(&own, |k| is_free[k]);
        let surface = self.surface(rail.region);
        for k in (0..n).filter(|&k| is_free[k]) {
            let at = surface.closest(own[k]);
            if at.coords.iter().all(|x| x.is_finite()) {
                points[rail.copies[k] as usize] = at;
            }
        }
    }

    /// The sides that begin at a vertex, counterclockwise.
    pub(super) fn fan(&self, v: u32) -> Vec<usize> {
        let ring = self.rings.triangles(VertexId(v));
        let starts =
            |t: u32| (3 * t as usize..3 * t as usize + 3).find(|&s| self.mesh.side(s).0.0 == v);
        let Some(first) = ring.first().and_then(|&t| starts(t)) else { return Vec::new() };
        let mut sides = vec![first];
        while let Some(next) =
            self.edges.across(3 * (sides[sides.len() - 1] / 3) + (sides[sides.len() - 1] + 2) % 3)
        {
            if next == first || sides.len() == ring.len() {
                break;
            }
            sides.push(next);
        }
        sides
    }

    /// The regions around a vertex with their sides, counterclockwise.
    pub(super) fn sectors(&self, sides: &[usize]) -> Vec<(u32, Vec<usize>)> {
        let region = |side: usize| self.of[side / 3];
        let n = sides.len();
        let first =
            (0..n).find(|&k| region(sides[k]) != region(sides[(k + n - 1) % n])).unwrap_or(0);
        let mut sectors: Vec<(u32, Vec<usize>)> = Vec::new();
        for k in 0..n {
            let side = sides[(first + k) % n];
            match sectors.last_mut() {
                Some((own, all)) if *own == region(side) => all.push(side),
                _ => sectors.push((region(side), vec![side])),
            }
        }
        sectors
    }

    /// The way to part the sectors around a vertex into the fewest copies, and of those the one that moves them least.
    fn parting(
        &self,
        sectors: &[(u32, Vec<usize>)],
        apart: &[[u32; 2]],
        touching: &BTreeSet<[u32; 2]>,
        start: Point,
    ) -> Parting {
        let n = sectors.len();
        let regions: Vec<u32> = sectors.iter().map(|of| of.0).collect();
        // A bit for each sector that begins a copy.
        let ways = if n <= MOST_SECTORS { 0..1usize << n } else { 0..0 };
        let mut ways: Vec<usize> = ways.filter(|way| way.count_ones() != 1).collect();
        ways.sort_by_key(|way| way.count_ones());
        let mut best: Option<(u32, f64, Parting)> = None;
        for way in ways {
            if best.as_ref().is_some_and(|best| best.0 < way.count_ones()) {
                break;
            }
            let parting = parted(n, way);
            let places = self.places(&regions, &parting, apart, touching, start);
            let Some(places) = places else { continue };
            let moved: f64 = places.iter().map(|p| (p - start).norm()).sum();
            if best.as_ref().is_none_or(|best| moved < best.1) {
                best = Some((way.count_ones(), moved, Parting { copy: parting, places }));
            }
        }
        best.map_or_else(
            || {
                let own = |&r: &u32| if r == NONE { start } else { self.surface(r).closest(start) };
                Parting { copy: (0..n).collect(), places: regions.iter().map(own).collect() }
            },
            |best| best.2,
        )
    }

    /// The places of the copies of a parting, if there are some.
    fn places(
        &self,
        regions: &[u32],
        copy: &[usize],
        apart: &[[u32; 2]],
        touching: &BTreeSet<[u32; 2]>,
        start: Point,
    ) -> Option<Vec<Point>> {
        let count = copy.iter().max()? + 1;
        let place = |k: usize| {
            let own = regions.iter().zip(copy).filter(|(r, c)| **c == k && **r != NONE);
            let own: BTreeSet<u32> = own.map(|of| *of.0).collect();
            if apart.iter().any(|pair| pair.iter().all(|r| own.contains(r))) {
                return None;
            }
            self.placed(&own.into_iter().collect::<Vec<_>>(), touching, start).ok()
        };
        (0..count).map(place).collect()
    }

    /// The places of connected risers.
    fn connected(
        &self,
        torn: &BTreeMap<u32, Tear>,
        copies: &BTreeMap<u32, Copies>,
        risers: &[[VertexId; 3]],
        points: &[Point],
    ) -> Vec<Riser> {
        let mut sets = Sets::new(points.len());
        for corners in risers {
            sets.join(corners[0].index(), corners[1].index());
            sets.join(corners[0].index(), corners[2].index());
        }
        let mut count: BTreeMap<usize, usize> = BTreeMap::new();
        for corners in risers {
            *count.entry(sets.find(corners[0].index())).or_default() += 1;
        }
        let mut found = Vec::new();
        for &v in copies.keys() {
            if let Some(triangles) = count.remove(&sets.find(v as usize)) {
                found.push(Riser {
                    place: self.mesh.points[v as usize],
                    triangles,
                    why: torn[&v].why,
                });
            }
        }
        found
    }
}

/// For each sector its copy, if those of the given bits begin one.
fn parted(n: usize, way: usize) -> Vec<usize> {
    let count = way.count_ones() as usize;
    let mut copy = Vec::with_capacity(n);
    let mut own = 0;
    for k in 0..n {
        own += way >> k & 1;
        // What is before the first bit belongs to the last copy.
        copy.push(if own == 0 { count.max(1) - 1 } else { own - 1 });
    }
    copy
}

/// The triangles of a riser, whose corners follow each other counterclockwise. Of a corner that occurs twice nothing is left.
fn riser(corners: [VertexId; 4], points: &[Point]) -> Vec<[VertexId; 3]> {
    let [a, b, c, d] = corners;
    let at = |v: VertexId| points[v.index()];
    let halves = if (at(a) - at(c)).norm() <= (at(b) - at(d)).norm() {
        [[a, b, c], [a, c, d]]
    } else {
        [[b, c, d], [b, d, a]]
    };
    let is_whole = |t: &[VertexId; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    halves.into_iter().filter(is_whole).collect()
}
