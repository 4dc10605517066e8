//! B-spline curves and surfaces as in CAD files. They have any degree up to 25 and may be rational.
//! The constructors check that knots, poles and weights are consistent.

mod basis;

pub use basis::SplineBasis;

/// The highest degree. This is the limit of OpenCASCADE, and other kernels do not have a higher
/// one.
pub(crate) const MAX_DEGREE: usize = 25;

/// A non-decreasing knot vector and its degree from 1 to 25. It may be unclamped.
#[derive(Debug, Clone, PartialEq)]
pub struct SplineKnots {
    degree: usize,
    knots: Vec<f64>,
}

/// A B-spline curve in space (D = 3) or in a parameter plane (D = 2).
#[derive(Debug, Clone, PartialEq)]
pub struct SplineCurve<const D: usize> {
    knots: SplineKnots,
    poles: Vec<[f64; D]>,
    weights: Option<Vec<f64>>,
}

/// A B-spline surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SplineSurface {
    u: SplineKnots,
    v: SplineKnots,
    poles: Vec<[f64; 3]>,
    weights: Option<Vec<f64>>,
}

impl SplineKnots {
    /// Creates a knot vector for `poles` poles.
    ///
    /// # Errors
    /// The number of knots is wrong, the knots decrease, are not finite or have an empty range, or
    /// the degree is not from 1 to 25.
    pub fn new(degree: usize, knots: Vec<f64>, poles: usize) -> Result<Self, String> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(format!("degree {degree}"));
        }
        if poles <= degree || knots.len() != poles + degree + 1 {
            let count = knots.len();
            return Err(format!("{count} knots for {poles} poles of degree {degree}"));
        }
        let rising = knots.windows(2).all(|w| w[0] <= w[1]);
        if !rising || knots.iter().any(|k| !k.is_finite()) {
            return Err("knots that decrease, or are not finite".into());
        }
        if knots[degree] >= knots[poles] {
            return Err("knots with an empty range".into());
        }
        Ok(SplineKnots { degree, knots })
    }

    /// The degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// All knots.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The number of poles for this knot vector.
    pub fn poles(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// The range of parameters, on which the basis functions sum to 1.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.poles()])
    }

    /// Whether a curve over these knots begins at its first pole and ends at its last pole.
    pub fn are_clamped(&self) -> bool {
        let (low, high) = self.range();
        self.knots[0] == low && self.knots[self.knots.len() - 1] == high
    }

    /// The knots in reverse order over the same range.
    fn reversed(&self) -> SplineKnots {
        let (first, last) = (self.knots[0], self.knots[self.knots.len() - 1]);
        // The ends must stay exactly the same.
        let mirror = |&t: &f64| if t == first { last } else { first + (last - t) };
        let knots = self.knots.iter().rev().map(mirror).collect();
        SplineKnots { degree: self.degree, knots }
    }

    /// The knots scaled to the range [0, 1].
    fn over_unit(mut self) -> SplineKnots {
        let (a, b) = self.range();
        self.knots.iter_mut().for_each(|t| *t = (*t - a) / (b - a));
        self
    }

    /// The distinct knots of the range.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..=self.poles()].to_vec();
        breaks.dedup();
        breaks
    }
}

impl<const D: usize> SplineCurve<D> {
    /// Creates a curve. `weights`, if there are any, must be positive.
    ///
    /// # Errors
    /// A description of the first inconsistency.
    pub fn new(
        degree: usize,
        knots: Vec<f64>,
        poles: Vec<[f64; D]>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, String> {
        let knots = SplineKnots::new(degree, knots, poles.len())?;
        let weights = checked(&poles, weights)?;
        Ok(SplineCurve { knots, poles, weights })
    }

    /// The polyline through at least two points, with the parameters 0, 1, 2 and so on.
    pub(crate) fn polyline(poles: Vec<[f64; D]>) -> Result<Self, String> {
        let n = poles.len();
        let inner = (0..n).map(|i| i as f64);
        let last = n.saturating_sub(1) as f64;
        let knots = std::iter::once(0.0).chain(inner).chain(std::iter::once(last)).collect();
        SplineCurve::new(1, knots, poles, None)
    }

    /// The knot vector.
    pub fn knots(&self) -> &SplineKnots {
        &self.knots
    }

    /// The control points.
    pub fn poles(&self) -> &[[f64; D]] {
        &self.poles
    }

    /// The weights of the control points. `None` if the curve is polynomial.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The point at `t`, which is clamped to the range.
    pub fn point(&self, t: f64) -> [f64; D] {
        let (sum, weights) = self.sum(&SplineBasis::new(&self.knots, t), 0);
        sum.map(|x| x / weights)
    }

    /// The derivative at `t`, which is clamped to the range.
    pub fn speed(&self, t: f64) -> [f64; D] {
        let basis = SplineBasis::new(&self.knots, t);
        let [(sum, weights), (mut speed, change)] = [0, 1].map(|k| self.sum(&basis, k));
        speed.iter_mut().zip(sum).for_each(|(s, x)| *s = (*s - change * x / weights) / weights);
        speed
    }

    /// The sum of the poles, multiplied by their weights and the `k`-th derivatives of their
    /// functions, and the same sum of the weights alone.
    fn sum(&self, basis: &SplineBasis, k: usize) -> ([f64; D], f64) {
        let (mut sum, mut weights) = ([0.0; D], 0.0);
        for j in 0..=self.knots.degree {
            let i = basis.first + j;
            let weight = basis.derivative[k][j] * self.weights.as_ref().map_or(1.0, |w| w[i]);
            sum.iter_mut().zip(self.poles[i]).for_each(|(s, x)| *s += x * weight);
            weights += weight;
        }
        (sum, weights)
    }

    /// The points at the start and at the end of the range.
    pub fn ends(&self) -> [[f64; D]; 2] {
        let (start, end) = self.knots.range();
        [self.point(start), self.point(end)]
    }

    /// The curve in the opposite direction over the same range.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let poles = self.poles.iter().rev().copied().collect();
        let weights = self.weights.as_ref().map(|w| w.iter().rev().copied().collect());
        SplineCurve { knots: self.knots.reversed(), poles, weights }
    }

    /// The image of the curve under `map`, which must be affine.
    #[must_use]
    pub fn mapped<const E: usize>(self, map: impl Fn([f64; D]) -> [f64; E]) -> SplineCurve<E> {
        let poles = self.poles.into_iter().map(map).collect();
        SplineCurve { knots: self.knots, poles, weights: self.weights }
    }

    /// The same curve with parameters over [0, 1].
    pub(crate) fn over_unit(self) -> Self {
        SplineCurve { knots: self.knots.over_unit(), ..self }
    }
}

impl SplineSurface {
    /// Creates a surface. Pole (i, j) is at the index `i * n + j`, where n is the number of poles
    /// in v.
    ///
    /// # Errors
    /// A description of the first inconsistency.
    pub fn new(
        u: SplineKnots,
        v: SplineKnots,
        poles: Vec<[f64; 3]>,
        weights: Option<Vec<f64>>,
    ) -> Result<Self, String> {
        let (m, n) = (u.poles(), v.poles());
        if m.checked_mul(n) != Some(poles.len()) {
            return Err(format!("{} poles for a net of {m} × {n}", poles.len()));
        }
        let weights = checked(&poles, weights)?;
        Ok(SplineSurface { u, v, poles, weights })
    }

    /// The knot vector in u.
    pub fn u(&self) -> &SplineKnots {
        &self.u
    }

    /// The knot vector in v.
    pub fn v(&self) -> &SplineKnots {
        &self.v
    }

    /// The control net. The index of v changes fastest.
    pub fn poles(&self) -> &[[f64; 3]] {
        &self.poles
    }

    /// The weights in the same order. `None` if the surface is polynomial.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    /// The point at (u, v), which is clamped to the ranges.
    pub fn point(&self, u: f64, v: f64) -> [f64; 3] {
        let (sum, weights) =
            self.sum([&SplineBasis::new(&self.u, u), &SplineBasis::new(&self.v, v)], [0, 0]);
        sum.map(|x| x / weights)
    }

    /// The point at (u, v) and the derivatives in u and in v.
    pub fn tangents(&self, u: f64, v: f64) -> [[f64; 3]; 3] {
        let (of_u, of_v) = (SplineBasis::new(&self.u, u), SplineBasis::new(&self.v, v));
        if self.weights.is_none() {
            return self.plain_tangents([&of_u, &of_v]);
        }
        let sum = |derivative| self.sum([&of_u, &of_v], derivative);
        let (sums, weights) = sum([0, 0]);
        let point = sums.map(|x| x / weights);
        let derivative =
            |(d, change): ([f64; 3], f64)| [0, 1, 2].map(|k| (d[k] - change * point[k]) / weights);
        [point, derivative(sum([1, 0])), derivative(sum([0, 1]))]
    }

    /// The point and the derivatives without weights.
    fn plain_tangents(&self, [of_u, of_v]: [&SplineBasis; 2]) -> [[f64; 3]; 3] {
        let [u, v] = [of_u, of_v].map(|basis| &basis.derivative);
        let mut sums = [[0.0; 3]; 3];
        for (i, (of, slope)) in u[0].iter().zip(&u[1]).take(self.u.degree + 1).enumerate() {
            let first = (of_u.first + i) * self.v.poles() + of_v.first;
            for (j, pole) in self.poles[first..=first + self.v.degree].iter().enumerate() {
                let shares = [of * v[0][j], slope * v[0][j], of * v[1][j]];
                for (sum, share) in sums.iter_mut().zip(shares) {
                    (0..3).for_each(|k| sum[k] += pole[k] * share);
                }
            }
        }
        sums
    }

    /// The sum of the poles, multiplied by their weights and derivatives of their functions in u
    /// and in v, and the same sum of the weights alone.
    fn sum(&self, [of_u, of_v]: [&SplineBasis; 2], [du, dv]: [usize; 2]) -> ([f64; 3], f64) {
        let (mut sum, mut weights) = ([0.0; 3], 0.0);
        for i in 0..=self.u.degree {
            for j in 0..=self.v.degree {
                let at = (of_u.first + i) * self.v.poles() + of_v.first + j;
                let weight = self.weights.as_ref().map_or(1.0, |w| w[at]);
                let share = weight * of_u.derivative[du][i] * of_v.derivative[dv][j];
                sum.iter_mut().zip(self.poles[at]).for_each(|(s, x)| *s += x * share);
                weights += share;
            }
        }
        (sum, weights)
    }

    /// The image of the surface under `map`, which must be affine.
    #[must_use]
    pub fn mapped(mut self, map: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        self.poles.iter_mut().for_each(|pole| *pole = map(*pole));
        self
    }
}

/// The weights, or `None` if all are equal.
fn checked<const D: usize>(
    poles: &[[f64; D]],
    weights: Option<Vec<f64>>,
) -> Result<Option<Vec<f64>>, String> {
    if poles.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a pole that is not finite".into());
    }
    let Some(weights) = weights else { return Ok(None) };
    if weights.len() != poles.len() {
        return Err(format!("{} weights for {} poles", weights.len(), poles.len()));
    }
    if weights.iter().any(|w| !(w.is_finite() && *w > 0.0)) {
        return Err("a weight that is not positive".into());
    }
    let even = weights.iter().all(|w| *w == weights[0]);
    Ok((!even).then_some(weights))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversed_curve_keeps_its_range_to_the_last_bit() {
        let knots = vec![0.1, 0.1, 0.3, 0.3000000001, 0.7, 0.7];
        let poles = vec![[1.0], [2.0], [3.0], [4.0]];
        let curve = SplineCurve::new(1, knots, poles, None).unwrap();
        let reversed = curve.reversed();
        assert_eq!(reversed.poles(), &[[4.0], [3.0], [2.0], [1.0]]);
        let knots = reversed.knots().knots();
        assert_eq!((knots[..2].to_vec(), knots[4..].to_vec()), (vec![0.1; 2], vec![0.7; 2]));
        assert!((knots[3] - 0.5).abs() < 1e-15 && knots[2] < knots[3]);
    }

    #[test]
    fn a_pole_that_is_no_number_is_refused() {
        let curve = SplineCurve::new(1, vec![0.0, 0.0, 1.0, 1.0], vec![[f64::NAN], [0.0]], None);
        assert_eq!(curve.unwrap_err(), "a pole that is not finite");
    }

    /// A quarter of a circle of radius 2, exact as a rational curve.
    #[test]
    fn a_rational_curve_has_its_points_and_its_speed() {
        let poles = vec![[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let weights = vec![1.0, 0.5_f64.sqrt(), 1.0];
        let knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let arc = SplineCurve::new(2, knots, poles, Some(weights)).unwrap();
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            let ([x, y], [dx, dy]) = (arc.point(t), arc.speed(t));
            assert!((x.hypot(y) - 2.0).abs() < 1e-15);
            assert!((x * dx + y * dy).abs() < 1e-14, "a tangent is at right angles to the radius");
            let step = 1e-6;
            let [a, b] = [arc.point(t - step), arc.point(t + step)];
            if k % 10 != 0 {
                assert!((dx - (b[0] - a[0]) / (2.0 * step)).abs() < 1e-8);
            }
        }
    }
}
