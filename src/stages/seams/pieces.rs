//! Parts of pcurves, each with its chord and how far the curve may be from that.

use formats::brep::PCurve;

/// The first pieces of a curve: their chords follow it so well that nearly all of them are apart.
const FIRST: usize = 24;

/// A piece so close to its chord is the chord, in the units of the parameters. Kernels find crossings to a tenth of a
/// nanometre.
pub(super) const FINE: f64 = 1e-10;

/// A curve is farther from its chord than at three samples by at most this factor: a parabola by nothing, a cubic by a quarter.
const BETWEEN_SAMPLES: f64 = 1.25;

/// A part of a pcurve.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurvePiece {
    pub range: [f64; 2],
    pub ends: [[f64; 2]; 2],
    /// The largest distance of the curve from its chord.
    pub sagitta: f64,
}

/// The first pieces of a pcurve.
pub(super) fn pieces(pcurve: &PCurve) -> Vec<CurvePiece> {
    let (start, end) = pcurve.range();
    if matches!(pcurve, PCurve::Line(_)) {
        return vec![CurvePiece::new(pcurve, [start, end])];
    }
    let at = |k: usize| start + (end - start) * k as f64 / FIRST as f64;
    (0..FIRST).map(|k| CurvePiece::new(pcurve, [at(k), at(k + 1)])).collect()
}

impl CurvePiece {
    fn new(pcurve: &PCurve, range: [f64; 2]) -> Self {
        let ends = range.map(|t| pcurve.point(t));
        let mut sagitta: f64 = 0.0;
        if !matches!(pcurve, PCurve::Line(_)) {
            for share in [0.25, 0.5, 0.75] {
                let p = pcurve.point(range[0] + share * (range[1] - range[0]));
                sagitta = sagitta.max(to_segment(p, ends));
            }
            sagitta *= BETWEEN_SAMPLES;
        }
        CurvePiece { range, ends, sagitta }
    }

    /// Whether another piece begins where this one ends.
    pub(super) fn touches(&self, next: &CurvePiece) -> bool {
        let off = |k: usize| next.ends[0][k] - self.ends[1][k];
        off(0).hypot(off(1)) <= FINE
    }

    /// Both halves, or the whole if it is straight or its range cannot be halved.
    fn halves(&self, pcurve: &PCurve) -> Vec<CurvePiece> {
        let [start, end] = self.range;
        let middle = 0.5 * (start + end);
        if self.sagitta <= FINE || middle == start || middle == end {
            return vec![*self];
        }
        vec![CurvePiece::new(pcurve, [start, middle]), CurvePiece::new(pcurve, [middle, end])]
    }
}

/// The pairs of halves of two pieces that may meet. None if both pieces are straight.
pub(super) fn halved(
    [a, b]: [&CurvePiece; 2],
    [of_a, of_b]: [&PCurve; 2],
) -> Option<Vec<(CurvePiece, CurvePiece)>> {
    let (halves, others) = (a.halves(of_a), b.halves(of_b));
    let pairs = halves.iter().flat_map(|a| others.iter().map(move |b| (*a, *b)));
    (halves.len() + others.len() > 2).then(|| pairs.filter(|(a, b)| are_near(a, b)).collect())
}

/// Whether curves of two pieces may meet.
pub(super) fn are_near(a: &CurvePiece, b: &CurvePiece) -> bool {
    let reach = a.sagitta + b.sagitta + FINE;
    let apart = |k: usize| {
        let range =
            |p: &CurvePiece| [p.ends[0][k].min(p.ends[1][k]), p.ends[0][k].max(p.ends[1][k])];
        let [a, b] = [range(a), range(b)];
        a[0] - b[1] > reach || b[0] - a[1] > reach
    };
    if apart(0) || apart(1) {
        return false;
    }
    let to = |p: [f64; 2], of: &CurvePiece| to_segment(p, of.ends) <= reach;
    place_of_lines(a, b, 0.0).is_some()
        || a.ends.iter().any(|&p| to(p, b))
        || b.ends.iter().any(|&p| to(p, a))
}

/// The parameters where the chords of two pieces cross, if they do so within their ends or a share beyond them.
pub(super) fn place_of_lines(a: &CurvePiece, b: &CurvePiece, beyond: f64) -> Option<[f64; 2]> {
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let wedge = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let (d, e) = (minus(a.ends[1], a.ends[0]), minus(b.ends[1], b.ends[0]));
    let between = minus(b.ends[0], a.ends[0]);
    let area = wedge(d, e);
    if area == 0.0 {
        return None;
    }
    let shares = [wedge(between, e) / area, wedge(between, d) / area];
    let is_inside = shares.iter().all(|share| (-beyond..=1.0 + beyond).contains(share));
    let at = |piece: &CurvePiece, share: f64| {
        piece.range[0] + share.clamp(0.0, 1.0) * (piece.range[1] - piece.range[0])
    };
    is_inside.then(|| [at(a, shares[0]), at(b, shares[1])])
}

/// The parameters where an end of one piece touches the chord of the other one.
pub(super) fn places_of_ends(a: &CurvePiece, b: &CurvePiece) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    for (ends_of, chord, is_inverted) in [(a, b, false), (b, a, true)] {
        for (end, t) in ends_of.ends.into_iter().zip(ends_of.range) {
            if to_segment(end, chord.ends) <= FINE {
                let [from, to] = chord.range;
                let other = from + share_of_segment(end, chord.ends) * (to - from);
                found.push(if is_inverted { [other, t] } else { [t, other] });
            }
        }
    }
    found
}

fn to_segment(p: [f64; 2], ends: [[f64; 2]; 2]) -> f64 {
    let ([a, b], share) = (ends, share_of_segment(p, ends));
    let off = |k: usize| p[k] - a[k] - share * (b[k] - a[k]);
    off(0).hypot(off(1))
}

/// How far along a segment the place next to a point is, from 0 to 1.
fn share_of_segment(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (d, e) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = d[0] * d[0] + d[1] * d[1];
    if square > 0.0 { ((d[0] * e[0] + d[1] * e[1]) / square).clamp(0.0, 1.0) } else { 0.0 }
}
