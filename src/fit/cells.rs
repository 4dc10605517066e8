//! Samples sorted by the knot cell that holds them.

use rayon::prelude::*;

use super::weight::{Metric, Weight};
use crate::geometry::{Uv, Vector};
use crate::mesh::Buckets;
use crate::spline::spans::KnotSpans;
use crate::spline::{KnotVector, Samples};

/// The knot cells of a net, and the samples in each.
pub struct Cells<'a> {
    /// The samples.
    pub samples: &'a Samples,
    /// How distances from them count in different directions; none where that is all
    /// the same.
    pub metrics: &'a [Metric],
    /// Knot vectors in u and v.
    pub knots: [&'a KnotVector; 2],
    /// Their spans.
    pub spans: [KnotSpans; 2],
    /// Where the net is counted from, so that sums do not suffer from a scan
    /// that lies far from the origin.
    pub origin: Vector,
    homes: Buckets,
}

/// A sample in a cell: its place in the cell, (−1, −1) to (1, 1), its weight,
/// and its point less the origin.
pub struct Local<W> {
    pub place: Uv,
    pub weight: W,
    pub point: Vector,
}

impl<'a> Cells<'a> {
    /// Sorts the samples, stably, so that sums over a cell do not depend on
    /// anything but the input's order.
    pub fn new(samples: &'a Samples, knots: [&'a KnotVector; 2]) -> Self {
        let spans = knots.map(KnotSpans::new);
        let down = spans[1].all.len();
        let home = |at: &Uv| (spans[0].find(at.x) * down + spans[1].find(at.y)) as u32;
        let homes: Vec<u32> = samples.uv.par_iter().map(home).collect();
        let count = spans[0].all.len() * down;
        let homes = Buckets::new(count, homes.len(), |i| homes[i as usize]);
        let origin = origin(samples);
        Cells { samples, metrics: &[], knots, spans, origin, homes }
    }

    /// The same, each sample's distance counting by a matrix of its own.
    pub fn with_metrics(self, metrics: &'a [Metric]) -> Self {
        Cells { metrics, ..self }
    }

    /// How many cells there are in u and in v. Knots inside are single, so a
    /// net of n control points has n − 3 cells.
    pub fn counts(&self) -> [usize; 2] {
        self.spans.each_ref().map(|s| s.all.len())
    }

    /// How many samples cell (p, q) has.
    pub fn count(&self, p: usize, q: usize) -> usize {
        self.indices(p, q).len()
    }

    /// The samples in cell (p, q), by their index.
    pub fn indices(&self, p: usize, q: usize) -> &[u32] {
        self.homes.of(p * self.counts()[1] + q)
    }

    /// The samples in cell (p, q).
    pub fn samples<W: Weight>(&self, p: usize, q: usize) -> impl Iterator<Item = Local<W>> + '_ {
        let (u, v) = (&self.spans[0].all[p], &self.spans[1].all[q]);
        self.indices(p, q).iter().map(move |&i| {
            let (i, at) = (i as usize, self.samples.uv[i as usize]);
            Local {
                place: Uv::new(u.local(at.x), v.local(at.y)),
                weight: W::of(self, i),
                point: self.samples.points[i].coords - self.origin,
            }
        })
    }

    /// The places of the samples in cell (p, q).
    pub fn places(&self, p: usize, q: usize) -> impl Iterator<Item = Uv> + '_ {
        let (u, v) = (&self.spans[0].all[p], &self.spans[1].all[q]);
        self.indices(p, q).iter().map(move |&i| {
            let at = self.samples.uv[i as usize];
            Uv::new(u.local(at.x), v.local(at.y))
        })
    }
}

/// So many samples tell where about their middle is.
const FEW: usize = 1 << 12;

/// The mean of some of the samples.
fn origin(samples: &Samples) -> Vector {
    let few = samples.points.iter().step_by(samples.len().div_ceil(FEW).max(1));
    let (sum, count) = few.fold((Vector::zeros(), 0.0), |(sum, n), p| (sum + p.coords, n + 1.0));
    sum / f64::max(count, 1.0)
}
