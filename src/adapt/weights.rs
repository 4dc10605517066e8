//! How much each vertex of a map counts in a fit.

use crate::geometry::{VertexId, unit_normal};
use crate::mesh::Parameterized;
use crate::mesh::{EdgeMap, FaceOrigin, Patch};

/// Weight of a vertex that was not measured.
const FILLED: f64 = 0.3;

/// Weight of one that closes a bay. Nothing of it is in the face; it keeps the surface
/// from running wild where nothing else holds it, and shall not be felt elsewhere.
const BAY: f64 = 3e-3;

/// Weight of a bay's vertices near a fold, which are no guide.
const ASTRAY: f64 = 3e-7;

/// The cosine of the angle between triangles of a bay, or beside it, from which on it
/// counts as folded there …
const FOLDED: f64 = 0.3;

/// … and how many rings of vertices around are near.
const NEAR: usize = 2;

/// Weight of a vertex of the patch's boundary, as a multiple. Where the surface ends,
/// or goes on without samples, few of them beside it hold it.
const SIDE: f64 = 4.0;

/// Weight of a corner of the domain, which the patch is to meet, as a multiple.
pub const CORNER: f64 = 1e3;

/// The weights of a map's vertices; `is_corner` tells those in the domain's corners.
pub fn weights(map: &Parameterized, is_corner: impl Fn(VertexId) -> bool) -> Vec<f64> {
    let patch = &map.patch;
    let mut weights = vec![1.0; patch.measured];
    weights.resize(patch.mesh.points.len(), FILLED);
    if patch.measured_outer.is_some() {
        let of_bays = bays(patch).flat_map(|t| patch.mesh.triangles[t]).map(|v| (v, BAY));
        for (v, weight) in of_bays.chain(astray(patch).into_iter().map(|v| (v, ASTRAY))) {
            if !patch.is_measured(v) {
                weights[v.index()] = weight;
            }
        }
    }
    for &v in &patch.outer {
        weights[v.index()] *= if is_corner(v) { CORNER } else { SIDE };
    }
    weights
}

/// The numbers of the triangles that close bays.
fn bays(patch: &Patch) -> impl Iterator<Item = usize> + '_ {
    (0..patch.origin.len()).filter(|&t| patch.origin[t] == FaceOrigin::Bay)
}

/// The vertices of bays near places where these fold.
fn astray(patch: &Patch) -> Vec<VertexId> {
    let (mesh, edges) = (&patch.mesh, EdgeMap::new(&patch.mesh));
    let normal = |t: usize| unit_normal(mesh.corners(mesh.triangles[t])).unwrap_or_default();
    let folds = |t: usize, k: usize| {
        edges.across(3 * t + k).is_some_and(|s| normal(s / 3).dot(&normal(t)) < FOLDED)
    };
    let mut is_near = vec![false; mesh.points.len()];
    for t in bays(patch) {
        let corners = mesh.triangles[t];
        for k in (0..3).filter(|&k| folds(t, k)) {
            [k, (k + 1) % 3].iter().for_each(|&k| is_near[corners[k].index()] = true);
        }
    }
    for _ in 0..NEAR {
        let triangles = bays(patch).map(|t| mesh.triangles[t]);
        let touched = triangles.filter(|t| t.iter().any(|v| is_near[v.index()]));
        let touched: Vec<VertexId> = touched.flatten().collect();
        touched.into_iter().for_each(|v| is_near[v.index()] = true);
    }
    (0..is_near.len()).filter(|v| is_near[*v]).map(VertexId::from).collect()
}
