//! The knots of a face that misses the tolerance: spans in which it does are halved.

use super::fit::FaceFit;
use crate::spline::KnotVector;

/// The knots with halved spans. The spans with the most points beyond the tolerance come first, as long as the
/// face has at most `most` control points. `None` if no span can be halved.
pub(super) fn halved(fit: &FaceFit, most: usize) -> Option<[KnotVector; 2]> {
    let knots = [&fit.surface.u, &fit.surface.v];
    let mut counts = knots.map(|knots| vec![0; knots.functions()]);
    for at in &fit.beyond_at {
        let spans = [knots[0].span(at.x), knots[1].span(at.y)];
        (0..2).for_each(|axis| counts[axis][spans[axis]] += 1);
    }
    let spans = |axis: usize| (0..counts[axis].len()).map(move |span| (axis, span));
    let mut order: Vec<(usize, usize)> = spans(0).chain(spans(1)).collect();
    order.retain(|&(axis, span)| counts[axis][span] > 0);
    order.sort_by_key(|&(axis, span)| std::cmp::Reverse(counts[axis][span]));
    let mut functions = knots.map(KnotVector::functions);
    let mut all = knots.map(|knots| knots.knots().to_vec());
    for (axis, span) in order {
        if (functions[axis] + 1) * functions[1 - axis] > most {
            break;
        }
        functions[axis] += 1;
        let [low, high] = [0, 1].map(|k| knots[axis].knots()[span + k]);
        all[axis].push(0.5 * (low + high));
    }
    let more = functions != knots.map(KnotVector::functions);
    more.then(|| {
        all.map(|mut knots| {
            knots.sort_by(f64::total_cmp);
            KnotVector::new(3, knots)
        })
    })
}
