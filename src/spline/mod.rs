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
mod network;
mod network_cut;
mod polynomials;
mod refine;
mod samples;
pub(crate) mod spans;
pub mod subdivision;
mod surface;

pub use crate::error::LoopFault;
pub use certified_loop::{CertifiedLoop, crossings};
pub(crate) use certified_loop::{LocatedFault, Nest, misplaced};
pub use compose::pieces_on_surface;
pub(crate) use compose::{curve_on_surface, off_surface};
pub use curve::Curve;
pub use edges::EdgeTree;
pub use foot::{foot_point, foot_point_moving, last_step};
pub use knots::KnotVector;
pub(crate) use knots::MOST_SPANS;
pub(crate) use knots::{Basis, runs};
pub(crate) use network::SideUse;
pub use network::{Network, SeamPlace, Side, Track};
pub use network_cut::{CutArc, CutPart, KeptFace, KeptPlaces, NetworkCut, TrackNode};
pub(crate) use network_cut::{PieceEnd, chord_points, side_line};

pub(crate) use polynomials::fast_evaluator;
pub(crate) use refine::{inserted, refined};
pub use samples::Samples;
pub use surface::{Jet, ParametricSurface, Surface};

/// The relative accuracy of places: a share of the diagonal, of a distance if that is longer, or of the
/// domain. Files are rounded more coarsely. A smaller value would make queries from places with many
/// equally near points, such as the centre of a sphere, take very long.
pub(crate) const ACCURACY: f64 = 1e-7;

/// The number of samples of each span in u and in v that show its shape: between two samples a span moves away from
/// its chord by less than a ninth of its height. Newton's method finds foot points from the nearest of them.
pub(crate) const SAMPLES_PER_SPAN: usize = 3;

/// The largest number of times that a part of a curve or a surface is halved. Smaller parts are below
/// the resolution of floating-point numbers.
const MOST_HALVINGS: usize = 24;
