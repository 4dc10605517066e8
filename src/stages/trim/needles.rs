//! Removal of needles: slits and spikes of a rim that are too thin for a curve to run around.
//!
//! The input is a closed polygon of parameter points. The output is the positions of the vertices
//! to keep.

use crate::geometry::Uv;

/// A closed cubic spline needs at least this many spans.
const MIN_SPANS: usize = 4;

/// A needle is at most as wide as this share of its shorter side.
const WIDTH: f64 = 0.01;

/// Returns the positions of a closed polygon's corners without the tips of needles. A needle runs
/// to its tip and straight back, so that it encloses almost no area.
pub(crate) fn without(uv: &[Uv]) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..uv.len()).collect();
    let mut first = 0;
    while kept.len() > MIN_SPANS {
        let n = kept.len();
        let at = |i: usize| uv[kept[i % n]];
        let tip = (first..n).find(|&i| is_tip(at(i + n - 1), at(i), at(i + 1)));
        let Some(tip) = tip else { break };
        kept.remove(tip);
        // Among the vertices before it, only its neighbour can have become a tip.
        first = if tip + 1 == n { 0 } else { tip.saturating_sub(1) };
    }
    kept
}

/// Whether a polygon that runs from `a` over `b` to `c` turns back at `b`.
fn is_tip(a: Uv, b: Uv, c: Uv) -> bool {
    let (to, from) = (a - b, c - b);
    to.dot(&from) > 0.0 && to.perp(&from).abs() <= WIDTH * to.norm() * from.norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[(f64, f64)]) -> Vec<Uv> {
        corners.iter().map(|&(u, v)| Uv::new(u, v)).collect()
    }

    #[test]
    fn needles_are_left_out_whole() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        assert_eq!(without(&polygon(&square)), [0, 1, 2, 3]);
        // A slit cut in from the top, with a vertex on one of its sides.
        let slit = [(0.5001, 1.0), (0.5, 0.4), (0.4999, 0.7), (0.4998, 1.0)];
        let cut = [&square[..3], &slit, &square[3..]].concat();
        let kept = without(&polygon(&cut));
        assert!(kept.iter().all(|&i| cut[i].1 == 1.0 || cut[i].1 == 0.0), "{kept:?}");
        assert!([0, 1, 2, 7].iter().all(|i| kept.contains(i)), "{kept:?}");
    }
}
