//! Remeshing of triangulations in space. A coarse triangulation and the wanted edge lengths go in;
//! a triangulation with these edge lengths and well-shaped triangles comes out. Long edges are
//! divided, edges are flipped towards the Delaunay criterion, and inner points move to the mean of
//! their neighbours. The stages use it for the triangles that fill holes and close bays.

pub(crate) mod flips;
mod isotropic;
mod refine;
mod sizes;

pub(crate) use isotropic::{EQUILATERAL, LEAST_VALENCE, isotropic};
pub(crate) use refine::{RimTriangulation, divide};
pub(crate) use sizes::Sizes;

/// The surface folds at a side if the cosine of the angle between the normals of its triangles is
/// below this value. The normals then differ by more than 107°.
pub(crate) const FOLDED: f64 = -0.3;

/// An edge is too long if it is longer than this multiple of the wanted length there. The halves of a
/// divided edge are then not much too short.
pub(crate) const TOO_LONG: f64 = 1.4;

/// Two triangles count as flat if the cosine of the angle between them is at least this (26°).
const FLAT: f64 = 0.9;

/// The rounds of flips and moves that make triangles even. Later rounds change few triangles. With 2 the
/// rms over the hole bench is 3 % less, with 8 it is 4 % more, and the least angles are a degree larger
/// or smaller.
pub(crate) const ROUNDS: usize = 4;
