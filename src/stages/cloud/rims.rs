//! Rims of meshes of means: a mean lies inside its points, so that rims through means would be half a cell short.

use std::collections::HashMap;

use formats::{Points, Soup};

use super::LEFT_OUT;
use crate::geometry::{FEW, Point, Vector, VertexId, unit_normal};
use crate::mesh::{EdgeMap, Mesh};
use crate::statistics::quantile;

/// The share of the points below the lower quartile.
const QUARTER: f64 = 0.25;

/// How far the points of one vertex of a rim reach outward.
#[derive(Default)]
struct Reach {
    outward: Vector,
    /// How far outward each point is.
    along: Vec<f64>,
}

/// Moves the vertices of rims outward to where their points end. `vertex_of` has the vertex of each point. Both the
/// places of the triangles and those where vertices were measured move.
pub(super) fn extend(
    soup: &mut Soup,
    measured: &mut [[f64; 3]],
    cloud: &Points,
    vertex_of: &[u32],
) {
    let mut rims = outward(soup);
    for (position, vertex) in cloud.positions.iter().zip(vertex_of) {
        let Some(reach) = (*vertex != LEFT_OUT).then(|| rims.get_mut(vertex)).flatten() else {
            continue;
        };
        let own = Point::from(soup.points[*vertex as usize]);
        reach.along.push((Point::from(*position) - own).dot(&reach.outward));
    }
    for (&vertex, reach) in &mut rims {
        let by = reach.length() * reach.outward;
        for places in [soup.points.as_mut_slice(), &mut *measured] {
            let Some(place) = places.get_mut(vertex as usize) else { continue };
            *place = (Point::from(*place) + by).into();
        }
    }
}

impl Reach {
    /// Points that are spread evenly end as far beyond their median as this is beyond their end on the other side, and
    /// their quartile is in the middle between the two. Noise blurs the outer end only. Few points do not tell.
    fn length(&mut self) -> f64 {
        if self.along.len() < FEW {
            return 0.0;
        }
        let at = |share| quantile(&mut self.along, share);
        let [quartile, median] = [QUARTER, 2.0 * QUARTER].map(at);
        quartile
            .zip(median)
            .map_or(0.0, |(quartile, median)| 3.0 * median - 2.0 * quartile)
            .max(0.0)
    }
}

/// The vertices of rims, each with the direction in which its triangles end.
fn outward(soup: &Soup) -> HashMap<u32, Reach> {
    let points = soup.points.iter().map(|&p| Point::from(p)).collect();
    let corners = |corners: &[u32]| [0, 1, 2].map(|k| VertexId(corners[k]));
    let mesh = Mesh { points, triangles: soup.polygons.iter().map(corners).collect() };
    let mut rims: HashMap<u32, Reach> = HashMap::new();
    for side in EdgeMap::new(&mesh).open_sides() {
        let normal = unit_normal(mesh.corners(mesh.triangles[side / 3])).unwrap_or_default();
        let (from, to) = mesh.side(side);
        let outward = (mesh.point(to) - mesh.point(from)).cross(&normal);
        [from, to].into_iter().for_each(|v| rims.entry(v.0).or_default().outward += outward);
    }
    for reach in rims.values_mut() {
        reach.outward = reach.outward.try_normalize(0.0).unwrap_or_default();
    }
    rims
}
