//! The knots of a face that misses the tolerance: spans in which it does are halved.

use super::fit::{FIXED, FaceFit};
use crate::spline::KnotVector;

/// The most control points that a face can have.
pub(super) struct ControlRoom {
    /// The most of those inside, which a fit moves.
    pub inner: usize,
    /// The most of all.
    pub all: usize,
}

impl ControlRoom {
    /// The knots with halved spans, those with the most points beyond the tolerance first, as long as there is
    /// room. `None` if no span can be halved.
    pub(crate) fn halved(&self, fit: &FaceFit) -> Option<[KnotVector; 2]> {
        let knots = [&fit.surface.u, &fit.surface.v];
        let mut functions = knots.map(KnotVector::functions);
        let mut all = knots.map(|knots| knots.knots().to_vec());
        for (axis, span) in spans(fit) {
            let [m, n] = [functions[axis] + 1, functions[1 - axis]];
            if (m - 2 * FIXED) * (n - 2 * FIXED) > self.inner || m * n > self.all {
                break;
            }
            functions[axis] = m;
            let [low, high] = [0, 1].map(|k| knots[axis].knots()[span + k]);
            all[axis].push(0.5 * (low + high));
        }
        let finer = functions != knots.map(KnotVector::functions);
        finer.then(|| {
            all.map(|mut knots| {
                knots.sort_by(f64::total_cmp);
                KnotVector::new(3, knots)
            })
        })
    }
}

/// The spans with points beyond the tolerance in u (axis 0) and in v (axis 1). Those with the most points come
/// first.
fn spans(fit: &FaceFit) -> Vec<(usize, usize)> {
    let knots = [&fit.surface.u, &fit.surface.v];
    let mut counts = knots.map(|knots| vec![0; knots.knots().len()]);
    for &foot in &fit.beyond {
        let at = fit.feet[foot];
        counts[0][knots[0].span(at.x)] += 1;
        counts[1][knots[1].span(at.y)] += 1;
    }
    let of_axis = |axis: usize| (0..counts[axis].len()).map(move |span| (axis, span));
    let mut spans: Vec<(usize, usize)> = of_axis(0).chain(of_axis(1)).collect();
    spans.retain(|&(axis, span)| counts[axis][span] > 0);
    spans.sort_by_key(|&(axis, span)| std::cmp::Reverse(counts[axis][span]));
    spans
}
