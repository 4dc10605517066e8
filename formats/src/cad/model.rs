//! What a CAD file holds: trimmed faces as the file gives them.
//!
//! Data only, and in the file's own terms: who measures on them evaluates them,
//! finds what a file leaves out (pcurves, ranges), and checks that the parts
//! agree. Lengths are millimetres, whatever the file's unit; parameters are the
//! file's, since surfaces and lines are scaled instead.

use std::sync::Arc;

use crate::spline::{SplineCurve, SplineSurface};

/// The faces of a CAD file.
#[derive(Debug, Clone, Default)]
pub struct CadModel {
    /// The part's name, where the file has one.
    pub name: String,
    /// Every face of every body, in the file's order.
    pub faces: Vec<CadFace>,
    /// The shells, by which the file groups faces. A face may belong to none.
    pub shells: Vec<CadShell>,
    /// The solids, by which the file groups shells. A shell may belong to none.
    pub solids: Vec<CadSolid>,
}

/// Faces that hang together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CadShell {
    /// The numbers of its faces in [`CadModel::faces`].
    pub faces: Vec<usize>,
    /// Whether the file says that it is closed.
    pub closed: bool,
}

/// A body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CadSolid {
    /// The number of the shell around it in [`CadModel::shells`].
    pub outer: usize,
    /// The numbers of the shells around the empty spaces in it.
    pub voids: Vec<usize>,
}

/// A trimmed surface.
#[derive(Debug, Clone)]
pub struct CadFace {
    /// What the file calls it: `#17`, `directory entry 5`.
    pub entity: String,
    /// What it lies on; faces may share one.
    pub surface: Arc<CadSurface>,
    /// Whether the surface's own edges bound it, and `loops` only cut holes.
    pub natural: bool,
    /// The loops, in any order.
    pub loops: Vec<Vec<CadEdge>>,
}

/// One use of an edge in a loop.
#[derive(Debug, Clone)]
pub struct CadEdge {
    /// The curve in space, if there is one.
    pub curve: Option<Arc<CadCurve<3>>>,
    /// Where the edge begins and ends on that curve, in the curve's direction.
    /// `None`: it is the whole of the curve's range.
    pub ends: Option<[[f64; 3]; 2]>,
    /// Whether the loop runs along the curve.
    pub forward: bool,
    /// Curves in the parameter plane; two for a seam, of which this use has one.
    pub pcurves: Vec<Arc<CadCurve<2>>>,
    /// Whether the loop runs along them.
    pub pcurve_forward: bool,
}

/// A curve in space (D = 3) or in a parameter plane (D = 2).
#[derive(Debug, Clone, PartialEq)]
pub struct CadCurve<const D: usize> {
    /// Its points.
    pub shape: CurveShape<D>,
    /// From where to where; `None` where the file says it by end points only.
    pub range: Option<(f64, f64)>,
}

/// The kinds of curves.
#[derive(Debug, Clone, PartialEq)]
pub enum CurveShape<const D: usize> {
    /// origin + t direction.
    Line {
        /// The point at t = 0.
        origin: [f64; D],
        /// The way that a unit of t goes.
        direction: [f64; D],
    },
    /// centre + cos(t) x + sin(t) y: circles, too.
    Ellipse {
        /// The middle.
        centre: [f64; D],
        /// The half axis at t = 0.
        x: [f64; D],
        /// The half axis at t = π/2.
        y: [f64; D],
    },
    /// A B-spline curve, over the whole of its knots' range if none is said.
    Spline(SplineCurve<D>),
}

/// The kinds of surfaces.
#[derive(Debug, Clone, PartialEq)]
pub enum CadSurface {
    /// A B-spline surface.
    Spline(SplineSurface),
    /// origin + u x + v y.
    Plane {
        /// The point at (0, 0).
        origin: [f64; 3],
        /// The way that a unit of u goes.
        x: [f64; 3],
        /// The way that a unit of v goes.
        y: [f64; 3],
    },
    /// origin + cos(u) x + sin(u) y + v z.
    Cylinder {
        /// The point of the axis at v = 0.
        origin: [f64; 3],
        /// The radius at u = 0.
        x: [f64; 3],
        /// The radius at u = π/2.
        y: [f64; 3],
        /// The way that a unit of v goes.
        z: [f64; 3],
    },
    /// curve(u) + v vector.
    Extrusion {
        /// The curve that is moved.
        curve: CadCurve<3>,
        /// The way that a unit of v goes.
        vector: [f64; 3],
    },
    /// A surface moved along its unit normal, Sᵤ × Sᵥ.
    Offset {
        /// The surface at distance 0.
        base: Arc<CadSurface>,
        /// How far, in mm.
        distance: f64,
    },
}
