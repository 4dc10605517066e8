//! Bounding boxes of curves and of shells.

use std::f64::consts::{PI, TAU};

use super::{BoundedCurve, Brep, BrepSurface, EllipseArc, Face, Frame, PCurve, ShellId};
use crate::cad::affine::dot;

/// A bounding box: its lowest and its highest coordinates.
type CoordinateBox<const D: usize> = [[f64; D]; 2];

impl Brep {
    /// A box around a shell: the bounding box of its edges and of its faces on curved surfaces. A
    /// face on a B-spline surface counts with its edges alone.
    pub(super) fn bounds(&self, shell: ShellId) -> CoordinateBox<3> {
        let mut bounds = self.edge_bounds(shell);
        for face in self.shells[shell.0].faces.iter().map(|id| &self.faces[id.0]) {
            add_surface(&mut bounds, &self.surfaces[face.surface.0], face);
        }
        bounds
    }

    /// The bounding box of a shell's edges. A B-spline counts with its poles.
    pub(super) fn edge_bounds(&self, shell: ShellId) -> CoordinateBox<3> {
        let mut bounds = nothing();
        let faces = self.shells[shell.0].faces.iter().map(|id| &self.faces[id.0]);
        for of_loop in faces.flat_map(|face| face.loops.iter().flatten()) {
            add_curve(&mut bounds, &self.edges[of_loop.edge.0].curve);
        }
        bounds
    }

    /// The bounding box of the pcurves of all faces on a surface.
    pub(crate) fn parameters_on(&self, surface: usize) -> CoordinateBox<2> {
        let mut bounds = nothing();
        for face in self.faces.iter().filter(|face| face.surface.0 == surface) {
            face.plane_bounds().iter().for_each(|corner| add(&mut bounds, corner));
        }
        bounds
    }

    /// The largest absolute coordinate of all vertices, edges that are arcs, and poles of surfaces.
    pub(crate) fn reach(&self) -> f64 {
        let arcs = self.edges.iter().filter(|edge| edge.curve.spline().is_none());
        let mut bounds = nothing();
        arcs.for_each(|edge| add_curve(&mut bounds, &edge.curve));
        let corners = bounds.iter().filter(|corner| corner[0].is_finite());
        let poles = self.surfaces.iter().flat_map(|surface| match surface {
            BrepSurface::Spline(spline) => spline.poles(),
            _ => &[],
        });
        let points = self.vertices.iter().chain(corners).chain(poles);
        points.flatten().fold(0.0, |reach, x| x.abs().max(reach))
    }
}

impl Face {
    /// The bounding box of the face's pcurves.
    pub(super) fn plane_bounds(&self) -> CoordinateBox<2> {
        let mut bounds = nothing();
        let uses = self.loops.iter().flatten();
        uses.for_each(|of_loop| add_curve::<2>(&mut bounds, &of_loop.pcurve as &PCurve));
        bounds
    }
}

fn nothing<const D: usize>() -> CoordinateBox<D> {
    [[f64::INFINITY; D], [f64::NEG_INFINITY; D]]
}

fn add<const D: usize>(bounds: &mut CoordinateBox<D>, point: &[f64; D]) {
    for k in 0..D {
        bounds[0][k] = bounds[0][k].min(point[k]);
        bounds[1][k] = bounds[1][k].max(point[k]);
    }
}

fn add_curve<const D: usize>(bounds: &mut CoordinateBox<D>, curve: &BoundedCurve<D>) {
    match curve {
        BoundedCurve::Spline(spline) => spline.poles().iter().for_each(|pole| add(bounds, pole)),
        BoundedCurve::Line(_) => curve.ends().iter().for_each(|end| add(bounds, end)),
        BoundedCurve::Ellipse(ellipse) => {
            curve.ends().iter().for_each(|end| add(bounds, end));
            let farthest = extremes(ellipse, curve.range());
            farthest.for_each(|t| add(bounds, &curve.point(t)));
        }
    }
}

/// The parameters within the range at which a coordinate of an ellipse is greatest or least.
fn extremes<const D: usize>(
    ellipse: &EllipseArc<D>,
    (start, end): (f64, f64),
) -> impl Iterator<Item = f64> {
    let ([x, y], [a, b]) = (ellipse.axes(), ellipse.radii());
    let greatest = move |k: usize| (b * y[k]).atan2(a * x[k]);
    let both = (0..D).map(greatest).flat_map(|t| [t, t + PI]);
    both.map(move |t| start + (t - start).rem_euclid(TAU)).filter(move |t| *t < end)
}

/// Adds the part of a curved surface that a face may cover.
fn add_surface(bounds: &mut CoordinateBox<3>, surface: &BrepSurface, face: &Face) {
    let [low, high] = face.plane_bounds();
    let mut circle = |frame: &Frame, radius: f64, height: f64| {
        let centre = frame.point([0.0, 0.0, height]);
        add_ring(bounds, centre, frame.z(), radius);
    };
    match surface {
        BrepSurface::Spline(_) | BrepSurface::Plane { .. } => {}
        BrepSurface::Cylinder { frame, radius } => {
            [low[1], high[1]].iter().for_each(|v| circle(frame, *radius, *v));
        }
        BrepSurface::Cone { frame, radius, half_angle } => {
            let at = |v: f64| radius + v * half_angle.tan();
            [low[1], high[1]].iter().for_each(|v| circle(frame, at(*v), *v));
        }
        BrepSurface::Sphere { frame, radius } => add_ball(bounds, frame.origin(), *radius),
        BrepSurface::Torus { frame, major, minor } => {
            [-minor, *minor].iter().for_each(|v| circle(frame, major + minor, *v));
        }
        BrepSurface::Extrusion { profile, direction } => {
            for (pole, v) in profile.poles().iter().flat_map(|p| [(p, low[1]), (p, high[1])]) {
                add(bounds, &[0, 1, 2].map(|i| pole[i] + v * direction[i]));
            }
        }
        BrepSurface::Revolution { profile, origin, axis } => {
            for pole in profile.poles() {
                let from = [0, 1, 2].map(|i| pole[i] - origin[i]);
                let height = dot(from, *axis);
                let out = (dot(from, from) - height * height).max(0.0).sqrt();
                let centre = [0, 1, 2].map(|i| origin[i] + height * axis[i]);
                add_ring(bounds, centre, *axis, out);
            }
        }
    }
}

fn add_ball(bounds: &mut CoordinateBox<3>, centre: [f64; 3], radius: f64) {
    add(bounds, &centre.map(|x| x - radius));
    add(bounds, &centre.map(|x| x + radius));
}

/// Adds a circle about an axis.
fn add_ring(bounds: &mut CoordinateBox<3>, centre: [f64; 3], axis: [f64; 3], radius: f64) {
    let wide = axis.map(|z| radius * (1.0 - z * z).max(0.0).sqrt());
    add(bounds, &[0, 1, 2].map(|i| centre[i] - wide[i]));
    add(bounds, &[0, 1, 2].map(|i| centre[i] + wide[i]));
}
