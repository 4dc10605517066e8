//! The noise of a cloud, and how many neighbours it takes to find the surface through it.

use super::project::{SurfacePoint, farthest, first};
use super::quadric::Rows;
use crate::geometry::Point;
use crate::mesh::Neighbours;

/// The numbers of neighbours that are tried, fewest first. 24 smooth little; with 96 the noise may
/// be as large as the spacing.
const COUNTS: [usize; 3] = [24, 48, 96];

/// The radius of a neighbourhood must be this many standard deviations of the noise. Below, the
/// points form a ball and not a disk, and the normal is lost.
const LEAST_RADIUS: f64 = 4.0;

/// The number of points that are looked at.
const TRIALS: usize = 2000;

/// The number of neighbours that the noise asks for.
pub(super) fn neighbour_count(points: &[Point], near: &Neighbours) -> usize {
    let step = points.len().div_ceil(TRIALS);
    let enough = |&k: &usize| {
        let (mut found, mut rows) = (Vec::new(), Rows::default());
        let mut ratios: Vec<f64> = Vec::new();
        for i in (0..points.len()).step_by(step) {
            near.nearest_n(points[i], k + 1, &mut found);
            let list: Vec<u32> =
                found.iter().map(|f| f.0).filter(|&j| j as usize != i).take(k).collect();
            let fit = first(i, points, &list, &mut rows);
            ratios.extend(fit.variance.map(|v| farthest(points[i], points, &list) / v.sqrt()));
        }
        median(&mut ratios).is_none_or(|ratio| ratio >= LEAST_RADIUS)
    };
    COUNTS.iter().find(|k| enough(k)).copied().unwrap_or(COUNTS[COUNTS.len() - 1])
}

/// The standard deviation of the noise of points that were projected by `k` neighbours, from the
/// median of the local variances. A few outliers and edges of the object do not change it.
pub(super) fn of_points(surface: &[SurfacePoint], k: usize) -> f64 {
    let mut variances: Vec<f64> = surface.iter().filter_map(|s| s.variance).collect();
    // The median of a chi-squared distribution as a share of its mean (Wilson, Hilferty 1931). With
    // the weights exp(−4 d²/r²) it has about k/3 − 5 degrees of freedom.
    let freedom = k as f64 / 2.0 - 4.0;
    let share = (1.0 - 2.0 / (9.0 * freedom)).powi(3);
    median(&mut variances).map_or(0.0, |v| (v / share).sqrt())
}

/// The upper median. The values change their order.
pub(super) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
