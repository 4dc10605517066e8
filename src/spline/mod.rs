//! B-spline curves and surfaces: evaluation, foot points, nearest points, and curves on surfaces.
//! Notation and algorithms follow Piegl & Tiller, "The NURBS Book" (1997), chapters 2 to 5.

mod bezier_piece;
mod certified_loop;
mod checked;
pub(crate) mod chords;
mod compose;
mod curve;
pub(crate) mod decimal;
mod edges;
mod foot;
mod knots;
pub(crate) mod nearest;
mod polynomials;
mod refine;
mod samples;
pub(crate) mod spans;
mod surface;

pub use crate::error::LoopFault;

pub use certified_loop::{CertifiedLoop, LocatedFault, Nest, crossings, misplaced};
pub use compose::{curve_on_surface, off_surface, pieces_on_surface};
pub use curve::Curve;
pub use edges::EdgeTree;
pub use foot::{foot_point, foot_point_moving, last_step};
pub(crate) use knots::MAX_SPANS;
pub use knots::{Basis, KnotVector, runs};
pub(crate) use polynomials::fast_evaluator;
pub(crate) use refine::refined;
pub use samples::Samples;
pub use surface::{Jet, ParametricSurface, Surface};

/// The relative accuracy of geometry: distances as shares of the diagonal, or of the distance if
/// that is longer, and parameters in [0, 1]. Files are rounded more coarsely. A smaller value would
/// make queries from places with many equally near points, such as the centre of a sphere, take
/// very long.
pub(crate) const EXACT: f64 = 1e-7;

/// The number of parts of a polynomial piece between which a search for one of its points begins.
/// With fewer it may miss one, and more only take longer.
pub(crate) const SAMPLES: usize = 16;

/// The largest number of times that a cell or a piece of a curve is halved. Smaller ones are below
/// the resolution of floating-point numbers.
const MAX_HALVINGS: usize = 24;
