//! How much each vertex of a map counts in a fit.

use crate::geometry::{VertexId, unit_normal};
use crate::mesh::Parameterized;
use crate::mesh::{EdgeMap, FaceOrigin, Patch};

/// Weight of a vertex that was not measured: it holds the surface where nothing else does, and
/// yields to measured vertices beside it.
const FILLED: f64 = 0.3;

/// Weight of a vertex that closes a bay. Nothing of it is in the face. It keeps the surface
/// from running wild where nothing else holds it, and a hundredth of a filled vertex is not felt
/// elsewhere.
const BAY: f64 = 3e-3;

/// Weight of a bay's vertices near a fold, which are no guide: just above 0, as equations need
/// it.
const ASTRAY: f64 = 3e-7;

/// A bay counts as folded where two triangles of it, or one beside it, have normals with a
/// smaller cosine between them: over an edge of a smooth sheet
/// they do not turn by 73 degrees.
const FOLDED: f64 = 0.3;

/// So many rings of vertices around a fold are near it: it reaches beyond the edge at which it
/// shows.
const NEAR: usize = 2;

/// Weight of a vertex of the patch's boundary, as a multiple. An inner vertex has neighbours on
/// all sides that hold the surface with it; at the boundary few do.
const SIDE: f64 = 4.0;

/// Weight of a corner of the domain, as a multiple: so much that the surface all but passes
/// through it. The corner of the net is then moved into it.
pub(crate) const CORNER: f64 = 1e3;

/// The weights of a map's vertices; `is_corner` tells those in the domain's corners.
pub(crate) fn weights(map: &Parameterized, is_corner: impl Fn(VertexId) -> bool) -> Vec<f64> {
    let patch = &map.patch;
    let mut weights = patch.counts();
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
