//! Reader of points, placements and transformations (ISO 10303-42, clause 4). Points are in the unit of the file.

use std::collections::HashMap;
use std::sync::Arc;

use super::exchange::Exchange;
use crate::Result;
use crate::brep::Frame;
use crate::cad::CadSurface;
use crate::cad::affine::{Affine, dot};

/// Reads geometry. A surface or a curve that is used several times is read once.
pub(super) struct StepGeometry<'f, 'a> {
    pub(super) file: &'f Exchange<'a>,
    /// The unit of angles in radians.
    pub(super) angle: f64,
    /// The unit of length in mm. Only operators are in mm.
    unit: f64,
    pub(super) surfaces: HashMap<u64, Arc<CadSurface>>,
}

impl<'f, 'a> StepGeometry<'f, 'a> {
    pub(super) fn new(file: &'f Exchange<'a>, angle: f64) -> Self {
        StepGeometry { file, angle, unit: 1.0, surfaces: HashMap::new() }
    }

    /// The same for a unit of length in mm.
    pub(super) fn scaled(self, unit: f64) -> Self {
        StepGeometry { unit, ..self }
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

    pub(super) fn direction<const D: usize>(&self, id: u64) -> Result<[f64; D]> {
        let d: [f64; D] = self.coordinates(id, "DIRECTION")?;
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length.is_finite() && length > 0.0 {
            return Ok(d.map(|x| x / length));
        }
        Err(self.file.error(id, "is a direction without a length"))
    }

    pub(super) fn vector<const D: usize>(&self, id: u64) -> Result<[f64; D]> {
        let mut attributes = self.file.of_type(id, "VECTOR")?;
        attributes.skip(1)?;
        let direction: [f64; D] = self.direction(attributes.reference()?)?;
        let length = attributes.real()?;
        Ok(direction.map(|x| x * length))
    }

    pub(super) fn frame(&self, id: u64) -> Result<Frame> {
        let mut attributes = self.file.of_type(id, "AXIS2_PLACEMENT_3D")?;
        attributes.skip(1)?;
        let origin = self.point(attributes.reference()?)?;
        let z: [f64; 3] = match attributes.option()? {
            Some(id) => self.direction(id)?,
            None => [0.0, 0.0, 1.0],
        };
        let frame = match attributes.option()? {
            Some(id) => Frame::new(origin, z, self.direction(id)?),
            None => without_x(origin, z),
        };
        frame.map_err(|_| self.file.error(id, "has parallel axes"))
    }

    /// The origin and the axes x and y of a placement.
    pub(super) fn flat_frame<const D: usize>(&self, id: u64) -> Result<[[f64; D]; 3]> {
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

    /// The map from the coordinates of a placement, or of a transformation, to those around it, in mm.
    pub(super) fn operator(&self, id: u64) -> Result<Affine> {
        let mut entity = self.file.entity(id)?;
        if entity.records.iter().any(|r| r.name == "AXIS2_PLACEMENT_3D") {
            let frame = self.frame(id)?;
            let origin = frame.origin().map(|x| self.unit * x);
            return Ok(Affine::to_axes(origin, [frame.x(), frame.y(), frame.z()]));
        }
        let name = "CARTESIAN_TRANSFORMATION_OPERATOR_3D";
        let Some(own) = self.file.part(&mut entity, name) else {
            let kind = entity.records.first().map_or("", |record| record.name);
            let what = format!("is a transformation of an unsupported kind: {kind}");
            return Err(self.file.unread(id, what));
        };
        let base = self.file.part(&mut entity, "CARTESIAN_TRANSFORMATION_OPERATOR");
        let (mut own, mut base) = (own, base);
        if base.is_none() {
            // Its names come first: one, or three if it also has those of a transformation.
            own.skip(own.count_left().saturating_sub(OPERATOR))?;
        }
        let from = base.as_mut().unwrap_or(&mut own);
        let axes = [from.option()?, from.option()?];
        let origin: [f64; 3] = self.point(from.reference()?)?;
        let scale = from.optional_real()?.unwrap_or(1.0);
        let third = own.option()?;
        let axis = |id: Option<u64>| id.map(|id| self.direction::<3>(id)).transpose();
        let [x, y, z] = [axis(axes[0])?, axis(axes[1])?, axis(third)?];
        let bad = || self.file.error(id, "is a transformation without proper axes");
        let z = z.unwrap_or([0.0, 0.0, 1.0]);
        let origin = origin.map(|x| self.unit * x);
        let frame = match x {
            Some(x) => Frame::new(origin, z, x),
            None => without_x(origin, z),
        };
        let frame = frame.map_err(|_| bad())?;
        // The second axis tells whether the transformation mirrors.
        let mirrors = y.is_some_and(|y| dot(y, frame.y()) < 0.0);
        let y = if mirrors { frame.y().map(|e| -e) } else { frame.y() };
        if !(scale.is_finite() && scale > 0.0) {
            return Err(bad());
        }
        let axes = Affine::to_axes(origin.map(|x| x / scale), [frame.x(), y, frame.z()]);
        Ok(Affine { scale, ..axes })
    }
}

/// The number of attributes of a transformation operator after its names.
const OPERATOR: usize = 5;

/// The frame whose direction of x the file omits: that of the coordinates, at right angles to z (ISO 10303-42,
/// `first_proj_axis`).
fn without_x(origin: [f64; 3], z: [f64; 3]) -> std::result::Result<Frame, String> {
    Frame::new(origin, z, [1.0, 0.0, 0.0]).or_else(|_| Frame::new(origin, z, [0.0, 1.0, 0.0]))
}
