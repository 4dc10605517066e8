//! The ends of colour scales, and numbers beside them.

use super::view::{ReportView, ViewFigures};
use crate::report::picture::scale::rounded_up;

/// The ends of the colour scales, in mm.
pub(super) struct Ends {
    pub measured: f64,
    #[cfg(feature = "html")]
    pub smoothed: f64,
}

/// The end of a scale as a multiple of the 95th percentile of the distances. The few points
/// that are farthest would make all others look alike.
pub(super) const SPREAD: f64 = 1.3;

/// The tolerance is put on the scale unless it is more than this multiple of that end: the
/// distances would have no colours then.
const NEAR: f64 = 3.0;

impl Ends {
    pub(super) fn of(views: &[ReportView]) -> Ends {
        Ends {
            measured: end(views, |figures| figures.vertex_p95),
            #[cfg(feature = "html")]
            smoothed: end(views, |figures| figures.smoothed.p95),
        }
    }
}

fn end(views: &[ReportView], of: fn(&ViewFigures) -> f64) -> f64 {
    let figures = || views.iter().map(|view| &view.figures);
    let tolerance = figures().map(|figures| figures.tolerance).fold(0.0, f64::max);
    let most = SPREAD * figures().map(of).fold(0.0, f64::max);
    let with_tolerance = 1.1 * tolerance;
    rounded_up(if with_tolerance < NEAR * most { most.max(with_tolerance) } else { most })
}

/// A number with three significant digits, without zeros at the end.
pub(super) fn short(x: f64) -> String {
    if x < 0.0 {
        return format!("−{}", short(-x));
    }
    let digits = if x > 0.0 { 2 - x.log10().floor() as i32 } else { 0 };
    let text = format!("{x:.*}", digits.clamp(0, 14) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_below_zero_keep_their_digits() {
        assert_eq!([0.0123, -0.0123, -12.0, 0.0].map(short), ["0.0123", "−0.0123", "−12", "0"]);
    }
}
