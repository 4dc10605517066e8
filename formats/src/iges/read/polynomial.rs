//! Curves and surfaces of cubic polynomials (clauses 4.14 and 4.15) as B-splines.

use super::parameters::Parameters;
use crate::Result;
use crate::spline::{SplineCurve, SplineKnots, SplineSurface};

/// The number of coefficients of a cubic.
const CUBIC: usize = 4;

/// A parametric spline curve (112): for each piece the coefficients of its coordinates in the powers of t − tᵢ.
pub(super) fn curve(p: &mut Parameters) -> Result<std::result::Result<SplineCurve<3>, String>> {
    p.skip(3);
    let pieces = p.count()?;
    let breaks = p.several(pieces.saturating_add(1), Parameters::real)?;
    let cubics = p.several(pieces, |p| Ok([cubic(p)?, cubic(p)?, cubic(p)?]))?;
    let mut poles = Vec::new();
    for (cubic, ends) in cubics.iter().zip(breaks.windows(2)) {
        let [x, y, z] = cubic.map(|of| bezier(of, ends[1] - ends[0]));
        poles.extend((usize::from(!poles.is_empty())..CUBIC).map(|i| [x[i], y[i], z[i]]));
    }
    Ok(SplineCurve::new(CUBIC - 1, knots(&breaks), poles, None))
}

/// A parametric spline surface (114): for each patch the coefficients of its coordinates in the powers of u − uᵢ, which
/// change fastest, and of v − vⱼ. Numbers without a meaning follow each row of patches.
pub(super) fn surface(p: &mut Parameters) -> Result<std::result::Result<SplineSurface, String>> {
    p.skip(2);
    let (m, n) = (p.count()?, p.count()?);
    let u = p.several(m.saturating_add(1), Parameters::real)?;
    let v = p.several(n.saturating_add(1), Parameters::real)?;
    let rows = p.several(m, |p| {
        let row = p.several(n, |p| p.several(3 * CUBIC, cubic))?;
        p.skip(3 * CUBIC * CUBIC);
        Ok(row)
    })?;
    let (across, along) = ((CUBIC - 1) * n + 1, (CUBIC - 1) * m + 1);
    let mut poles = vec![[0.0; 3]; across.saturating_mul(along)];
    for (i, row) in rows.iter().enumerate() {
        for (j, patch) in row.iter().enumerate() {
            let lengths = [u[i + 1] - u[i], v[j + 1] - v[j]];
            for (axis, coordinate) in patch.chunks(CUBIC).enumerate() {
                let in_u: Vec<[f64; CUBIC]> =
                    coordinate.iter().map(|&powers| bezier(powers, lengths[0])).collect();
                let columns: [[f64; CUBIC]; CUBIC] =
                    std::array::from_fn(|a| std::array::from_fn(|b| in_u[b][a]));
                for (a, powers) in columns.into_iter().enumerate() {
                    for (b, value) in bezier(powers, lengths[1]).into_iter().enumerate() {
                        let at = ((CUBIC - 1) * i + a) * across + (CUBIC - 1) * j + b;
                        poles[at][axis] = value;
                    }
                }
            }
        }
    }
    let of = |breaks: &[f64], count| SplineKnots::new(CUBIC - 1, knots(breaks), count);
    let build = || SplineSurface::new(of(&u, along)?, of(&v, across)?, poles, None);
    Ok(build())
}

fn cubic(p: &mut Parameters) -> Result<[f64; CUBIC]> {
    Ok([p.real()?, p.real()?, p.real()?, p.real()?])
}

/// The Bézier poles of a + b s + c s² + d s³ over [0, length].
fn bezier([a, b, c, d]: [f64; CUBIC], length: f64) -> [f64; CUBIC] {
    let (b, c, d) = (b * length, c * length.powi(2), d * length.powi(3));
    [a, a + b / 3.0, a + (2.0 * b + c) / 3.0, a + b + c + d]
}

/// Knots at which Bézier pieces meet.
fn knots(breaks: &[f64]) -> Vec<f64> {
    let ends = [breaks.first(), breaks.last()].map(|end| end.copied());
    let inner = breaks.iter().flat_map(|&t| [t; CUBIC - 1]);
    ends[0].into_iter().chain(inner).chain(ends[1]).collect()
}
