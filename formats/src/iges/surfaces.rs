//! The surfaces of a file, and the parameters that pcurves have on them.

use std::borrow::Cow;
use std::f64::consts::TAU;

use super::entity::{EntityData, EntityStatus, Pointer};
use super::plan::Plan;
use crate::brep::{Brep, BrepSurface, Face, Frame};
use crate::spline::SplineCurve;

/// A surface of the file. Its parameters are those of the model, after a shift and a scaling, and in
/// reverse order if it is a surface of revolution.
pub(super) struct PlannedSurface {
    pub(super) pointer: Pointer,
    shift: [f64; 2],
    scale: [f64; 2],
    swapped: bool,
    /// Whether the normal is opposite to that of the model.
    turned: bool,
}

/// The degrees of a radian. The angles of the surfaces 192 to 198 are in degrees.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl PlannedSurface {
    fn new(pointer: Pointer, scale: [f64; 2]) -> Self {
        PlannedSurface { pointer, shift: [0.0; 2], scale, swapped: false, turned: false }
    }

    /// Whether the parameters are those of the model.
    pub(super) fn keeps_parameters(&self) -> bool {
        !self.swapped && self.scale == [1.0; 2] && self.shift == [0.0; 2]
    }

    /// The parameters in the file for those of the model.
    pub(super) fn parameters(&self, at: [f64; 2]) -> [f64; 2] {
        let [u, v] = [0, 1].map(|k| (at[k] - self.shift[k]) * self.scale[k]);
        if self.swapped { [v, u] } else { [u, v] }
    }

    /// Whether a face has the normal of the file's surface.
    pub(super) fn agrees(&self, face: &Face) -> bool {
        face.forward != self.turned
    }
}

impl<'a> Plan<'a> {
    /// Adds all surfaces.
    pub(super) fn surfaces(&mut self, brep: &'a Brep) -> Vec<PlannedSurface> {
        (0..brep.surfaces.len()).map(|number| self.surface(brep, number)).collect()
    }

    fn surface(&mut self, brep: &'a Brep, number: usize) -> PlannedSurface {
        match &brep.surfaces[number] {
            BrepSurface::Spline(spline) => {
                let body = EntityData::Surface(spline);
                PlannedSurface::new(self.add(EntityStatus::Part, body), [1.0; 2])
            }
            BrepSurface::Plane { frame } => self.elementary(190, frame, vec![], [1.0; 2]),
            BrepSurface::Cylinder { frame, radius } => {
                self.elementary(192, frame, vec![*radius], [DEGREES, 1.0])
            }
            BrepSurface::Cone { frame, radius, half_angle } => {
                let measures = vec![*radius, half_angle.to_degrees()];
                // OpenCASCADE takes v as the length along the cone, not along its axis. Other
                // importers compute their own pcurves from the curves in space.
                self.elementary(194, frame, measures, [DEGREES, half_angle.cos().recip()])
            }
            BrepSurface::Sphere { frame, radius } => {
                self.elementary(196, frame, vec![*radius], [DEGREES; 2])
            }
            BrepSurface::Torus { frame, major, minor } => {
                let planned =
                    self.elementary(198, frame, vec![*major, *minor], [-DEGREES, DEGREES]);
                PlannedSurface { shift: [TAU, 0.0], swapped: true, ..planned }
            }
            BrepSurface::Extrusion { profile, direction } => {
                self.extrusion(profile, *direction, brep.parameters_on(number))
            }
            BrepSurface::Revolution { profile, origin, axis } => {
                self.revolution(profile, (*origin, *axis), brep.parameters_on(number))
            }
        }
    }

    /// Adds a plane, a cylinder, a cone, a sphere or a torus.
    fn elementary(
        &mut self,
        number: u16,
        frame: &Frame,
        measures: Vec<f64>,
        scale: [f64; 2],
    ) -> PlannedSurface {
        let [origin, z, x] = self.frame(frame);
        let body = EntityData::Elementary { number, origin, z, x, measures };
        PlannedSurface::new(self.add(EntityStatus::Part, body), scale)
    }

    /// Adds a tabulated cylinder. It begins and ends where its faces do, and both of its parameters
    /// are over [0, 1].
    fn extrusion(
        &mut self,
        profile: &'a SplineCurve<3>,
        direction: [f64; 3],
        [low, high]: [[f64; 2]; 2],
    ) -> PlannedSurface {
        let moved = |v: f64| move |p: [f64; 3]| [0, 1, 2].map(|i| p[i] + v * direction[i]);
        let start = profile.clone().mapped(moved(low[1]));
        let end = moved(high[1])(profile.ends()[0]);
        let curve = self.add(EntityStatus::Part, EntityData::Curve(Cow::Owned(start)));
        let pointer = self.add(EntityStatus::Part, EntityData::Extrusion { curve, end });
        let (from, to) = profile.knots().range();
        let scale = [(to - from).recip(), (high[1] - low[1]).recip()];
        PlannedSurface { pointer, shift: [from, low[1]], scale, swapped: false, turned: false }
    }

    /// Adds a surface of revolution. Its first parameter is that of the curve, and its second one
    /// is the angle.
    fn revolution(
        &mut self,
        profile: &'a SplineCurve<3>,
        (origin, axis): ([f64; 3], [f64; 3]),
        [low, high]: [[f64; 2]; 2],
    ) -> PlannedSurface {
        let status = EntityStatus::Part;
        let end = [0, 1, 2].map(|i| origin[i] + axis[i]);
        let axis = self.add(status, EntityData::Line([origin, end]));
        let curve = self.add(status, EntityData::Curve(Cow::Borrowed(profile)));
        let body = EntityData::Revolution { axis, curve, angles: [low[0], high[0]] };
        let pointer = self.add(status, body);
        PlannedSurface { swapped: true, turned: true, ..PlannedSurface::new(pointer, [1.0; 2]) }
    }
}
