//! The start of conjugate gradients on a large net: nested iteration.
//!
//! The input is samples sorted by knot cell. The output is the net of a coarser fit, refined to the
//! knots of the net. The coarser net has a quarter of the spans in u and in v and is fitted to one
//! sample in each cell. Its own fit starts in the same way.
//!
//! The coarser fit costs a sixteenth. What remains are the details that it cannot follow and the
//! noise. Its knots are a subset of the finer ones, so knot insertion represents its surface
//! exactly.

use super::knot_cells::KnotCells;
use super::normal::{NormalEquations, PaddedPoint};
use crate::spline::{KnotVector, Samples, refined};

/// The number of spans that become one span of the coarser net.
const SPANS_MERGED: usize = 4;

/// The number of spans in u and in v from which on a coarser fit is worth its cost.
const MIN_SPANS: usize = 24;

/// The net to start at, relative to the origin of the samples. It is zero if the net is small or
/// if the samples do not determine the coarser net.
pub(super) fn of(cells: &KnotCells) -> Vec<PaddedPoint> {
    coarse(cells).unwrap_or_else(|| {
        vec![PaddedPoint::zeros(); cells.spans.each_ref().map(|s| s.all.len() + 3).iter().product()]
    })
}

fn coarse(cells: &KnotCells) -> Option<Vec<PaddedPoint>> {
    if cells.counts().iter().any(|&count| count < MIN_SPANS) {
        return None;
    }
    let knots = cells.knots.map(merged);
    let samples = one_a_cell(cells);
    let coarse = KnotCells::new(&samples, [&knots[0], &knots[1]]);
    let (net, _) = super::optimum(&NormalEquations::new(&coarse), &coarse).ok()?;
    let shift = (coarse.origin - cells.origin).push(0.0);
    let net: Vec<PaddedPoint> = net.iter().map(|p| p + shift).collect();
    Some(refined(&net, knots.each_ref(), cells.knots))
}

/// The knot vector with one of every [`SPANS_MERGED`] knots.
fn merged(knots: &KnotVector) -> KnotVector {
    let breaks = knots.breaks();
    let last = breaks.len() - 1;
    let kept: Vec<f64> = (0..last).step_by(SPANS_MERGED).chain([last]).map(|i| breaks[i]).collect();
    KnotVector::clamped(3, &kept, 1)
}

/// The first sample of every cell that has samples.
fn one_a_cell(cells: &KnotCells) -> Samples {
    let [across, down] = cells.counts();
    let of = cells.samples;
    let mut some = Samples { open: of.open, ..Samples::default() };
    for at in 0..across * down {
        if let Some(&i) = cells.indices(at / down, at % down).first() {
            let i = i as usize;
            some.points.push(of.points[i]);
            some.uv.push(of.uv[i]);
            some.weights.push(of.weights[i]);
        }
    }
    some
}
