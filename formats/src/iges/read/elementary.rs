//! Reader of cylinders, cones, spheres, tori, surfaces of revolution, and their axes.

use super::geometry::IgesGeometry;
use super::parameters::Parameters;
use crate::Result;
use crate::cad::affine::{Affine, cross, dot, unit};
use crate::cad::{CadSurface, CurveShape};

impl IgesGeometry<'_> {
    /// A cylinder, a cone, a sphere or a torus.
    pub(super) fn round(&self, pointer: i64, kind: i64, mut p: Parameters) -> Result<CadSurface> {
        let mut measures = self.deck.parameters(pointer)?;
        // The measures are between the axis and the reference direction. The radius of a sphere is
        // before the axis.
        measures.skip(if kind == 196 { 1 } else { 2 });
        let measure = |p: &mut Parameters| {
            let found = p.real()?;
            let infinite = || self.deck.error(pointer, "has a measure that is not finite");
            if found.is_finite() { Ok(found) } else { Err(infinite()) }
        };
        let radius = measure(&mut measures)?;
        let between = match kind {
            192 => 1,
            196 => 0,
            _ => 2,
        };
        let (origin, [x, y, z]) = match kind {
            196 => self.frame_after(pointer, &mut p, 1)?,
            _ => self.frame(pointer, &mut p, between)?,
        };
        let [a, b, c] = [x, y, z].map(|axis| axis.map(|e| radius * e));
        Ok(match kind {
            192 => CadSurface::Cylinder { origin, x: a, y: b, z },
            196 => CadSurface::Sphere { origin, x: a, y: b, z: c },
            194 => {
                let slope = measure(&mut measures)?.to_radians().tan();
                CadSurface::Cone { origin, x, y, z, radius, slope }
            }
            _ => {
                let minor = measure(&mut measures)?;
                CadSurface::Torus { origin, x, y, z, major: radius, minor }
            }
        })
    }

    /// A surface of revolution: the axis, the curve that turns, and the angles.
    pub(super) fn revolution(&self, pointer: i64, mut p: Parameters) -> Result<CadSurface> {
        let (axis, generatrix) = (p.integer()?, p.integer()?);
        let angles = (p.real()?, p.real()?);
        let unplaced = Affine::scaling(1.0);
        let axis = self.place(axis, &unplaced)?.curve(self.curve(axis)?);
        let CurveShape::Line { origin, direction } = axis.shape else {
            return Err(self.deck.error(pointer, "has an axis that is no line"));
        };
        if angles.0.partial_cmp(&angles.1) != Some(std::cmp::Ordering::Less) {
            return Err(self.deck.error(pointer, "turns by no angle"));
        }
        let bad = || self.deck.error(pointer, "has an axis without a direction");
        let axis = unit(direction).ok_or_else(bad)?;
        let curve = self.place(generatrix, &unplaced)?.curve(self.curve(generatrix)?);
        Ok(CadSurface::Revolution { curve, origin, axis, angles })
    }

    /// The factor from the length along a cone to the length along its axis.
    pub(super) fn cosine(&self, pointer: i64) -> Result<f64> {
        let mut p = self.deck.parameters(pointer)?;
        p.skip(3);
        Ok(p.real()?.to_radians().cos())
    }

    /// The origin and the axes of a surface. The file has a point, the direction of z,
    /// other parameters `between`, and a direction for x.
    pub(super) fn frame(
        &self,
        pointer: i64,
        p: &mut Parameters,
        between: usize,
    ) -> Result<([f64; 3], [[f64; 3]; 3])> {
        let (origin, z) = (p.integer()?, p.integer()?);
        p.skip(between);
        self.axes(pointer, [origin, z, p.integer()?])
    }

    /// The origin and the axes of a sphere. The file has other parameters between the point and the
    /// direction of z.
    fn frame_after(
        &self,
        pointer: i64,
        p: &mut Parameters,
        between: usize,
    ) -> Result<([f64; 3], [[f64; 3]; 3])> {
        let origin = p.integer()?;
        p.skip(between);
        self.axes(pointer, [origin, p.integer()?, p.integer()?])
    }

    /// A point, and the axes from the directions of z and x.
    fn axes(
        &self,
        pointer: i64,
        [origin, z, towards]: [i64; 3],
    ) -> Result<([f64; 3], [[f64; 3]; 3])> {
        let origin = self.of_kind(origin, 116, "a point")?.point()?;
        let bad = || self.deck.error(pointer, "has no proper axes");
        let z = unit(self.of_kind(z, 123, "a direction")?.point()?).ok_or_else(bad)?;
        let towards = match towards {
            // The surface has no parametrization, so any direction is possible.
            0 if z[0].abs() < 0.9 => [1.0, 0.0, 0.0],
            0 => [0.0, 1.0, 0.0],
            towards => self.of_kind(towards, 123, "a direction")?.point()?,
        };
        let along = dot(towards, z);
        let x = unit([0, 1, 2].map(|i| towards[i] - along * z[i])).ok_or_else(bad)?;
        Ok((origin, [x, cross(z, x), z]))
    }
}
