//! A mesh that is known to be a disk with holes. The holes may contain islands.

use std::collections::HashMap;
use std::ops::Range;

use super::boundary::{self, Loop};
use super::topology::Topology;
use super::{EdgeMap, Mesh};
use crate::error::Result;
use crate::geometry::{Point, Vector, VertexId, in_lengths};

/// The rule that selects the outer boundary loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Outer {
    /// The loop with the largest vector area of those that do not run around a hole. The area counts
    /// because a ragged rim may be long around a small hole.
    #[default]
    Auto,
    /// The loop with the vertex nearest to this point.
    Near(Point),
}

/// An oriented mesh of genus 0 with at least one boundary loop, together with the islands in its
/// holes. An island is a piece of genus 0 as well. A body of any genus, which may be closed, has no
/// outer boundary.
#[derive(Debug, Clone)]
pub struct Disk {
    /// The triangles and points: those of the disk first, then those of each island.
    pub mesh: Mesh,
    /// The outer boundary loop; the surface lies to its left. It is empty for a body.
    pub outer: Loop,
    /// The rims of the holes; the surface lies to their left. The holes of the disk come first,
    /// then those of each island. Within a piece they are ordered by their lowest vertices.
    pub holes: Vec<Loop>,
    /// The islands, in the order in which `mesh` holds them.
    pub islands: Vec<Island>,
}

/// A separate piece of the surface that lies in a hole of another piece.
#[derive(Debug, Clone, PartialEq)]
pub struct Island {
    /// The number of its component; the largest component of the scan is 0.
    pub component: usize,
    /// The hole in which the island lies, as a position in [`Disk::holes`].
    pub hole: usize,
    /// The outer boundary loop of the island; the surface lies to its left.
    pub rim: Loop,
    /// The holes of the island, as positions in [`Disk::holes`].
    pub holes: Range<usize>,
    /// The number of its triangles.
    pub triangles: usize,
}

impl Disk {
    /// The disk with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Disk { mesh: self.mesh.scaled(factor), ..self }
    }

    /// Makes a disk of a connected, oriented mesh. The Euler characteristic decides whether it is
    /// one.
    pub(super) fn new(mesh: Mesh, edges: &EdgeMap, outer: Outer) -> Result<Self> {
        Topology::new(&mesh, edges, true).check_disk()?;
        let mut loops = boundary::boundary_loops(&mesh, edges);
        let outer = loops.remove(outer.among(&mesh, edges, &loops));
        Ok(Disk { mesh, outer, holes: loops, islands: Vec::new() })
    }

    /// All boundary loops: the outer one, the rims of the holes, and those of the islands.
    pub fn loops(&self) -> impl Iterator<Item = &Loop> {
        let islands = self.islands.iter().map(|island| &island.rim);
        let outer = std::iter::once(&self.outer).filter(|ring| !ring.is_empty());
        outer.chain(&self.holes).chain(islands)
    }

    /// Puts another disk into a hole of this disk or of one of its islands.
    pub(super) fn add_island(&mut self, component: usize, hole: usize, island: Disk) {
        let first = self.mesh.points.len() as u32;
        let shifted = |ring: Loop| ring.into_iter().map(|v| VertexId(v.0 + first)).collect();
        let holes = self.holes.len()..self.holes.len() + island.holes.len();
        let triangles = island.mesh.triangles.len();
        let rim = shifted(island.outer);
        self.holes.extend(island.holes.into_iter().map(shifted));
        self.islands.push(Island { component, hole, rim, holes, triangles });
        self.mesh.points.extend(island.mesh.points);
        let moved = island.mesh.triangles.into_iter().map(|t| t.map(|v| VertexId(v.0 + first)));
        self.mesh.triangles.extend(moved);
    }
}

impl Outer {
    /// The rule with its point expressed in lengths of `mm` each.
    pub(crate) fn in_lengths(self, mm: f64) -> Self {
        match self {
            Outer::Auto => Outer::Auto,
            Outer::Near(place) => Outer::Near(in_lengths(place, mm)),
        }
    }

    /// The position of the outer loop among `loops`.
    pub(crate) fn among(self, mesh: &Mesh, edges: &EdgeMap, loops: &[Loop]) -> usize {
        let rank: Vec<(bool, f64)> = match self {
            Outer::Auto => {
                let sides = open_side_normals(mesh, edges);
                let rank = |ring: &Loop| {
                    (turn(mesh, &sides, ring) >= 0, boundary::area(mesh, ring).norm())
                };
                loops.iter().map(rank).collect()
            }
            Outer::Near(p) => {
                let distance = |v: &VertexId| (mesh.point(*v) - p).norm();
                let nearest = |ring: &Loop| ring.iter().map(distance).fold(f64::MAX, f64::min);
                loops.iter().map(|ring| (true, -nearest(ring))).collect()
            }
        };
        let order = |i: usize, j: usize| {
            rank[i].0.cmp(&rank[j].0).then(rank[i].1.total_cmp(&rank[j].1)).then(j.cmp(&i))
        };
        (0..loops.len()).max_by(|&i, &j| order(i, j)).unwrap_or(0)
    }
}

/// A loop has a clear sense of rotation if its vector area is at least this share of what the
/// normals beside it would allow.
const CLEAR: f64 = 0.3;

/// The sense of rotation of a loop: 1 if it runs around the surface beside it, counter-clockwise
/// seen from outside; −1 if it runs around a hole; 0 if neither is clear, as at the end of a
/// sleeve.
pub(super) fn turn(mesh: &Mesh, normals: &HashMap<VertexId, Vector>, ring: &Loop) -> i32 {
    let beside = |(v, side): (&VertexId, f64)| side * normals.get(v).copied().unwrap_or_default();
    let normal: Vector = ring.iter().zip(boundary::sides(mesh, ring)).map(beside).sum();
    let area = boundary::area(mesh, ring);
    let share = area.dot(&normal) / (area.norm() * boundary::length(mesh, ring));
    i32::from(share > CLEAR) - i32::from(share < -CLEAR)
}

/// The unit normal of the triangle at each boundary edge. The key is the vertex at which the edge
/// starts.
pub(super) fn open_side_normals(mesh: &Mesh, edges: &EdgeMap) -> HashMap<VertexId, Vector> {
    let normal = |side: usize| {
        let t = mesh.triangles[side / 3];
        (t[side % 3], mesh.area_vector(t).try_normalize(0.0).unwrap_or_default())
    };
    edges.open_sides().map(normal).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 20 × 20 cells with a comb-shaped hole whose rim is longer than the square's
    /// boundary.
    fn combed() -> Mesh {
        let n = 21;
        let is_cut = |i: usize, j: usize| {
            let tooth = (3..17).contains(&i) && (4..17).contains(&j) && i % 2 == 1;
            tooth || ((3..17).contains(&i) && j == 3)
        };
        let cells = (0..20).flat_map(|i| (0..20).map(move |j| (i, j)));
        let triangles = cells.filter(|&(i, j)| !is_cut(i, j)).flat_map(|(i, j)| {
            let k = i * n + j;
            [[k, k + n, k + n + 1], [k, k + n + 1, k + 1]].map(|t| t.map(VertexId::from))
        });
        let at = |k: usize| Point::new((k / n) as f64, (k % n) as f64, 0.0);
        Mesh { points: (0..n * n).map(at).collect(), triangles: triangles.collect() }
    }

    #[test]
    fn a_ragged_hole_is_not_the_outside() {
        let mesh = combed();
        let edges = EdgeMap::new(&mesh);
        let loops = boundary::boundary_loops(&mesh, &edges);
        let lengths: Vec<f64> = loops.iter().map(|l| boundary::length(&mesh, l)).collect();
        let outer = Outer::Auto.among(&mesh, &edges, &loops);
        assert_eq!(lengths[outer], 80.0);
        assert!(lengths.iter().any(|&l| l > 80.0));
        let inner = Outer::Near(Point::new(5.0, 5.0, 0.0)).among(&mesh, &edges, &loops);
        assert_ne!(inner, outer);
    }
}
