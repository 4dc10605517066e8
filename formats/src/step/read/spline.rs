//! Reader of B-spline curves and surfaces. Rational ones are complex entity instances.

use super::attributes::Attributes;
use super::geometry::StepGeometry;
use crate::Result;
use crate::cad::{CadCurve, CadSurface, CurveShape};
use crate::spline::{MAX_DEGREE, SplineCurve, SplineKnots, SplineSurface};

impl StepGeometry<'_, '_> {
    pub(super) fn spline<const D: usize>(&self, id: u64) -> Result<CadCurve<D>> {
        let mut entity = self.file.entity(id)?;
        let (base, knots, weights) = if entity.records.len() == 1 {
            let (kind, mut all) = self.file.simple(id)?;
            all.skip(1)?;
            let base = self.spline_base(&mut all)?;
            let knots = match Uniform::of(kind, "CURVE") {
                Some(uniform) => KnotSource::Uniform(uniform),
                None => KnotSource::List(knots(&mut all)?),
            };
            (base, knots, None)
        } else {
            let missing = || self.file.unread(id, "is not a B-spline curve with knots");
            let uniform = entity.records.iter().find_map(|r| Uniform::of(r.name, "CURVE"));
            let mut part = |name| self.file.part(&mut entity, name);
            let base = self.spline_base(&mut part("B_SPLINE_CURVE").ok_or_else(missing)?)?;
            let knots = match uniform {
                Some(uniform) => KnotSource::Uniform(uniform),
                None => {
                    let mut own = part("B_SPLINE_CURVE_WITH_KNOTS").ok_or_else(missing)?;
                    KnotSource::List(knots(&mut own)?)
                }
            };
            let weights = part("RATIONAL_B_SPLINE_CURVE").map(|mut w| w.reals()).transpose()?;
            (base, knots, weights)
        };
        let (degree, poles) = base;
        let built = knots
            .expanded(degree, poles.len())
            .and_then(|knots| SplineCurve::new(degree, knots, poles, weights));
        let spline = built.map_err(|e| self.file.error(id, e))?;
        Ok(CadCurve { shape: CurveShape::Spline(spline), range: None })
    }

    /// Reads the degree, the poles, and the three flags after them.
    fn spline_base<const D: usize>(
        &self,
        attributes: &mut Attributes,
    ) -> Result<(usize, Vec<[f64; D]>)> {
        let degree = attributes.count()?;
        let poles = attributes.references()?;
        self.file.spend(attributes.id, poles.len())?;
        attributes.skip(3)?;
        let poles = poles.into_iter().map(|id| self.point(id)).collect::<Result<_>>()?;
        Ok((degree, poles))
    }

    pub(super) fn spline_surface(&self, id: u64) -> Result<CadSurface> {
        let mut entity = self.file.entity(id)?;
        let simple = entity.records.len() == 1;
        let missing = || self.file.unread(id, "is not a B-spline surface with knots");
        let uniform = entity.records.iter().find_map(|r| Uniform::of(r.name, "SURFACE"));
        let mut base = if simple {
            let mut all = self.file.simple(id)?.1;
            all.skip(1)?;
            all
        } else {
            self.file.part(&mut entity, "B_SPLINE_SURFACE").ok_or_else(missing)?
        };
        let (p, q) = (base.count()?, base.count()?);
        let rows = base.rows()?;
        base.skip(4)?;
        let [u, v] = match uniform {
            Some(uniform) => [KnotSource::Uniform(uniform), KnotSource::Uniform(uniform)],
            None => {
                let own = self.file.part(&mut entity, "B_SPLINE_SURFACE_WITH_KNOTS");
                let mut rest = match own {
                    Some(rest) if !simple => rest,
                    None if !simple => return Err(missing()),
                    _ => base,
                };
                let counts = [rest.counts()?, rest.counts()?];
                let values = [rest.reals()?, rest.reals()?];
                let ([u_counts, v_counts], [u, v]) = (counts, values);
                let list = |values, counts| KnotSource::List(KnotList { values, counts });
                [list(u, u_counts), list(v, v_counts)]
            }
        };
        let weights = self.file.part(&mut entity, "RATIONAL_B_SPLINE_SURFACE");
        let weights = weights.map(|mut w| w.real_rows()).transpose()?;
        let (m, n) = (rows.len(), rows.first().map_or(0, Vec::len));
        if rows.iter().any(|row| row.len() != n) {
            return Err(self.file.error(id, "has rows of different lengths"));
        }
        let poles = rows.into_iter().flatten().map(|p| self.point(p)).collect::<Result<_>>()?;
        let build = || {
            let (u, v) = (u.expanded(p, m)?, v.expanded(q, n)?);
            let (u, v) = (SplineKnots::new(p, u, m)?, SplineKnots::new(q, v, n)?);
            SplineSurface::new(u, v, poles, weights)
        };
        build().map(CadSurface::Spline).map_err(|e| self.file.error(id, e))
    }
}

/// Knots that follow from the kind of a curve or a surface (ISO 10303-42, clauses 4.4.32 to 4.4.34).
#[derive(Clone, Copy)]
enum Uniform {
    /// All steps are equal.
    Plain,
    /// The same, and the ends are repeated.
    Clamped,
    /// Bézier pieces.
    Bezier,
}

impl Uniform {
    /// The knots of a kind, which is that of a `CURVE` or a `SURFACE`.
    fn of(kind: &str, suffix: &str) -> Option<Self> {
        match kind.strip_suffix(suffix)? {
            "UNIFORM_" => Some(Uniform::Plain),
            "QUASI_UNIFORM_" => Some(Uniform::Clamped),
            "BEZIER_" => Some(Uniform::Bezier),
            _ => None,
        }
    }
}

/// Where the knots of a spline come from.
enum KnotSource {
    List(KnotList),
    Uniform(Uniform),
}

impl KnotSource {
    fn expanded(&self, degree: usize, poles: usize) -> std::result::Result<Vec<f64>, String> {
        let uniform = match self {
            KnotSource::List(list) => return list.expanded(degree, poles),
            KnotSource::Uniform(uniform) => uniform,
        };
        if !(1..=MAX_DEGREE).contains(&degree) || poles <= degree {
            return Err(format!("{poles} poles of degree {degree}"));
        }
        let spans = match uniform {
            Uniform::Bezier if !(poles - 1).is_multiple_of(degree) => {
                return Err(format!("{poles} poles of Bézier pieces of degree {degree}"));
            }
            Uniform::Bezier => (poles - 1) / degree,
            _ => poles - degree,
        };
        let knot = |i: usize| match uniform {
            Uniform::Plain => i as f64 - degree as f64,
            Uniform::Clamped => (i as f64 - degree as f64).clamp(0.0, spans as f64),
            Uniform::Bezier => (i.saturating_sub(1) / degree).min(spans) as f64,
        };
        Ok((0..poles + degree + 1).map(knot).collect())
    }
}

/// Knots as in STEP: distinct values with their multiplicities.
struct KnotList {
    values: Vec<f64>,
    counts: Vec<usize>,
}

fn knots(attributes: &mut Attributes) -> Result<KnotList> {
    let counts = attributes.counts()?;
    Ok(KnotList { values: attributes.reals()?, counts })
}

impl KnotList {
    /// The knots repeated by their multiplicities. Their number must suit the degree and the poles.
    fn expanded(&self, degree: usize, poles: usize) -> std::result::Result<Vec<f64>, String> {
        let KnotList { values, counts } = self;
        if values.len() != counts.len() {
            return Err(format!("{} knots with {} multiplicities", values.len(), counts.len()));
        }
        // Check the total before a list of this length is allocated.
        let total = counts.iter().fold(0usize, |sum, n| sum.saturating_add(*n));
        if degree > MAX_DEGREE || total != poles + degree + 1 {
            return Err(format!("{total} knots for {poles} poles of degree {degree}"));
        }
        let each = values.iter().zip(counts);
        Ok(each.flat_map(|(x, n)| std::iter::repeat_n(*x, *n)).collect())
    }
}
