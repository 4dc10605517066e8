//! Cross-validation: selects the support that predicts left-out points best.

/// A support with its errors. There is one error for each point: the squared distance between the
/// point and the fit without it, or `None` if there is no fit.
pub(crate) struct SupportScore {
    /// The support, in mm.
    pub h: f64,
    /// The squared errors.
    pub squares: Vec<Option<f64>>,
}

/// Selects the widest support whose mean error exceeds the smallest one by at most the standard
/// error of their difference. Two supports are compared on the points that both fit. A support that
/// does not fit most of the points is not selected.
pub(crate) fn chosen(tried: &[SupportScore]) -> Option<f64> {
    let fits_most = |t: &&SupportScore| 2 * t.squares.iter().flatten().count() > t.squares.len();
    let usable = || tried.iter().filter(fits_most);
    let best = usable().reduce(|best, next| {
        let is_better = excess(&next.squares, &best.squares).is_some_and(|(mean, _)| mean < 0.0);
        if is_better { next } else { best }
    })?;
    let as_good = |t: &&SupportScore| {
        excess(&t.squares, &best.squares).is_some_and(|(mean, error)| mean <= error)
    };
    usable().rfind(as_good).map(|t| t.h)
}

/// The mean of `first` minus `second` over the points that have both errors, and the standard error
/// of this mean. `None` if no point has both.
fn excess(first: &[Option<f64>], second: &[Option<f64>]) -> Option<(f64, f64)> {
    let both = first.iter().zip(second).filter_map(|(x, y)| Some((*x)? - (*y)?));
    let worse: Vec<f64> = both.collect();
    let n = worse.len() as f64;
    let mean = worse.iter().sum::<f64>() / n;
    let variance = worse.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n;
    (n > 0.0).then(|| (mean, (variance / n).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_support_gains_nothing_by_points_that_it_does_not_fit() {
        let some = |i: usize, square: f64| (!i.is_multiple_of(4)).then_some(square);
        let short = SupportScore { h: 1.0, squares: (0..40).map(|i| some(i, 1.1)).collect() };
        let long = SupportScore { h: 2.0, squares: vec![Some(1.0); 40] };
        let longest = SupportScore {
            h: 3.0,
            squares: (0..40).map(|i| Some(2.0).filter(|_| i < 9)).collect(),
        };
        assert_eq!(chosen(&[short, long, longest]), Some(2.0));
    }
}
