//! Gaps of a mesh, closed with triangles: on the surfaces of the faces beside a gap where these have its corners, else in the
//! plane of its rim, else as facets.

use std::collections::BTreeSet;

use super::rims::{OFF_RIM, Rim, directions, rims};
use super::triangulation::{Triangulation, triangulated};
use super::vertices::placed;
use super::{EXACT, FacePatch, FacetForm, SolidFault};
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{EdgeMap, Mesh, boundary, cut_up};
use crate::primitives::Primitive;

/// The most corners of a gap that is not flat: the time of its triangulation grows with the cube of their number.
const MOST_CORNERS: usize = 400;

/// The most faces that meet at a corner that is missing.
const MOST_FACES: usize = 8;

/// A missing corner is no farther from the middle of its gap than the rim is, times this.
const CORNER: f64 = 2.0;

/// A flat gap with so many corners may be one face. Four can be a strip of a ruled surface.
const FLAT_CORNERS: usize = 5;

/// A triangle of a face is at most so many times as far from its surface as others: 1.5², as steps of one face differ by
/// less than 1.5.
pub(super) const SAGITTA_RATIO: f64 = 2.25;

/// What closes a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapFill {
    /// The faces beside it, which were extended.
    Extension,
    /// Planes through its rim.
    Plane,
    /// A cylinder between its rim and another one: the wall of a bore.
    Bore,
    /// Facets, all or some.
    Facets,
}

/// A gap that was closed. Lengths are in mm.
#[derive(Debug, Clone, Copy)]
pub struct ClosedGap {
    /// The number of the vertices of its rim.
    pub rim_vertices: usize,
    /// The length of its rim.
    pub rim_length: f64,
    /// The number of vertices that were added.
    pub added_vertices: usize,
    /// The number of triangles that were added.
    pub added_triangles: usize,
    /// The middle of its rim.
    pub place: Point,
    /// What closes it.
    pub fill: GapFill,
}

/// A mesh without gaps. What was added is behind what was there.
#[derive(Debug)]
pub struct ClosedMesh {
    /// The mesh in mm.
    pub mesh: Mesh,
    /// The bounds of the errors of its vertices.
    pub errors: Vec<f64>,
    /// The patches with what was added to them, and those that were added.
    pub patches: Vec<FacePatch>,
    /// The gaps.
    pub gaps: Vec<ClosedGap>,
}

/// Closes all gaps of a mesh. Lengths are in mm.
///
/// # Errors
/// A gap has too many corners, a vertex belongs to two gaps, or a fill would cross the mesh or lie on it.
pub fn close_gaps(
    mesh: &Mesh,
    errors: &[f64],
    patches: Vec<FacePatch>,
) -> Result<ClosedMesh, SolidFault> {
    let edges = EdgeMap::new(mesh);
    let mut of_triangle = vec![usize::MAX; mesh.triangles.len()];
    for (number, patch) in patches.iter().enumerate() {
        patch.triangles.iter().for_each(|&t| of_triangle[t as usize] = number);
    }
    let measured = mesh.triangles.len();
    let (mesh, errors, gaps) = (mesh.clone(), errors.to_vec(), Vec::new());
    let likely = directions(patches.iter().map(|patch| &patch.surface));
    let mut closure =
        GapClosure { closed: ClosedMesh { mesh, errors, patches, gaps }, of_triangle, likely };
    let all = rims(&closure.closed.mesh, &edges);
    if all.iter().map(|rim| rim.sides.len()).sum::<usize>() != edges.open_sides().count() {
        return Err(SolidFault::Gap { place: Point::origin(), why: "two gaps share a vertex" });
    }
    let bores = closure.bores(&all);
    for (number, rim) in all.iter().enumerate() {
        match bores.iter().find(|bore| bore.rims.contains(&number)) {
            Some(bore) if bore.rims[0] == number => closure.close_bore(bore, &all),
            Some(_) => {}
            None => closure.close(rim)?,
        }
    }
    if !all.is_empty() {
        closure.check(measured)?;
        closure.join(measured);
    }
    closure.closed.patches.retain(|patch| !patch.triangles.is_empty());
    Ok(closure.closed)
}

/// A mesh whose gaps are being closed.
pub(super) struct GapClosure {
    pub(super) closed: ClosedMesh,
    /// For each triangle its patch.
    pub(super) of_triangle: Vec<usize>,
    /// The directions that planes are likely to have.
    likely: Vec<Vector>,
}

impl GapClosure {
    fn close(&mut self, rim: &Rim) -> Result<(), SolidFault> {
        let mesh = &self.closed.mesh;
        let n = rim.vertices.len();
        let place = extent(&rim.points(mesh)).0;
        let [vertices, triangles] = [mesh.points.len(), mesh.triangles.len()];
        let rim_length = boundary::length(mesh, &rim.vertices);
        let fill = match self.flat(rim) {
            Some(fill) => fill,
            None if n > MOST_CORNERS => {
                return Err(SolidFault::Gap { place, why: "its rim has too many corners" });
            }
            None => self.bent(rim),
        };
        let mesh = &self.closed.mesh;
        self.closed.gaps.push(ClosedGap {
            rim_vertices: n,
            rim_length,
            added_vertices: mesh.points.len() - vertices,
            added_triangles: mesh.triangles.len() - triangles,
            place,
            fill,
        });
        Ok(())
    }

    /// The patches beside a rim that are no facets, each once.
    fn beside(&self, rim: &Rim) -> Vec<usize> {
        let mut all: Vec<usize> = rim.sides.iter().map(|side| self.of_triangle[side / 3]).collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|&i| self.closed.patches.get(i).is_some_and(|patch| !patch.is_facet));
        all
    }

    /// Closes a gap whose rim is flat.
    fn flat(&mut self, rim: &Rim) -> Option<GapFill> {
        let ClosedMesh { mesh, errors, .. } = &self.closed;
        let plane = rim.plane(mesh, errors, &self.likely)?;
        let ring: Vec<u32> = rim.vertices.iter().rev().map(|v| v.0).collect();
        let mut triangles = Vec::with_capacity(ring.len());
        if !cut_up(&mesh.points, &ring, &mut triangles) {
            return None;
        }
        let holds = |&i: &usize| {
            let is_as_flat = || {
                let sagitta = |t: &[VertexId; 3]| self.sagitta(i, *t);
                let widest = triangles.iter().map(sagitta).fold(0.0, f64::max);
                let own = self.closed.patches[i].triangles.iter();
                let largest =
                    own.map(|&t| sagitta(&mesh.triangles[t as usize])).fold(0.0, f64::max);
                widest <= SAGITTA_RATIO * largest
            };
            triangles.iter().all(|t| self.is_on(i, *t))
                && (self.corners(rim) < FLAT_CORNERS
                    || matches!(self.closed.patches[i].surface, Primitive::Plane { .. })
                    || is_as_flat())
        };
        let home = self.beside(rim).into_iter().find(holds);
        let (patch, fill) = match home {
            Some(i) => (i, GapFill::Extension),
            None => {
                let triangles = Vec::new();
                // The plane of a single triangle follows its corners.
                let is_facet = ring.len() == 3;
                let patch = FacePatch {
                    surface: plane,
                    side: 1.0,
                    is_facet,
                    form: FacetForm::Flat,
                    triangles,
                };
                self.closed.patches.push(patch);
                (self.closed.patches.len() - 1, GapFill::Plane)
            }
        };
        triangles.into_iter().for_each(|t| self.add(t, patch));
        Some(fill)
    }

    /// Closes a gap whose rim is not flat.
    fn bent(&mut self, rim: &Rim) -> GapFill {
        let ring: Vec<VertexId> = rim.vertices.iter().rev().copied().collect();
        let beside = self.beside(rim);
        let mut made = self.over(&ring, &beside);
        if made.iter().any(|(_, home)| home.is_none()) {
            made = self.with_corner(rim).unwrap_or(made);
        }
        let (on_faces, left): (Vec<_>, Vec<_>) = made.into_iter().partition(|of| of.1.is_some());
        for (triangle, home) in on_faces {
            home.into_iter().for_each(|patch| self.add(triangle, patch));
        }
        let mut fill = if left.is_empty() { GapFill::Extension } else { GapFill::Plane };
        let mut left: Vec<[VertexId; 3]> = left.into_iter().map(|of| of.0).collect();
        while let Some(first) = left.pop() {
            let group = self.in_plane(first, &mut left);
            fill = if group.len() == 1 { GapFill::Facets } else { fill };
            let number = self.closed.mesh.triangles.len() as u32;
            let numbers = (number..).take(group.len()).collect();
            self.of_triangle.extend(group.iter().map(|_| self.closed.patches.len()));
            self.closed.mesh.triangles.extend(&group);
            let is_facet = group.len() == 1;
            let patch = FacePatch::facet(&self.closed.mesh, numbers);
            self.closed.patches.push(FacePatch { is_facet, ..patch });
        }
        fill
    }

    /// Takes the triangles that lie in the plane of one and are joined to it.
    fn in_plane(&self, first: [VertexId; 3], left: &mut Vec<[VertexId; 3]>) -> Vec<[VertexId; 3]> {
        let ClosedMesh { mesh, errors, .. } = &self.closed;
        let origin = mesh.point(first[0]);
        let Some(normal) = mesh.area_vector(first).try_normalize(f64::MIN_POSITIVE) else {
            return vec![first];
        };
        let is_on = |t: &[VertexId; 3]| {
            let off = |v: &VertexId| (mesh.point(*v) - origin).dot(&normal).abs();
            t.iter().all(|v| off(v) <= OFF_RIM * errors[v.index()])
                && mesh.area_vector(*t).dot(&normal) >= 0.0
        };
        let mut group = vec![first];
        let mut done = 0;
        while let Some(&of) = group.get(done) {
            done += 1;
            let shared = |t: &[VertexId; 3]| t.iter().filter(|v| of.contains(v)).count();
            group.extend(left.extract_if(.., |t| shared(t) == 2 && is_on(t)));
        }
        group
    }

    /// The triangulation of a ring of which most lies on some patches.
    fn over(&self, ring: &[VertexId], patches: &[usize]) -> Triangulation<VertexId> {
        let inner = self.joined(ring);
        triangulated(
            ring.len(),
            |a, b| {
                let (v, w) = (ring[a].min(ring[b]), ring[a].max(ring[b]));
                inner.contains(&[v, w]) || self.closed.mesh.point(v) == self.closed.mesh.point(w)
            },
            |t| self.closed.mesh.area_vector(t.map(|k| ring[k])).norm(),
            |t| patches.iter().copied().find(|&i| self.is_on(i, t.map(|k| ring[k]))),
        )
        .into_iter()
        .map(|(t, home)| (t.map(|k| ring[k]), home))
        .collect()
    }

    /// The edges of the mesh between vertices of a ring.
    fn joined(&self, ring: &[VertexId]) -> BTreeSet<[VertexId; 2]> {
        let own: BTreeSet<VertexId> = ring.iter().copied().collect();
        let pair = |[a, b, c]: [VertexId; 3]| [[a, b], [b, c], [c, a]];
        let sides = self.closed.mesh.triangles.iter().flat_map(|&t| pair(t));
        let inner = sides.filter(|side| side.iter().all(|v| own.contains(v)));
        inner.map(|[a, b]| [a.min(b), a.max(b)]).collect()
    }

    /// Adds the vertex in which the faces beside a rim meet, and triangulates each of them up to it.
    fn with_corner(&mut self, rim: &Rim) -> Option<Triangulation<VertexId>> {
        let runs = rim.runs(&self.of_triangle);
        let own: BTreeSet<usize> = runs.iter().map(|run| run.2).collect();
        if !(3..=MOST_FACES).contains(&runs.len()) || own.len() != runs.len() {
            return None;
        }
        let ClosedMesh { mesh, errors, patches, .. } = &self.closed;
        let meeting: Vec<&FacePatch> = own.iter().map(|&i| &patches[i]).collect();
        if meeting.iter().any(|patch| patch.is_facet) {
            return None;
        }
        let (middle, size) = extent(&rim.points(mesh));
        let error = rim.vertices.iter().map(|v| errors[v.index()]).fold(0.0, f64::max);
        let limit = error.max(EXACT);
        let (corner, left) = placed(&meeting, middle, error, limit);
        if !(left < limit && (corner - middle).norm() < CORNER * size) {
            return None;
        }
        let apex = VertexId::from(mesh.points.len());
        self.closed.mesh.points.push(corner);
        self.closed.errors.push(error);
        let n = rim.vertices.len();
        let mut made = Vec::new();
        for (from, to, patch) in runs {
            let along = (from..=to).rev().map(|k| rim.vertices[k % n]);
            let part = self.over(&along.chain([apex]).collect::<Vec<_>>(), &[patch]);
            if part.is_empty() || part.iter().any(|(_, home)| home.is_none()) {
                self.closed.mesh.points.pop();
                self.closed.errors.pop();
                return None;
            }
            made.extend(part);
        }
        Some(made)
    }

    /// Adds a triangle to a patch.
    pub(super) fn add(&mut self, triangle: [VertexId; 3], patch: usize) {
        let number = self.closed.mesh.triangles.len() as u32;
        self.closed.mesh.triangles.push(triangle);
        self.of_triangle.push(patch);
        self.closed.patches[patch].triangles.push(number);
    }
}

/// The middle of some points, and the distance of the farthest of them.
pub(super) fn extent(points: &[Point]) -> (Point, f64) {
    let sum: Vector = points.iter().map(|p| p.coords).sum();
    let middle = Point::from(sum / points.len().max(1) as f64);
    (middle, points.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max))
}
