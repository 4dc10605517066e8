//! Triangulations in space that get the edge lengths wanted and a good shape: long edges are
//! divided, edges flipped towards Delaunay's, and inner points moved to the mean of their
//! neighbours. What fills holes and closes bays is made with these.

pub mod flips;
mod refine;
mod sizes;

pub use refine::Triangulation;
pub use sizes::Sizes;

/// The surface folds at a side where the cosine of the angle between the normals of its
/// triangles is less than this: they turn by more than 107°.
pub const FOLDED: f64 = -0.3;
