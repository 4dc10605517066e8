//! Bays of a ragged outer boundary, closed so that what is left has a smooth course
//! that four sides can follow.
//!
//! Where a surface goes on beyond the scan without anything to hold it, its parts on
//! the two banks of a bay run through each other, and teeth on straight sides stretch
//! the map. So ears between the banks are closed, shortest first, until the boundary
//! turns nowhere more outwards than it does on the whole: on the flat that is the
//! convex hull. Ears that span no more than a wide curve are opened again.

mod ears;
mod flat;
#[cfg(test)]
mod tests;

use foldhash::HashMap;
use rayon::prelude::*;

use crate::geometry::{Point, Uv, Vector, VertexId, segment_distance};
use crate::mesh::boundary::Loop;
use crate::mesh::remesh::{Sizes, Triangulation};
use crate::mesh::{Adjacency, FaceOrigin, Patch, Rings};
use ears::Ears;

/// Turning by less, in radians, is none.
const STRAIGHT: f64 = 1e-3;

/// Bays less deep, in mean edges of the boundary, are left …
const SHALLOW: f64 = 1.0;

/// … as those are whose depth is a smaller share of their width.
const WIDE: f64 = 0.25;

/// Those with triangles that lean over are closed from this share of the mesh's diagonal
/// on: less deep, what goes on straight does no harm there, and the surface need not fold.
const DEEP: f64 = 0.05;

/// Sides across mouths are divided that are longer, in edges wanted there.
const LONG: f64 = 1.4;

/// What closes bays of an outer boundary, so that a map can go around them. It is there for
/// the map alone: no part of the face is there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Bays {
    /// How many were closed.
    pub count: usize,
    /// Triangles added.
    pub added_triangles: usize,
}

/// Closes the bays of a patch's outer boundary: those that a map of it shows, a place in the
/// plane for every vertex, or, without one, those that the surface's angles along the boundary
/// do. What these say of bays that are deep, or between strongly curved banks, a map knows
/// better. None must be closed yet.
pub fn close(mut patch: Patch, map: Option<&[Uv]>) -> (Patch, Bays) {
    let rings = Rings::new(&patch.mesh);
    let closing = closing(Adjacency { mesh: &patch.mesh, rings: &rings }, &patch.outer, map);
    let count = closing.as_ref().map_or(0, |closing| closing.count);
    if let Some(closing) = closing {
        closing.close_in(&mut patch);
    }
    debug_assert!(patch.is_disk(), "closing bays leaves a disk");
    let added = patch.origin.iter().filter(|origin| **origin == FaceOrigin::Bay).count();
    (patch, Bays { count, added_triangles: added })
}

/// Points, numbered from the mesh's vertex count on, triangles, and the new outer boundary.
struct Closing {
    points: Vec<Point>,
    triangles: Vec<[VertexId; 3]>,
    outer: Loop,
    /// How many bays were closed.
    count: usize,
}

/// What closes the bays of an outer boundary. `None`: it has none.
fn closing(mesh: Adjacency, outer: &[VertexId], map: Option<&[Uv]>) -> Option<Closing> {
    let mut ears = Ears::new(mesh, outer, map);
    ears.close();
    let points = outer.iter().map(|&v| mesh.mesh.point(v)).collect();
    let boundary = Boundary { mesh, outer, sizes: Sizes::new(&[points]) };
    // What the new boundary runs over: measured vertices, or across a bay's mouth.
    let mut course = Vec::new();
    let left = ears.left();
    let nexts = left.iter().skip(1).copied().chain([left[0] + outer.len()]);
    let mut mouths: Vec<[usize; 2]> = left.iter().zip(nexts).map(|(&i, j)| [i, j]).collect();
    mouths.reverse();
    while let Some([from, to]) = mouths.pop() {
        match ears.over(from, to) {
            None => course.push((from, None)),
            Some(_) if boundary.is_bay(from, to, ears.lean(from, to)) => {
                course.push((from, Some(to)));
            }
            Some(tip) => mouths.extend([[tip, to], [from, tip]]),
        }
    }
    let filled = |&(from, to): &(usize, Option<usize>)| {
        (from, to.map(|to| boundary.surface(from, to, &ears.within(from, to))))
    };
    let filled: Vec<_> = course.par_iter().map(filled).collect();
    let (points, triangles, outer) = (Vec::new(), Vec::new(), Vec::new());
    let mut closing = Closing { points, triangles, outer, count: 0 };
    for (from, surface) in filled {
        match surface {
            None => closing.outer.push(boundary.vertex(from)),
            Some(surface) => closing.add(&boundary, from, surface),
        }
    }
    (closing.count > 0).then_some(closing)
}

/// The measured outer boundary; places on it are counted on beyond its end.
struct Boundary<'a> {
    mesh: Adjacency<'a>,
    outer: &'a [VertexId],
    sizes: Sizes,
}

impl Boundary<'_> {
    fn vertex(&self, i: usize) -> VertexId {
        self.outer[i % self.outer.len()]
    }

    fn at(&self, i: usize) -> Point {
        self.mesh.mesh.point(self.vertex(i))
    }

    /// Whether what is between two places reaches in far enough from the straight line
    /// between them.
    fn is_bay(&self, from: usize, to: usize, leans: bool) -> bool {
        let (a, b) = (self.at(from), self.at(to));
        let deep = if leans { DEEP * self.mesh.mesh.diagonal() } else { 0.0 };
        let least = (SHALLOW * self.sizes.mean).max(WIDE * (b - a).norm()).max(deep);
        (from..to).any(|i| segment_distance(self.at(i), a, b) >= least)
    }

    /// The points that divide the line across a mouth.
    fn mouth(&self, a: Point, b: Point, into: &mut Vec<Point>) {
        let middle = nalgebra::center(&a, &b);
        if (b - a).norm() > LONG * self.sizes.at(middle) {
            self.mouth(a, middle, into);
            into.push(middle);
            self.mouth(middle, b, into);
        }
    }

    /// A bay as a surface over the vertices on its banks, the points across its mouth,
    /// and those inside; with how many there are of the first and of the first two.
    fn surface(&self, from: usize, to: usize, ears: &[[usize; 3]]) -> (Triangulation, [usize; 2]) {
        let mut points: Vec<Point> = (from..=to).map(|i| self.at(i)).collect();
        let banks = points.len();
        self.mouth(self.at(from), self.at(to), &mut points);
        let rim = points.len();
        let n = self.outer.len();
        let local = |i: usize| (i + n - from % n) % n;
        let mut triangles = Vec::new();
        for ear in ears {
            let [p, v, q] = ear.map(local);
            // The last ear is divided as the mouth is.
            let mouth = if [p, q] == [0, banks - 1] { banks..rim } else { 0..0 };
            let chain: Vec<usize> = std::iter::once(p).chain(mouth).chain([q]).collect();
            triangles.extend(chain.windows(2).map(|side| [side[0], side[1], v]));
        }
        let normal =
            |k: usize| self.mesh.normal_at(self.vertex(from + k), self.vertex(from + k + 1));
        let beside: HashMap<(usize, usize), Vector> =
            (0..banks - 1).filter_map(|k| Some(((k + 1, k), normal(k)?))).collect();
        let mut surface = Triangulation { points, triangles, rim, beside };
        let joined = |a: usize, b: usize| {
            a.max(b) < banks && self.mesh.joined(self.vertex(from + a), self.vertex(from + b))
        };
        surface.refine(&self.sizes, joined);
        surface.unfold(joined);
        (surface, [banks, rim])
    }
}

impl Closing {
    /// Closes them in a patch that has none closed yet, whose vertices end where the
    /// points begin.
    fn close_in(self, patch: &mut Patch) {
        patch.mesh.points.extend(self.points);
        patch.mesh.triangles.extend(self.triangles);
        patch.origin.resize(patch.mesh.triangles.len(), FaceOrigin::Bay);
        patch.measured_outer = Some(std::mem::replace(&mut patch.outer, self.outer));
    }

    fn add(&mut self, boundary: &Boundary, from: usize, surface: (Triangulation, [usize; 2])) {
        let (mut surface, [banks, rim]) = surface;
        let first = boundary.mesh.mesh.points.len() + self.points.len();
        let global = |k: usize| match k.checked_sub(banks) {
            None => boundary.vertex(from + k),
            Some(new) => VertexId::from(first + new),
        };
        self.triangles.extend(surface.triangles.iter().map(|t| t.map(global)));
        self.outer.push(boundary.vertex(from));
        self.outer.extend((banks..rim).map(global));
        self.points.extend(surface.points.drain(banks..));
        self.count += 1;
    }
}
