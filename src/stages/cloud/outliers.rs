//! Outliers: points that do not belong to a surface.

use rayon::prelude::*;

use super::nearest_lists::NearestLists;
use super::project::SurfacePoint;
use crate::geometry::Point;
use crate::statistics::{SIGNIFICANT, absolute_at, median, outlying};

/// The neighbour whose distance measures the spacing at a point.
const EIGHTH: usize = 8;

/// A point with a spacing of more than this multiple of its neighbours' is lonely. At a boundary
/// the spacing is √2 times as large, at the corner of a sheet twice.
pub(super) const LONELY: f64 = 2.5;

/// The spacing at each point: the distance at which an even cloud would have its next point.
/// A disk of radius d₈ holds 8 points; a square cell of side h holds one.
pub(super) fn spacings(points: &[Point], lists: &NearestLists) -> Vec<f64> {
    let spacing = |distances: &mut Vec<f64>, i: usize| {
        distances.clear();
        distances
            .extend(lists.of(i).iter().map(|&j| (points[j as usize] - points[i]).norm_squared()));
        let (_, eighth, _) = distances.select_nth_unstable_by(EIGHTH - 1, f64::total_cmp);
        eighth.sqrt() * (std::f64::consts::PI / EIGHTH as f64).sqrt()
    };
    (0..points.len()).into_par_iter().map_init(Vec::new, spacing).collect()
}

/// Which points are lonely.
pub(super) fn lonely(spacing: &[f64], lists: &NearestLists) -> Vec<bool> {
    above_neighbours(spacing, lists, LONELY)
}

/// Which points are far from the surface, and which of them are so far that they are no noise either,
/// and the noise should not be measured with them. Their neighbours' median distance tells what noise
/// is. Without the points in between, the tail of the noise would be cut off.
pub(super) fn far(surface: &[SurfacePoint], lists: &NearestLists) -> [Vec<bool>; 2] {
    let moved: Vec<f64> = surface.iter().map(|s| s.moved.abs()).collect();
    [SIGNIFICANT, outlying(surface.len())]
        .map(|deviations| above_neighbours(&moved, lists, deviations / absolute_at(0.5)))
}

/// Where a value is more than a multiple of its neighbours' median.
fn above_neighbours(values: &[f64], lists: &NearestLists, multiple: f64) -> Vec<bool> {
    let above = |around: &mut Vec<f64>, i: usize| {
        around.clear();
        around.extend(lists.of(i).iter().map(|&j| values[j as usize]));
        median(around).is_some_and(|middle| values[i] > multiple * middle)
    };
    (0..values.len()).into_par_iter().map_init(Vec::new, above).collect()
}
