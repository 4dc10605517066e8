//! The boundary representation that the writers take.
//!
//! Geometry and topology are truck's: vertices, edges with a B-spline curve
//! each, wires, a face on a B-spline surface. truck has no curves in the
//! parameter plane, so they stand beside the face, one for every use of an
//! edge. Lengths are millimetres.

use truck_modeling::{BSplineCurve, Face, Point2};

/// A curve in the parameter plane (u, v) of a face's surface.
pub type PCurve = BSplineCurve<Point2>;

/// What is written to one file: an open shell of trimmed faces and its name.
#[derive(Debug, Clone)]
pub struct Brep {
    /// The part's name, any Unicode; CAD programs show it in their tree.
    pub name: String,
    /// The faces.
    pub faces: Vec<TrimmedFace>,
    /// An honest bound on the distance between the representations of one
    /// edge (3D curve against pcurve on the surface), in mm.
    pub uncertainty_mm: f64,
}

/// A face on a B-spline surface, with the pcurves of its edges.
///
/// `face.boundaries()[i]` is the face's `i`-th loop, the outer one first;
/// `pcurves[i][j]` belongs to that loop's `j`-th edge. A pcurve has the
/// parameter range and the direction of the edge's own curve (`edge.curve()`),
/// whichever way the loop uses the edge, so that `S(pcurve(t))` is `C(t)`.
/// Seen in the (u, v) plane the outer loop runs counter-clockwise and inner
/// ones run clockwise.
#[derive(Debug, Clone)]
pub struct TrimmedFace {
    /// Surface (`Surface::BSplineSurface`), loops and edges (`Curve::BSplineCurve`).
    pub face: Face,
    /// A pcurve for each edge of each loop.
    pub pcurves: Vec<Vec<PCurve>>,
}
