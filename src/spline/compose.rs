//! The curve in space that a parameter curve traces on a surface.

use nalgebra::{SVector, Vector3};

use super::{Curve, KnotVector, MOST_HALVINGS, Surface};
use crate::geometry::{MOST_ROUNDS, ROUNDING, Uv, Vector};

/// After this number of halvings, a halving that does not at least halve the error is the last one.
/// The remaining error is then due to rounding.
const SURE_HALVINGS: usize = 10;

/// The curve C in space with |C(t) − S(c(t))| ≤ `eps` mm for the pcurve `c`, at the same parameter.
/// C is a quintic with triple knots and therefore C².
///
/// Between the knots of the pcurve and its crossings of knot lines of the surface, S∘c is a
/// polynomial of degree up to 18. On such a piece the Hermite quintic, which has the position and
/// two derivatives at both ends, converges with the sixth power of the length of the piece. Pieces
/// are halved until samples agree within `eps` / 4. Some importers check only a few points; with a
/// coarser bound a curve could pass their check and still exceed `eps` elsewhere.
pub(crate) fn curve_on_surface(surface: &Surface, c: &Curve<2>, eps: f64) -> Curve<3> {
    let breaks = pieces_on_surface(surface, c);
    let mut knots = vec![breaks[0]];
    let mut pieces = Vec::new();
    for span in breaks.windows(2) {
        let begun = (MOST_HALVINGS, f64::INFINITY);
        refine(surface, c, span[0], span[1], 0.25 * eps, begun, &mut knots, &mut pieces);
    }
    assemble(&knots, &pieces)
}

/// The largest distance in mm between an edge and the trace of its pcurve at the same parameter. It
/// is measured at 17 places on each knot span of the edge. The result is NaN if the distance is NaN
/// at one of them.
pub(crate) fn off_surface(surface: &Surface, pcurve: &Curve<2>, edge: &Curve<3>) -> f64 {
    let mut worst: f64 = 0.0;
    for span in edge.knots.breaks().windows(2) {
        for k in 0..=SAMPLES {
            let t = span[0] + (span[1] - span[0]) * k as f64 / SAMPLES as f64;
            let off = (edge.point(t) - surface.point(Uv::from(pcurve.point(t))).coords).norm();
            if off.is_nan() {
                return off;
            }
            worst = worst.max(off);
        }
    }
    worst
}

/// The ends of the pieces of a pcurve on which it traces polynomials: its own knots and its
/// crossings of the knot lines of the surface.
pub fn pieces_on_surface(surface: &Surface, c: &Curve<2>) -> Vec<f64> {
    let own = c.knots.breaks();
    let mut all = own.clone();
    for (axis, lines) in [surface.u.breaks(), surface.v.breaks()].iter().enumerate() {
        for span in own.windows(2) {
            crossings(c, axis, &lines[1..lines.len() - 1], span[0], span[1], &mut all);
        }
    }
    all.sort_by(f64::total_cmp);
    let (first, last) = c.knots.range();
    let least = ROUNDING * (last - first);
    // Knots of the pcurve are kept exactly; a crossing next to one is not needed. The first and the
    // last break stay the ends of the range.
    let mut breaks: Vec<f64> = Vec::with_capacity(all.len());
    for t in all {
        if breaks.last().is_none_or(|&b| t - b > least) {
            breaks.push(t);
        }
    }
    if let Some(end) = breaks.last_mut() {
        *end = last;
    }
    breaks
}

/// The number of parts of a piece in which a crossing of a line is looked for, and between which its distance from
/// the surface is measured. A cubic turns back at most twice, so that crossings that share a part are a near touch.
const SAMPLES: usize = 12;

/// Parameters in (a, b) at which coordinate `axis` equals one of the ascending `levels`. The curve
/// must be a single polynomial there. Crossings are bracketed between samples and found by
/// bisection.
fn crossings(c: &Curve<2>, axis: usize, levels: &[f64], a: f64, b: f64, found: &mut Vec<f64>) {
    let at = |i: usize| a + (b - a) * i as f64 / SAMPLES as f64;
    let value = |t: f64| c.point(t)[axis];
    let mut before = value(a);
    for i in 1..=SAMPLES {
        let after = value(at(i));
        let (least, most) = (before.min(after), before.max(after));
        let between =
            levels.partition_point(|&l| l <= least)..levels.partition_point(|&l| l < most);
        for &level in levels.get(between).unwrap_or_default() {
            let (mut low, mut high) = (at(i - 1), at(i));
            for _ in 0..MOST_ROUNDS {
                let middle = 0.5 * (low + high);
                if (value(middle) - level) * (before - level) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            found.push(0.5 * (low + high));
        }
        before = after;
    }
}

/// Position and first two derivatives of S∘c at `t`, by the chain rule.
fn composed(surface: &Surface, c: &Curve<2>, t: f64) -> [Vector; 3] {
    let [p, d, dd] = c.derivatives(t);
    let j = surface.jet(Uv::from(p));
    let first = j.su * d.x + j.sv * d.y;
    let bend = j.suu * (d.x * d.x) + j.suv * (2.0 * d.x * d.y) + j.svv * (d.y * d.y);
    [j.s.coords, first, bend + j.su * dd.x + j.sv * dd.y]
}

/// The Bézier points of the quintic with the given position and derivatives at both ends of a range
/// of length `w`.
fn hermite(a: &[Vector; 3], b: &[Vector; 3], w: f64) -> [Vector; 6] {
    let (first, second) = (w / 5.0, w * w / (4.0 * 5.0));
    [
        a[0],
        a[0] + a[1] * first,
        a[0] + a[1] * (2.0 * first) + a[2] * second,
        b[0] - b[1] * (2.0 * first) + b[2] * second,
        b[0] - b[1] * first,
        b[0],
    ]
}

fn bezier(points: &[Vector; 6], s: f64) -> Vector {
    let mut p = *points;
    for level in (1..6).rev() {
        for i in 0..level {
            p[i] = p[i] * (1.0 - s) + p[i + 1] * s;
        }
    }
    p[0]
}

#[allow(clippy::too_many_arguments)]
fn refine(
    surface: &Surface,
    c: &Curve<2>,
    a: f64,
    b: f64,
    eps: f64,
    (halvings, before): (usize, f64),
    knots: &mut Vec<f64>,
    pieces: &mut Vec<[Vector; 6]>,
) {
    let quintic = hermite(&composed(surface, c, a), &composed(surface, c, b), b - a);
    let off = |i: usize| {
        let s = i as f64 / SAMPLES as f64;
        let exact = surface.point(Uv::from(c.point(a + s * (b - a)))).coords;
        (bezier(&quintic, s) - exact).norm()
    };
    // A NaN error does not become a number by halving; it is ignored here.
    let worst = (1..SAMPLES).map(off).fold(0.0, f64::max);
    let stuck = halvings + SURE_HALVINGS <= MOST_HALVINGS && worst > 0.5 * before;
    if halvings == 0 || worst <= eps || stuck {
        knots.push(b);
        pieces.push(quintic);
        return;
    }
    let middle = 0.5 * (a + b);
    refine(surface, c, a, middle, eps, (halvings - 1, worst), knots, pieces);
    refine(surface, c, middle, b, eps, (halvings - 1, worst), knots, pieces);
}

/// The piece from which control point `i` is computed: one that its five knots touch. If these
/// knots touch two pieces, both give the same point, and the longer piece gives it with less
/// rounding.
fn piece_of(i: usize, breaks: &[f64]) -> usize {
    let last = breaks.len() - 2;
    let piece = (i / 3).saturating_sub(usize::from(i.is_multiple_of(3))).min(last);
    let length = |piece: usize| breaks[piece + 1] - breaks[piece];
    let shared = i % 3 == 1 && piece > 0 && i / 3 <= last;
    if shared && length(piece - 1) > length(piece) { piece - 1 } else { piece }
}

/// Joins Hermite pieces into one B-spline with triple inner knots. Control point i is the blossom
/// of a piece at five consecutive knots.
fn assemble(breaks: &[f64], pieces: &[[Vector; 6]]) -> Curve<3> {
    let knots = KnotVector::clamped(5, breaks, 3);
    let control: Vec<Vector3<f64>> = (0..knots.functions())
        .map(|i| {
            let piece = piece_of(i, breaks);
            let (a, b) = (breaks[piece], breaks[piece + 1]);
            let local = KnotVector::clamped(5, &[a, b], 1);
            let arguments = &knots.knots()[i + 1..=i + 5];
            let control: [SVector<f64, 3>; 6] = pieces[piece];
            local.blossom(5, &control, arguments)
        })
        .collect();
    Curve::new(knots, control)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_stays_on_the_surface() {
        let u = KnotVector::clamped(3, &[0.0, 0.2, 0.35, 0.7, 1.0], 1);
        let v = KnotVector::uniform(3, 9);
        let net = (0..u.functions() * v.functions()).map(|n| {
            let (i, j) = (n / v.functions(), n % v.functions());
            let z = ((i * 5 + j * 3) % 7) as f64;
            Vector::new(100.0 * u.greville(i), 100.0 * v.greville(j), z)
        });
        let net = net.collect();
        let surface = Surface::new(u, v, net);
        let knots = KnotVector::new(3, (0..16).map(|i| f64::from(i) / 8.0 - 0.375).collect());
        let ring = |i: i32| std::f64::consts::TAU * f64::from(i) / 8.0;
        let control =
            (0..12).map(|i| SVector::from([0.5 + 0.3 * ring(i).cos(), 0.5 + 0.25 * ring(i).sin()]));
        let c = Curve::<2>::new(knots, control.collect()).part(0.1, 0.8);
        let curve = curve_on_surface(&surface, &c, 1e-7);
        let mut worst: f64 = 0.0;
        for i in 0..=5000 {
            let t = 0.1 + 0.7 * f64::from(i) / 5000.0;
            let exact = surface.point(Uv::from(c.point(t))).coords;
            worst = worst.max((curve.point(t) - exact).norm());
        }
        assert!(worst < 1e-7, "{worst:e} mm off, {} poles", curve.control.len());
        assert!(curve.control.len() < 250, "{} poles", curve.control.len());
    }
}
