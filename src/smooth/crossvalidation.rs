//! Which of several supports predicts left-out points best.

/// A support, and for each point that it fits the square by which it misses the point
/// when that is left out.
pub struct Tried {
    /// The support, in mm.
    pub h: f64,
    /// The squares.
    pub squares: Vec<Option<f64>>,
}

/// The longest support that is no worse than the best one by more than the standard error
/// of their difference. Two are compared by the points that both fit; those that do not
/// fit most of the points are out.
pub fn chosen(tried: &[Tried]) -> Option<f64> {
    let fits_most = |t: &&Tried| 2 * t.squares.iter().flatten().count() > t.squares.len();
    let usable = || tried.iter().filter(fits_most);
    let best = usable().reduce(|best, next| {
        let is_better = excess(&next.squares, &best.squares).is_some_and(|(mean, _)| mean < 0.0);
        if is_better { next } else { best }
    })?;
    let as_good =
        |t: &&Tried| excess(&t.squares, &best.squares).is_some_and(|(mean, error)| mean <= error);
    usable().rfind(as_good).map(|t| t.h)
}

/// By how much the first squares are greater than the second ones, in the mean over the
/// points that have both, and that mean's standard error. `None` where no point has both.
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
        let short = Tried { h: 1.0, squares: (0..40).map(|i| some(i, 1.1)).collect() };
        let long = Tried { h: 2.0, squares: vec![Some(1.0); 40] };
        let longest =
            Tried { h: 3.0, squares: (0..40).map(|i| Some(2.0).filter(|_| i < 9)).collect() };
        assert_eq!(chosen(&[short, long, longest]), Some(2.0));
    }
}
