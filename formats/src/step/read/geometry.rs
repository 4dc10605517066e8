//! Reader of points, curves and surfaces (ISO 10303-42, clause 4) in the unit of the file.

use std::collections::HashMap;
use std::sync::Arc;

use super::attributes::Attributes;
use super::exchange::Exchange;
use crate::Result;
use crate::brep::Frame;
use crate::cad::{CadCurve, CadSurface, CurveShape};
use crate::spline::SplineCurve;

/// The largest depth of curves that consist of other curves, and of surfaces that consist of other
/// surfaces.
const MAX_DEPTH: usize = 8;

/// Reads geometry. A surface or a curve that is used several times is read once.
pub(super) struct StepGeometry<'f, 'a> {
    pub(super) file: &'f Exchange<'a>,
    /// The unit of angles in radians.
    angle: f64,
    surfaces: HashMap<u64, Arc<CadSurface>>,
}

impl<'f, 'a> StepGeometry<'f, 'a> {
    pub(super) fn new(file: &'f Exchange<'a>, angle: f64) -> Self {
        StepGeometry { file, angle, surfaces: HashMap::new() }
    }

    pub(super) fn point<const D: usize>(&self, id: u64) -> Result<[f64; D]> {
        self.coordinates(id, "CARTESIAN_POINT")
    }

    fn coordinates<const D: usize>(&self, id: u64, kind: &str) -> Result<[f64; D]> {
        let mut attributes = self.file.of_type(id, kind)?;
        attributes.skip(1)?;
        let reals = attributes.reals()?;
        let found = reals.len();
        <[f64; D]>::try_from(reals)
            .map_err(|_| self.file.error(id, format!("has {found} coordinates instead of {D}")))
    }

    fn direction<const D: usize>(&self, id: u64) -> Result<[f64; D]> {
        let d: [f64; D] = self.coordinates(id, "DIRECTION")?;
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length.is_finite() && length > 0.0 {
            return Ok(d.map(|x| x / length));
        }
        Err(self.file.error(id, "is a direction without a length"))
    }

    fn vector<const D: usize>(&self, id: u64) -> Result<[f64; D]> {
        let mut attributes = self.file.of_type(id, "VECTOR")?;
        attributes.skip(1)?;
        let direction: [f64; D] = self.direction(attributes.reference()?)?;
        let length = attributes.real()?;
        Ok(direction.map(|x| x * length))
    }

    fn frame(&self, id: u64) -> Result<Frame> {
        let mut attributes = self.file.of_type(id, "AXIS2_PLACEMENT_3D")?;
        attributes.skip(1)?;
        let origin = self.point(attributes.reference()?)?;
        let z: [f64; 3] = match attributes.option()? {
            Some(id) => self.direction(id)?,
            None => [0.0, 0.0, 1.0],
        };
        let frame = match attributes.option()? {
            Some(id) => Frame::new(origin, z, self.direction(id)?),
            None => Frame::along(origin, z),
        };
        frame.map_err(|_| self.file.error(id, "has parallel axes"))
    }

    /// The origin and the axes x and y of a placement.
    fn flat_frame<const D: usize>(&self, id: u64) -> Result<[[f64; D]; 3]> {
        let mut frame = [[0.0; D]; 3];
        if D == 3 {
            let placed = self.frame(id)?;
            let [origin, x, y] = [placed.origin(), placed.x(), placed.y()];
            [origin, x, y].iter().zip(&mut frame).for_each(|(from, to)| to.copy_from_slice(from));
            return Ok(frame);
        }
        let mut attributes = self.file.of_type(id, "AXIS2_PLACEMENT_2D")?;
        attributes.skip(1)?;
        frame[0] = self.point(attributes.reference()?)?;
        frame[1][0] = 1.0;
        if let Some(id) = attributes.option()? {
            frame[1] = self.direction(id)?;
        }
        frame[2][0] = -frame[1][1];
        frame[2][1] = frame[1][0];
        Ok(frame)
    }

    /// A curve in space or in a parameter plane.
    pub(super) fn curve<const D: usize>(&self, id: u64) -> Result<CadCurve<D>> {
        self.curve_at(id, 0)
    }

    fn curve_at<const D: usize>(&self, id: u64, depth: usize) -> Result<CadCurve<D>> {
        if self.file.entity(id)?.records.len() > 1 {
            return self.spline(id);
        }
        let (kind, mut attributes) = self.file.simple(id)?;
        let whole = |shape| CadCurve { shape, range: None };
        match kind {
            "B_SPLINE_CURVE_WITH_KNOTS" => self.spline(id),
            "POLYLINE" => {
                attributes.skip(1)?;
                let points = attributes.references()?;
                self.file.spend(id, points.len())?;
                let points = points.into_iter().map(|p| self.point(p)).collect::<Result<_>>()?;
                let spline = SplineCurve::polyline(points);
                spline.map(CurveShape::Spline).map(whole).map_err(|e| self.file.error(id, e))
            }
            "LINE" => {
                attributes.skip(1)?;
                let origin = self.point(attributes.reference()?)?;
                let direction = self.vector(attributes.reference()?)?;
                Ok(whole(CurveShape::Line { origin, direction }))
            }
            "CIRCLE" | "ELLIPSE" => {
                attributes.skip(1)?;
                let [centre, x, y] = self.flat_frame(attributes.reference()?)?;
                let a = attributes.real()?;
                let b = if kind == "ELLIPSE" { attributes.real()? } else { a };
                let shape =
                    CurveShape::Ellipse { centre, x: x.map(|e| a * e), y: y.map(|e| b * e) };
                Ok(whole(shape))
            }
            "TRIMMED_CURVE" if depth < MAX_DEPTH => {
                attributes.skip(1)?;
                // The end points of the edge that uses it define the part.
                self.curve_at(attributes.reference()?, depth + 1)
            }
            other => {
                Err(self.file.unread(id, format!("is a curve of an unsupported kind: {other}")))
            }
        }
    }

    pub(super) fn surface(&mut self, id: u64) -> Result<Arc<CadSurface>> {
        self.surface_at(id, 0)
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
        if kind == "B_SPLINE_SURFACE_WITH_KNOTS" {
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
            | "TOROIDAL_SURFACE" => {
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
                // The loops of the face bound it, and its parameters are those of the basis
                // surface.
                self.surface_at(attributes.reference()?, depth + 1).map(Arc::unwrap_or_clone)
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
                CadSurface::Torus { origin, x, y, z, major: radius, minor }
            }
        })
    }
}
