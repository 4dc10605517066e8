//! Closes the bays of a ragged outer boundary for the map. A bay is a concavity of the boundary. A
//! patch goes in; the patch with triangles in its bays comes out. Its new boundary is smooth enough
//! to be mapped to four sides.
//!
//! Nothing holds the fitted surface beyond the scan, so without this its parts on the two sides of
//! a bay would intersect each other there, and teeth on straight sides would stretch the map. Ears
//! between the two sides of a bay are cut off, shortest first, until the boundary turns outwards
//! nowhere more than on average. On a flat sheet the result is the convex hull. Regions that only
//! span a wide curve are opened again.

mod ears;
mod mapped_loop;
#[cfg(test)]
mod tests;

use foldhash::HashMap;
use rayon::prelude::*;

use crate::geometry::{Point, Uv, Vector, VertexId, segment_distance};
use crate::mesh::boundary::Loop;
use crate::mesh::remesh::{RimTriangulation, Sizes, TOO_LONG};
use crate::mesh::{Adjacency, FaceOrigin, Patch, VertexRings};
use ears::Ears;

/// Angles below this, in radians, count as zero.
const STRAIGHT: f64 = 1e-3;

/// A bay is closed only if its depth is at least this share of its width, and the mean edge length of the
/// boundary.
const MIN_DEPTH_RATIO: f64 = 0.25;

/// A bay with triangles that lean is closed only if its depth is at least this share of the
/// diagonal of the mesh. A straight continuation does no harm in a shallower one, and the surface
/// need not fold there.
const MIN_LEANING_DEPTH: f64 = 0.05;

/// The triangles that close the bays of an outer boundary. They exist only for the map; the face
/// does not include them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Bays {
    /// The number of closed bays.
    pub count: usize,
    /// The number of added triangles.
    pub added_triangles: usize,
}

/// Closes the bays of the outer boundary of a patch. `map` has a position in the plane for every
/// vertex, and the bays are found on it. Without a map they are found by the angles of the surface
/// along the boundary. The map is more reliable for bays that are deep or lie between strongly
/// curved sides. No bay of the patch may be closed yet.
pub(crate) fn close(mut patch: Patch, map: Option<&[Uv]>) -> (Patch, Bays) {
    let rings = VertexRings::new(&patch.mesh);
    let closing = closing(Adjacency { mesh: &patch.mesh, rings: &rings }, &patch.outer, map);
    let count = closing.as_ref().map_or(0, |closing| closing.count);
    if let Some(closing) = closing {
        closing.close_in(&mut patch);
    }
    debug_assert!(patch.is_disk(), "closing bays leaves a disk");
    let added = patch.origin.iter().filter(|origin| **origin == FaceOrigin::Bay).count();
    (patch, Bays { count, added_triangles: added })
}

/// The points, triangles and new outer boundary that close bays. Points are numbered from the
/// vertex count of the mesh on.
struct BayClosure {
    points: Vec<Point>,
    triangles: Vec<[VertexId; 3]>,
    outer: Loop,
    /// The number of closed bays.
    count: usize,
}

/// Finds the triangles that close the bays of an outer boundary. `None` if there are no bays.
fn closing(mesh: Adjacency, outer: &[VertexId], map: Option<&[Uv]>) -> Option<BayClosure> {
    let mut ears = Ears::new(mesh, outer, map);
    ears.close();
    let points = outer.iter().map(|&v| mesh.mesh.point(v)).collect();
    let boundary = MeasuredBoundary { mesh, outer, sizes: Sizes::new(&[points]) };
    // The new boundary: measured vertices, and sides across the openings of bays.
    let mut course = Vec::new();
    let left = ears.left();
    let nexts = left.iter().skip(1).copied().chain([left[0] + outer.len()]);
    let mut openings: Vec<[usize; 2]> = left.iter().zip(nexts).map(|(&i, j)| [i, j]).collect();
    openings.reverse();
    while let Some([from, to]) = openings.pop() {
        match ears.over(from, to) {
            None => course.push((from, None)),
            Some(_) if boundary.is_bay(from, to, ears.lean(from, to)) => {
                course.push((from, Some(to)));
            }
            Some(tip) => openings.extend([[tip, to], [from, tip]]),
        }
    }
    let filled = |&(from, to): &(usize, Option<usize>)| {
        (from, to.map(|to| boundary.surface(from, to, &ears.within(from, to))))
    };
    let filled: Vec<_> = course.par_iter().map(filled).collect();
    let (points, triangles, outer) = (Vec::new(), Vec::new(), Vec::new());
    let mut closing = BayClosure { points, triangles, outer, count: 0 };
    for (from, surface) in filled {
        match surface {
            None => closing.outer.push(boundary.vertex(from)),
            Some(surface) => closing.add(&boundary, from, surface),
        }
    }
    (closing.count > 0).then_some(closing)
}

/// The measured outer boundary. Positions on it may continue beyond its end.
struct MeasuredBoundary<'a> {
    mesh: Adjacency<'a>,
    outer: &'a [VertexId],
    sizes: Sizes,
}

impl MeasuredBoundary<'_> {
    fn vertex(&self, i: usize) -> VertexId {
        self.outer[i % self.outer.len()]
    }

    fn at(&self, i: usize) -> Point {
        self.mesh.mesh.point(self.vertex(i))
    }

    /// Whether the boundary between two positions is deep enough inside the straight line between
    /// them.
    fn is_bay(&self, from: usize, to: usize, leans: bool) -> bool {
        let (a, b) = (self.at(from), self.at(to));
        let deep = if leans { MIN_LEANING_DEPTH * self.mesh.mesh.diagonal() } else { 0.0 };
        let least = self.sizes.mean.max(MIN_DEPTH_RATIO * (b - a).norm()).max(deep);
        (from..to).any(|i| segment_distance(self.at(i), a, b) >= least)
    }

    /// The points that divide the line across the opening of a bay where it is too long.
    fn opening(&self, a: Point, b: Point, into: &mut Vec<Point>) {
        let middle = nalgebra::center(&a, &b);
        if (b - a).norm() > TOO_LONG * self.sizes.at(middle) {
            self.opening(a, middle, into);
            into.push(middle);
            self.opening(middle, b, into);
        }
    }

    /// The triangulation of a bay. Its points are the vertices on the sides of the bay, the points
    /// across its opening, and inner points. The two numbers count the first, and the first and
    /// second together.
    fn surface(
        &self,
        from: usize,
        to: usize,
        ears: &[[usize; 3]],
    ) -> (RimTriangulation, [usize; 2]) {
        let mut points: Vec<Point> = (from..=to).map(|i| self.at(i)).collect();
        let side_count = points.len();
        self.opening(self.at(from), self.at(to), &mut points);
        let rim = points.len();
        let n = self.outer.len();
        let local = |i: usize| (i + n - from % n) % n;
        let mut triangles = Vec::new();
        for ear in ears {
            let [p, v, q] = ear.map(local);
            // The last ear is divided in the same way as the opening.
            let opening = if [p, q] == [0, side_count - 1] { side_count..rim } else { 0..0 };
            let chain: Vec<usize> = std::iter::once(p).chain(opening).chain([q]).collect();
            triangles.extend(chain.windows(2).map(|side| [side[0], side[1], v]));
        }
        let normal =
            |k: usize| self.mesh.normal_at(self.vertex(from + k), self.vertex(from + k + 1));
        let beside: HashMap<(usize, usize), Vector> =
            (0..side_count - 1).filter_map(|k| Some(((k + 1, k), normal(k)?))).collect();
        let mut surface = RimTriangulation { points, triangles, rim, beside };
        let joined = |a: usize, b: usize| {
            a.max(b) < side_count && self.mesh.joined(self.vertex(from + a), self.vertex(from + b))
        };
        surface.refine(&self.sizes, joined);
        surface.unfold(joined);
        (surface, [side_count, rim])
    }
}

impl BayClosure {
    /// Adds the triangles to a patch without closed bays. The new points follow its vertices.
    fn close_in(self, patch: &mut Patch) {
        patch.mesh.points.extend(self.points);
        patch.mesh.triangles.extend(self.triangles);
        patch.origin.resize(patch.mesh.triangles.len(), FaceOrigin::Bay);
        patch.measured_outer = Some(std::mem::replace(&mut patch.outer, self.outer));
    }

    fn add(
        &mut self,
        boundary: &MeasuredBoundary,
        from: usize,
        surface: (RimTriangulation, [usize; 2]),
    ) {
        let (mut surface, [side_count, rim]) = surface;
        let first = boundary.mesh.mesh.points.len() + self.points.len();
        let global = |k: usize| match k.checked_sub(side_count) {
            None => boundary.vertex(from + k),
            Some(new) => VertexId::from(first + new),
        };
        self.triangles.extend(surface.triangles.iter().map(|t| t.map(global)));
        self.outer.push(boundary.vertex(from));
        self.outer.extend((side_count..rim).map(global));
        self.points.extend(surface.points.drain(side_count..));
        self.count += 1;
    }
}
