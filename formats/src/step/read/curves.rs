//! Reader of curves (ISO 10303-42, clause 4) in the unit of the file.

use super::attributes::Attributes;
use super::geometry::StepGeometry;
use super::value::Value;
use crate::Result;
use crate::cad::{CadCurve, CurveShape};
use crate::spline::SplineCurve;

/// The largest depth of curves that consist of other curves.
const MAX_DEPTH: usize = 8;

impl StepGeometry<'_, '_> {
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
            "B_SPLINE_CURVE_WITH_KNOTS"
            | "BEZIER_CURVE"
            | "UNIFORM_CURVE"
            | "QUASI_UNIFORM_CURVE" => self.spline(id),
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
            "CIRCLE" | "ELLIPSE" | "HYPERBOLA" | "PARABOLA" => {
                attributes.skip(1)?;
                self.conic(kind, &mut attributes).map(whole)
            }
            "TRIMMED_CURVE" if depth < MAX_DEPTH => {
                attributes.skip(1)?;
                let basis = self.curve_at(attributes.reference()?, depth + 1)?;
                self.trimmed(basis, &mut attributes)
            }
            "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE" if depth < MAX_DEPTH => {
                attributes.skip(1)?;
                self.curve_at(attributes.reference()?, depth + 1)
            }
            other => {
                Err(self.file.unread(id, format!("is a curve of an unsupported kind: {other}")))
            }
        }
    }

    fn conic<const D: usize>(
        &self,
        kind: &str,
        attributes: &mut Attributes,
    ) -> Result<CurveShape<D>> {
        let [centre, x, y] = self.flat_frame(attributes.reference()?)?;
        let a = attributes.real()?;
        let scaled = |axis: [f64; D], by: f64| axis.map(|e| by * e);
        Ok(match kind {
            "CIRCLE" => CurveShape::Ellipse { centre, x: scaled(x, a), y: scaled(y, a) },
            "PARABOLA" => {
                CurveShape::Parabola { vertex: centre, x: scaled(x, a), y: scaled(y, 2.0 * a) }
            }
            _ => {
                let (x, y) = (scaled(x, a), scaled(y, attributes.real()?));
                match kind {
                    "ELLIPSE" => CurveShape::Ellipse { centre, x, y },
                    _ => CurveShape::Hyperbola { centre, x, y },
                }
            }
        })
    }

    /// A part of a curve. The ends of the edge that uses it count more than its own.
    fn trimmed<const D: usize>(
        &self,
        basis: CadCurve<D>,
        attributes: &mut Attributes,
    ) -> Result<CadCurve<D>> {
        let unit = match basis.shape {
            CurveShape::Ellipse { .. } => self.angle,
            _ => 1.0,
        };
        let [mut from, mut to] =
            [self.trim(&basis.shape, attributes)?, self.trim(&basis.shape, attributes)?];
        if !attributes.logical()? {
            (from, to) = (to, from);
        }
        let CadCurve { shape, .. } = basis;
        let range = from.zip(to).map(|(from, to)| {
            let (from, mut to) = (from.in_unit(unit), to.in_unit(unit));
            if matches!(shape, CurveShape::Ellipse { .. }) && to <= from {
                to +=
                    std::f64::consts::TAU * ((from - to) / std::f64::consts::TAU).floor().max(0.0);
                to += if to <= from { std::f64::consts::TAU } else { 0.0 };
            }
            (from, to)
        });
        let range = range.filter(|(from, to)| from < to);
        Ok(CadCurve { shape, range })
    }

    /// One end of a trimmed curve: a parameter, or a point that is converted to one. `None` if it is a point of a
    /// spline.
    fn trim<const D: usize>(
        &self,
        shape: &CurveShape<D>,
        attributes: &mut Attributes,
    ) -> Result<Option<TrimEnd>> {
        let mut found = None;
        for value in attributes.values()? {
            match value {
                Value::Reference(point) if found.is_none() => {
                    found = parameter(shape, self.point(point)?).map(TrimEnd::Ours);
                }
                Value::Typed(value) => match *value {
                    Value::Real(t) => found = Some(TrimEnd::File(t)),
                    Value::Integer(t) => found = Some(TrimEnd::File(t as f64)),
                    _ => {}
                },
                _ => {}
            }
        }
        Ok(found)
    }
}

/// The parameter of an end of a trimmed curve.
enum TrimEnd {
    /// In the unit of the file.
    File(f64),
    /// In radians, if it is an angle.
    Ours(f64),
}

impl TrimEnd {
    fn in_unit(&self, unit: f64) -> f64 {
        match self {
            TrimEnd::File(t) => t * unit,
            TrimEnd::Ours(t) => *t,
        }
    }
}

/// The parameter of a point of a line or a conic.
fn parameter<const D: usize>(shape: &CurveShape<D>, p: [f64; D]) -> Option<f64> {
    let along = |origin: &[f64; D], axis: &[f64; D]| {
        let dot = |a: &[f64; D]| a.iter().zip(axis).map(|(a, b)| a * b).sum::<f64>();
        (dot(&p) - dot(origin)) / dot(axis)
    };
    match shape {
        CurveShape::Line { origin, direction } => Some(along(origin, direction)),
        CurveShape::Ellipse { centre, x, y } => Some(along(centre, y).atan2(along(centre, x))),
        CurveShape::Hyperbola { centre, y, .. } => Some(along(centre, y).asinh()),
        CurveShape::Parabola { vertex, y, .. } => Some(along(vertex, y)),
        CurveShape::Spline(_) => None,
    }
}
