//! Mean value coordinates (Floater, "Mean value coordinates", 2003).

use crate::mesh::{Mesh, Patch};

/// Weights of the six directed edges of every triangle: `pairs[t][k]` holds
/// what triangle t adds to the weight of its corner k+1, and of its corner
/// k+2, in the equation of its corner k. The weight of an edge is the sum over
/// its two triangles.
pub struct Weights {
    pub pairs: Vec<[[f64; 2]; 3]>,
}

/// w(i→j) = (tan(α/2) + tan(β/2)) / ‖j − i‖ with the angles at i on both sides
/// of the edge. All are positive, so the map is a convex combination.
pub fn mean_value(mesh: &Mesh) -> Weights {
    let least = 1e-9 * mesh.mean_edge();
    let of = |t: &[crate::geometry::VertexId; 3]| {
        let p = mesh.corners(*t);
        [0, 1, 2].map(|k| {
            let (d, e) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            let (dl, el) = (d.norm().max(least), e.norm().max(least));
            // tan(α/2) = sin α / (1 + cos α); bounded where a needle's angle
            // comes near a half turn, and from below where it vanishes.
            let tan = d.cross(&e).norm() / (dl * el + d.dot(&e)).max(1e-8 * dl * el);
            [tan.max(1e-8) / dl, tan.max(1e-8) / el]
        })
    };
    Weights { pairs: mesh.triangles.iter().map(of).collect() }
}

impl Weights {
    /// Divides the weight of every neighbour by the square root of the stretch
    /// there (the damped form), so that stretched regions draw their
    /// surroundings less and widen.
    pub fn even_stretch(&mut self, patch: &Patch, stretch: &[f64]) {
        for (t, pairs) in patch.mesh.triangles.iter().zip(&mut self.pairs) {
            for k in 0..3 {
                for (j, weight) in pairs[k].iter_mut().enumerate() {
                    *weight /= stretch[t[(k + 1 + j) % 3].index()].sqrt();
                }
            }
        }
    }
}
