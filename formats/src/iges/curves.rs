//! The curves of a file: lines, arcs and B-splines, each in the direction of its use.

use std::borrow::Cow;

use super::entity::{EntityData, EntityStatus, Pointer};
use super::plan::Plan;
use super::surfaces::PlannedSurface;
use crate::brep::{BrepCurve, EllipseArc, Frame, PCurve};
use crate::cad::affine::cross;
use crate::spline::SplineCurve;

impl<'a> Plan<'a> {
    /// Adds a curve in space.
    pub(super) fn curve(&mut self, curve: &'a BrepCurve, forward: bool) -> Pointer {
        match curve {
            BrepCurve::Spline(spline) => {
                self.add(EntityStatus::Part, EntityData::Curve(along(spline, forward)))
            }
            BrepCurve::Line(_) => {
                let ends = directed(curve.ends(), forward);
                self.add(EntityStatus::Part, EntityData::Line(ends))
            }
            BrepCurve::Ellipse(ellipse) => {
                let [x, y] = ellipse.axes();
                let axes = [x, y, cross(x, y)];
                let status = EntityStatus::Part;
                self.arc(status, (ellipse, curve.range()), (axes, ellipse.centre()), forward)
            }
        }
    }

    /// Adds a curve in the parameter plane of a surface.
    pub(super) fn pcurve(
        &mut self,
        surface: &PlannedSurface,
        pcurve: &'a PCurve,
        forward: bool,
    ) -> Pointer {
        let status = EntityStatus::ParameterPlane;
        match pcurve {
            PCurve::Spline(spline) => {
                let spline = match surface.keeps_parameters() {
                    true => along(spline, forward),
                    false => {
                        let there = spline.clone().mapped(|at| surface.parameters(at));
                        Cow::Owned(along(&there, forward).into_owned())
                    }
                };
                self.add(status, EntityData::PCurve(spline))
            }
            PCurve::Line(_) => {
                let ends = pcurve.ends().map(|at| surface.parameters(at)).map(|[u, v]| [u, v, 0.0]);
                self.add(status, EntityData::Line(directed(ends, forward)))
            }
            // These occur on planes, which keep their parameters.
            PCurve::Ellipse(ellipse) => {
                let space = |[u, v]: [f64; 2]| [u, v, 0.0];
                let [x, y] = ellipse.axes().map(space);
                let centre = space(ellipse.centre());
                self.arc(status, (ellipse, pcurve.range()), ([x, y, cross(x, y)], centre), forward)
            }
        }
    }

    /// Adds an arc of a circle or of an ellipse, which the file has in a plane of its own and
    /// counter-clockwise.
    fn arc<const D: usize>(
        &mut self,
        status: EntityStatus,
        (ellipse, (start, end)): (&EllipseArc<D>, (f64, f64)),
        ([x, y, z], centre): ([[f64; 3]; 3], [f64; 3]),
        forward: bool,
    ) -> Pointer {
        let radii = ellipse.radii();
        let side = if forward { 1.0 } else { -1.0 };
        let at = |t: f64| [radii[0] * t.cos(), side * radii[1] * t.sin()];
        let whole = end - start == std::f64::consts::TAU;
        let ends = directed([at(start), if whole { at(start) } else { at(end) }], forward);
        let columns = [x, y.map(|e| side * e), z.map(|e| side * e), centre];
        let matrix = self.add(EntityStatus::Part, EntityData::Matrix(columns));
        let body = EntityData::Arc { centre: [0.0; 2], radii, ends };
        self.placed(status, body, Some(matrix))
    }

    /// Adds the origin and the axes z and x of a frame.
    pub(super) fn frame(&mut self, frame: &Frame) -> [Pointer; 3] {
        let status = EntityStatus::Part;
        [
            self.add(status, EntityData::Point(frame.origin())),
            self.add(status, EntityData::Direction(frame.z())),
            self.add(status, EntityData::Direction(frame.x())),
        ]
    }
}

fn directed<T>([from, to]: [T; 2], forward: bool) -> [T; 2] {
    if forward { [from, to] } else { [to, from] }
}

/// `curve` if `forward`, otherwise the curve in the opposite direction over the same range.
fn along<const D: usize>(curve: &SplineCurve<D>, forward: bool) -> Cow<'_, SplineCurve<D>> {
    if forward { Cow::Borrowed(curve) } else { Cow::Owned(curve.reversed()) }
}
