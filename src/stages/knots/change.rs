//! Insertion of knot lines where a surface misses points, and removal of knot lines with little
//! effect.
//!
//! A knot line adds control points across the whole net, so the direction in which a span is halved
//! matters. If the surface bends along u more sharply than its knots allow there, lines in v do not
//! help.

use rayon::prelude::*;

use super::jumps::Jumps;
use crate::geometry::{BLOCK, Uv};
use crate::spline::{KnotVector, Surface};

/// A place at which the surface misses a point, and the distance. The distance is the weight of the
/// place.
pub(crate) type Miss = (Uv, f64);

/// A span is halved in both directions unless the gain in one is smaller than this share of the
/// gain in the other.
const BOTH_DIRECTIONS: f64 = 0.5;

/// Only spans whose sum of misses is at least this share of the largest sum are halved. The next
/// fit shows what a few lines achieve.
const MIN_SCORE_SHARE: f64 = 0.05;

/// The limits on the knots that are inserted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InsertionLimits {
    /// Spans shorter than 2^−`depth` of the domain are not made.
    pub depth: u32,
    /// The largest number of control points of the net.
    pub most: usize,
    /// The smallest sum of misses of a span for each control point that halving the span adds.
    pub price: f64,
}

/// The knot vectors with a knot in the middle of the spans with large misses, the largest first.
/// They are unchanged if no span can be halved. Only the part of a span inside `reach` is
/// considered; `reach` holds the lowest and the highest parameters of all points.
pub(crate) fn insert(
    surface: &Surface,
    misses: &[Miss],
    reach: [Uv; 2],
    bounds: &InsertionLimits,
) -> [KnotVector; 2] {
    let jumps = Jumps::new(surface);
    let shortest = 1.001 * 0.5f64.powi(bounds.depth.min(1000) as i32);
    let reached = |axis: usize, span: usize| {
        let ends = &jumps.breaks[axis][span..span + 2];
        [ends[0].max(reach[0][axis]), ends[1].min(reach[1][axis])]
    };
    let long = |axis: usize, span: usize| {
        let [start, end] = reached(axis, span);
        end - start > shortest
    };
    let knots = [&surface.u, &surface.v];
    let none = || knots.map(|k| vec![0.0; k.functions() - 3]);
    let score = |misses: &[Miss]| {
        let mut scores = none();
        for &(at, size) in misses {
            let place = [0, 1].map(|axis| knots[axis].span(at[axis]) - 3);
            let gain = [0, 1].map(|axis| match long(axis, place[axis]) {
                true => jumps.of_cell(axis, place),
                false => -1.0,
            });
            for axis in 0..2 {
                if gain[axis] >= 0.0 && gain[axis] >= BOTH_DIRECTIONS * gain[1 - axis] {
                    scores[axis][place[axis]] += size;
                }
            }
        }
        scores
    };
    let blocks: Vec<[Vec<f64>; 2]> = misses.par_chunks(BLOCK).map(score).collect();
    let mut scores = none();
    for (axis, block) in blocks.iter().flat_map(|block| block.iter().enumerate()) {
        scores[axis].iter_mut().zip(block).for_each(|(sum, more)| *sum += more);
    }
    let mut spans: Vec<(f64, usize, usize)> = Vec::new();
    for (axis, scores) in scores.iter().enumerate() {
        spans.extend(scores.iter().enumerate().filter(|s| *s.1 > 0.0).map(|(n, &s)| (s, axis, n)));
    }
    spans.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut size = knots.map(KnotVector::functions);
    let mut breaks = jumps.breaks.clone();
    for &(score, axis, span) in &spans {
        let larger = (size[axis] + 1).saturating_mul(size[1 - axis]);
        if score < MIN_SCORE_SHARE * spans[0].0 || larger > bounds.most {
            break;
        }
        if score < bounds.price * size[1 - axis] as f64 {
            continue;
        }
        size[axis] += 1;
        let [start, end] = reached(axis, span);
        breaks[axis].push(0.5 * (start + end));
    }
    breaks.map(|mut breaks| {
        breaks.sort_by(f64::total_cmp);
        KnotVector::clamped(3, &breaks, 1)
    })
}

/// The knot vectors without the given share of the inner knot lines, and the number of removed
/// lines. Lines with the smallest effect on the surface are removed first, but no two neighbouring
/// lines.
pub(crate) fn remove(surface: &Surface, share: f64) -> ([KnotVector; 2], usize) {
    let jumps = Jumps::new(surface);
    let mut lines: Vec<(f64, usize, usize)> = Vec::new();
    for (axis, breaks) in jumps.breaks.iter().enumerate() {
        lines.extend((0..breaks.len() - 2).map(|line| (jumps.of_line(axis, line), axis, line)));
    }
    lines.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let wanted = (share * lines.len() as f64).ceil() as usize;
    let mut gone = jumps.breaks.each_ref().map(|b| vec![false; b.len()]);
    let mut count = 0;
    for &(_, axis, line) in &lines {
        let gone = &mut gone[axis];
        if count < wanted && !gone[line] && !gone[line + 2] {
            gone[line + 1] = true;
            count += 1;
        }
    }
    let left = [0, 1].map(|axis| {
        let breaks = jumps.breaks[axis].iter().zip(&gone[axis]);
        let breaks: Vec<f64> = breaks.filter(|(_, gone)| !**gone).map(|(b, _)| *b).collect();
        KnotVector::clamped(3, &breaks, 1)
    });
    (left, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;

    const FREE: InsertionLimits = InsertionLimits { depth: 8, most: 1000, price: 0.0 };

    const ALL: [Uv; 2] = [Uv::new(0.0, 0.0), Uv::new(1.0, 1.0)];

    /// A sheet that bends along u only, and only near u = 0.
    fn gutter(u: KnotVector, v: KnotVector) -> Surface {
        let mut net = Vec::new();
        for i in 0..u.functions() {
            for j in 0..v.functions() {
                let (x, y) = (u.greville(i), v.greville(j));
                net.push(Vector::new(x, y, 0.1 * (-50.0 * x * x).exp()));
            }
        }
        Surface::new(u, v, net)
    }

    #[test]
    fn knots_go_where_the_surface_bends() {
        let s = gutter(KnotVector::uniform(3, 11), KnotVector::uniform(3, 11));
        let breaks = |reach| {
            let [u, v] = insert(&s, &[(Uv::new(0.2, 0.6), 1.0)], reach, &FREE);
            assert_eq!((u.functions(), v.functions()), (12, 11));
            u.breaks()
        };
        assert!(breaks(ALL).contains(&0.1875));
        let beyond = [Uv::new(0.15, 0.0), Uv::new(1.0, 1.0)];
        assert!(breaks(beyond).contains(&0.2), "the middle of where points are");
    }

    #[test]
    fn bounds_hold() {
        let s = gutter(KnotVector::uniform(3, 11), KnotVector::uniform(3, 11));
        let miss = [(Uv::new(0.2, 0.6), 1.0)];
        let same = [s.u.clone(), s.v.clone()];
        assert_eq!(insert(&s, &miss, ALL, &InsertionLimits { most: 121, ..FREE }), same);
        assert_eq!(insert(&s, &miss, ALL, &InsertionLimits { depth: 3, ..FREE }), same);
        assert_eq!(insert(&s, &miss, ALL, &InsertionLimits { price: 0.1, ..FREE }), same);
        assert_ne!(insert(&s, &miss, ALL, &InsertionLimits { price: 0.09, ..FREE }), same);
    }

    #[test]
    fn lines_that_do_nothing_go_first() {
        let s = gutter(KnotVector::uniform(3, 11), KnotVector::uniform(3, 7));
        let ([u, v], count) = remove(&s, 0.2);
        assert_eq!((u.functions(), v.functions(), count), (11, 5, 2));
    }
}
