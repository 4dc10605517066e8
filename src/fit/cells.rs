//! Samples sorted by the knot cell that holds them.

use crate::spline::{KnotVector, Samples};

/// The knot cells of a net, and the samples in each.
pub struct Cells<'a> {
    /// Knot vector in u.
    pub u: &'a KnotVector,
    /// Knot vector in v.
    pub v: &'a KnotVector,
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl<'a> Cells<'a> {
    /// Sorts the samples, stably, so that sums over a cell do not depend on
    /// anything but the input's order.
    pub fn new(samples: &Samples, u: &'a KnotVector, v: &'a KnotVector) -> Self {
        let mut cells = Cells { u, v, starts: Vec::new(), order: Vec::new() };
        let [across, down] = cells.counts();
        let mut counts = vec![0u32; across * down + 1];
        let homes: Vec<u32> =
            samples.uv.iter().map(|at| cells.number(u.span(at.x) - 3, v.span(at.y) - 3)).collect();
        for &home in &homes {
            counts[home as usize + 1] += 1;
        }
        for i in 1..counts.len() {
            counts[i] += counts[i - 1];
        }
        cells.starts = counts.clone();
        cells.order = vec![0; homes.len()];
        for (i, &home) in homes.iter().enumerate() {
            cells.order[counts[home as usize] as usize] = i as u32;
            counts[home as usize] += 1;
        }
        cells
    }

    /// How many cells there are in u and in v. Knots inside are single, so a
    /// net of n control points has n − 3 cells.
    pub fn counts(&self) -> [usize; 2] {
        [self.u.functions() - 3, self.v.functions() - 3]
    }

    fn number(&self, p: usize, q: usize) -> u32 {
        (p * self.counts()[1] + q) as u32
    }

    /// The samples in cell (p, q).
    pub fn samples(&self, p: usize, q: usize) -> &[u32] {
        let n = self.number(p, q) as usize;
        &self.order[self.starts[n] as usize..self.starts[n + 1] as usize]
    }
}
