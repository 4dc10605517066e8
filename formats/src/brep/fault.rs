//! What can be wrong with a boundary representation.

use std::fmt;

use super::{EdgeId, FaceId, ShellId};

/// A part of a [`Brep`](super::Brep), by its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A vertex.
    Vertex(usize),
    /// An edge.
    Edge(usize),
    /// A surface.
    Surface(usize),
    /// A face.
    Face(usize),
    /// A loop of a face; 0 is the outer one.
    Loop(usize, usize),
    /// A use of an edge in a loop of a face.
    Use(usize, usize, usize),
    /// A shell.
    Shell(usize),
    /// A solid.
    Solid(usize),
}

/// Why a [`Brep`](super::Brep) is not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// It has no face.
    #[error("it has no face")]
    Empty,
    /// The bound on the distance between representations is no positive length.
    #[error("its uncertainty is {0} mm")]
    Uncertainty(f64),
    /// A part names another one that is not there.
    #[error("{0} names {1}, which is not there")]
    Missing(Part, Part),
    /// A coordinate is infinite or not a number.
    #[error("{0} is not finite")]
    NotFinite(Part),
    /// A curve or a surface does not begin and end at its outermost poles.
    #[error("the knots of {0} are not clamped")]
    Unclamped(Part),
    /// A face has no loop, or a loop no edge.
    #[error("{0} is empty")]
    Nothing(Part),
    /// A vertex is not where the edge's curve ends.
    #[error("{0} ends {1} mm from its vertex")]
    Vertex(Part, f64),
    /// A pcurve has another parameter range than its edge.
    #[error("the pcurve of {0} has another range than its edge")]
    Range(Part),
    /// A pcurve leaves the surface's parameter range.
    #[error("the pcurve of {0} leaves its surface")]
    Leaves(Part),
    /// A pcurve on its surface is farther from the edge's curve than the uncertainty.
    #[error("{0} is {1} mm off its surface")]
    OffSurface(Part, f64),
    /// An edge of a loop begins at another vertex than the edge before it ends at.
    #[error("the loop is open before {0}")]
    Open(Part),
    /// A pcurve of a loop begins elsewhere than the pcurve before it ends.
    #[error("the loop in the parameter plane is open before {0}")]
    OpenInPlane(Part),
    /// An outer loop runs clockwise, or an inner one counter-clockwise.
    #[error("{0} runs the wrong way round")]
    WrongWay(Part),
    /// A face, or a shell, belongs to none or to several of what it must belong to one of.
    #[error("{0} is used {1} times")]
    Owners(Part, usize),
    /// An edge is used by a number of loops that its shell does not allow.
    #[error("{} of {} is used {uses} times", Part::Edge(edge.0), Part::Shell(shell.0))]
    Uses {
        /// The shell.
        shell: ShellId,
        /// The edge.
        edge: EdgeId,
        /// How often it is used.
        uses: usize,
    },
    /// Two faces that meet in an edge look to different sides.
    #[error(
        "{} and {} look to different sides of {}",
        Part::Face(faces[0].0), Part::Face(faces[1].0), Part::Edge(edge.0)
    )]
    Turned {
        /// The faces.
        faces: [FaceId; 2],
        /// The edge.
        edge: EdgeId,
    },
    /// An edge is used by faces of several shells.
    #[error("{0} belongs to several shells")]
    Shared(Part),
    /// The faces of a shell do not hang together.
    #[error("{0} is in several pieces")]
    Pieces(Part),
    /// Vertices, edges, faces and loops of a closed shell do not make a closed surface.
    #[error("{0} has the Euler number {1}: an even number, 2 at the most, is due")]
    Euler(Part, i64),
    /// A solid names a shell that is open.
    #[error("{0} names {1}, which is open")]
    OpenShell(Part, Part),
    /// The faces of a shell look into the material.
    #[error("{0} of {1} is turned inside out")]
    InsideOut(Part, Part),
    /// A void is not within the shell around it.
    #[error("{0} is not within {1}")]
    Outside(Part, Part),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Part::Vertex(n) => write!(f, "vertex {n}"),
            Part::Edge(n) => write!(f, "edge {n}"),
            Part::Surface(n) => write!(f, "surface {n}"),
            Part::Face(n) => write!(f, "face {n}"),
            Part::Loop(face, n) => write!(f, "loop {n} of face {face}"),
            Part::Use(face, ring, n) => write!(f, "edge {n} in loop {ring} of face {face}"),
            Part::Shell(n) => write!(f, "shell {n}"),
            Part::Solid(n) => write!(f, "solid {n}"),
        }
    }
}

impl From<Fault> for std::io::Error {
    fn from(fault: Fault) -> Self {
        std::io::Error::new(std::io::ErrorKind::InvalidInput, fault)
    }
}
