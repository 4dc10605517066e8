//! The boundary representation that the writers take.
//!
//! Parts stand in lists and name each other by typed numbers: a face names its surface, a
//! loop its edges, an edge its vertices, a shell its faces, a solid its shells. Edges and
//! surfaces are shared: an edge has one curve in space, however many faces meet in it, and
//! several faces may lie on one surface. Each use of an edge has its own curve in the
//! parameter plane of the face's surface, its pcurve. Lengths are millimetres.
//!
//! [`Brep::check`] says whether the parts suit each other. The writers check before they
//! write a byte.

mod check;
mod fault;
mod truck;
mod volume;

pub use fault::{Fault, Part};
pub use truck::Refusal;

use crate::spline::{SplineCurve, SplineSurface};

/// Declares the number of a part in its list.
macro_rules! number {
    ($(#[$doc:meta] $name:ident)*) => {$(
        #[$doc]
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub usize);
    )*};
}

number! {
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

/// A curve in the parameter plane (u, v) of a face's surface.
pub type PCurve = SplineCurve<2>;

/// What is written to one file.
///
/// Shells that no solid names stand for themselves, as sheets. Each face belongs to one
/// shell, and each shell to one solid at most.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Brep {
    /// The part's name, any Unicode. CAD programs show it in their tree.
    pub name: String,
    /// Points where edges end.
    pub vertices: Vec<[f64; 3]>,
    /// Curves between vertices, in which faces meet or end.
    pub edges: Vec<Edge>,
    /// What faces lie on.
    pub surfaces: Vec<Surface>,
    /// Bounded parts of surfaces.
    pub faces: Vec<Face>,
    /// Faces that hang together.
    pub shells: Vec<Shell>,
    /// Bodies bounded by shells.
    pub solids: Vec<Solid>,
    /// An honest bound in mm on the distance between the representations of one edge: its
    /// curve in space, its pcurve on each face, and its vertices.
    pub uncertainty_mm: f64,
}

/// A curve and the vertices at its start and at its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The points of the edge, over the whole of the curve's range.
    pub curve: Curve,
    /// The vertex at the start of the curve and that at its end: the same one if it is closed.
    pub ends: [VertexId; 2],
}

/// The curve of an edge.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Curve {
    /// A B-spline curve, rational or not.
    Spline(SplineCurve<3>),
}

/// The surface of a face.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Surface {
    /// A B-spline surface, rational or not.
    Spline(SplineSurface),
}

/// A part of a surface, bounded by loops.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// What it lies on.
    pub surface: SurfaceId,
    /// Whether the face looks where its surface's normal S_u × S_v looks. A face of a solid
    /// looks out of the material.
    pub forward: bool,
    /// The outer loop, then the inner ones. Seen from where the face looks, the outer loop runs
    /// counter-clockwise and the inner ones run clockwise.
    pub loops: Vec<Vec<EdgeUse>>,
}

/// One use of an edge in a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeUse {
    /// The edge.
    pub edge: EdgeId,
    /// Whether the loop runs along the edge's curve.
    pub forward: bool,
    /// The edge in the face's parameter plane. It has the range and the direction of the
    /// edge's curve, whichever way the loop runs: S(pcurve(t)) is curve(t).
    pub pcurve: PCurve,
}

/// Faces that hang together by edges.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shell {
    /// The faces.
    pub faces: Vec<FaceId>,
    /// Whether the faces close it: each edge is then used twice, in opposite directions.
    pub closed: bool,
}

/// A body. All its faces look out of the material.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// The closed shell around it.
    pub outer: ShellId,
    /// The closed shells around the empty spaces in it.
    pub voids: Vec<ShellId>,
}

impl Brep {
    /// Adds a vertex.
    pub fn add_vertex(&mut self, point: [f64; 3]) -> VertexId {
        self.vertices.push(point);
        VertexId(self.vertices.len() - 1)
    }

    /// Adds an edge.
    pub fn add_edge(&mut self, curve: Curve, ends: [VertexId; 2]) -> EdgeId {
        self.edges.push(Edge { curve, ends });
        EdgeId(self.edges.len() - 1)
    }

    /// Adds a surface.
    pub fn add_surface(&mut self, surface: Surface) -> SurfaceId {
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

    /// Adds the parts of another model. The uncertainty becomes the larger one of both; the
    /// name stays.
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

    /// The shells that no solid names.
    pub fn sheets(&self) -> impl Iterator<Item = ShellId> {
        let solids = self.solids.iter();
        let named: Vec<ShellId> = solids.flat_map(Solid::shells).collect();
        (0..self.shells.len()).map(ShellId).filter(move |shell| !named.contains(shell))
    }

    /// For each edge its uses: the face and the use in one of its loops.
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

    /// The largest absolute coordinate of vertices and of poles of surfaces.
    pub(crate) fn reach(&self) -> f64 {
        let poles = self.surfaces.iter().flat_map(|Surface::Spline(surface)| surface.poles());
        self.vertices.iter().chain(poles).flatten().fold(0.0, |reach, x| x.abs().max(reach))
    }
}

impl Solid {
    /// All its shells, the outer one first.
    pub fn shells(&self) -> impl Iterator<Item = ShellId> {
        std::iter::once(self.outer).chain(self.voids.iter().copied())
    }
}
