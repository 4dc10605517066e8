//! The solid whose faces lie on known surfaces, from the triangles of each surface.
//!
//! The input is a mesh, the bounds of the errors of its vertices, and a [`FacePatch`] for each surface. The
//! output is a checked [`Brep`] with a solid for each connected part of the mesh, and a void for each part inside of another
//! one that faces the other way. The mesh edges between two patches are chained, the chains are
//! projected onto both surfaces, and become lines, arcs or cubic B-splines. Vertices lie on all surfaces around them.
//!
//! Where that fails, the triangles next to the place become flat faces, and the whole patch if it fails again. Facets that hang together can
//! become free-form faces in the end.
//! [`Report::fallbacks`] names the place. The largest gap between an edge and its faces is what modelling kernels take
//! for exact, or the rounding of the file if that is larger. The model states it as its uncertainty.
//!
//! The gaps of an open mesh can be closed first ([`close_gaps`]), or it becomes a shell whose edges at the rims belong to
//! one face each ([`open_shell`]).

mod agreement;
mod arches;
mod bores;
mod chart;
mod chords;
mod coons;
mod crossings;
mod curves;
mod domain;
mod faces;
mod facets;
mod fallback;
mod followed;
mod free_face;
mod free_form;
mod gap_checks;
mod gaps;
mod groups;
mod guard;
mod hermite;
mod leading;
mod network;
mod pcurves;
mod perimeter;
mod pieces;
mod rims;
mod rings;
mod shell;
mod shells;
mod stretches;
mod triangulation;
mod vertices;
mod walls;

use std::sync::Arc;

use formats::Brep;
pub use free_form::FreeForm;
pub use gaps::{ClosedGap, ClosedMesh, GapFill, close_gaps};
use stretches::{RimStretches, WallKind};

use crate::geometry::{Point, Vector};
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
    /// What kind of facet it is, if it is one.
    pub form: FacetForm,
    /// The triangles.
    pub triangles: Vec<u32>,
}

/// A kind of facet.
#[derive(Debug, Clone, Default)]
pub enum FacetForm {
    /// A triangle, or triangles in a plane.
    #[default]
    Flat,
    /// Two triangles that have no plane. The surface is laid through their four edges.
    Bent,
    /// Facets that hang together. The surface is a B-spline through their border.
    Free(Arc<FreeForm>),
}

/// What a caller decides.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The name of the part.
    pub name: String,
    /// The least share of the area that must not become facets, from 0 to 1. What needs more is given up early.
    pub least_exact: f64,
    /// Which facets become free-form faces.
    pub free_forms: FreeForms,
}

/// Which facets become free-form faces.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum FreeForms {
    /// None.
    #[default]
    None,
    /// Those of a clean mesh that hang together smoothly: neighbours turn by at most so many radians. The faces pass through their vertices.
    Through {
        /// The angle.
        turn: f64,
        /// The farthest that a vertex may be off its face in mm. A tenth of the chord error of the face is enough, too.
        within: f64,
    },
    /// Those of a scan that hang together. The faces are within its noise.
    Near,
}

/// A face of which some or all triangles became facets.
#[derive(Debug, Clone)]
pub struct Fallback {
    /// The kind of its surface.
    pub kind: PrimitiveKind,
    /// The number of these triangles.
    pub triangles: usize,
    /// A point of them in mm.
    pub place: Point,
    /// The reason.
    pub why: String,
}

/// What was made.
#[derive(Debug, Clone, Default)]
pub struct Report {
    /// For each face of the solid its triangles and their surface.
    pub patches: Vec<FacePatch>,
    /// The faces that are facets only.
    pub facets: usize,
    /// The free-form faces, which take the place of other facets.
    pub free_forms: usize,
    /// The faces that became facets here, whole or in part.
    pub fallbacks: Vec<Fallback>,
    /// The largest distance in mm between an edge and its faces.
    pub gap: f64,
}

impl Report {
    /// For each face of the solid the kind of its surface.
    pub fn kinds(&self) -> Vec<PrimitiveKind> {
        self.patches.iter().map(|patch| patch.surface.kind()).collect()
    }
}

/// Why there is no solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolidFault {
    /// The mesh has no triangles.
    #[error("the mesh has no triangles")]
    Empty,
    /// The mesh is not closed.
    #[error("the mesh is not closed: {edges} edges have one triangle, one of them at {place}")]
    Open {
        /// The number of edges that do not have two triangles.
        edges: usize,
        /// A point of one in mm.
        place: Point,
    },
    /// Neighbouring triangles face opposite ways.
    #[error("the triangles at {place} face opposite ways")]
    Unoriented {
        /// The place in mm.
        place: Point,
    },
    /// Less of the area than asked for is on the surfaces.
    #[error("{:.0} % of its area would be facets, as {why}", 100.0 * .facets)]
    Facets {
        /// The share of the facets.
        facets: f64,
        /// Why the first face became facets.
        why: String,
    },
    /// A gap of the mesh cannot be closed.
    #[error("the gap near ({:.3}, {:.3}, {:.3}) is not closed, as {why}", place.x, place.y, place.z)]
    Gap {
        /// The middle of its rim in mm.
        place: Point,
        /// Why.
        why: &'static str,
    },
    /// Not even the triangles make a valid solid.
    #[error("the triangles make no valid solid: {0}")]
    Unsound(String),
}

/// What is exact to so many mm is exact to modelling kernels: their precision, 1e-7, less a fifth.
const EXACT: f64 = 8e-8;

/// What all steps of one shell read.
struct Work<'a> {
    mesh: &'a Mesh,
    /// The mean length of the edges of the mesh in mm.
    edge: f64,
    /// The errors of the vertices. Loose edges of the model add to the rounding.
    errors: Vec<f64>,
    /// The farthest that loose edges put a vertex off its surface, in mm.
    loose: f64,
    /// Edges and vertices lie on their faces within so many mm. Nearly all of them do so within [`EXACT`], but surfaces that
    /// do not quite meet are known no better than the file states its coordinates.
    limit: f64,
    edges: EdgeMap,
    patches: Vec<FacePatch>,
    /// How often each patch lost triangles. Of a facet that was split before, 1.
    tries: Vec<u32>,
    /// For each triangle its patch.
    of_triangle: Vec<usize>,
    /// The rims of an open mesh.
    stretches: RimStretches,
    /// What the last patches are, which are walls on rims.
    walls: Vec<WallKind>,
    free_forms: FreeForms,
    /// For each triangle whether it was lost by a curved surface.
    is_lost: Vec<bool>,
    /// The largest distance of a curve of the model from its chord in a clean mesh, if it has curved faces that tell.
    most_sagitta: Option<f64>,
}

/// Makes the solids. Lengths are in mm.
///
/// # Errors
/// The mesh is not closed, or not even its triangles make a valid solid.
pub fn solid(
    mesh: &Mesh,
    errors: &[f64],
    patches: Vec<FacePatch>,
    options: &Options,
) -> Result<(Brep, Report), SolidFault> {
    let edges = EdgeMap::new(mesh);
    shells::check(mesh, &edges, false)?;
    made(mesh, errors, patches, &edges, options)
}

/// Makes the shell of an open mesh. Its edges at the rims of the mesh belong to one face each. Lengths are in mm.
///
/// # Errors
/// Not even the triangles make a valid shell.
pub fn open_shell(
    mesh: &Mesh,
    errors: &[f64],
    patches: Vec<FacePatch>,
    options: &Options,
) -> Result<(Brep, Report), SolidFault> {
    let edges = EdgeMap::new(mesh);
    shells::check(mesh, &edges, true)?;
    made(mesh, errors, patches, &edges, options)
}

fn made(
    mesh: &Mesh,
    errors: &[f64],
    patches: Vec<FacePatch>,
    edges: &EdgeMap,
    options: &Options,
) -> Result<(Brep, Report), SolidFault> {
    let parts = shells::split(mesh, errors, edges, &patches);
    let mut report = Report::default();
    let mut made = Vec::with_capacity(parts.len());
    for part in &parts {
        // What one of several parts may lose is not known.
        let least_exact = if parts.len() == 1 { options.least_exact } else { 0.0 };
        let work = Work::new(part, options.free_forms);
        let (shell, own) = work.made(&Options { least_exact, ..options.clone() })?;
        made.push(shell);
        report.patches.extend(own.patches.into_iter().map(|patch| part.in_whole(patch)));
        report.facets += own.facets;
        report.free_forms += own.free_forms;
        report.fallbacks.extend(own.fallbacks);
        report.gap = report.gap.max(own.gap);
    }
    check_facets(mesh, &report.patches, &report.fallbacks, options)?;
    let brep = shells::join(&parts, made, &options.name);
    brep.check().map_err(|fault| SolidFault::Unsound(fault.to_string()))?;
    Ok((brep, report))
}

/// An error if too much of the area is facets.
fn check_facets(
    mesh: &Mesh,
    patches: &[FacePatch],
    fallbacks: &[Fallback],
    options: &Options,
) -> Result<(), SolidFault> {
    // Free-form faces of a clean mesh are as good as exact ones.
    let is_clean = matches!(options.free_forms, FreeForms::Through { .. });
    let is_left = |patch: &&FacePatch| patch.is_facet && !(is_clean && patch.free_form().is_some());
    let area = |patch: &FacePatch| patch.area(mesh);
    let all: f64 = patches.iter().map(area).sum();
    let facets = patches.iter().filter(is_left).map(area).sum::<f64>() / all;
    if facets <= 1.0 - options.least_exact || all == 0.0 {
        return Ok(());
    }
    let why = fallbacks.first().map_or("no surface has their corners", |first| &first.why).into();
    Err(SolidFault::Facets { facets, why })
}

impl<'a> Work<'a> {
    fn new(part: &'a shells::ShellPart, free_forms: FreeForms) -> Self {
        let mut work = Work {
            mesh: &part.mesh,
            edge: mean_edge(&part.mesh),
            errors: part.errors.clone(),
            loose: 0.0,
            limit: part.errors.iter().copied().fold(EXACT, f64::max),
            edges: EdgeMap::new(&part.mesh),
            patches: Vec::new(),
            tries: Vec::new(),
            of_triangle: vec![0; part.mesh.triangles.len()],
            stretches: RimStretches::default(),
            walls: Vec::new(),
            free_forms,
            is_lost: vec![false; part.mesh.triangles.len()],
            most_sagitta: None,
        };
        for patch in &part.patches {
            for set in work.joined(&patch.triangles).members() {
                let triangles = set.iter().map(|&k| patch.triangles[k as usize]).collect();
                work.patches.push(FacePatch { triangles, ..patch.clone() });
            }
        }
        work.tries = vec![0; work.patches.len()];
        work.number();
        work.find_stretches();
        work
    }

    /// Tries to make the shell until nothing fails.
    fn made(mut self, options: &Options) -> Result<(Brep, Report), SolidFault> {
        let mut fallbacks = Vec::new();
        let mut faults = self.loosen();
        loop {
            if !faults.is_empty() && !self.give_up(&faults, &mut fallbacks) {
                let why = faults.into_iter().next().map_or_else(String::new, |fault| fault.why);
                return Err(SolidFault::Unsound(why));
            }
            self.drop_walls();
            // Facets of clean meshes become free-form faces.
            if !matches!(self.free_forms, FreeForms::Through { .. }) {
                check_facets(self.mesh, &self.patches, &fallbacks, options)?;
            }
            self.number();
            match shell::shell(&mut self) {
                Ok(built) => {
                    let built = self.with_free_forms(built, &mut fallbacks);
                    let shell::BuiltShell { brep, gap, patches } = built;
                    let free_forms = patches.iter().filter(|p| p.free_form().is_some()).count();
                    let facets = patches.iter().filter(|p| p.is_facet).count() - free_forms;
                    return Ok((brep, Report { patches, facets, free_forms, fallbacks, gap }));
                }
                Err(found) => faults = found,
            }
        }
    }

    fn number(&mut self) {
        for (number, patch) in self.patches.iter().enumerate() {
            patch.triangles.iter().for_each(|&t| self.of_triangle[t as usize] = number);
        }
    }
}

fn mean_edge(mesh: &Mesh) -> f64 {
    let count = 3 * mesh.triangles.len();
    let long = |side: usize| {
        let (a, b) = mesh.side(side);
        (mesh.point(a) - mesh.point(b)).norm()
    };
    (0..count).map(long).sum::<f64>() / count.max(1) as f64
}

impl FacePatch {
    /// What is known of it if it is a free-form face.
    pub fn free_form(&self) -> Option<&FreeForm> {
        match &self.form {
            FacetForm::Free(form) => Some(form),
            _ => None,
        }
    }

    /// The area of its triangles.
    fn area(&self, mesh: &Mesh) -> f64 {
        let of = |&t: &u32| mesh.area_vector(mesh.triangles[t as usize]).norm();
        self.triangles.iter().map(of).sum()
    }

    /// A facet of some triangles. Its plane is laid through its vertices later.
    fn facet(mesh: &Mesh, triangles: Vec<u32>) -> Self {
        let of = |t: &u32| mesh.triangles[*t as usize];
        let normal: Vector = triangles.iter().map(|t| mesh.area_vector(of(t))).sum();
        let normal = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector::z);
        let origin = triangles.first().map_or_else(Point::origin, |t| mesh.point(of(t)[0]));
        let surface = Primitive::Plane { origin, normal };
        FacePatch { surface, side: 1.0, is_facet: true, form: FacetForm::Flat, triangles }
    }
}
