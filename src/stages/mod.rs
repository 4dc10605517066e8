//! The stages, in the order in which the data go through them. Each has one entry function, and options and a
//! report of its own. No stage uses another one, except that [`adapt`] alternates [`knots`] and [`fit`].
//! [`convert`](crate::convert) calls them.

// What is read.

pub mod crop;

pub mod cloud;

// The exact surfaces of a mesh that a CAD program made, or of a noisy scan of a part.

pub mod regions;
pub mod seams;
pub mod sharpen;

// A mesh without noise and gaps, of no more vertices than the noise lets tell.

pub mod thin;

pub mod smooth;

pub mod fill;

// One face: parameters for each vertex, then a surface.

pub mod parameterize;

pub mod knots;

pub mod fit;

pub mod adapt;

// A body of several faces: quads, one subdivision surface, and its pieces.

pub mod layout;

pub mod net;

pub mod patches;

pub mod refine;

// What CAD takes.

pub mod trim;

pub mod brep;
