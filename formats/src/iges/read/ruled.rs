//! Ruled surfaces between two curves (clause 4.17) as B-splines.

use crate::cad::{CadCurve, CurveShape};
use crate::spline::{SplineCurve, SplineKnots, SplineSurface};

/// The surface (1 − v) C(u) + v D(u), where both curves are over [0, 1].
pub(super) fn between(curves: [SplineCurve<3>; 2]) -> Result<SplineSurface, String> {
    let [c, d] = curves.map(SplineCurve::over_unit);
    let mut breaks = [c.knots().breaks(), d.knots().breaks()].concat();
    breaks.sort_unstable_by(f64::total_cmp);
    breaks.dedup();
    let degree = c.knots().degree() + d.knots().degree();
    let mut sides: [Vec<[f64; 4]>; 2] = Default::default();
    for ends in breaks.windows(2) {
        let (c, d) = (bezier(&c, ends), bezier(&d, ends));
        // Both sides get the weights of both, as a surface has one denominator.
        for (side, (poles, weights)) in sides.iter_mut().zip([(&c, &d), (&d, &c)]) {
            let skipped = usize::from(!side.is_empty());
            side.extend(product(poles, weights).into_iter().skip(skipped));
        }
    }
    let mut knots = vec![breaks[0]];
    knots.extend(breaks.iter().flat_map(|&t| std::iter::repeat_n(t, degree)));
    knots.push(breaks[breaks.len() - 1]);
    let count = sides[0].len();
    let both = || (0..count).flat_map(|i| sides.each_ref().map(|side| side[i]));
    let poles = both().map(|[x, y, z, w]| [x / w, y / w, z / w]).collect();
    let weights = both().map(|pole| pole[3]).collect();
    let across = SplineKnots::new(1, vec![0.0, 0.0, 1.0, 1.0], 2)?;
    SplineSurface::new(SplineKnots::new(degree, knots, count)?, across, poles, Some(weights))
}

/// A line or a spline over its range as a spline. `None` for a conic, whose parameter no spline has.
pub(super) fn spline(curve: &CadCurve<3>) -> Option<SplineCurve<3>> {
    match (&curve.shape, curve.range) {
        (CurveShape::Spline(spline), None) => Some(spline.clone()),
        (CurveShape::Spline(spline), Some(range)) if range == spline.knots().range() => {
            Some(spline.clone())
        }
        (CurveShape::Line { origin, direction }, Some((from, to))) => {
            let at = |t: f64| std::array::from_fn(|i| origin[i] + t * direction[i]);
            SplineCurve::polyline(vec![at(from), at(to)]).ok()
        }
        _ => None,
    }
}

/// The homogeneous Bézier poles of a piece of a curve, by its blossom (Ramshaw, 1989): pole j is the value where j of
/// the arguments are the end of the piece and the others its beginning.
fn bezier(curve: &SplineCurve<3>, ends: &[f64]) -> Vec<[f64; 4]> {
    let (degree, knots) = (curve.knots().degree(), curve.knots().knots());
    let poles = curve.poles().iter().enumerate();
    let weighted = poles.map(|(i, &[x, y, z])| {
        let w = curve.weights().map_or(1.0, |weights| weights[i]);
        [x * w, y * w, z * w, w]
    });
    let weighted: Vec<[f64; 4]> = weighted.collect();
    let span = knots.partition_point(|&t| t <= 0.5 * (ends[0] + ends[1])) - 1;
    let pole = |j: usize| {
        let mut of: Vec<[f64; 4]> = weighted[span - degree..=span].to_vec();
        for level in 1..=degree {
            let t = if level <= j { ends[1] } else { ends[0] };
            for i in 0..=degree - level {
                let low = knots[span - degree + level + i];
                let share = (t - low) / (knots[span + 1 + i] - low);
                let next = of[i + 1];
                of[i] = std::array::from_fn(|k| (1.0 - share) * of[i][k] + share * next[k]);
            }
        }
        of[0]
    };
    (0..=degree).map(pole).collect()
}

/// The homogeneous poles of a curve whose weights are multiplied by those of another one.
fn product(poles: &[[f64; 4]], weights: &[[f64; 4]]) -> Vec<[f64; 4]> {
    let (m, n) = (poles.len() - 1, weights.len() - 1);
    let mut found = vec![[0.0; 4]; m + n + 1];
    for (i, pole) in poles.iter().enumerate() {
        for (j, weight) in weights.iter().enumerate() {
            let share = choose(m, i) * choose(n, j) / choose(m + n, i + j) * weight[3];
            for k in 0..4 {
                found[i + j][k] += share * pole[k];
            }
        }
    }
    found
}

/// The binomial coefficient.
fn choose(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
}
