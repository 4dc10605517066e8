//! The points that lead the border of a free-form face: as few vertices of the mesh as tell where it is.

use super::followed::led_at;
use super::network::ChainNetwork;
use super::{FreeForms, Work};
use crate::geometry::{Point, Vector, faired};

/// A border passes its vertices within this share of their mean distance. A scan does not tell more: its noise is about as large.
const PASSES: f64 = 0.1;

/// The most spans of an edge. Programs integrate along an edge with at most 61 places (OpenCASCADE), whatever it has.
const MOST_SPANS: usize = 16;

/// The parts of a piece between two points whose chords stand for it.
const PARTS: usize = 8;

impl Work<'_> {
    /// Smooths the borders of free-form faces on the faces beside them.
    pub(super) fn fair_borders(&self, network: &mut ChainNetwork) {
        for k in 0..network.chains.len() {
            let chain = &network.chains[k];
            let sides = [chain.left, chain.right];
            if !sides.iter().any(|&i| self.is_free(i)) {
                continue;
            }
            let pair = self.pair(chain);
            let is_noisy = self.free_forms == FreeForms::Near;
            let points =
                if is_noisy { faired(&chain.points, |_| true) } else { chain.points.clone() };
            let points: Vec<Point> = points.into_iter().map(|p| pair.project(p)).collect();
            let most =
                if is_noisy { PASSES * mean_step(&points) } else { self.limit_at(chain.error) };
            let points = led(&points, most, self.most_sagitta, |p| pair.normal(p));
            if points.iter().any(|p| !p.coords.iter().all(|x| x.is_finite())) {
                continue;
            }
            network.chains[k].points = points;
            self.cut_spans(network, k);
        }
    }

    /// Cuts the border of a free-form face where its curve would have many spans.
    fn cut_spans(&self, network: &mut ChainNetwork, k: usize) {
        let chain = &network.chains[k];
        let Ok((curve, _)) = self.pair(chain).curve(chain) else { return };
        let breaks = curve.breaks();
        let spans = breaks.len() - 1;
        let parts = spans.div_ceil(MOST_SPANS);
        if parts < 2 || chain.is_closed() {
            return;
        }
        let (first, last) = (chain.points[0], chain.points[chain.points.len() - 1]);
        let mut points: Vec<Point> = breaks.iter().map(|&t| curve.point(t).into()).collect();
        (points[0], points[spans]) = (first, last);
        network.chains[k].points = points.clone();
        // The part that is cut off comes last.
        let mut at = k;
        let mut begin = 0;
        for part in 1..parts {
            let end = part * spans / parts;
            network.cut(at, end - begin - 1, points[end]);
            let along = Vector::from(curve.speed(breaks[end])).normalize();
            network.chains[at].tangents[1] = Some(along);
            at = network.chains.len() - 1;
            network.chains[at].tangents[0] = Some(along);
            begin = end;
        }
    }
}

/// The mean distance between neighbouring points.
fn mean_step(points: &[Point]) -> f64 {
    let steps = points.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    steps.sum::<f64>() / (points.len() - 1).max(1) as f64
}

/// The points among those of a polygon through which a curve passes all of them within a length. What is along the normal of a surface does not
/// count.
fn led(
    points: &[Point],
    most: f64,
    most_sagitta: Option<f64>,
    normal: impl Fn(Point) -> Option<Vector>,
) -> Vec<Point> {
    let n = points.len();
    let mut along = vec![0.0];
    for pair in points.windows(2) {
        along.push(along[along.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let mut kept = vec![0, n - 1];
    if n < 3 || points[0] == points[n - 1] {
        return points.to_vec();
    }
    loop {
        let t: Vec<f64> = kept.iter().map(|&k| along[k]).collect();
        let some: Vec<Point> = kept.iter().map(|&k| points[k]).collect();
        let Ok(curve) = led_at(&t, &some, most_sagitta) else { return points.to_vec() };
        let mut more = Vec::new();
        for piece in kept.windows(2) {
            let (from, to) = (along[piece[0]], along[piece[1]]);
            let at =
                |j: usize| Point::from(curve.point(from + (to - from) * j as f64 / PARTS as f64));
            let chords: Vec<Point> = (0..=PARTS).map(at).collect();
            let off = |k: usize| {
                let p = points[k];
                let aside = nearest(&chords, p) - p;
                normal(p).map_or(aside, |n| aside - aside.dot(&n) * n).norm()
            };
            let worst = (piece[0] + 1..piece[1]).map(|k| (off(k), k));
            let worst = worst.max_by(|a, b| a.0.total_cmp(&b.0));
            more.extend(worst.filter(|worst| worst.0 > most).map(|worst| worst.1));
        }
        if more.is_empty() {
            return kept.into_iter().map(|k| points[k]).collect();
        }
        kept.extend(more);
        kept.sort_unstable();
    }
}

/// The point of a polygon next to another one.
fn nearest(polygon: &[Point], p: Point) -> Point {
    let on = |pair: &[Point]| {
        let chord = pair[1] - pair[0];
        let share = (p - pair[0]).dot(&chord) / chord.norm_squared().max(f64::MIN_POSITIVE);
        pair[0] + share.clamp(0.0, 1.0) * chord
    };
    let all = polygon.windows(2).map(on);
    let near = all.min_by(|a, b| (a - p).norm().total_cmp(&(b - p).norm()));
    near.unwrap_or_else(|| polygon[0])
}

/// How far a point is off a polygon.
pub(super) fn off_polygon(polygon: &[Point], p: Point) -> f64 {
    (nearest(polygon, p) - p).norm()
}

/// How far a smooth curve through points leaves their chords: by an eighth of the second difference.
pub(super) fn bend(points: &[Point]) -> f64 {
    let of = |p: &[Point]| ((p[0] - p[1]) + (p[2] - p[1])).norm() / 8.0;
    points.windows(3).map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_border_needs_its_ends_only() {
        let at = |k: i32| Point::new(f64::from(k), 0.05 * f64::from(k % 2), 0.0);
        let points: Vec<Point> = (0..=20).map(at).collect();
        assert_eq!(led(&points, 0.1, None, |_| None), [points[0], points[20]]);
    }

    #[test]
    fn a_bent_border_is_passed_closely() {
        let at = |k: i32| {
            let s = 0.1 * f64::from(k);
            Point::new(10.0 * s.cos(), 10.0 * s.sin(), 0.0)
        };
        let points: Vec<Point> = (0..=40).map(at).collect();
        let few = led(&points, 0.01, None, |_| None);
        assert!(few.len() < 12, "{}", few.len());
        assert!(points.iter().all(|&p| off_polygon(&few, p) < bend(&few) + 0.1));
    }
}
