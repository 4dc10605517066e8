//! Where conjugate gradients start on a large net: at the fit of a net of a quarter
//! as many spans in u and in v to one sample a cell, which has itself started so.
//!
//! What is left to do is what the coarser net cannot follow and what is noise; most of
//! the way from nothing is gone at a sixteenth of the cost. The coarser knots are among
//! the finer ones, so that its surface is one over these, too.

use super::cells::Cells;
use super::normal::{Equations, Lane};
use crate::spline::{KnotVector, Samples, refined};

/// So many of a net's spans make one of the coarser net.
const MERGED: usize = 4;

/// Spans in u and in v from which on a start pays.
const LEAST: usize = 24;

/// The net to start at, from the samples' origin; zeros for nets that are small, or whose
/// coarser ones samples do not determine.
pub fn of(cells: &Cells) -> Vec<Lane> {
    coarse(cells).unwrap_or_else(|| {
        vec![Lane::zeros(); cells.spans.each_ref().map(|s| s.all.len() + 3).iter().product()]
    })
}

fn coarse(cells: &Cells) -> Option<Vec<Lane>> {
    if cells.counts().iter().any(|&count| count < LEAST) {
        return None;
    }
    let knots = cells.knots.map(merged);
    let samples = one_a_cell(cells);
    let coarse = Cells::new(&samples, [&knots[0], &knots[1]]);
    let (net, _) = super::optimum(&Equations::new(&coarse), &coarse).ok()?;
    let shift = (coarse.origin - cells.origin).push(0.0);
    let net: Vec<Lane> = net.iter().map(|p| p + shift).collect();
    Some(refined(&net, knots.each_ref(), cells.knots))
}

/// Every fourth knot.
fn merged(knots: &KnotVector) -> KnotVector {
    let breaks = knots.breaks();
    let last = breaks.len() - 1;
    let kept: Vec<f64> = (0..last).step_by(MERGED).chain([last]).map(|i| breaks[i]).collect();
    KnotVector::clamped(3, &kept, 1)
}

/// The first sample of every cell that has any.
fn one_a_cell(cells: &Cells) -> Samples {
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
