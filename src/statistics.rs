//! The two significance levels of the program, one for tests and one for outliers, and the
//! distributions behind them.

use std::f64::consts::{SQRT_2, TAU};

/// What a test takes for more than chance, in standard deviations of a normal error. Chance
/// exceeds it once in 370 times.
pub(crate) const SIGNIFICANT: f64 = 3.0;

/// The probability with which chance exceeds [`SIGNIFICANT`].
pub(crate) fn level() -> f64 {
    libm::erfc(SIGNIFICANT / SQRT_2)
}

/// How many standard deviations one of `count` normal errors exceeds with the probability
/// [`level`]: beyond it lie outliers (Bonferroni's correction).
pub(crate) fn outlying(count: usize) -> f64 {
    -normal_at(0.5 * level() / count.max(1) as f64)
}

/// At least this share of a scan is taken to be free of edges, so that its smallest residuals tell the
/// noise. A smaller share would tell it less exactly.
pub(crate) const CALM: f64 = 0.2;

/// The value below which a share of normal errors of standard deviation 1 is.
pub(crate) fn normal_at(share: f64) -> f64 {
    // Beyond the lower bound the share is too small for a number.
    let (mut low, mut high) = (-40.0, 10.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle: f64 = 0.5 * (low + high);
        if normal_below(middle) > share { high = middle } else { low = middle }
    }
    low
}

/// The share of normal errors of standard deviation 1 that is below a value.
fn normal_below(value: f64) -> f64 {
    0.5 * libm::erfc(-value / SQRT_2)
}

/// The value below which a share of the absolute values of such errors is.
pub(crate) fn absolute_at(share: f64) -> f64 {
    normal_at(0.5 + 0.5 * share)
}

/// The standard deviation of the value below which a share of many values is, as a multiple of that
/// of their mean, for normal errors.
pub(crate) fn deviation_at(share: f64) -> f64 {
    let density = (-0.5 * normal_at(share).powi(2)).exp() / TAU.sqrt();
    (share * (1.0 - share)).sqrt() / density
}

/// The distribution of the mean square of normal errors, divided by its expectation, for this
/// number of degrees of freedom (Wilson and Hilferty, "The distribution of chi-square", 1931).
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanSquare(pub f64);

impl MeanSquare {
    /// The value below which a share of all values is.
    pub(crate) fn quantile(self, share: f64) -> f64 {
        self.at(normal_at(share))
    }

    /// The value at `z` standard deviations of the normal distribution that corresponds to it.
    pub(crate) fn at(self, z: f64) -> f64 {
        let (middle, deviation) = self.of_root();
        (middle + z * deviation).max(0.0).powi(3)
    }

    /// The standard deviations of the corresponding normal distribution at which a value is.
    pub(crate) fn deviations(self, value: f64) -> f64 {
        let (middle, deviation) = self.of_root();
        (value.cbrt() - middle) / deviation
    }

    /// The mean of the values below a limit. That of all values is 1.
    pub(crate) fn mean_below(self, limit: f64) -> f64 {
        let wider = MeanSquare(self.0 + 2.0);
        let share = |of: Self, value: f64| normal_below(of.deviations(value));
        share(wider, limit * self.0 / wider.0) / share(self, limit)
    }

    /// The mean and the standard deviation of the cubic root.
    fn of_root(self) -> (f64, f64) {
        let variance = 2.0 / (9.0 * self.0);
        (1.0 - variance, variance.sqrt())
    }
}

/// The value below which this share of the values is; `None` without values. They change their
/// order.
pub(crate) fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let at = (share * values.len() as f64) as usize;
    (at < values.len()).then(|| *values.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// The upper median; `None` without values. They change their order.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    quantile(values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_of_outliers_grows_with_the_number_of_points() {
        assert!((outlying(1) - SIGNIFICANT).abs() < 1e-9);
        // Tables of the normal distribution: 2.7e-8 on both sides are beyond 5.56.
        assert!((outlying(100_000) - 5.56).abs() < 0.01);
        assert!(outlying(usize::MAX) < 12.0);
        assert!((normal_at(0.975) - 1.959_964).abs() < 1e-6);
        assert!((absolute_at(0.5) - 0.674_490).abs() < 1e-6);
        assert!((deviation_at(0.5) - 1.253_314).abs() < 1e-6);
    }

    #[test]
    fn mean_squares_are_distributed_as_in_tables() {
        // χ² of 10 degrees of freedom: median 9.342, 99 % below 23.209.
        let ten = MeanSquare(10.0);
        assert!((10.0 * ten.at(0.0) - 9.342).abs() < 0.01);
        assert!((10.0 * ten.at(2.326_35) - 23.209).abs() < 0.05);
        assert!((ten.deviations(ten.at(1.5)) - 1.5).abs() < 1e-9);
        assert!((ten.mean_below(1e3) - 1.0).abs() < 1e-6);
        // Half of the values, those below the median, have a smaller mean.
        assert!((0.6..0.7).contains(&ten.mean_below(ten.at(0.0))));
    }

    #[test]
    fn quantiles_of_few_values() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(quantile(&mut [3.0, 1.0, 2.0, 4.0], 0.25), Some(2.0));
        assert_eq!(median(&mut []), None);
    }
}
