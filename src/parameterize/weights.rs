//! Mean value coordinates (Floater, "Mean value coordinates", 2003).

use std::collections::HashSet;

use crate::mesh::Mesh;

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
    /// Makes the weights uniform in the triangles given and around their
    /// vertices, where they do not determine the map in double precision.
    pub fn even_out(&mut self, mesh: &Mesh, triangles: &[usize]) {
        let around: HashSet<_> = triangles.iter().flat_map(|&t| mesh.triangles[t]).collect();
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for (k, corner) in corners.iter().enumerate() {
                if around.contains(corner) {
                    self.pairs[t][k] = [1.0, 1.0];
                }
            }
        }
    }
}
