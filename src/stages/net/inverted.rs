//! Quads on which a subdivision surface is turned over.

use rayon::prelude::*;

use super::Net;
use crate::geometry::Uv;
use crate::spline::subdivision::QuadPlace;

/// The number of samples along a side of a quad.
const SAMPLES: usize = 5;

/// The cosine of the angle to the scan's normal beyond which the surface counts as turned over (84°). The
/// patches beside irregular vertices, which are not exact, turn by a few degrees more.
const TURNED: f64 = 0.1;

/// The quads on which the surface is turned over: a normal differs from that of the scan where the
/// layout has put the place.
pub(super) fn quads(net: &Net) -> Vec<usize> {
    let control = net.control();
    let is_inverted = |scratch: &mut Vec<[f64; 3]>, quad: usize| {
        let at = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
        let is_off = |k: usize| {
            let at = Uv::new(at(k % SAMPLES), at(k / SAMPLES));
            let [_, du, dv] = net.surface.jet(&control, QuadPlace { quad, at }, scratch);
            let (normal, facing) = (du.cross(&dv), net.mesh.normal(quad, at));
            normal.dot(&facing) <= TURNED * normal.norm() * facing.norm()
        };
        (0..SAMPLES * SAMPLES).any(is_off).then_some(quad)
    };
    let all = (0..net.mesh.quads.len()).into_par_iter().map_init(Vec::new, is_inverted);
    all.flatten_iter().collect()
}
