//! Loops in the parameter plane that must not cross.

use super::closed::ClosedCubic;
use crate::geometry::{Uv, is_inside, segments_cross, uv_bounds};

/// Chords a knot span.
const CHORDS: usize = 8;

/// How near a loop may come to the edge of the patch: importers refuse a
/// pcurve that leaves the domain, by however little.
const MARGIN: f64 = 1e-7;

/// A loop as a polygon with its bounding box.
#[derive(Debug, Clone)]
pub struct Outline {
    polygon: Vec<Uv>,
    low: Uv,
    high: Uv,
}

impl Outline {
    /// The chords of a closed curve.
    pub fn new(curve: &ClosedCubic) -> Self {
        let unrolled = curve.unrolled();
        let spans = unrolled.knots.breaks().len() - 1;
        let count = CHORDS * spans;
        let polygon: Vec<Uv> =
            (0..count).map(|i| Uv::from(unrolled.point(i as f64 / count as f64))).collect();
        Outline::of(polygon)
    }

    fn of(polygon: Vec<Uv>) -> Self {
        let [low, high] = uv_bounds(&polygon);
        Outline { polygon, low, high }
    }

    /// What is wrong with the loop, if anything is: it leaves the domain, runs
    /// the wrong way round, crosses itself or one of `others`, or does not lie
    /// within just those of them that are `around` it.
    pub fn fault(&self, others: &[Outline], around: &[usize]) -> Option<String> {
        if self.low.coords.min() < MARGIN || self.high.coords.max() > 1.0 - MARGIN {
            return Some("leaves the patch".into());
        }
        if self.crosses_itself() {
            return Some("crosses itself".into());
        }
        // Clockwise around a hole, counter-clockwise around an island in one, and
        // so on.
        let clockwise = around.len().is_multiple_of(2);
        if self.area() == 0.0 || (self.area() < 0.0) != clockwise {
            return Some("runs the wrong way round".into());
        }
        let clash = |(i, other): (usize, &Outline)| {
            self.crosses(other)
                || self.encloses(other)
                || other.encloses(self) != around.contains(&i)
        };
        others.iter().enumerate().any(clash).then(|| "runs into another one".into())
    }

    fn sides(&self) -> impl Iterator<Item = (Uv, Uv)> + '_ {
        let nexts = self.polygon.iter().cycle().skip(1);
        self.polygon.iter().copied().zip(nexts.copied())
    }

    /// Signed area, positive counter-clockwise.
    fn area(&self) -> f64 {
        0.5 * self.sides().map(|(a, b)| a.x * b.y - b.x * a.y).sum::<f64>()
    }

    fn crosses_itself(&self) -> bool {
        let sides: Vec<(Uv, Uv)> = self.sides().collect();
        let mut order: Vec<usize> = (0..sides.len()).collect();
        let left = |i: usize| sides[i].0.x.min(sides[i].1.x);
        let right = |i: usize| sides[i].0.x.max(sides[i].1.x);
        order.sort_by(|&i, &j| left(i).total_cmp(&left(j)));
        // Only chords whose ranges of u overlap can cross.
        order.iter().enumerate().any(|(k, &i)| {
            order[k + 1..]
                .iter()
                .take_while(|&&j| left(j) <= right(i))
                .any(|&j| segments_cross(sides[i].0, sides[i].1, sides[j].0, sides[j].1))
        })
    }

    fn crosses(&self, other: &Outline) -> bool {
        let apart = self.low.x > other.high.x
            || other.low.x > self.high.x
            || self.low.y > other.high.y
            || other.low.y > self.high.y;
        !apart && self.sides().any(|(a, b)| other.sides().any(|(c, d)| segments_cross(a, b, c, d)))
    }

    /// Whether the other loop begins inside this one.
    fn encloses(&self, other: &Outline) -> bool {
        is_inside(other.polygon[0], &self.polygon)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clockwise square, or one that runs the other way.
    fn square(u: f64, r: f64, clockwise: bool) -> Outline {
        let mut corners = [(-r, -r), (-r, r), (r, r), (r, -r)];
        if !clockwise {
            corners.reverse();
        }
        Outline::of(corners.map(|(x, y)| Uv::new(u + x, 0.5 + y)).to_vec())
    }

    #[test]
    fn islands_run_the_other_way_within_their_holes() {
        let others = [square(0.3, 0.2, true), square(0.8, 0.1, true)];
        let fault = |u: f64, r: f64, clockwise, around: &[usize]| {
            square(u, r, clockwise).fault(&others, around)
        };
        assert_eq!(fault(0.3, 0.1, false, &[0]), None);
        assert!(fault(0.3, 0.1, true, &[0]).is_some(), "clockwise");
        assert!(fault(0.6, 0.02, false, &[0]).is_some(), "in no hole");
        assert!(fault(0.8, 0.02, false, &[0]).is_some(), "in another one");
        assert!(fault(0.45, 0.1, false, &[0]).is_some(), "across a rim");
        assert!(fault(0.3, 0.1, true, &[]).is_some(), "a hole in a hole");
        assert_eq!(fault(0.6, 0.02, true, &[]), None);
    }
}
