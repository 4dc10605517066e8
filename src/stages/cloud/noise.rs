//! The noise of a cloud, and how many neighbours it takes to find the surface through it.
//!
//! Both are measured at a sample of the points, and the median over the sample counts. Outliers and
//! edges of the object are at few of these places and do not change it.

use super::layers::{LayerSearch, Layers};
use super::nearest_lists::NearestLists;
use super::project::{SurfacePoint, farthest, first};
use super::quadric::{QuadricRows, Scatter};
use crate::geometry::Point;
use crate::statistics::{MeanSquare, median, quantile};

/// The numbers of neighbours that are tried, fewest first. 24 smooth little; with 96 the noise may
/// be larger than the spacing.
pub(super) const COUNTS: [usize; 3] = [24, 48, 96];

/// The radius of a neighbourhood must be this many standard deviations of the noise. Below 4 the
/// points are a ball and not a disk, and normals are lost; more smooths more than is needed.
pub(super) const LEAST_RADIUS: f64 = 5.0;

/// The share of the places at which the radius may be less.
pub(super) const NARROW: f64 = 0.1;

/// The number of places at which the noise is measured. The median over them is 2 % off.
const PLACES: usize = 4000;

/// The number of neighbours that the noise asks for. More are taken as long as the neighbourhood is
/// too narrow for the noise and grows faster than the residuals. Residuals that grow faster are not
/// noise: the shape of a coarse scan is too curved for a quadric.
pub(super) fn neighbour_count(points: &[Point], layers: &Layers<'_>) -> usize {
    let mut best = (COUNTS[0], 0.0);
    for count in COUNTS {
        let Some(radius) = relative_radius(points, layers, count) else { break };
        if radius <= best.1 {
            break;
        }
        best = (count, radius);
        if radius >= LEAST_RADIUS {
            break;
        }
    }
    best.0
}

/// The radius of neighbourhoods of `count` points in standard deviations of their noise. A share of
/// [`NARROW`] has a smaller one. `None` if there is no noise.
fn relative_radius(points: &[Point], layers: &Layers<'_>, count: usize) -> Option<f64> {
    let (mut search, mut rows) = (LayerSearch::default(), QuadricRows::default());
    let mut ratios = Vec::new();
    for i in sample(points.len()) {
        let own = points[i];
        layers.list(i, count, &mut search);
        ratios.extend(around(own, points, &search.list, &mut rows).map(|(ratio, _)| ratio));
    }
    quantile(&mut ratios, NARROW)
}

/// The distance of the farthest point in a list in standard deviations of their noise, and how they lie about the surface
/// at a place. `None` if they are too few or too uneven to tell.
pub(super) fn around(
    own: Point,
    points: &[Point],
    list: &[u32],
    rows: &mut QuadricRows,
) -> Option<(f64, Scatter)> {
    let radius = farthest(own, points, list);
    let surface = first(own, points, list, rows);
    let others = list.iter().map(|&j| points[j as usize]);
    let scatter = rows.scatter(surface.place, surface.normal, radius, others)?;
    Some((radius / scatter.variance.sqrt(), scatter))
}

/// Some of `count` numbers, evenly spaced.
fn sample(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(PLACES).max(1))
}

/// The standard deviation of the points' noise along the normal.
///
/// The lists have the points that were measured near each other. Points with equal noise are among
/// them more often than by chance, which would make the noise look smaller. The neighbours are
/// therefore chosen anew by their projected places.
pub(super) fn deviation(
    points: &[Point],
    lists: &NearestLists,
    surface: &[SurfacePoint],
    left_out: &[bool],
) -> f64 {
    let (mut around, mut rows) = (Vec::new(), QuadricRows::default());
    let mut variances = Vec::new();
    for i in sample(points.len()).filter(|&i| !left_out[i]) {
        let own = &surface[i];
        let radius = lists.nearest_of_two_rings(i, surface, left_out, &mut around);
        let raw = around.iter().map(|&(_, j)| points[j as usize]);
        variances
            .extend(rows.scatter(own.place, own.normal, radius, raw).map(|found| found.variance));
    }
    let of_noise = MeanSquare(freedom(lists.count())).at(0.0);
    median(&mut variances).map_or(0.0, |v| (v / of_noise).sqrt())
}

/// The degrees of freedom of the variance around a quadric through `count` points with the weights
/// exp(−4 d²/r²). The weights count as half as many points, and the quadric takes six.
fn freedom(count: usize) -> f64 {
    0.5 * count as f64 - 4.0
}
