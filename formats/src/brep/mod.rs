//! The boundary representation (B-rep) that the writers take.
//!
//! The elements are in lists and refer to each other by typed numbers: a face to its surface, a
//! loop to its edges, an edge to its vertices, a shell to its faces, and a solid to its shells.
//! Edges and surfaces are shared. An edge has one curve in space, however many faces use it, and
//! several faces may lie on one surface. Each use of an edge has its own curve in the parameter
//! plane of the face's surface, which is called its pcurve. Lengths are in millimetres. The model
//! follows ISO 10303-42.
//!
//! [`Brep::check`] checks whether the elements are consistent. The writers call it before they
//! write anything.

mod bounds;
mod check;
mod conic;
mod curve;
mod fault;
mod frame;
mod integrals;
mod loops;
mod surface;
mod truck;

pub use conic::{EllipseArc, LineSegment};
pub use curve::{BoundedCurve, BrepCurve, PCurve};
pub use fault::{BrepElement, ModelFault};
pub use frame::Frame;
pub use surface::BrepSurface;
pub use truck::Refusal;

crate::numbered::number! {
    /// The number of a vertex in [`Brep::vertices`].
    VertexId
    /// The number of an edge in [`Brep::edges`].
    EdgeId
    /// The number of a surface in [`Brep::surfaces`].
    SurfaceId
    /// The number of a face in [`Brep::faces`].
    FaceId
    /// The number of a shell in [`Brep::shells`].
    ShellId
}

/// The model that is written to one file.
///
/// Each face belongs to one shell, and each shell to at most one solid. A shell that belongs to no
/// solid is a sheet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Brep {
    /// The name of the part in any Unicode characters. CAD programs show it in their tree.
    pub name: String,
    /// What a reader of the file should know about the part, for example where its origin lies. It
    /// may be empty.
    pub description: String,
    /// The points at which edges end.
    pub vertices: Vec<[f64; 3]>,
    /// The curves between vertices that bound faces.
    pub edges: Vec<Edge>,
    /// The surfaces on which faces lie.
    pub surfaces: Vec<BrepSurface>,
    /// The bounded parts of surfaces.
    pub faces: Vec<Face>,
    /// The sets of connected faces.
    pub shells: Vec<Shell>,
    /// The bodies that shells bound.
    pub solids: Vec<Solid>,
    /// A bound in mm on the distance between the representations of an edge: its curve in space,
    /// its pcurve on each face, and its vertices. A value that is too small makes
    /// [`check`](Brep::check) fail. A value that is too large makes CAD programs treat gaps as
    /// closed.
    pub uncertainty_mm: f64,
}

/// A curve and the vertices at its start and at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The curve. The edge uses its whole range.
    pub curve: BrepCurve,
    /// The vertices at the start and at the end of the curve. They are the same if it is closed.
    pub ends: [VertexId; 2],
}

/// A part of a surface, bounded by loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The surface on which the face lies.
    pub surface: SurfaceId,
    /// Whether the normal of the face is that of its surface, S_u × S_v. The normal of a solid's
    /// face points out of the material.
    pub forward: bool,
    /// The outer loop, then the inner loops. Seen against the normal of the face, the outer loop
    /// runs counter-clockwise and the inner loops run clockwise.
    ///
    /// A face that goes around a periodic surface uses a seam edge twice in its outer loop, once in
    /// each direction and with a pcurve on each side of the period. At a pole of a sphere or at the
    /// apex of a cone no edge is needed: the loop may jump there from one pcurve to the next.
    pub loops: Vec<Vec<EdgeUse>>,
}

/// One use of an edge in a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeUse {
    /// The edge.
    pub edge: EdgeId,
    /// Whether the loop runs in the direction of the edge's curve.
    pub forward: bool,
    /// The edge in the parameter plane of the face. It has the range and the direction of the
    /// edge's curve in either direction of the loop: S(pcurve(t)) is curve(t).
    pub pcurve: PCurve,
}

/// A set of faces that are connected by edges.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shell {
    /// The faces.
    pub faces: Vec<FaceId>,
    /// Whether the shell is closed. Then each edge is used twice in opposite directions.
    pub closed: bool,
}

/// A body. The normals of all its faces point out of the material.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// The closed shell around it.
    pub outer: ShellId,
    /// The closed shells around the empty spaces in it.
    pub voids: Vec<ShellId>,
}

/// The number of roundings of its coordinates that a place of a moved model may differ by. Sixteen
/// poles have a part in a place of a bicubic surface; with fewer roundings the check of a far
/// model fails, and with many more gaps count as closed.
const ROUNDINGS: f64 = 16.0;

impl Brep {
    /// Adds a vertex.
    pub fn add_vertex(&mut self, point: [f64; 3]) -> VertexId {
        self.vertices.push(point);
        VertexId(self.vertices.len() - 1)
    }

    /// Adds an edge.
    pub fn add_edge(&mut self, curve: BrepCurve, ends: [VertexId; 2]) -> EdgeId {
        self.edges.push(Edge { curve, ends });
        EdgeId(self.edges.len() - 1)
    }

    /// Adds a surface.
    pub fn add_surface(&mut self, surface: BrepSurface) -> SurfaceId {
        self.surfaces.push(surface);
        SurfaceId(self.surfaces.len() - 1)
    }

    /// Adds a face.
    pub fn add_face(&mut self, face: Face) -> FaceId {
        self.faces.push(face);
        FaceId(self.faces.len() - 1)
    }

    /// Adds a shell.
    pub fn add_shell(&mut self, shell: Shell) -> ShellId {
        self.shells.push(shell);
        ShellId(self.shells.len() - 1)
    }

    /// Adds the elements of another model. The uncertainty becomes the larger one of the two. The
    /// name and the description do not change.
    pub fn append(&mut self, other: Brep) {
        let [vertices, edges] = [self.vertices.len(), self.edges.len()];
        let [surfaces, faces, shells] = [self.surfaces.len(), self.faces.len(), self.shells.len()];
        let shell = |id: ShellId| ShellId(id.0 + shells);
        self.vertices.extend(other.vertices);
        self.edges.extend(
            other
                .edges
                .into_iter()
                .map(|edge| Edge { ends: edge.ends.map(|end| VertexId(end.0 + vertices)), ..edge }),
        );
        self.surfaces.extend(other.surfaces);
        self.faces.extend(other.faces.into_iter().map(|mut face| {
            face.surface.0 += surfaces;
            face.loops.iter_mut().flatten().for_each(|of_loop| of_loop.edge.0 += edges);
            face
        }));
        self.shells.extend(other.shells.into_iter().map(|mut shell| {
            shell.faces.iter_mut().for_each(|face| face.0 += faces);
            shell
        }));
        self.solids.extend(other.solids.into_iter().map(|solid| Solid {
            outer: shell(solid.outer),
            voids: solid.voids.into_iter().map(shell).collect(),
        }));
        self.uncertainty_mm = self.uncertainty_mm.max(other.uncertainty_mm);
    }

    /// The same with all faces turned over: the outside becomes the inside.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        for face in &mut self.faces {
            face.forward = !face.forward;
            for ring in &mut face.loops {
                ring.reverse();
                ring.iter_mut().for_each(|used| used.forward = !used.forward);
            }
        }
        self
    }

    /// The model moved by a vector. The uncertainty grows by what the larger coordinates lose when
    /// they are rounded.
    #[must_use]
    pub fn translated(mut self, by: [f64; 3]) -> Self {
        let moved = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + by[k]);
        self.vertices.iter_mut().for_each(|vertex| *vertex = moved(*vertex));
        let moved = |edge: Edge| Edge { curve: edge.curve.translated(by), ..edge };
        self.edges = self.edges.into_iter().map(moved).collect();
        self.surfaces = self.surfaces.into_iter().map(|on| on.translated(by)).collect();
        self.uncertainty_mm += ROUNDINGS * f64::EPSILON * self.reach();
        self
    }

    /// The shells that belong to no solid.
    pub fn sheets(&self) -> impl Iterator<Item = ShellId> {
        let solids = self.solids.iter();
        let named: Vec<ShellId> = solids.flat_map(Solid::shells).collect();
        (0..self.shells.len()).map(ShellId).filter(move |shell| !named.contains(shell))
    }

    /// Whether all surfaces and curves are B-splines.
    pub(crate) fn has_splines_only(&self) -> bool {
        let uses = || self.faces.iter().flat_map(|face| face.loops.iter().flatten());
        self.surfaces.iter().all(|surface| surface.spline().is_some())
            && self.edges.iter().all(|edge| edge.curve.spline().is_some())
            && uses().all(|of_loop| of_loop.pcurve.spline().is_some())
    }

    /// What the model has, for human readers of a file.
    pub(crate) fn content(&self) -> &'static str {
        if self.has_splines_only() { "Trimmed B-spline surfaces" } else { "Trimmed surfaces" }
    }

    /// The uses of each edge: the face and the use in one of its loops.
    pub fn uses(&self) -> Vec<Vec<(FaceId, &EdgeUse)>> {
        let mut uses = vec![Vec::new(); self.edges.len()];
        for (number, face) in self.faces.iter().enumerate() {
            for of_loop in face.loops.iter().flatten() {
                if let Some(of_edge) = uses.get_mut(of_loop.edge.0) {
                    of_edge.push((FaceId(number), of_loop));
                }
            }
        }
        uses
    }
}

impl Solid {
    /// All shells of the solid. The outer one comes first.
    pub fn shells(&self) -> impl Iterator<Item = ShellId> {
        std::iter::once(self.outer).chain(self.voids.iter().copied())
    }
}
