//! Reader of curves and surfaces. Lengths are in millimetres.

use std::collections::HashMap;
use std::sync::Arc;

use super::deck::Deck;
use super::parameters::Parameters;
use super::shape::{arc, conic, flat, middle_normal, over_unit, turned};
use super::{polynomial, ruled};
use crate::Result;
use crate::cad::affine::{Affine, cross, dot, unit};
use crate::cad::{CadCurve, CadSurface, CurveShape};
use crate::spline::{MAX_DEGREE, SplineCurve, SplineKnots, SplineSurface};

/// The largest depth of entities that consist of other entities.
const MAX_DEPTH: usize = 8;

/// Reads geometry. A surface that is used several times is read once.
pub(super) struct IgesGeometry<'d> {
    pub(super) deck: &'d Deck<'d>,
    surfaces: HashMap<i64, (Affine, Arc<CadSurface>)>,
}

impl<'d> IgesGeometry<'d> {
    pub(super) fn new(deck: &'d Deck<'d>) -> Self {
        IgesGeometry { deck, surfaces: HashMap::new() }
    }

    /// The placement of an entity by its matrices, followed by `outer`.
    pub(super) fn place(&self, pointer: i64, outer: &Affine) -> Result<Affine> {
        let mut place = *outer;
        let mut matrices = Vec::new();
        let mut next = self.deck.entry(pointer)?.matrix;
        while next != 0 {
            if matrices.len() == MAX_DEPTH {
                return Err(self.deck.error(next, "is a matrix with too many nested matrices"));
            }
            matrices.push(self.matrix(next)?);
            next = self.deck.entry(next)?.matrix;
        }
        // The matrix of the entity is applied first, then the matrix of that matrix.
        matrices.iter().rev().for_each(|matrix| place = place.after(matrix));
        Ok(place)
    }

    fn matrix(&self, pointer: i64) -> Result<Affine> {
        let mut p = self.of_kind(pointer, 124, "a matrix")?;
        let mut matrix = Affine::scaling(1.0);
        for i in 0..3 {
            matrix.turn[i] = p.point()?;
            matrix.shift[i] = p.real()?;
        }
        let product = |i: usize, j: usize| dot(matrix.turn[i], matrix.turn[j]);
        let off = |i: usize, j: usize| (product(i, j) - f64::from(u8::from(i == j))).abs() > 1e-6;
        if (0..9).any(|k| off(k / 3, k % 3)) {
            return Err(self.deck.unread(pointer, "is a matrix that does not preserve lengths"));
        }
        Ok(matrix)
    }

    pub(super) fn of_kind(&self, pointer: i64, kind: i64, name: &str) -> Result<Parameters<'d>> {
        let found = self.deck.entry(pointer)?.kind;
        if found == kind {
            return self.deck.parameters(pointer);
        }
        Err(self
            .deck
            .error(pointer, format!("is of type {found} where {name} ({kind}) is expected")))
    }

    /// The curves in space that an entity consists of, in order.
    pub(super) fn curves(&self, pointer: i64, outer: &Affine) -> Result<Vec<Arc<CadCurve<3>>>> {
        let curves = self.pieces(pointer, outer, 0)?;
        Ok(curves.into_iter().map(Arc::new).collect())
    }

    /// The curves in a parameter plane that an entity consists of, in order.
    pub(super) fn pcurves(&self, pointer: i64) -> Result<Vec<Arc<CadCurve<2>>>> {
        // Parameters have no unit. Matrices place arcs, which the file has in planes of their own.
        let curves = self.pieces(pointer, &Affine::scaling(1.0), 0)?;
        Ok(curves.into_iter().map(|curve| Arc::new(flat(curve))).collect())
    }

    fn pieces(&self, pointer: i64, outer: &Affine, depth: usize) -> Result<Vec<CadCurve<3>>> {
        let place = self.place(pointer, outer)?;
        if self.deck.entry(pointer)?.kind != 102 {
            return Ok(vec![place.curve(self.curve(pointer)?)]);
        }
        if depth == MAX_DEPTH {
            return Err(self.deck.error(pointer, "is a composite curve that is nested too deeply"));
        }
        let mut p = self.deck.parameters(pointer)?;
        let count = p.count()?;
        let mut all = Vec::new();
        for part in p.several(count, Parameters::integer)? {
            all.extend(self.pieces(part, &place, depth + 1)?);
        }
        Ok(all)
    }

    /// One curve in its own coordinates.
    pub(super) fn curve(&self, pointer: i64) -> Result<CadCurve<3>> {
        let entry = self.deck.entry(pointer)?;
        let mut p = self.deck.parameters(pointer)?;
        match entry.kind {
            100 => arc(&mut p),
            104 => {
                let refused = "is no arc of a conic";
                conic(&mut p)?.ok_or_else(|| self.deck.error(pointer, refused))
            }
            106 if matches!(entry.form, 11..=13 | 63) => {
                let kind = p.integer()?;
                let count = p.count()?;
                let level = if kind == 1 { p.real()? } else { 0.0 };
                let points = p.several(count, |p| match kind {
                    1 => Ok([p.real()?, p.real()?, level]),
                    2 => p.point(),
                    // Every point has a vector.
                    _ => p.point().inspect(|_| p.skip(3)),
                })?;
                let spline = SplineCurve::polyline(points);
                let spline = spline.map_err(|e| self.deck.error(pointer, e))?;
                Ok(CadCurve { shape: CurveShape::Spline(spline), range: None })
            }
            110 if entry.form == 0 => {
                let (origin, end) = (p.point()?, p.point()?);
                let direction = [0, 1, 2].map(|i| end[i] - origin[i]);
                let shape = CurveShape::Line { origin, direction };
                Ok(CadCurve { shape, range: Some((0.0, 1.0)) })
            }
            112 => {
                let spline = polynomial::curve(&mut p)?.map_err(|e| self.deck.error(pointer, e))?;
                Ok(CadCurve { shape: CurveShape::Spline(spline), range: None })
            }
            126 => self.spline(pointer, p),
            kind => {
                let form = entry.form;
                let what = format!("is a curve of an unsupported type: {kind} form {form}");
                Err(self.deck.unread(pointer, what))
            }
        }
    }

    fn spline(&self, pointer: i64, mut p: Parameters) -> Result<CadCurve<3>> {
        let (count, degree) = (self.poles(pointer, &mut p)?, self.degree(pointer, &mut p)?);
        p.skip(4);
        let knots = p.several(count + degree + 1, Parameters::real)?;
        let weights = p.several(count, Parameters::real)?;
        let poles = p.several(count, Parameters::point)?;
        let range = (p.real()?, p.real()?);
        let spline = SplineCurve::new(degree, knots, poles, Some(weights));
        let spline = spline.map_err(|e| self.deck.error(pointer, e))?;
        let range = (range.0 < range.1).then_some(range);
        Ok(CadCurve { shape: CurveShape::Spline(spline), range })
    }

    /// A number of poles. The file has the index of the last one.
    fn poles(&self, pointer: i64, p: &mut Parameters) -> Result<usize> {
        let last = p.count()?;
        let count = last.checked_add(1).filter(|n| *n < usize::MAX / 4);
        count.ok_or_else(|| self.deck.error(pointer, "has too many poles"))
    }

    fn degree(&self, pointer: i64, p: &mut Parameters) -> Result<usize> {
        let degree = p.count()?;
        if degree <= MAX_DEGREE {
            return Ok(degree);
        }
        Err(self.deck.error(pointer, format!("degree {degree}")))
    }

    pub(super) fn surface(&mut self, pointer: i64, outer: &Affine) -> Result<Arc<CadSurface>> {
        let place = self.place(pointer, outer)?;
        match self.surfaces.get(&pointer) {
            Some((known, surface)) if *known == place => return Ok(surface.clone()),
            _ => {}
        }
        let surface = Arc::new(place.surface(self.plain_surface(pointer, 0)?));
        self.surfaces.insert(pointer, (place, surface.clone()));
        Ok(surface)
    }

    /// One surface in its own coordinates.
    fn plain_surface(&self, pointer: i64, depth: usize) -> Result<CadSurface> {
        let entry = self.deck.entry(pointer)?;
        let mut p = self.deck.parameters(pointer)?;
        match entry.kind {
            108 => self.plane(pointer, &mut p),
            114 => {
                let spline = polynomial::surface(&mut p)?;
                spline.map(CadSurface::Spline).map_err(|e| self.deck.error(pointer, e))
            }
            118 => self.ruled(pointer, entry.form, p),
            122 => self.tabulated(pointer, p),
            128 => self.spline_surface(pointer, p),
            140 if depth < MAX_DEPTH => {
                let (towards, distance) = (p.point()?, p.real()?);
                let base = p.integer()?;
                let base = self.plain_surface(base, depth + 1)?;
                let turned = middle_normal(&base).is_some_and(|n| dot(n, towards) < 0.0);
                let distance = if turned { -distance } else { distance };
                Ok(CadSurface::Offset { base: Arc::new(base), distance })
            }
            120 => self.revolution(pointer, p),
            190 => {
                let (origin, [x, y, _]) = self.frame(pointer, &mut p, 0)?;
                Ok(CadSurface::Plane { origin, x, y })
            }
            192 | 194 | 196 | 198 => self.round(pointer, entry.kind, p),
            kind => {
                let what = format!("is a surface of an unsupported type: {kind}");
                Err(self.deck.unread(pointer, what))
            }
        }
    }

    /// A plane that is given by the equation a x + b y + c z = d. Pcurves on it have no meaning,
    /// because it has no axes.
    fn plane(&self, pointer: i64, p: &mut Parameters) -> Result<CadSurface> {
        let (normal, d) = (p.point()?, p.real()?);
        let bad = || self.deck.error(pointer, "is a plane without a normal");
        let z = unit(normal).ok_or_else(bad)?;
        let away = d / dot(normal, normal).sqrt();
        let helper = if z[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let x = unit(cross(helper, z)).ok_or_else(bad)?;
        Ok(CadSurface::Plane { origin: z.map(|e| away * e), x, y: cross(z, x) })
    }

    /// A tabulated cylinder: a curve over [0, 1] that is extruded. The file has the point to which
    /// the start of the curve moves.
    fn tabulated(&self, pointer: i64, mut p: Parameters) -> Result<CadSurface> {
        let (directrix, end) = (p.integer()?, p.point()?);
        let place = self.place(directrix, &Affine::scaling(1.0))?;
        let curve = place.curve(self.curve(directrix)?);
        let (start, curve) = match curve.shape {
            CurveShape::Line { origin, .. } => (origin, curve),
            CurveShape::Spline(spline) => (spline.poles()[0], over_unit(spline)),
            CurveShape::Ellipse { centre, x, y } => {
                let t = curve.range.map_or(0.0, |r| r.0);
                let point = |i: usize| centre[i] + t.cos() * x[i] + t.sin() * y[i];
                ([0, 1, 2].map(point), curve)
            }
            CurveShape::Hyperbola { centre, x, y } => {
                let t = curve.range.map_or(0.0, |r| r.0);
                let point = |i: usize| centre[i] + t.cosh() * x[i] + t.sinh() * y[i];
                ([0, 1, 2].map(point), curve)
            }
            CurveShape::Parabola { vertex, x, y } => {
                let t = curve.range.map_or(0.0, |r| r.0);
                let point = |i: usize| vertex[i] + t * t * x[i] + t * y[i];
                ([0, 1, 2].map(point), curve)
            }
        };
        let vector = [0, 1, 2].map(|i| end[i] - start[i]);
        if unit(vector).is_none() {
            return Err(self.deck.error(pointer, "is a cylinder without a height"));
        }
        Ok(CadSurface::Extrusion { curve, vector })
    }

    /// A ruled surface. Form 0 joins places of equal shares of the lengths of both curves, which those of equal parameters
    /// are on lines. Form 1 joins places of equal parameters.
    fn ruled(&self, pointer: i64, form: i64, mut p: Parameters) -> Result<CadSurface> {
        let pointers = [p.integer()?, p.integer()?];
        let is_opposite = p.integer()? != 0;
        let mut curves = Vec::new();
        for curve in pointers {
            let place = self.place(curve, &Affine::scaling(1.0))?;
            curves.push(place.curve(self.curve(curve)?));
        }
        let is_line = |curve: &CadCurve<3>| matches!(curve.shape, CurveShape::Line { .. });
        let splines = [ruled::spline(&curves[0]), ruled::spline(&curves[1])];
        let [Some(first), Some(second)] = splines else {
            return Err(self.deck.unread(pointer, "is a ruled surface beside a conic"));
        };
        if form == 0 && !curves.iter().all(is_line) {
            return Err(self
                .deck
                .unread(pointer, "is a ruled surface by the lengths of its curves"));
        }
        let second = if is_opposite { second.reversed() } else { second };
        let surface = ruled::between([first, second]);
        surface.map(CadSurface::Spline).map_err(|e| self.deck.error(pointer, e))
    }

    fn spline_surface(&self, pointer: i64, mut p: Parameters) -> Result<CadSurface> {
        let (m, n) = (self.poles(pointer, &mut p)?, self.poles(pointer, &mut p)?);
        let (du, dv) = (self.degree(pointer, &mut p)?, self.degree(pointer, &mut p)?);
        p.skip(5);
        let u = p.several(m + du + 1, Parameters::real)?;
        let v = p.several(n + dv + 1, Parameters::real)?;
        let count = m.saturating_mul(n);
        let weights = p.several(count, Parameters::real)?;
        let poles = p.several(count, Parameters::point)?;
        let build = || {
            let (u, v) = (SplineKnots::new(du, u, m)?, SplineKnots::new(dv, v, n)?);
            SplineSurface::new(u, v, turned(&poles, m, n), Some(turned(&weights, m, n)))
        };
        build().map(CadSurface::Spline).map_err(|e| self.deck.error(pointer, e))
    }
}
