//! Samples sorted by knot cell.
//!
//! The input is samples and two knot vectors. The output is the list of samples in each cell of the
//! knot grid, with their positions in the cell.

use rayon::prelude::*;

use super::weight::{Metric, Weight};
use crate::geometry::{Uv, Vector};
use crate::mesh::Buckets;
use crate::spline::spans::KnotSpans;
use crate::spline::{KnotVector, Samples};

/// The knot cells of a net, and the samples in each.
pub(crate) struct KnotCells<'a> {
    /// The samples.
    pub samples: &'a Samples,
    /// The matrices by which the distances from the samples are weighted. Empty if distances in all
    /// directions count equally.
    pub metrics: &'a [Metric],
    /// Knot vectors in u and v.
    pub knots: [&'a KnotVector; 2],
    /// The spans of the knot vectors.
    pub spans: [KnotSpans; 2],
    /// The origin of the net in the equations. It is near the samples, so that sums stay accurate
    /// for a scan that is far from the origin of the coordinates.
    pub origin: Vector,
    homes: Buckets,
}

/// A sample in a cell: its position in the cell from (−1, −1) to (1, 1), its weight, and its point
/// relative to the origin.
pub(crate) struct CellSample<W> {
    pub place: Uv,
    pub weight: W,
    pub point: Vector,
}

impl<'a> KnotCells<'a> {
    /// Sorts the samples by cell. The order of samples within a cell is the order of the input, so
    /// that sums over a cell do not depend on the number of threads.
    pub(super) fn new(samples: &'a Samples, knots: [&'a KnotVector; 2]) -> Self {
        let spans = knots.map(KnotSpans::new);
        let down = spans[1].all.len();
        let home = |at: &Uv| (spans[0].find(at.x) * down + spans[1].find(at.y)) as u32;
        let homes: Vec<u32> = samples.uv.par_iter().map(home).collect();
        let count = spans[0].all.len() * down;
        let homes = Buckets::new(count, homes.len(), |i| homes[i as usize]);
        let origin = origin(samples);
        KnotCells { samples, metrics: &[], knots, spans, origin, homes }
    }

    /// The same cells with a weight matrix for each sample.
    pub(crate) fn with_metrics(self, metrics: &'a [Metric]) -> Self {
        KnotCells { metrics, ..self }
    }

    /// The number of cells in u and in v. Inner knots are simple, so a net of n control points has
    /// n − 3 cells.
    pub(crate) fn counts(&self) -> [usize; 2] {
        self.spans.each_ref().map(|s| s.all.len())
    }

    /// The number of samples in cell (p, q).
    pub(super) fn count(&self, p: usize, q: usize) -> usize {
        self.indices(p, q).len()
    }

    /// The indices of the samples in cell (p, q).
    pub(crate) fn indices(&self, p: usize, q: usize) -> &[u32] {
        self.homes.of(p * self.counts()[1] + q)
    }

    /// The samples in cell (p, q).
    pub(crate) fn samples<W: Weight>(
        &self,
        p: usize,
        q: usize,
    ) -> impl Iterator<Item = CellSample<W>> + '_ {
        let (u, v) = (&self.spans[0].all[p], &self.spans[1].all[q]);
        self.indices(p, q).iter().map(move |&i| {
            let (i, at) = (i as usize, self.samples.uv[i as usize]);
            CellSample {
                place: Uv::new(u.local(at.x), v.local(at.y)),
                weight: W::of(self, i),
                point: self.samples.points[i].coords - self.origin,
            }
        })
    }

    /// The positions of the samples in cell (p, q), from (−1, −1) to (1, 1).
    pub(crate) fn places(&self, p: usize, q: usize) -> impl Iterator<Item = Uv> + '_ {
        let (u, v) = (&self.spans[0].all[p], &self.spans[1].all[q]);
        self.indices(p, q).iter().map(move |&i| {
            let at = self.samples.uv[i as usize];
            Uv::new(u.local(at.x), v.local(at.y))
        })
    }
}

/// The number of samples that suffice to estimate the mean of all samples.
const ORIGIN_SAMPLES: usize = 1 << 12;

/// The mean of some of the samples.
fn origin(samples: &Samples) -> Vector {
    let few = samples.points.iter().step_by(samples.len().div_ceil(ORIGIN_SAMPLES).max(1));
    let (sum, count) = few.fold((Vector::zeros(), 0.0), |(sum, n), p| (sum + p.coords, n + 1.0));
    sum / f64::max(count, 1.0)
}
