//! Remeshing of triangulations in space. A coarse triangulation and the wanted edge lengths go in;
//! a triangulation with these edge lengths and well-shaped triangles comes out. Long edges are
//! divided, edges are flipped towards the Delaunay criterion, and inner points move to the mean of
//! their neighbours. The stages use it for the triangles that fill holes and close bays.

pub mod flips;
mod isotropic;
mod refine;
mod sizes;

pub use isotropic::isotropic;
pub use refine::{RimTriangulation, divide};
pub use sizes::Sizes;

/// The surface folds at a side if the cosine of the angle between the normals of its triangles is
/// below this value. The normals then differ by more than 107°.
pub const FOLDED: f64 = -0.3;
