//! Cubic Bézier pieces of curves in the parameter plane.

use super::Curve;
use crate::geometry::{SAME_SIDE, Uv, UvVector, uv_bounds};

/// A cubic Bézier curve over a range of the parameters of a loop.
#[derive(Debug, Clone)]
pub(super) struct BezierPiece {
    range: [f64; 2],
    pub points: [Uv; 4],
}

impl BezierPiece {
    /// The pieces of cubic arcs, one for each knot span. `None` if an arc is not cubic.
    pub(super) fn all(arcs: &[Curve<2>]) -> Option<Vec<BezierPiece>> {
        let mut pieces = Vec::new();
        for arc in arcs {
            if arc.knots.degree() != 3 {
                return None;
            }
            for range in arc.knots.breaks().windows(2) {
                let (a, b) = (range[0], range[1]);
                let span = arc.knots.span(0.5 * (a + b));
                let point = |t| Uv::from(arc.knots.blossom(span, &arc.control, t));
                let points =
                    [&[a, a, a], &[a, a, b], &[a, b, b], &[b, b, b]].map(|t: &[f64; 3]| point(t));
                pieces.push(BezierPiece { range: [a, b], points });
            }
        }
        (!pieces.is_empty()).then_some(pieces)
    }

    pub(crate) fn start(&self) -> Uv {
        self.points[0]
    }

    pub(crate) fn end(&self) -> Uv {
        self.points[3]
    }

    /// The parameter in the middle of the range.
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.range[0] + self.range[1])
    }

    /// The length of the parameter range.
    pub(crate) fn length(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    /// The two halves, by de Casteljau's algorithm.
    pub(crate) fn split(&self) -> [BezierPiece; 2] {
        let [a, b, c, d] = self.points;
        let half = |p: &Uv, q: &Uv| nalgebra::center(p, q);
        let (ab, bc, cd) = (half(&a, &b), half(&b, &c), half(&c, &d));
        let (abc, bcd) = (half(&ab, &bc), half(&bc, &cd));
        let top = half(&abc, &bcd);
        let middle = self.middle();
        [
            BezierPiece { range: [self.range[0], middle], points: [a, ab, abc, top] },
            BezierPiece { range: [middle, self.range[1]], points: [top, bcd, cd, d] },
        ]
    }

    /// A box that contains the piece.
    pub(crate) fn bounds(&self) -> [Uv; 2] {
        uv_bounds(&self.points)
    }

    /// The control vectors of the derivative. Every direction of the piece lies in their cone.
    fn directions(&self) -> [UvVector; 3] {
        [0, 1, 2].map(|i| self.points[i + 1] - self.points[i])
    }

    fn chord(&self) -> UvVector {
        self.end() - self.start()
    }

    /// Whether every direction of the piece is within 60° of its chord. The piece then cannot cross
    /// itself.
    pub(crate) fn turns_little(&self) -> bool {
        let chord = self.chord();
        chord.norm() > 0.0
            && self.directions().iter().all(|d| {
                let along = d.dot(&chord);
                along > 0.0 && along >= SAME_SIDE * d.norm() * chord.norm()
            })
    }

    /// Whether both coordinates stay between `low` and `high`.
    pub(crate) fn is_within(&self, low: f64, high: f64, shortest: f64) -> bool {
        let fits = |p: &Uv| p.coords.min() >= low && p.coords.max() <= high;
        self.points.iter().all(fits)
            || (fits(&self.start())
                && fits(&self.end())
                && self.length() > shortest
                && self.split().iter().all(|half| half.is_within(low, high, shortest)))
    }

    /// Whether the pieces are proved to be more than `clearance` apart.
    pub(crate) fn is_apart(&self, other: &BezierPiece, clearance: f64, shortest: f64) -> bool {
        let ([a, b], [c, d]) = (self.bounds(), other.bounds());
        let gap = (c - b).sup(&(a - d));
        if gap.max() > clearance {
            return true;
        }
        let (larger, smaller) =
            if (b - a).amax() >= (d - c).amax() { (self, other) } else { (other, self) };
        larger.length() > shortest
            && larger.split().iter().all(|half| half.is_apart(smaller, clearance, shortest))
    }

    /// Whether the ray from `p` in the direction of increasing u crosses the piece an odd number of
    /// times.
    pub(crate) fn ray_crosses(&self, p: Uv, shortest: f64) -> bool {
        let [low, high] = self.bounds();
        if p.y < low.y || p.y > high.y || p.x > high.x {
            return false;
        }
        if p.x < low.x || self.length() <= shortest {
            return (self.start().y > p.y) != (self.end().y > p.y);
        }
        let [a, b] = self.split();
        a.ray_crosses(p, shortest) != b.ray_crosses(p, shortest)
    }
}

/// Whether two consecutive pieces meet only at their common end. This holds if both advance in one
/// common direction.
pub(super) fn run_on(before: &BezierPiece, after: &BezierPiece) -> bool {
    let along = before.chord().normalize() + after.chord().normalize();
    before.directions().iter().chain(&after.directions()).all(|d| d.dot(&along) > 0.0)
}
