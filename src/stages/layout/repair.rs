//! Repair of quads that face away from the scan: by relaxation with larger weights, on a smoother ground,
//! and by smaller blocks.

use super::base::{Base, TrianglePlace};
use super::flips::split_side;
use super::grid::BlockGrid;
use super::ground::Ground;
use super::relax::Relaxed;
use crate::error::Result;
use crate::progress::Progress;

/// Sweeps of relaxation without and with the barrier.
const PLAIN: usize = 20;
const BARRIER: usize = 40;

/// The factor by which the weight of bad quads grows in a round of repair.
const HEAVIER: f64 = 3.0;

/// The sweeps around bad quads in each round, and the most rounds in a row that leave as many of them.
const LOCAL: usize = 6;

/// The ground is smoothed under bad quads. First only those are smoothed that are smaller than this number
/// of the ground's edges, because the scan tells no more about their shape.
const SMALL: f64 = 4.0;

/// Repair ends when this many smoothings in a row have left as many bad quads as before.
const IN_VAIN: usize = 2;

/// Blocks are split where bad quads are larger than this number of the ground's edges. Smaller blocks
/// do not help at creases of the size of the edges.
const COARSE: f64 = 2.5;

/// A grid whose vertices were relaxed.
#[derive(Default)]
pub(super) struct RelaxedGrid {
    pub grid: BlockGrid,
    /// The bad quads.
    pub bad: Vec<usize>,
    /// The bad quads that smaller blocks may mend.
    coarse: Vec<usize>,
}

impl RelaxedGrid {
    /// The blocks that should be smaller.
    pub(crate) fn coarse(&self) -> Vec<usize> {
        let per_block = self.grid.mesh.side * self.grid.mesh.side;
        let mut blocks: Vec<usize> = self.coarse.iter().map(|q| q / per_block).collect();
        blocks.dedup();
        blocks
    }
}

/// Relaxes vertices, all or those that are `chosen`, and repairs bad quads as far as possible without
/// another layout.
pub(super) fn relaxed(
    mut grid: BlockGrid,
    ground: &mut Ground,
    chosen: Option<&[bool]>,
    progress: &mut Progress,
) -> Result<RelaxedGrid> {
    let mut relaxed = Relaxed::new(&grid.mesh, ground, grid.places);
    for sweep in 0..PLAIN + BARRIER {
        progress(sweep as f64 / (PLAIN + BARRIER) as f64)?;
        relaxed.sweep(chosen, sweep >= PLAIN);
    }
    let mut best = (relaxed.bad().len(), relaxed.places.clone());
    let mut in_vain = 0;
    loop {
        let before = best.0;
        reweigh(&mut relaxed, &mut best);
        in_vain = if best.0 < before { 0 } else { in_vain + 1 };
        let bad = relaxed.bad();
        if best.0 == 0 || in_vain == IN_VAIN {
            break;
        }
        let small: Vec<usize> =
            bad.iter().copied().filter(|&q| relaxed.ground_edges(q) < SMALL).collect();
        relaxed.smooth_under(if small.is_empty() { &bad } else { &small });
    }
    let relaxed = Relaxed::new(&grid.mesh, ground, best.1);
    let bad = relaxed.bad();
    let coarse = bad.iter().copied().filter(|&q| relaxed.ground_edges(q) > COARSE).collect();
    grid.places = relaxed.places;
    Ok(RelaxedGrid { grid, bad, coarse })
}

/// Relaxes around bad quads with larger and larger weights, and keeps the best state.
fn reweigh(relaxed: &mut Relaxed, best: &mut (usize, Vec<TrianglePlace>)) {
    let mut in_vain = 0;
    loop {
        let bad = relaxed.bad();
        in_vain += 1;
        if bad.len() < best.0 {
            *best = (bad.len(), relaxed.places.clone());
            in_vain = 0;
        }
        if bad.is_empty() || in_vain > LOCAL {
            return;
        }
        relaxed.weigh(&bad, HEAVIER);
        let chosen = vertices_near(relaxed, &bad);
        (0..LOCAL).for_each(|_| relaxed.sweep(Some(&chosen), true));
    }
}

/// The vertices of some quads and of the quads around them.
fn vertices_near(relaxed: &Relaxed, quads: &[usize]) -> Vec<bool> {
    let mut own = vec![false; relaxed.places.len()];
    quads.iter().flat_map(|&q| relaxed.mesh.quads[q]).for_each(|v| own[v.index()] = true);
    relaxed.mesh.with_neighbours(&own)
}

/// Splits the longest side of the base in each of some blocks. A block whose triangles have been split since the grid was
/// made is smaller in the next one. Returns whether there is such a block, or one could be split.
pub(super) fn split_blocks(
    base: &mut Base,
    ground: &Ground,
    grid: &BlockGrid,
    blocks: &[usize],
) -> bool {
    let mut split = false;
    for &block in blocks {
        let pair = grid.triangles[block];
        let alive = pair.into_iter().filter(|&t| base.alive[t as usize]);
        let sides = alive.flat_map(|t| (0..3).map(move |k| (t as usize, k)));
        let length = |&(t, k): &(usize, usize)| base.side_length(t, k);
        let longest = sides.max_by(|x, y| length(x).total_cmp(&length(y)).then(y.cmp(x)));
        split |= longest.is_none_or(|(t, k)| split_side(base, ground, t, k));
    }
    split
}
