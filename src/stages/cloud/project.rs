//! The projection of every point onto the surface that its neighbours sample: moving least squares
//! (Levin, *Mesh-independent surface interpolation*, 2003; Alexa et al., *Computing and rendering
//! point set surfaces*, 2003).

use rayon::prelude::*;

use super::CHUNK;
use super::nearest_lists::NearestLists;
use super::quadric::{PrincipalPlane, Quadric, QuadricRows, weight};
use crate::geometry::{Point, Vector};

/// Where a point is on the surface of its neighbours.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfacePoint {
    /// The place, which differs from the measured one along the normal.
    pub place: Point,
    /// The unit normal of the surface. Its sign is arbitrary.
    pub normal: Vector,
    /// The distance from the measured place, with its sign along the normal.
    pub moved: f64,
    /// Whether the neighbours are on a line, so that the normal says nothing.
    pub on_line: bool,
}

impl SurfacePoint {
    fn new(from: Point, normal: Vector, on_line: bool, fit: Option<Quadric>) -> Self {
        match fit {
            Some(Quadric { height, normal: turned }) => {
                let place = from + height * normal;
                SurfacePoint { place, normal: turned, moved: height, on_line }
            }
            None => SurfacePoint { place: from, normal, moved: 0.0, on_line },
        }
    }
}

/// Projects a place onto the surface of the points in the list, by a plane through them and a
/// quadric over it. The point at the place itself is not in its list, so an outlier cannot draw
/// the surface to itself.
pub(super) fn first(
    own: Point,
    points: &[Point],
    list: &[u32],
    rows: &mut QuadricRows,
) -> SurfacePoint {
    let radius = farthest(own, points, list);
    let others = || list.iter().map(|&j| points[j as usize]);
    let plane = PrincipalPlane::fit(others().map(|p| {
        let d = p - own;
        (weight(d.norm_squared(), radius), d)
    }));
    let fit = rows.fit(own, plane.normal, radius, others());
    SurfacePoint::new(own, plane.normal, plane.is_line, fit)
}

/// The distance from a place to the farthest point in a list.
pub(super) fn farthest(from: Point, points: &[Point], list: &[u32]) -> f64 {
    let squared = list.iter().map(|&j| (points[j as usize] - from).norm_squared());
    squared.fold(0.0, f64::max).sqrt()
}

/// Projects all points for the first time.
pub(super) fn all(points: &[Point], lists: &NearestLists) -> Vec<SurfacePoint> {
    let project = |rows: &mut QuadricRows, i: usize| first(points[i], points, lists.of(i), rows);
    let numbers = (0..points.len()).into_par_iter().with_min_len(CHUNK);
    numbers.map_init(QuadricRows::default, project).collect()
}

/// Projects the `chosen` points again. The plane is now that of the first projection, and points
/// that are `left_out` do not take part.
pub(super) fn again(
    chosen: &[u32],
    points: &[Point],
    lists: &NearestLists,
    first: &[SurfacePoint],
    left_out: &[bool],
) -> Vec<SurfacePoint> {
    let project = |rows: &mut QuadricRows, &i: &u32| {
        let i = i as usize;
        let list = lists.of(i);
        let all = list.iter().map(|&j| j as usize).chain([i]);
        let used = all.filter(|&j| !left_out[j]).map(|j| points[j]);
        let from = first[i];
        let radius = farthest(points[i], points, list);
        let fit = rows.fit(from.place, from.normal, radius, used);
        SurfacePoint::new(from.place, from.normal, from.on_line, fit)
    };
    chosen.par_iter().with_min_len(CHUNK).map_init(QuadricRows::default, project).collect()
}
