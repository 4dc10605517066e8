//! B-spline curves in space (D = 3) and in the parameter plane (D = 2).

use nalgebra::SVector;

use super::KnotVector;

/// A B-spline curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve<const D: usize> {
    /// The knot vector.
    pub knots: KnotVector,
    /// The control points, one for each basis function.
    pub control: Vec<SVector<f64, D>>,
}

impl<const D: usize> Curve<D> {
    /// A curve from its knots and control points.
    ///
    /// # Panics
    /// Panics if the numbers of control points and basis functions differ. [`Curve::try_new`]
    /// returns an error instead.
    pub fn new(knots: KnotVector, control: Vec<SVector<f64, D>>) -> Self {
        assert_eq!(knots.functions(), control.len(), "control points");
        Curve { knots, control }
    }

    /// The straight line from `a` to `b`, over [0, 1].
    #[cfg(test)]
    pub(crate) fn line(a: SVector<f64, D>, b: SVector<f64, D>) -> Self {
        Curve::new(KnotVector::clamped(1, &[0.0, 1.0], 1), vec![a, b])
    }

    /// The value and the first and second derivatives at `t`.
    pub(crate) fn derivatives(&self, t: f64) -> [SVector<f64, D>; 3] {
        let b = self.knots.basis(t);
        let control = &self.control[b.first..=b.first + self.knots.degree()];
        b.derivative
            .map(|row| row.iter().zip(control).fold(SVector::zeros(), |sum, (&c, p)| sum + p * c))
    }

    /// The point at `t`.
    pub fn point(&self, t: f64) -> SVector<f64, D> {
        self.derivatives(t)[0]
    }

    /// The part of the curve between the parameters `a` and `b`, as a clamped curve with unchanged
    /// parameters.
    pub(crate) fn part(&self, a: f64, b: f64) -> Self {
        let p = self.knots.degree();
        let mut breaks = vec![a];
        breaks.extend(self.knots.breaks().into_iter().filter(|&t| a < t && t < b));
        breaks.push(b);
        self.recast(KnotVector::clamped(p, &breaks, 1))
    }

    /// The same curve in the opposite direction, over the same range.
    #[must_use]
    pub(crate) fn reversed(&self) -> Self {
        let (low, high) = self.knots.range();
        let knots = self.knots.knots().iter().rev().map(|t| low + high - t).collect();
        let control = self.control.iter().rev().copied().collect();
        Curve::new(KnotVector::new(self.knots.degree(), knots), control)
    }

    /// The same curve over another knot vector of the same degree. Each span of the new vector must
    /// lie in one span of this curve. Control point i is the blossom at the knots i + 1 … i +
    /// degree of the polynomial on a span among them.
    fn recast(&self, knots: KnotVector) -> Self {
        let p = knots.degree();
        let control = (0..knots.functions())
            .map(|i| {
                let middle = (i..=i + p)
                    .find(|&j| knots.knots()[j] < knots.knots()[j + 1])
                    .map_or(knots.knots()[i], |j| 0.5 * (knots.knots()[j] + knots.knots()[j + 1]));
                let arguments = &knots.knots()[i + 1..=i + p];
                self.knots.blossom(self.knots.span(middle), &self.control, arguments)
            })
            .collect();
        Curve::new(knots, control)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn a_part_runs_where_the_whole_does() {
        let knots = KnotVector::new(3, (0..12).map(f64::from).collect());
        let control = (0..8).map(|i| Vector2::new(f64::from(i), f64::from(i * i % 5))).collect();
        let curve = Curve::<2>::new(knots, control);
        let part = curve.part(3.5, 7.25);
        assert_eq!(part.knots.range(), (3.5, 7.25));
        for i in 0..=40 {
            let t = 3.5 + 3.75 * f64::from(i) / 40.0;
            assert!((part.point(t) - curve.point(t)).norm() < 1e-12);
        }
    }
}
