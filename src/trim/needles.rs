//! Slits and spikes of a rim that are too thin for a curve to run around.

use crate::geometry::Uv;

/// A needle is no wider than this share of its shorter side.
const WIDTH: f64 = 0.01;

/// A rim keeps at least as many vertices.
const LEAST: usize = 4;

/// The positions of a closed polygon's corners without the tips of needles: what runs
/// to a tip and straight back encloses next to nothing.
pub fn without(uv: &[Uv]) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..uv.len()).collect();
    let mut first = 0;
    while kept.len() > LEAST {
        let n = kept.len();
        let at = |i: usize| uv[kept[i % n]];
        let tip = (first..n).find(|&i| is_tip(at(i + n - 1), at(i), at(i + 1)));
        let Some(tip) = tip else { break };
        kept.remove(tip);
        // Of those before it only its neighbour can be one now.
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
