//! The places at which a scan is farthest from its face.

use super::ReportView;
use crate::geometry::Point;

/// A vertex of the scan with its distances in mm, positive above the face.
pub(super) struct FarPlace {
    pub at: Point,
    pub measured: f32,
    pub smoothed: f32,
}

/// The number of places: a table of these is read at a glance.
const COUNT: usize = 8;

/// How far the places are from each other at least, as a share of the scan's diagonal: the
/// neighbours of the farthest vertex are nearly as far and tell nothing new.
const APART: f64 = 0.05;

/// The places at which the points as measured are farthest from the face, the farthest first.
pub(super) fn far_places(view: &ReportView) -> Vec<FarPlace> {
    let mesh = &view.scan.mesh;
    let far = |v: &usize| view.measured[view.scan.old[*v]].abs();
    let mut order: Vec<usize> = (0..mesh.points.len()).collect();
    order.sort_by(|a, b| far(b).total_cmp(&far(a)));
    let apart = APART * mesh.diagonal();
    let mut chosen: Vec<usize> = Vec::new();
    for v in order {
        if chosen.iter().all(|&w| (mesh.points[v] - mesh.points[w]).norm() > apart) {
            chosen.push(v);
        }
        if chosen.len() == COUNT {
            break;
        }
    }
    let place = |v: usize| {
        let old = view.scan.old[v];
        FarPlace { at: mesh.points[v], measured: view.measured[old], smoothed: view.smoothed[old] }
    };
    chosen.into_iter().map(place).collect()
}
