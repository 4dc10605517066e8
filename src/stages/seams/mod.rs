//! The solid whose faces lie on known surfaces, from the triangles of each surface.
//!
//! The input is a closed mesh, the bounds of the errors of its vertices, and a [`FacePatch`] for each surface. The
//! output is a checked [`Brep`] with one shell. The mesh edges between two patches are chained, the chains are
//! projected onto both surfaces, and become lines, arcs or cubic B-splines. Vertices lie on all surfaces around them.
//!
//! A patch for which that fails becomes its triangles, each of which is a flat face. [`Report::fallbacks`] names it.

mod chart;
mod contact;
mod curves;
mod faces;
mod guard;
mod hermite;
mod network;
mod pcurves;
mod rings;
mod shell;
mod vertices;
mod winding;

use formats::Brep;

use crate::geometry::Point;
use crate::mesh::{EdgeMap, Mesh};
use crate::primitives::{Primitive, PrimitiveKind};

/// Triangles that lie on one surface.
#[derive(Debug, Clone)]
pub struct FacePatch {
    /// The surface, in mm.
    pub surface: Primitive,
    /// +1 if the outside of the solid is where the distance to the surface is positive, -1 otherwise.
    pub side: f64,
    /// Whether the surface is only the plane of a facet. Its vertices are then corners of the face.
    pub is_facet: bool,
    /// The triangles.
    pub triangles: Vec<u32>,
}

/// What a caller decides.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The name of the part.
    pub name: String,
}

/// A face that became facets.
#[derive(Debug, Clone)]
pub struct Fallback {
    /// The kind of its surface.
    pub kind: PrimitiveKind,
    /// The number of its triangles.
    pub triangles: usize,
    /// A point of it in mm.
    pub place: Point,
    /// The reason.
    pub why: String,
}

/// What was made.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// For each face of the solid the kind of its surface.
    pub kinds: Vec<PrimitiveKind>,
    /// For each face its triangles and their surface.
    pub patches: Vec<FacePatch>,
    /// The faces that are facets only.
    pub facets: usize,
    /// The faces that became facets here.
    pub fallbacks: Vec<Fallback>,
    /// The largest distance in mm between an edge and its faces.
    pub gap: f64,
}

/// Why patches do not become faces.
#[derive(Debug, Clone)]
pub(crate) struct SeamFault {
    /// The patches.
    patches: Vec<usize>,
    why: String,
}

impl SeamFault {
    fn new(patches: &[usize], why: impl Into<String>) -> Self {
        SeamFault { patches: patches.to_vec(), why: why.into() }
    }
}

/// What all steps read.
struct Work<'a> {
    mesh: &'a Mesh,
    errors: &'a [f64],
    edges: EdgeMap,
    patches: Vec<FacePatch>,
    /// For each triangle its patch.
    of_triangle: Vec<usize>,
}

/// Makes the solid. Lengths are in mm.
///
/// # Errors
/// The mesh is not closed, or not even its triangles make a valid solid.
pub fn solid(
    mesh: &Mesh,
    errors: &[f64],
    patches: Vec<FacePatch>,
    options: &Options,
) -> Result<(Brep, Report), String> {
    let edges = EdgeMap::new(mesh);
    if (0..3 * mesh.triangles.len()).any(|side| edges.across(side).is_none()) {
        return Err("the mesh is not closed".into());
    }
    let of_triangle = vec![0; mesh.triangles.len()];
    let mut work = Work { mesh, errors, edges, patches, of_triangle };
    let mut fallbacks = Vec::new();
    loop {
        work.number();
        match shell::shell(&mut work, &options.name) {
            Ok((brep, gap)) => {
                let kinds = work.patches.iter().map(|p| p.surface.kind()).collect();
                let facets = work.patches.iter().filter(|p| p.is_facet).count();
                return Ok((brep, Report { kinds, patches: work.patches, facets, fallbacks, gap }));
            }
            Err(fault) => work.give_up(&fault, &mut fallbacks)?,
        }
    }
}

impl Work<'_> {
    fn number(&mut self) {
        for (number, patch) in self.patches.iter().enumerate() {
            patch.triangles.iter().for_each(|&t| self.of_triangle[t as usize] = number);
        }
    }

    /// Makes facets of the patches that failed. A plane that fails first gives up its curved neighbours.
    fn give_up(&mut self, fault: &SeamFault, fallbacks: &mut Vec<Fallback>) -> Result<(), String> {
        let is_curved =
            |work: &Self, i: &usize| work.patches[*i].surface.kind() != PrimitiveKind::Plane;
        let is_whole = |work: &Self, i: &usize| work.patches[*i].triangles.len() > 1;
        let curved = |of: &[usize]| -> Vec<usize> {
            of.iter().copied().filter(|i| is_curved(self, i)).collect()
        };
        let mut bad = curved(&fault.patches);
        if bad.is_empty() {
            bad = fault.patches.iter().copied().filter(|i| self.patches[*i].is_facet).collect();
            bad.retain(|i| is_whole(self, i));
        }
        if bad.is_empty() {
            bad = curved(&self.neighbours(&fault.patches));
        }
        if bad.is_empty() {
            bad = fault.patches.iter().copied().filter(|i| is_whole(self, i)).collect();
        }
        if bad.is_empty() {
            bad = (0..self.patches.len()).filter(|i| is_whole(self, i)).collect();
        }
        if bad.is_empty() {
            return Err(fault.why.clone());
        }
        bad.sort_unstable();
        bad.dedup();
        for i in bad {
            let patch = &self.patches[i];
            let [a, ..] = self.mesh.triangles[patch.triangles[0] as usize];
            if !patch.is_facet {
                fallbacks.push(Fallback {
                    kind: patch.surface.kind(),
                    triangles: patch.triangles.len(),
                    place: self.mesh.point(a),
                    why: fault.why.clone(),
                });
            }
            self.split(i);
        }
        Ok(())
    }

    fn neighbours(&self, patches: &[usize]) -> Vec<usize> {
        let mut found = Vec::new();
        for &t in patches.iter().flat_map(|&i| &self.patches[i].triangles) {
            for side in 3 * t as usize..3 * t as usize + 3 {
                found.extend(self.edges.across(side).map(|twin| self.of_triangle[twin / 3]));
            }
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|i| !patches.contains(i));
        found
    }

    /// Replaces a patch by its triangles.
    fn split(&mut self, i: usize) {
        let triangles = std::mem::take(&mut self.patches[i].triangles);
        let mut parts = triangles.into_iter().map(|t| {
            let corners = self.mesh.triangles[t as usize];
            let normal = self.mesh.area_vector(corners);
            let normal = normal.try_normalize(0.0).unwrap_or_else(crate::geometry::Vector::z);
            let surface = Primitive::Plane { origin: self.mesh.point(corners[0]), normal };
            FacePatch { surface, side: 1.0, is_facet: true, triangles: vec![t] }
        });
        if let Some(first) = parts.next() {
            let rest: Vec<FacePatch> = parts.collect();
            self.patches[i] = first;
            self.patches.extend(rest);
        }
    }
}
