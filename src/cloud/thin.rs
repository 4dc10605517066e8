//! Thinning: points that are much closer to each other than the spacing become one vertex.

use super::LEFT_OUT;
use super::nearest_lists::NearestLists;
use super::project::SurfacePoint;

/// The share of the spacing below which a point is removed. Half keeps nearly all points of a
/// single scan.
const CLOSE: f64 = 0.5;

/// The same where the noise is large. Points then have moved so far that more of them are close.
const CLOSE_IN_NOISE: f64 = 0.7;

/// The noise is large if it is more than this share of the spacing.
const LARGE_NOISE: f64 = 0.3;

/// The points that were kept, and the kept point that stands for each point.
pub(super) struct KeptPoints {
    pub kept: Vec<u32>,
    /// For each point its position in `kept`, or [`LEFT_OUT`] for outliers.
    pub vertex: Vec<u32>,
}

/// Keeps each point that no earlier one has removed.
pub(super) fn thin(
    surface: &[SurfacePoint],
    spacing: &[f64],
    noise: f64,
    lists: &NearestLists,
    outlier: &[bool],
) -> KeptPoints {
    let mut thinned = KeptPoints { kept: Vec::new(), vertex: vec![LEFT_OUT; surface.len()] };
    let mut removed = outlier.to_vec();
    for i in 0..surface.len() {
        if removed[i] {
            continue;
        }
        thinned.vertex[i] = thinned.kept.len() as u32;
        thinned.kept.push(i as u32);
        let share = if noise > LARGE_NOISE * spacing[i] { CLOSE_IN_NOISE } else { CLOSE };
        let squared = (share * spacing[i]).powi(2);
        for &j in lists.of(i) {
            let j = j as usize;
            let distance = (surface[j].place - surface[i].place).norm_squared();
            if distance < squared && thinned.vertex[j] == LEFT_OUT && !removed[j] {
                removed[j] = true;
                thinned.vertex[j] = thinned.vertex[i];
            }
        }
    }
    thinned
}
