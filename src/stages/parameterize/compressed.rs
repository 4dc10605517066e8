//! Detection of regions that the map compresses so much that no affordable net reaches the
//! tolerance there.

use std::fmt::{self, Display, Formatter};

use rayon::prelude::*;

use super::Parameterized;
use super::stretch;
use crate::geometry::Point;

/// A region for which the map leaves too little space.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct CompressedRegion {
    /// The numbers of knot spans in u and in v that the tolerance requires.
    pub spans: [f64; 2],
    /// The place that requires the closest knots.
    pub at: Point,
}

impl CompressedRegion {
    /// The same region with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        CompressedRegion { at: self.at * factor, ..self }
    }
}

impl Display for CompressedRegion {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let ([m, n], at) = (self.spans, self.at);
        write!(
            f,
            "the map compresses a protruding part: near ({:.3}, {:.3}, {:.3}) the tolerance requires knots as close as in a net of {m:.0} × {n:.0}; cut the scan there and convert the pieces separately, or raise --tolerance or --max-net",
            at.x, at.y, at.z
        )
    }
}

/// The requirement of one triangle in one parameter: the middle of the triangle, and the number of
/// spans per unit of the parameter.
struct KnotDemand {
    middle: f64,
    density: f64,
    triangle: usize,
}

/// Tests whether a net of at most `max_net` control points can reach the `tolerance`, in mm, on the
/// measured triangles. Returns the worst region if it cannot. Triangles that were divided because
/// the map stretches them strongly are ignored: where they lie along a crease, they require closer
/// knots the smaller they are.
///
/// A cubic span of length h on a circle of curvature κ deviates from it by κ³h⁴/384. This gives the
/// required distance of knots in u and in v at each triangle. A knot line runs across the whole
/// patch, so the closest requirement along it decides. Roughness requires more knots than this
/// estimate, so the test never reports a region wrongly.
pub fn compressed_region(
    map: &Parameterized,
    tolerance: f64,
    max_net: usize,
) -> Option<CompressedRegion> {
    let normals: Vec<Point> =
        map.patch.mesh.vertex_normals().into_iter().map(Point::from).collect();
    let patch = &map.patch;
    let is_whole = |t: &usize| patch.mesh.triangles[*t].iter().all(|&v| patch.is_measured(v));
    let triangles: Vec<usize> = patch.measured_triangles().filter(is_whole).collect();
    let demands: Vec<[KnotDemand; 2]> =
        triangles.par_iter().map(|&t| demands(map, &normals, tolerance, t)).collect();
    let along = |k: usize| spans(demands.iter().map(|demand| &demand[k]));
    let (along_u, along_v) = rayon::join(|| along(0), || along(1));
    if along_u.0 * along_v.0 <= max_net as f64 {
        return None;
    }
    let (_, triangle) = if along_u.0 > along_v.0 { along_u } else { along_v };
    let at = map.patch.mesh.point(map.patch.mesh.triangles[triangle][0]);
    Some(CompressedRegion { spans: [along_u.0, along_v.0], at })
}

fn demands(map: &Parameterized, normals: &[Point], tolerance: f64, t: usize) -> [KnotDemand; 2] {
    let corners = map.patch.mesh.triangles[t];
    let places = corners.map(|v| map.uv[v.index()]);
    let along = stretch::derivatives(map.patch.mesh.corners(corners), places, 0.0);
    let turn = stretch::derivatives(corners.map(|v| normals[v.index()]), places, 0.0);
    let demand = |k: usize| {
        let (along, turn) = ([along.2, along.3][k].norm(), [turn.2, turn.3][k].norm());
        // The number of spans per mm is (κ³ / 384 tolerance)^¼ with κ = turn / along.
        let density = (turn.powi(3) * along / (384.0 * tolerance)).powf(0.25);
        let middle = places.iter().map(|at| at[k]).sum::<f64>() / 3.0;
        KnotDemand { middle, density: if density.is_finite() { density } else { 0.0 }, triangle: t }
    };
    [demand(0), demand(1)]
}

/// The number of strips across a parameter in which the closest requirement is determined.
const STRIPS: usize = 256;

/// In each strip, one in this number of triangles, but at least three, may require closer knots
/// than the strip gets. Normals of single triangles are unreliable.
const OUTLIER_RATE: usize = 200;

/// The required number of spans, and the triangle that requires the closest knots.
fn spans<'a>(demands: impl Iterator<Item = &'a KnotDemand>) -> (f64, usize) {
    let mut strips: Vec<Vec<&KnotDemand>> = (0..STRIPS).map(|_| Vec::new()).collect();
    demands.for_each(|n| strips[((n.middle * STRIPS as f64) as usize).min(STRIPS - 1)].push(n));
    let (mut sum, mut closest) = (0.0, (0.0, 0));
    for strip in &mut strips {
        let rough = 3.max(strip.len() / OUTLIER_RATE);
        if strip.len() <= rough {
            continue;
        }
        let (_, demand, _) =
            strip.select_nth_unstable_by(rough, |a, b| b.density.total_cmp(&a.density));
        sum += demand.density / STRIPS as f64;
        if demand.density > closest.0 {
            closest = (demand.density, demand.triangle);
        }
    }
    (sum, closest.1)
}
