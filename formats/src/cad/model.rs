//! The model of a CAD file: trimmed faces as the file contains them.
//!
//! The model is plain data. The caller evaluates curves and surfaces, computes pcurves and ranges
//! that the file omits, and checks that the elements are consistent. Lengths are in millimetres in
//! any unit of the file. Parameters are those of the file, because surfaces and lines are scaled
//! instead.

use std::sync::Arc;

use super::affine::Affine;
use crate::spline::{SplineCurve, SplineSurface};

/// The faces of a CAD file.
#[derive(Debug, Clone, Default)]
pub struct CadModel {
    /// The name of the part. It is empty if the file has none.
    pub name: String,
    /// Every face of every body, in the order of the file.
    pub faces: Vec<CadFace>,
    /// The shells of the file. A face may belong to none.
    pub shells: Vec<CadShell>,
    /// The solids of the file. A shell may belong to none.
    pub solids: Vec<CadSolid>,
}

/// A set of connected faces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CadShell {
    /// The numbers of its faces in [`CadModel::faces`].
    pub faces: Vec<usize>,
    /// For each of its faces, whether the shell has the opposite normal.
    pub inverted: Vec<bool>,
    /// Whether the file declares the shell as closed.
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
    /// The name of the face in the file, for example `#17` or `directory entry 5`.
    pub entity: String,
    /// The surface, which several faces may share.
    pub surface: Arc<CadSurface>,
    /// Whether the outer boundary is that of the surface, so that `loops` only cut holes.
    pub natural: bool,
    /// Whether the normal of the face is that of its surface, which has the direction of Sᵤ × Sᵥ. The loops
    /// have the face to their left about the normal of the face. `None` if the file does not tell, and then
    /// the loops may run either way.
    pub forward: Option<bool>,
    /// The loops, in any order.
    pub loops: Vec<Vec<CadEdge>>,
    /// The places of the face in the model: one, or one for each use of its part in an assembly. The surface and the
    /// loops are in the coordinates of the part.
    pub places: Arc<[CadPlace]>,
}

/// The place of a part in the model: the coordinates of the part are turned, perhaps mirrored, shifted, and scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CadPlace(pub(crate) Affine);

impl CadPlace {
    /// The place of a part whose coordinates are those of the model.
    pub fn same() -> Self {
        CadPlace(Affine::scaling(1.0))
    }

    /// A point of the part in the coordinates of the model.
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.point(p)
    }

    /// A point of the model in the coordinates of the part.
    pub fn back(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.back(p)
    }

    /// A length in the model divided by the same length in the part.
    pub fn scale(&self) -> f64 {
        self.0.scale
    }
}

/// One use of an edge in a loop.
#[derive(Debug, Clone)]
pub struct CadEdge {
    /// The curve in space, if there is one.
    pub curve: Option<Arc<CadCurve<3>>>,
    /// The points at which the edge begins and ends on the curve, in the direction of the curve.
    /// `None` if the edge uses the whole range of the curve.
    pub ends: Option<[[f64; 3]; 2]>,
    /// Whether the loop runs in the direction of the curve.
    pub forward: bool,
    /// The curves in the parameter plane. A seam edge has two, and this use has one of them.
    pub pcurves: Vec<Arc<CadCurve<2>>>,
    /// Whether the loop runs in the direction of the pcurves.
    pub pcurve_forward: bool,
}

/// A curve in space (D = 3) or in a parameter plane (D = 2).
#[derive(Debug, Clone, PartialEq)]
pub struct CadCurve<const D: usize> {
    /// The geometry of the curve.
    pub shape: CurveShape<D>,
    /// The range of parameters. `None` if the file gives only end points.
    pub range: Option<(f64, f64)>,
}

/// The kinds of curves.
#[derive(Debug, Clone, PartialEq)]
pub enum CurveShape<const D: usize> {
    /// The line origin + t direction.
    Line {
        /// The point at t = 0.
        origin: [f64; D],
        /// The derivative in t.
        direction: [f64; D],
    },
    /// The ellipse or circle centre + cos(t) x + sin(t) y.
    Ellipse {
        /// The centre.
        centre: [f64; D],
        /// The semi-axis at t = 0.
        x: [f64; D],
        /// The semi-axis at t = π/2.
        y: [f64; D],
    },
    /// The branch of a hyperbola centre + cosh(t) x + sinh(t) y.
    Hyperbola {
        /// The centre.
        centre: [f64; D],
        /// The vector to the vertex.
        x: [f64; D],
        /// The derivative in t at the vertex.
        y: [f64; D],
    },
    /// The parabola vertex + t² x + t y.
    Parabola {
        /// The point at t = 0.
        vertex: [f64; D],
        /// Half of the second derivative in t.
        x: [f64; D],
        /// The derivative in t at the vertex.
        y: [f64; D],
    },
    /// A B-spline curve. If the range is not given, it is that of its knots.
    Spline(SplineCurve<D>),
}

impl<const D: usize> CurveShape<D> {
    /// The image of the curve under an affine map: `point` maps points, and `vector` maps differences of points.
    #[must_use]
    pub(crate) fn mapped<const E: usize>(
        self,
        point: impl Fn([f64; D]) -> [f64; E],
        vector: impl Fn([f64; D]) -> [f64; E],
    ) -> CurveShape<E> {
        match self {
            CurveShape::Line { origin, direction } => {
                CurveShape::Line { origin: point(origin), direction: vector(direction) }
            }
            CurveShape::Ellipse { centre, x, y } => {
                CurveShape::Ellipse { centre: point(centre), x: vector(x), y: vector(y) }
            }
            CurveShape::Hyperbola { centre, x, y } => {
                CurveShape::Hyperbola { centre: point(centre), x: vector(x), y: vector(y) }
            }
            CurveShape::Parabola { vertex, x, y } => {
                CurveShape::Parabola { vertex: point(vertex), x: vector(x), y: vector(y) }
            }
            CurveShape::Spline(spline) => CurveShape::Spline(spline.mapped(point)),
        }
    }
}

/// The kinds of surfaces.
#[derive(Debug, Clone, PartialEq)]
pub enum CadSurface {
    /// A B-spline surface.
    Spline(SplineSurface),
    /// The plane origin + u x + v y.
    Plane {
        /// The point at (0, 0).
        origin: [f64; 3],
        /// The derivative in u.
        x: [f64; 3],
        /// The derivative in v.
        y: [f64; 3],
    },
    /// The cylinder origin + cos(u) x + sin(u) y + v z.
    Cylinder {
        /// The point of the axis at v = 0.
        origin: [f64; 3],
        /// The radius vector at u = 0.
        x: [f64; 3],
        /// The radius vector at u = π/2.
        y: [f64; 3],
        /// The derivative in v.
        z: [f64; 3],
    },
    /// The cone origin + (radius + v slope) (cos(u) x + sin(u) y) + v z.
    Cone {
        /// The point of the axis at v = 0.
        origin: [f64; 3],
        /// The direction at u = 0.
        x: [f64; 3],
        /// The direction at u = π/2.
        y: [f64; 3],
        /// The direction of the axis.
        z: [f64; 3],
        /// The length of the radius vector at v = 0, as a multiple of x.
        radius: f64,
        /// The tangent of the half angle.
        slope: f64,
    },
    /// The sphere origin + cos(v) (cos(u) x + sin(u) y) + sin(v) z.
    Sphere {
        /// The centre.
        origin: [f64; 3],
        /// The radius vector at u = 0 and v = 0.
        x: [f64; 3],
        /// The radius vector at u = π/2 and v = 0.
        y: [f64; 3],
        /// The radius vector at v = π/2.
        z: [f64; 3],
    },
    /// The torus origin + (major + minor cos(v)) (cos(u) x + sin(u) y) + minor sin(v) z.
    Torus {
        /// The centre.
        origin: [f64; 3],
        /// The direction at u = 0.
        x: [f64; 3],
        /// The direction at u = π/2.
        y: [f64; 3],
        /// The direction of the axis.
        z: [f64; 3],
        /// The radius of the circle around which the tube runs, as a multiple of x.
        major: f64,
        /// The radius of the tube, as a multiple of x.
        minor: f64,
    },
    /// The surface of revolution: curve(v) turned by u about an axis.
    Revolution {
        /// The curve that turns.
        curve: CadCurve<3>,
        /// A point of the axis.
        origin: [f64; 3],
        /// The direction of the axis, a unit vector.
        axis: [f64; 3],
        /// The range of u. It is infinite if the file gives none.
        angles: (f64, f64),
    },
    /// The surface of linear extrusion curve(u) + v vector.
    Extrusion {
        /// The curve that is extruded.
        curve: CadCurve<3>,
        /// The derivative in v.
        vector: [f64; 3],
    },
    /// An offset of a surface along its unit normal, which has the direction of Sᵤ × Sᵥ.
    Offset {
        /// The surface at the distance 0.
        base: Arc<CadSurface>,
        /// The distance in mm.
        distance: f64,
    },
    /// The part of a surface over a rectangle of its parameters.
    Part {
        /// The surface.
        base: Arc<CadSurface>,
        /// The range of u. It may be infinite.
        u: (f64, f64),
        /// The range of v. It may be infinite.
        v: (f64, f64),
    },
}
