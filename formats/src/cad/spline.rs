//! B-splines whose parts suit each other.

use super::model::{SplineCurve, SplineKnots, SplineSurface};

/// OpenCASCADE's limit; other kernels' are no higher.
pub(crate) const MAX_DEGREE: usize = 25;

impl SplineKnots {
    /// A knot vector for `poles` poles.
    ///
    /// # Errors
    /// It has not the right number of knots; they decrease, are not finite, or
    /// span nothing; the degree is not from 1 to 25.
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
            return Err("knots that span nothing".into());
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

    /// How many poles belong to it.
    pub fn poles(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// The range on which the basis is complete.
    pub fn range(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.poles()])
    }

    /// The distinct knots of that range.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..=self.poles()].to_vec();
        breaks.dedup();
        breaks
    }
}

impl<const D: usize> SplineCurve<D> {
    /// A curve; `weights`, if any, must be positive.
    ///
    /// # Errors
    /// What does not suit.
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

    /// The line that joins some points, two at least: the polyline over 0, 1, 2 …
    pub(crate) fn polyline(poles: Vec<[f64; D]>) -> Result<Self, String> {
        let n = poles.len();
        let inner = (0..n).map(|i| i as f64);
        let last = n.saturating_sub(1) as f64;
        let knots = std::iter::once(0.0).chain(inner).chain(std::iter::once(last)).collect();
        SplineCurve::new(1, knots, poles, None)
    }

    /// Its knot vector.
    pub fn knots(&self) -> &SplineKnots {
        &self.knots
    }

    /// Its control points.
    pub fn poles(&self) -> &[[f64; D]] {
        &self.poles
    }

    /// Their weights; `None`: it is polynomial.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }
}

impl SplineSurface {
    /// A surface; pole (i, j) stands at `i * number in v + j`.
    ///
    /// # Errors
    /// What does not suit.
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

    /// The control net, the index of v running fastest.
    pub fn poles(&self) -> &[[f64; 3]] {
        &self.poles
    }

    /// The weights, likewise; `None`: it is polynomial.
    pub fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }
}

/// The weights, or none where all are the same.
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
