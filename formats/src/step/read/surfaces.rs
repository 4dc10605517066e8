//! Reader of surfaces (ISO 10303-42, clause 4) in the unit of the file.

use std::sync::Arc;

use super::attributes::Attributes;
use super::geometry::StepGeometry;
use crate::Result;
use crate::brep::Frame;
use crate::cad::{CadCurve, CadSurface, CurveShape};

/// The largest depth of surfaces that consist of other surfaces.
const MAX_DEPTH: usize = 8;

impl StepGeometry<'_, '_> {
    pub(super) fn surface(&mut self, id: u64) -> Result<Arc<CadSurface>> {
        self.surface_at(id, 0)
    }

    /// The surface that rectangular trimmed surfaces are parts of. The loops of the face bound it, and its
    /// parameters are those of the basis surface.
    pub(super) fn basis(&self, mut id: u64) -> Result<u64> {
        let name = "RECTANGULAR_TRIMMED_SURFACE";
        for _ in 0..MAX_DEPTH {
            if !self.file.is_a(id, name) {
                return Ok(id);
            }
            let mut attributes = self.file.of_type(id, name)?;
            attributes.skip(1)?;
            id = attributes.reference()?;
        }
        Err(self.file.error(id, "is a surface that is nested too deeply"))
    }

    fn surface_at(&mut self, id: u64, depth: usize) -> Result<Arc<CadSurface>> {
        if let Some(known) = self.surfaces.get(&id) {
            return Ok(known.clone());
        }
        let surface = if self.file.entity(id)?.records.len() > 1 {
            self.spline_surface(id)?
        } else {
            self.other_surface(id, depth)?
        };
        let surface = Arc::new(surface);
        self.surfaces.insert(id, surface.clone());
        Ok(surface)
    }

    fn other_surface(&mut self, id: u64, depth: usize) -> Result<CadSurface> {
        let (kind, mut attributes) = self.file.simple(id)?;
        if matches!(
            kind,
            "B_SPLINE_SURFACE_WITH_KNOTS"
                | "BEZIER_SURFACE"
                | "UNIFORM_SURFACE"
                | "QUASI_UNIFORM_SURFACE"
        ) {
            return self.spline_surface(id);
        }
        attributes.skip(1)?;
        match kind {
            "PLANE" => {
                let frame = self.frame(attributes.reference()?)?;
                let (origin, x, y) = (frame.origin(), frame.x(), frame.y());
                Ok(CadSurface::Plane { origin, x, y })
            }
            "CYLINDRICAL_SURFACE"
            | "CONICAL_SURFACE"
            | "SPHERICAL_SURFACE"
            | "TOROIDAL_SURFACE"
            | "DEGENERATE_TOROIDAL_SURFACE" => {
                let frame = self.frame(attributes.reference()?)?;
                self.round(kind, &frame, attributes)
            }
            "SURFACE_OF_REVOLUTION" => {
                let curve = self.curve(attributes.reference()?)?;
                let mut placement =
                    self.file.of_type(attributes.reference()?, "AXIS1_PLACEMENT")?;
                placement.skip(1)?;
                let origin = self.point(placement.reference()?)?;
                let axis = match placement.option()? {
                    Some(id) => self.direction(id)?,
                    None => [0.0, 0.0, 1.0],
                };
                let angles = (f64::NEG_INFINITY, f64::INFINITY);
                Ok(CadSurface::Revolution { curve, origin, axis, angles })
            }
            "SURFACE_OF_LINEAR_EXTRUSION" => {
                let curve = self.curve(attributes.reference()?)?;
                let vector = self.vector(attributes.reference()?)?;
                Ok(CadSurface::Extrusion { curve, vector })
            }
            "OFFSET_SURFACE" if depth < MAX_DEPTH => {
                let base = self.surface_at(attributes.reference()?, depth + 1)?;
                Ok(CadSurface::Offset { base, distance: attributes.real()? })
            }
            "RECTANGULAR_TRIMMED_SURFACE" if depth < MAX_DEPTH => {
                let base = self.surface_at(attributes.reference()?, depth + 1)?;
                self.rectangle(base, &mut attributes)
            }
            "SURFACE_REPLICA" if depth < MAX_DEPTH => {
                let base = self.surface_at(attributes.reference()?, depth + 1)?;
                // The place of the replica is in the unit of the file here.
                let place =
                    StepGeometry::new(self.file, self.angle).operator(attributes.reference()?)?;
                Ok(place.surface((*base).clone()))
            }
            other => {
                Err(self.file.unread(id, format!("is a surface of an unsupported kind: {other}")))
            }
        }
    }

    /// A cylinder, a cone, a sphere or a torus.
    fn round(&self, kind: &str, frame: &Frame, mut attributes: Attributes) -> Result<CadSurface> {
        let (origin, [x, y, z]) = (frame.origin(), [frame.x(), frame.y(), frame.z()]);
        let mut measure = || {
            let found = attributes.real()?;
            let infinite = || self.file.error(attributes.id, "has a measure that is not finite");
            if found.is_finite() { Ok(found) } else { Err(infinite()) }
        };
        let radius = measure()?;
        let [a, b, c] = [x, y, z].map(|axis| axis.map(|e| radius * e));
        Ok(match kind {
            "CYLINDRICAL_SURFACE" => CadSurface::Cylinder { origin, x: a, y: b, z },
            "SPHERICAL_SURFACE" => CadSurface::Sphere { origin, x: a, y: b, z: c },
            "CONICAL_SURFACE" => {
                let slope = (self.angle * measure()?).tan();
                CadSurface::Cone { origin, x, y, z, radius, slope }
            }
            _ => {
                let minor = measure()?;
                let torus = CadSurface::Torus { origin, x, y, z, major: radius, minor };
                if kind == "TOROIDAL_SURFACE" || minor <= radius {
                    return Ok(torus);
                }
                // The outer part is an apple, the inner part a lemon.
                let meeting = (-radius / minor).acos();
                let is_outer = attributes.logical()?;
                let inner = (meeting, std::f64::consts::TAU - meeting);
                let v = if is_outer { (-meeting, meeting) } else { inner };
                CadSurface::Part { base: Arc::new(torus), u: ENDLESS, v }
            }
        })
    }

    /// A part of a surface between lines of constant parameters.
    fn rectangle(&self, base: Arc<CadSurface>, attributes: &mut Attributes) -> Result<CadSurface> {
        let is_angle = angles(&base);
        let angles = is_angle.map(|is_angle| if is_angle { self.angle } else { 1.0 });
        let mut range = |axis: usize| {
            let (a, b) = (attributes.real()?, attributes.real()?);
            Ok((angles[axis] * a, angles[axis] * b))
        };
        let ranges: [(f64, f64); 2] = [range(0)?, range(1)?];
        let senses = [attributes.logical()?, attributes.logical()?];
        let proper = |axis: usize| {
            let (a, b) = ranges[axis];
            let (a, b) = if senses[axis] { (a, b) } else { (b, a) };
            // Around a periodic surface the range may go over the end of the period.
            match b > a {
                true => (a, b),
                false if is_angle[axis] => (a, b + std::f64::consts::TAU),
                false => (b, a),
            }
        };
        let (u, v) = (proper(0), proper(1));
        Ok(CadSurface::Part { base, u, v })
    }
}

/// The range of a parameter that nothing bounds.
const ENDLESS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Whether u and v are angles.
fn angles(surface: &CadSurface) -> [bool; 2] {
    let of_curve = |curve: &CadCurve<3>| matches!(curve.shape, CurveShape::Ellipse { .. });
    match surface {
        CadSurface::Cylinder { .. } | CadSurface::Cone { .. } => [true, false],
        CadSurface::Sphere { .. } | CadSurface::Torus { .. } => [true; 2],
        CadSurface::Revolution { curve, .. } => [true, of_curve(curve)],
        CadSurface::Extrusion { curve, .. } => [of_curve(curve), false],
        CadSurface::Offset { base, .. } | CadSurface::Part { base, .. } => angles(base),
        CadSurface::Spline(_) | CadSurface::Plane { .. } => [false; 2],
    }
}
