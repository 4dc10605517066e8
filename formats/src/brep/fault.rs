//! The faults of a boundary representation.

use std::fmt;

use super::{EdgeId, FaceId, ShellId};

/// An element of a [`Brep`](super::Brep), given by its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BrepElement {
    /// A vertex.
    Vertex(usize),
    /// An edge.
    Edge(usize),
    /// A surface.
    Surface(usize),
    /// A face.
    Face(usize),
    /// A loop of a face: the number of the face and of the loop. Loop 0 is the outer one.
    Loop(usize, usize),
    /// A use of an edge: the number of the face, of the loop, and of the use in the loop.
    Use(usize, usize, usize),
    /// A shell.
    Shell(usize),
    /// A solid.
    Solid(usize),
}

/// The reason why a [`Brep`](super::Brep) is not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelFault {
    /// The model has no face.
    #[error("it has no face")]
    Empty,
    /// The uncertainty is not a positive length.
    #[error("its uncertainty is {0} mm")]
    Uncertainty(f64),
    /// An element refers to another one that does not exist.
    #[error("{0} refers to {1}, which does not exist")]
    Missing(BrepElement, BrepElement),
    /// A coordinate is infinite or not a number.
    #[error("{0} is not finite")]
    NotFinite(BrepElement),
    /// A curve or a surface does not begin and end at its first and last poles.
    #[error("the knots of {0} are not clamped")]
    Unclamped(BrepElement),
    /// A radius or another measure of a surface is not valid.
    #[error("{0}: {1}")]
    Measures(BrepElement, &'static str),
    /// A face has no loop, or a loop has no edge.
    #[error("{0} is empty")]
    Nothing(BrepElement),
    /// A vertex is not at the end of the edge's curve.
    #[error("{0} ends {1} mm from its vertex")]
    Vertex(BrepElement, f64),
    /// A pcurve and its edge have different parameter ranges.
    #[error("the pcurve of {0} has a different range from its edge")]
    Range(BrepElement),
    /// A pcurve leaves the parameter range of its surface.
    #[error("the pcurve of {0} leaves its surface")]
    Leaves(BrepElement),
    /// The distance between the trace of a pcurve on its surface and the edge's curve exceeds the
    /// uncertainty.
    #[error("{0} is {1} mm off its surface")]
    OffSurface(BrepElement, f64),
    /// An edge of a loop does not begin at the vertex at which the previous edge ends.
    #[error("the loop is open before {0}")]
    Open(BrepElement),
    /// A pcurve of a loop does not begin where the previous pcurve ends.
    #[error("the loop in the parameter plane is open before {0}")]
    OpenInPlane(BrepElement),
    /// The pcurves of a face span more than one period of its surface.
    #[error("{0} laps over itself")]
    Laps(BrepElement),
    /// An outer loop runs clockwise, or an inner loop runs counter-clockwise.
    #[error("{0} has the wrong orientation")]
    WrongWay(BrepElement),
    /// A face does not belong to exactly one shell, or a shell belongs to several solids.
    #[error("{0} is used {1} times")]
    Owners(BrepElement, usize),
    /// The number of uses of an edge is not allowed in its shell.
    #[error("{} of {} is used {uses} times", BrepElement::Edge(edge.0), BrepElement::Shell(shell.0))]
    Uses {
        /// The shell.
        shell: ShellId,
        /// The edge.
        edge: EdgeId,
        /// The number of uses.
        uses: usize,
    },
    /// Two faces that share an edge have opposite orientations.
    #[error(
        "{} and {} have opposite orientations at {}",
        BrepElement::Face(faces[0].0), BrepElement::Face(faces[1].0), BrepElement::Edge(edge.0)
    )]
    Turned {
        /// The faces.
        faces: [FaceId; 2],
        /// The edge.
        edge: EdgeId,
    },
    /// Faces of several shells use the same edge.
    #[error("{0} belongs to several shells")]
    Shared(BrepElement),
    /// The faces of a shell are not connected.
    #[error("{0} is not connected")]
    Pieces(BrepElement),
    /// A closed shell does not have the Euler number of a closed surface.
    #[error("{0} has the Euler number {1}, which should be an even number of at most 2")]
    Euler(BrepElement, i64),
    /// A solid refers to a shell that is open.
    #[error("{0} refers to {1}, which is open")]
    OpenShell(BrepElement, BrepElement),
    /// The faces of a shell face into the material.
    #[error("{0} of {1} is turned inside out")]
    InsideOut(BrepElement, BrepElement),
    /// A void is not inside the outer shell.
    #[error("{0} is not within {1}")]
    Outside(BrepElement, BrepElement),
}

impl fmt::Display for BrepElement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BrepElement::Vertex(n) => write!(f, "vertex {n}"),
            BrepElement::Edge(n) => write!(f, "edge {n}"),
            BrepElement::Surface(n) => write!(f, "surface {n}"),
            BrepElement::Face(n) => write!(f, "face {n}"),
            BrepElement::Loop(face, n) => write!(f, "loop {n} of face {face}"),
            BrepElement::Use(face, ring, n) => write!(f, "edge {n} in loop {ring} of face {face}"),
            BrepElement::Shell(n) => write!(f, "shell {n}"),
            BrepElement::Solid(n) => write!(f, "solid {n}"),
        }
    }
}

impl From<ModelFault> for std::io::Error {
    fn from(fault: ModelFault) -> Self {
        std::io::Error::new(std::io::ErrorKind::InvalidInput, fault)
    }
}
