//! The order and the direction of the edges of loops with seams.
//!
//! ISO 10303-42 leaves both free. OpenCASCADE finds a face valid without healing only in some of
//! them, which were found by trying all of them:
//!
//! - Of the two uses of a seam the one against the seam comes first. Here the direction of a use
//!   is that for the normal of the surface, and the order is that of the file.
//! - A loop that jumps at a pole ends with the use that leaves the pole. So the seam must have the
//!   direction of this use.

use std::collections::HashMap;

use crate::brep::{Brep, EdgeId, EdgeUse, Face};

/// What the loops of a model need.
pub(super) struct SeamOrder {
    /// The edges that are written in the opposite direction.
    pub(super) reversed: Vec<bool>,
    /// The edges that are not written, because their face is a whole sphere.
    pub(super) left_out: Vec<bool>,
}

impl SeamOrder {
    pub(super) fn new(brep: &Brep) -> Self {
        let none = vec![false; brep.edges.len()];
        let mut order = SeamOrder { reversed: none.clone(), left_out: none };
        for face in brep.faces.iter().filter(|face| has_seams(brep, face)) {
            for ring in &face.loops {
                if is_whole(brep, face, ring) {
                    order.left_out[ring[0].edge.0] = true;
                    continue;
                }
                for (n, jumps) in brep.jumps(face, ring).into_iter().enumerate() {
                    let [towards, from] = [&ring[n], &ring[(n + 1) % ring.len()]];
                    let is_seam = towards.edge == from.edge;
                    if jumps && is_seam && towards.forward == face.forward {
                        order.reversed[towards.edge.0] = true;
                    }
                }
            }
        }
        order
    }

    /// Whether a use has the direction of its edge in the file.
    pub(super) fn forward(&self, of_loop: &EdgeUse) -> bool {
        of_loop.forward != self.reversed[of_loop.edge.0]
    }

    /// The number of the use with which a loop begins in the file.
    pub(super) fn first(&self, brep: &Brep, face: &Face, ring: &[EdgeUse]) -> usize {
        let mut used: Vec<EdgeId> = ring.iter().map(|of_loop| of_loop.edge).collect();
        used.sort_unstable();
        if !has_seams(brep, face) || used.windows(2).all(|pair| pair[0] != pair[1]) {
            return 0;
        }
        let jumps = brep.jumps(face, ring);
        let faults = |first: usize| {
            let order = (0..ring.len()).map(|n| (first + n) % ring.len());
            let mut seen: HashMap<EdgeId, bool> = HashMap::new();
            let mut faults = 0;
            for of_loop in order.map(|n| &ring[n]) {
                let along = self.forward(of_loop) == face.forward;
                if let Some(before) = seen.insert(of_loop.edge, along) {
                    faults += usize::from(before && !along);
                }
            }
            // The use before the last one arrives at the pole.
            let arrives = (first + ring.len().saturating_sub(2)) % ring.len();
            faults + usize::from(jumps.contains(&true) && !jumps[arrives])
        };
        (0..ring.len()).min_by_key(|&first| faults(first)).unwrap_or(0)
    }
}

/// Whether a loop bounds a whole sphere: it is one seam from pole to pole and back.
pub(super) fn is_whole(brep: &Brep, face: &Face, ring: &[EdgeUse]) -> bool {
    matches!(ring, [a, b] if a.edge == b.edge) && brep.jumps(face, ring) == [true; 2]
}

/// Whether a face may have a seam that needs an order. B-spline surfaces have none.
fn has_seams(brep: &Brep, face: &Face) -> bool {
    brep.surfaces[face.surface.0].spline().is_none()
}
