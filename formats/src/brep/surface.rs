//! The surfaces of faces: points, derivatives and ranges. The parametrisations are those of ISO
//! 10303-42.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::Frame;
use crate::cad::affine::{cross, dot, unit};
use crate::spline::{SplineCurve, SplineSurface};

/// The surface of a face. O, X, Y and Z are the origin and the axes of its frame. Angles are in
/// radians.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum BrepSurface {
    /// A B-spline surface, rational or not.
    Spline(SplineSurface),
    /// The plane O + u X + v Y.
    Plane {
        /// The frame.
        frame: Frame,
    },
    /// The cylinder O + R (cos u X + sin u Y) + v Z.
    Cylinder {
        /// The frame. Its z axis is that of the cylinder.
        frame: Frame,
        /// R in mm.
        radius: f64,
    },
    /// The cone O + (R + v tan α) (cos u X + sin u Y) + v Z. It widens along z. Its faces are on
    /// the side of the apex where R + v tan α is positive.
    Cone {
        /// The frame. Its z axis is that of the cone.
        frame: Frame,
        /// R, the radius at v = 0 in mm. It may be 0.
        radius: f64,
        /// α, the angle between the axis and the cone, between 0 and π/2.
        half_angle: f64,
    },
    /// The sphere O + R cos v (cos u X + sin u Y) + R sin v Z.
    Sphere {
        /// The frame. Its origin is the centre, and the poles are on its z axis.
        frame: Frame,
        /// R in mm.
        radius: f64,
    },
    /// The torus O + (R + r cos v) (cos u X + sin u Y) + r sin v Z. Where r is larger than R, it crosses itself on its axis, and
    /// faces lie on the outer part.
    Torus {
        /// The frame. Its origin is the centre, and its z axis is the axis.
        frame: Frame,
        /// R, the radius of the circle around which the tube runs, in mm.
        major: f64,
        /// r, the radius of the tube in mm.
        minor: f64,
    },
    /// The surface of linear extrusion C(u) + v D.
    Extrusion {
        /// The curve C.
        profile: SplineCurve<3>,
        /// The unit vector D.
        direction: [f64; 3],
    },
    /// The surface of revolution: C(v) turned by u about an axis.
    Revolution {
        /// The curve C.
        profile: SplineCurve<3>,
        /// A point of the axis.
        origin: [f64; 3],
        /// The direction of the axis, a unit vector.
        axis: [f64; 3],
    },
}

/// The largest error of the length of a unit vector. Components that were rounded to decimal digits
/// have errors of this size.
const UNIT: f64 = 1e-12;

impl BrepSurface {
    /// The plane of x and y of a frame.
    pub fn plane(frame: Frame) -> Self {
        BrepSurface::Plane { frame }
    }

    /// The cylinder about the z axis of a frame, with its radius in mm.
    pub fn cylinder(frame: Frame, radius: f64) -> Self {
        BrepSurface::Cylinder { frame, radius }
    }

    /// The cone about the z axis of a frame, with its radius at the origin in mm and the angle
    /// between axis and cone in radians.
    pub fn cone(frame: Frame, radius: f64, half_angle: f64) -> Self {
        BrepSurface::Cone { frame, radius, half_angle }
    }

    /// The sphere about the origin of a frame, with its radius in mm.
    pub fn sphere(frame: Frame, radius: f64) -> Self {
        BrepSurface::Sphere { frame, radius }
    }

    /// The torus about the z axis of a frame, with the radii of its circle and of its tube in mm.
    pub fn torus(frame: Frame, major: f64, minor: f64) -> Self {
        BrepSurface::Torus { frame, major, minor }
    }

    /// The surface of linear extrusion of a curve. The direction may have any length.
    ///
    /// # Errors
    /// The direction has no length.
    pub fn extrusion(profile: SplineCurve<3>, direction: [f64; 3]) -> Result<Self, String> {
        let direction = unit(direction).ok_or("an extrusion without a direction")?;
        Ok(BrepSurface::Extrusion { profile, direction })
    }

    /// The surface of revolution of a curve about an axis, which is given by a point and a
    /// direction of any length.
    ///
    /// # Errors
    /// The direction has no length.
    pub fn revolution(
        profile: SplineCurve<3>,
        origin: [f64; 3],
        axis: [f64; 3],
    ) -> Result<Self, String> {
        let axis = unit(axis).ok_or("a revolution without an axis")?;
        Ok(BrepSurface::Revolution { profile, origin, axis })
    }

    /// The point at (u, v). B-splines clamp their parameters to their ranges.
    pub fn point(&self, u: f64, v: f64) -> [f64; 3] {
        match self {
            BrepSurface::Spline(spline) => spline.point(u, v),
            _ => self.tangents(u, v)[0],
        }
    }

    /// The point at (u, v) and the derivatives in u and in v.
    pub fn tangents(&self, u: f64, v: f64) -> [[f64; 3]; 3] {
        match self {
            BrepSurface::Spline(spline) => spline.tangents(u, v),
            BrepSurface::Plane { frame } => [frame.point([u, v, 0.0]), frame.x(), frame.y()],
            BrepSurface::Cylinder { frame, radius } => turned(frame, u, [*radius, v], [0.0, 1.0]),
            BrepSurface::Cone { frame, radius, half_angle } => {
                let slope = half_angle.tan();
                turned(frame, u, [radius + v * slope, v], [slope, 1.0])
            }
            BrepSurface::Sphere { frame, radius } => {
                let [x, z] = [v.cos(), v.sin()].map(|e| radius * e);
                turned(frame, u, [x, z], [-z, x])
            }
            BrepSurface::Torus { frame, major, minor } => {
                let [x, z] = [v.cos(), v.sin()].map(|e| minor * e);
                turned(frame, u, [major + x, z], [-z, x])
            }
            BrepSurface::Extrusion { profile, direction } => {
                let start = profile.point(u);
                [[0, 1, 2].map(|i| start[i] + v * direction[i]), profile.speed(u), *direction]
            }
            BrepSurface::Revolution { profile, origin, axis } => {
                let from = |p: [f64; 3]| [0, 1, 2].map(|i| p[i] - origin[i]);
                let [at, around] = revolved(from(profile.point(v)), *axis, u);
                let [along, _] = revolved(profile.speed(v), *axis, u);
                [[0, 1, 2].map(|i| origin[i] + at[i]), around, along]
            }
        }
    }

    /// The unit normal, which has the direction of Sᵤ × Sᵥ. `None` at a pole or an apex.
    pub fn normal(&self, u: f64, v: f64) -> Option<[f64; 3]> {
        let [_, su, sv] = self.tangents(u, v);
        unit(cross(su, sv))
    }

    /// The ranges of u and v. They are infinite where the surface is unbounded or periodic.
    pub fn ranges(&self) -> [(f64, f64); 2] {
        const ENDLESS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        match self {
            BrepSurface::Spline(spline) => [spline.u().range(), spline.v().range()],
            BrepSurface::Plane { .. } | BrepSurface::Cylinder { .. } => [ENDLESS; 2],
            BrepSurface::Torus { .. } => [ENDLESS; 2],
            BrepSurface::Cone { radius, half_angle, .. } => {
                [ENDLESS, (-radius / half_angle.tan(), f64::INFINITY)]
            }
            BrepSurface::Sphere { .. } => [ENDLESS, (-FRAC_PI_2, FRAC_PI_2)],
            BrepSurface::Extrusion { profile, .. } => [profile.knots().range(), ENDLESS],
            BrepSurface::Revolution { profile, .. } => [ENDLESS, profile.knots().range()],
        }
    }

    /// The periods in u and in v.
    pub fn periods(&self) -> [Option<f64>; 2] {
        match self {
            BrepSurface::Spline(_) | BrepSurface::Plane { .. } => [None; 2],
            BrepSurface::Extrusion { .. } => [None; 2],
            BrepSurface::Cylinder { .. } | BrepSurface::Cone { .. } => [Some(TAU), None],
            BrepSurface::Sphere { .. } | BrepSurface::Revolution { .. } => [Some(TAU), None],
            BrepSurface::Torus { .. } => [Some(TAU); 2],
        }
    }

    /// The parameters between which the surface is smooth in u and in v. They are empty where it is
    /// smooth everywhere.
    pub(crate) fn breaks(&self) -> [Vec<f64>; 2] {
        match self {
            BrepSurface::Spline(spline) => [spline.u().breaks(), spline.v().breaks()],
            BrepSurface::Extrusion { profile, .. } => [profile.knots().breaks(), Vec::new()],
            BrepSurface::Revolution { profile, .. } => [Vec::new(), profile.knots().breaks()],
            _ => [Vec::new(), Vec::new()],
        }
    }

    /// Whether u and v are angles.
    pub(crate) fn angles(&self) -> [bool; 2] {
        let [around, _] = self.periods().map(|period| period.is_some());
        [around, matches!(self, BrepSurface::Sphere { .. } | BrepSurface::Torus { .. })]
    }

    /// The B-spline surface, if it is one.
    pub fn spline(&self) -> Option<&SplineSurface> {
        match self {
            BrepSurface::Spline(spline) => Some(spline),
            _ => None,
        }
    }

    /// Whether a B-spline in the surface is rational.
    pub(crate) fn is_rational(&self) -> bool {
        match self {
            BrepSurface::Spline(spline) => spline.weights().is_some(),
            BrepSurface::Extrusion { profile, .. } | BrepSurface::Revolution { profile, .. } => {
                profile.weights().is_some()
            }
            _ => false,
        }
    }

    /// The reason why the measures of the surface are not valid, if there is one.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let is_unit = |d: &[f64; 3]| (dot(*d, *d).sqrt() - 1.0).abs() <= UNIT;
        let (is_valid, fault) = match self {
            BrepSurface::Spline(_) | BrepSurface::Plane { .. } => (true, ""),
            BrepSurface::Cylinder { radius, .. } | BrepSurface::Sphere { radius, .. } => {
                (positive(*radius), "its radius is not positive")
            }
            BrepSurface::Cone { radius, half_angle, .. } => (
                (*radius == 0.0 || positive(*radius))
                    && *half_angle > 0.0
                    && *half_angle < FRAC_PI_2,
                "its radius is negative, or its half angle is not between 0 and π/2",
            ),
            BrepSurface::Torus { major, minor, .. } => (
                positive(*minor) && positive(*major),
                "the radius of its tube or that of its circle is not positive",
            ),
            BrepSurface::Extrusion { direction, .. } => {
                (is_unit(direction), "its direction is not a unit vector")
            }
            BrepSurface::Revolution { origin, axis, .. } => (
                is_unit(axis) && origin.iter().all(|x| x.is_finite()),
                "its axis is not a unit vector, or the point of the axis is not finite",
            ),
        };
        (!is_valid).then_some(fault)
    }

    /// The surface moved by a vector.
    #[must_use]
    pub fn translated(self, by: [f64; 3]) -> Self {
        let moved = |p: [f64; 3]| [0, 1, 2].map(|i| p[i] + by[i]);
        let there = |frame: Frame| frame.at(moved(frame.origin()));
        match self {
            BrepSurface::Spline(spline) => BrepSurface::Spline(spline.mapped(moved)),
            BrepSurface::Plane { frame } => BrepSurface::plane(there(frame)),
            BrepSurface::Cylinder { frame, radius } => BrepSurface::cylinder(there(frame), radius),
            BrepSurface::Cone { frame, radius, half_angle } => {
                BrepSurface::cone(there(frame), radius, half_angle)
            }
            BrepSurface::Sphere { frame, radius } => BrepSurface::sphere(there(frame), radius),
            BrepSurface::Torus { frame, major, minor } => {
                BrepSurface::torus(there(frame), major, minor)
            }
            BrepSurface::Extrusion { profile, direction } => {
                BrepSurface::Extrusion { profile: profile.mapped(moved), direction }
            }
            BrepSurface::Revolution { profile, origin, axis } => BrepSurface::Revolution {
                profile: profile.mapped(moved),
                origin: moved(origin),
                axis,
            },
        }
    }
}

/// The point and the derivatives of a surface of revolution about the z axis of a frame, from the
/// radius and the height of its meridian and their derivatives.
fn turned(
    frame: &Frame,
    u: f64,
    [radius, height]: [f64; 2],
    [widens, rises]: [f64; 2],
) -> [[f64; 3]; 3] {
    let (sin, cos) = u.sin_cos();
    [
        frame.point([radius * cos, radius * sin, height]),
        frame.vector([-radius * sin, radius * cos, 0.0]),
        frame.vector([widens * cos, widens * sin, rises]),
    ]
}

/// A vector turned by an angle about a direction, and its derivative in the angle.
fn revolved(vector: [f64; 3], axis: [f64; 3], angle: f64) -> [[f64; 3]; 2] {
    let (sin, cos) = angle.sin_cos();
    let along = dot(vector, axis);
    let out = [0, 1, 2].map(|i| vector[i] - along * axis[i]);
    let across = cross(axis, out);
    [
        [0, 1, 2].map(|i| along * axis[i] + cos * out[i] + sin * across[i]),
        [0, 1, 2].map(|i| cos * across[i] - sin * out[i]),
    ]
}
