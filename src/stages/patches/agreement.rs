//! The tangent planes of patches that meet at irregular vertices.
//!
//! The fit of a corner cannot reach the normals of the limit surface along both spokes: it has too few control
//! points. But patches need not reach them, as long as neighbours have the same tangent planes. So in each round the
//! two patches beside a spoke are fitted to the mean of their normals.

use rayon::prelude::*;

use super::corners::CornerFit;
use super::{FittedPatch, PatchSource};
use crate::geometry::Vector;

/// The number of rounds. Most of what they reach is reached after three.
const ROUNDS: usize = 10;

/// Makes patches that meet at irregular vertices agree in their normals along the sides that they share. Each
/// vertex keeps the round with the smallest largest angle, because where a spoke and the rows beside it have almost one
/// direction, the rounds may lead away.
pub(super) fn agree(source: &PatchSource, patches: &mut [FittedPatch]) {
    let mut best = vec![f64::INFINITY; source.mesh.points.len()];
    let corners = corners(source, patches.len());
    let mut kept = vec![Vec::new(); corners.len()];
    for round in 0..=ROUNDS {
        let own: Vec<[[Vec<Vector>; 2]; 4]> =
            patches.par_iter().map(FittedPatch::along_spokes).collect();
        let mut largest = vec![0.0; best.len()];
        for &Corner { block, k, other, side, vertex } in &corners {
            let pairs = own[block][k][1].iter().zip(&own[other][side][0]);
            let widest = pairs.clone().map(|(n, m)| n.angle(m)).fold(largest[vertex], f64::max);
            largest[vertex] = widest;
            let mean = |(n, m): (&Vector, &Vector)| (n + m).try_normalize(0.0).unwrap_or(*n);
            let means: Vec<Vector> = pairs.map(mean).collect();
            let towards = |fit: Option<&mut CornerFit>, spoke: usize| {
                fit.map(|fit| fit.normals[spoke].clone_from(&means))
            };
            towards(patches[other].fits[side].as_mut(), 0);
            towards(patches[block].fits[k].as_mut(), 1);
        }
        for (corner, kept) in corners.iter().zip(&mut kept) {
            let FittedPatch { surface, fits } = &patches[corner.block];
            if let Some(fit) = &fits[corner.k]
                && largest[corner.vertex] < best[corner.vertex]
            {
                *kept = fit.points(surface);
            }
        }
        best.iter_mut().zip(&largest).for_each(|(best, largest)| *best = best.min(*largest));
        if round < ROUNDS {
            patches.par_iter_mut().for_each(|FittedPatch { surface, fits }| {
                fits.iter_mut().flatten().for_each(|fit| source.fit_again(fit, surface));
            });
        }
    }
    for (corner, kept) in corners.iter().zip(kept) {
        let FittedPatch { surface, fits } = &mut patches[corner.block];
        if let Some(fit) = &fits[corner.k] {
            fit.set(surface, kept);
        }
    }
}

/// A corner of a block, and the corner beside it, whose first spoke is the second one of this corner.
struct Corner {
    block: usize,
    k: usize,
    other: usize,
    side: usize,
    vertex: usize,
}

/// The corners of all blocks.
fn corners(source: &PatchSource, blocks: usize) -> Vec<Corner> {
    let per_block = source.mesh.side * source.mesh.side;
    let of_block = |corner: usize| {
        let (block, k) = (corner / 4, corner % 4);
        let (quad, side) = source.surface.across(source.quad_at(block, k, 0), (k + 3) % 4);
        let vertex = source.mesh.corner(block, k).index();
        Corner { block, k, other: quad / per_block, side, vertex }
    };
    (0..4 * blocks).map(of_block).collect()
}

impl FittedPatch {
    /// The normals along the spokes of each corner in an irregular vertex.
    fn along_spokes(&self) -> [[Vec<Vector>; 2]; 4] {
        let along = |fit: &CornerFit| fit.along_spokes(&self.surface);
        self.fits.each_ref().map(|fit| fit.as_ref().map(along).unwrap_or_default())
    }
}
