//! Small motions of a surface: the unknowns of a fit.
//!
//! Each unknown is a motion seen from the data: turns about a pivot amid the points, shifts across the
//! axis, and changes of a radius under which the surface stays where the data are. So the unknowns do not
//! become one another for short arcs of large radii, and no choice of coordinates is singular.

use nalgebra::{Rotation3, SMatrix, SVector};

use super::Primitive;
use super::primitive::cylindrical;
use crate::geometry::{Point, Vector, plane_axes};

/// The most parameters of a surface, those of a torus.
pub(crate) const MOST_PARAMETERS: usize = 7;

/// The derivatives of a distance by the motions of a surface. Those beyond its number of parameters are 0.
pub(crate) type MotionRow = SVector<f64, MOST_PARAMETERS>;

/// A covariance of the motions of a surface.
pub(crate) type Covariance = SMatrix<f64, MOST_PARAMETERS, MOST_PARAMETERS>;

/// The motions of a surface, in this order:
///
/// | surface | motions |
/// | --- | --- |
/// | plane | turns about `across[0]` and `across[1]`, shift along the normal |
/// | cylinder | turns, shifts along `across`, radius |
/// | cone | turns, shifts along `across`, radius, angle |
/// | sphere | shifts along x, y, z, radius |
/// | torus | turns, shifts along `across`, shift along the axis, major radius, minor radius |
#[derive(Debug, Clone, Copy)]
pub struct Motions {
    surface: Primitive,
    pivot: Point,
    /// Two unit vectors that are perpendicular to the axis, or lie in the plane.
    across: [Vector; 2],
    /// The normal of the surface where the data are. Zero if radii change about a fixed centre.
    normal: Vector,
    /// The direction from the axis to the data. Zero if radii change about a fixed centre.
    out: Vector,
}

impl Motions {
    /// The motions of a surface about a pivot amid the data. With `fixed_centre` a radius changes about
    /// a fixed centre, otherwise so that the surface next to the pivot stays in place.
    pub(crate) fn new(surface: Primitive, pivot: Point, fixed_centre: bool) -> Self {
        let surface = surface.centred_at(pivot);
        let axis = match surface {
            Primitive::Plane { normal, .. } => normal,
            _ => surface.axis().unwrap_or_else(Vector::z),
        };
        let (x, y) = plane_axes(axis);
        let normal = surface.normal(pivot);
        let out = cylindrical(surface.origin(), axis, pivot).2;
        let [normal, out] = if fixed_centre { [Vector::zeros(); 2] } else { [normal, out] };
        Motions { surface, pivot, across: [x, y], normal, out }
    }

    /// The surface that is moved.
    pub(crate) fn surface(&self) -> Primitive {
        self.surface
    }

    /// The point that the turns are about.
    pub(crate) fn pivot(&self) -> Point {
        self.pivot
    }

    /// The distance of a point, and its derivatives by the motions.
    pub(crate) fn row(&self, p: Point) -> (f64, MotionRow) {
        let (d, g) = self.surface.distance(p);
        let q = p - self.pivot;
        let [x, y] = self.across;
        let turns = [-g.dot(&x.cross(&q)), -g.dot(&y.cross(&q))];
        let shifts = [-g.dot(&x), -g.dot(&y)];
        let mut row = MotionRow::zeros();
        match self.surface {
            Primitive::Plane { .. } => {
                row[0] = turns[0];
                row[1] = turns[1];
                row[2] = -1.0;
            }
            Primitive::Sphere { .. } => {
                row[0] = -g.x;
                row[1] = -g.y;
                row[2] = -g.z;
                row[3] = g.dot(&self.normal) - 1.0;
            }
            Primitive::Cylinder { .. } => {
                row[0] = turns[0];
                row[1] = turns[1];
                row[2] = shifts[0];
                row[3] = shifts[1];
                row[4] = g.dot(&self.normal) - 1.0;
            }
            Primitive::Cone { origin, axis, radius, angle } => {
                let (h, rho, _) = cylindrical(origin, axis, p);
                let (sin, cos) = angle.sin_cos();
                row[0] = turns[0];
                row[1] = turns[1];
                row[2] = shifts[0];
                row[3] = shifts[1];
                row[4] = g.dot(&self.out) - cos;
                row[5] = -(rho - radius) * sin - h * cos;
            }
            Primitive::Torus { centre, axis, .. } => {
                let out = cylindrical(centre, axis, p).2;
                row[0] = turns[0];
                row[1] = turns[1];
                row[2] = shifts[0];
                row[3] = shifts[1];
                row[4] = -g.dot(&axis);
                row[5] = g.dot(&self.out) - g.dot(&out);
                row[6] = g.dot(&self.normal) - 1.0;
            }
        }
        (d, row)
    }

    /// The surface after a step. `None` if it has degenerated: a radius beyond every bound, a cone that
    /// is none, a torus without a circle.
    pub(crate) fn moved(&self, step: &MotionRow) -> Option<Primitive> {
        let [x, y] = self.across;
        let turn = |by: [f64; 2]| Rotation3::new(by[0] * x + by[1] * y);
        let turned = |origin: Point, axis: Vector| {
            let turn = turn([step[0], step[1]]);
            let axis = (turn * axis).normalize();
            (self.pivot + turn * (origin - self.pivot) + step[2] * x + step[3] * y, axis)
        };
        match self.surface {
            Primitive::Plane { origin, normal } => {
                let turn = turn([step[0], step[1]]);
                let origin = self.pivot + turn * (origin - self.pivot) + step[2] * normal;
                Some(Primitive::Plane { origin, normal: (turn * normal).normalize() })
            }
            Primitive::Sphere { centre, radius } => {
                let new = bent(radius, step[3])?;
                let shift = Vector::new(step[0], step[1], step[2]);
                Some(Primitive::Sphere {
                    centre: centre + shift - (new - radius) * self.normal,
                    radius: new,
                })
            }
            Primitive::Cylinder { origin, axis, radius } => {
                let (origin, axis) = turned(origin, axis);
                let new = bent(radius, step[4])?;
                Some(Primitive::Cylinder {
                    origin: origin - (new - radius) * self.normal,
                    axis,
                    radius: new,
                })
            }
            Primitive::Cone { origin, axis, radius, angle } => {
                let (origin, axis) = turned(origin, axis);
                let new = bent(radius, step[4])?;
                let origin = origin - (new - radius) * self.out;
                cone(origin, axis, new, angle + step[5])
            }
            Primitive::Torus { centre, axis, major, minor } => {
                let shift = step[4] * axis;
                let (centre, axis) = turned(centre, axis);
                let new = bent(minor, step[6])?;
                // The tube follows its changed radius; the part across the axis is the major radius'.
                let back = (new - minor) * self.normal;
                let wide = major + step[5];
                let centre = centre + shift - step[5] * self.out - back;
                (wide > 0.0).then_some(Primitive::Torus { centre, axis, major: wide, minor: new })
            }
        }
    }
}

/// A cone whose radius grows along its axis, whatever the sign of the angle.
fn cone(origin: Point, axis: Vector, radius: f64, angle: f64) -> Option<Primitive> {
    let axis = if angle < 0.0 { -axis } else { axis };
    let angle = angle.abs();
    let is_one = angle > 0.0 && angle < std::f64::consts::FRAC_PI_2 && radius > 0.0;
    is_one.then_some(Primitive::Cone { origin, axis, radius, angle })
}

/// A radius whose curvature is changed as a small growth of the radius would change it. `None` if the
/// curvature becomes zero or changes its sign.
fn bent(radius: f64, growth: f64) -> Option<f64> {
    let share = 1.0 - growth / radius;
    (share > 0.0).then(|| radius / share).filter(|r| r.is_finite() && *r > 0.0)
}
