//! Places that the map crushes so much that no affordable net holds the tolerance
//! there.

use std::fmt::{self, Display, Formatter};

use rayon::prelude::*;

use super::Parameterized;
use super::stretch;
use crate::geometry::Point;

/// Where the map leaves too little room.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Crushed {
    /// Knot spans in u and in v that the tolerance asks for.
    pub spans: [f64; 2],
    /// Where they have to be closest.
    pub at: Point,
}

impl Crushed {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Crushed { at: self.at * factor, ..self }
    }
}

impl Display for Crushed {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let ([m, n], at) = (self.spans, self.at);
        write!(
            f,
            "the map crushes what sticks out: near ({:.3}, {:.3}, {:.3}) the tolerance needs knots as close as in a net of {m:.0} × {n:.0}; cut the scan there and convert the pieces, or raise --tolerance or --max-net",
            at.x, at.y, at.z
        )
    }
}

/// What one triangle asks for: its middle in a parameter, and spans for each
/// unit of that parameter.
struct Need {
    middle: f64,
    density: f64,
    triangle: usize,
}

/// Looks whether a net of `max_net` control points can hold the `tolerance`, in
/// mm, on the measured triangles, those left out that were divided because the map
/// draws them out: where these run up to a crease, the smaller they are the sharper it is.
///
/// A cubic span of length h on a circle of curvature κ is κ³h⁴/384 off it. That
/// tells how close the knots have to be at each triangle in u and in v, and as a
/// knot line runs across the whole patch, the closest along it decides. Roughness
/// needs more knots than this tells, so what is said to be too much, is.
pub fn crushed(map: &Parameterized, tolerance: f64, max_net: usize) -> Option<Crushed> {
    let normals: Vec<Point> =
        map.patch.mesh.vertex_normals().into_iter().map(Point::from).collect();
    let patch = &map.patch;
    let is_whole = |t: &usize| patch.mesh.triangles[*t].iter().all(|&v| patch.is_measured(v));
    let triangles: Vec<usize> = patch.measured_triangles().filter(is_whole).collect();
    let needs: Vec<[Need; 2]> =
        triangles.par_iter().map(|&t| needs(map, &normals, tolerance, t)).collect();
    let along = |k: usize| spans(needs.iter().map(|need| &need[k]));
    let (along_u, along_v) = rayon::join(|| along(0), || along(1));
    if along_u.0 * along_v.0 <= max_net as f64 {
        return None;
    }
    let (_, triangle) = if along_u.0 > along_v.0 { along_u } else { along_v };
    let at = map.patch.mesh.point(map.patch.mesh.triangles[triangle][0]);
    Some(Crushed { spans: [along_u.0, along_v.0], at })
}

fn needs(map: &Parameterized, normals: &[Point], tolerance: f64, t: usize) -> [Need; 2] {
    let corners = map.patch.mesh.triangles[t];
    let places = corners.map(|v| map.uv[v.index()]);
    let along = stretch::derivatives(map.patch.mesh.corners(corners), places, 0.0);
    let turn = stretch::derivatives(corners.map(|v| normals[v.index()]), places, 0.0);
    let need = |k: usize| {
        let (along, turn) = ([along.2, along.3][k].norm(), [turn.2, turn.3][k].norm());
        // (κ³ / 384 tolerance)^¼ spans for a mm, κ = turn / along.
        let density = (turn.powi(3) * along / (384.0 * tolerance)).powf(0.25);
        let middle = places.iter().map(|at| at[k]).sum::<f64>() / 3.0;
        Need { middle, density: if density.is_finite() { density } else { 0.0 }, triangle: t }
    };
    [need(0), need(1)]
}

/// Strips across a parameter in which the closest knots are looked for.
const STRIPS: usize = 256;

/// This share of a strip's triangles, and three, may ask for more than it gets:
/// normals are rough at single triangles.
const ROUGH: usize = 200;

/// How many spans that makes, and the triangle that needs the closest.
fn spans<'a>(needs: impl Iterator<Item = &'a Need>) -> (f64, usize) {
    let mut strips: Vec<Vec<&Need>> = (0..STRIPS).map(|_| Vec::new()).collect();
    needs.for_each(|n| strips[((n.middle * STRIPS as f64) as usize).min(STRIPS - 1)].push(n));
    let (mut sum, mut closest) = (0.0, (0.0, 0));
    for strip in &mut strips {
        let rough = 3.max(strip.len() / ROUGH);
        if strip.len() <= rough {
            continue;
        }
        let (_, need, _) =
            strip.select_nth_unstable_by(rough, |a, b| b.density.total_cmp(&a.density));
        sum += need.density / STRIPS as f64;
        if need.density > closest.0 {
            closest = (need.density, need.triangle);
        }
    }
    (sum, closest.1)
}
