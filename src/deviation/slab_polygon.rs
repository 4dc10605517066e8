//! Closed polygons of the parameter plane, with a fast point-in-polygon test.

use crate::geometry::{Uv, UvVector, ray_crosses, uv_bounds};

/// A polygon has so many images along an axis that may contain one place, at most.
const MOST_IMAGES: f64 = 16.0;

/// A closed polygon that is indexed by strips of v (slab method: Dobkin, Lipton, 1976).
#[derive(Debug, Clone)]
pub(crate) struct SlabPolygon {
    corners: Vec<Uv>,
    low: Uv,
    high: Uv,
    /// For each of some strips of equal width in v, the sides that cross it.
    strips: Vec<Vec<u32>>,
}

impl SlabPolygon {
    pub(super) fn new(corners: impl Iterator<Item = Uv>) -> Self {
        let corners: Vec<Uv> = corners.collect();
        let [low, high] = uv_bounds(&corners);
        let count = (corners.len() / 4).clamp(1, 4096);
        let mut outline = SlabPolygon { corners, low, high, strips: vec![Vec::new(); count] };
        for i in 0..outline.corners.len() {
            let (a, b) = outline.side(i);
            let strips = outline.strip(a.y.min(b.y))..=outline.strip(a.y.max(b.y));
            strips.for_each(|strip| outline.strips[strip].push(i as u32));
        }
        outline
    }

    fn side(&self, i: usize) -> (Uv, Uv) {
        (self.corners[i], self.corners[(i + 1) % self.corners.len()])
    }

    fn strip(&self, v: f64) -> usize {
        let share = (v - self.low.y) / (self.high.y - self.low.y);
        // For a polygon without height the share is NaN, and the strip is the first one.
        ((share * self.strips.len() as f64) as usize).min(self.strips.len() - 1)
    }

    /// Whether a parameter point is inside.
    pub(super) fn contains(&self, p: Uv) -> bool {
        if p.x < self.low.x || p.x > self.high.x || p.y < self.low.y || p.y > self.high.y {
            return false;
        }
        let sides = self.strips[self.strip(p.y)].iter();
        sides.filter(|&&i| ray_crosses(p, self.side(i as usize))).count() % 2 == 1
    }

    /// The vectors of whole periods by which the rectangle from `low` to `high` meets the polygon's box.
    pub(super) fn images(
        &self,
        periods: [Option<f64>; 2],
        low: Uv,
        high: Uv,
    ) -> impl Iterator<Item = UvVector> + use<> {
        let of = |axis: usize| match periods[axis] {
            Some(period) => {
                let first = ((self.low[axis] - high[axis]) / period).ceil();
                let last = ((self.high[axis] - low[axis]) / period).floor();
                // A polygon goes around once, so it has few images.
                let count = (last - first + 1.0).clamp(0.0, MOST_IMAGES);
                (first * period, period, count as usize)
            }
            None => (0.0, 0.0, 1),
        };
        let ([u, v], count) = ([of(0), of(1)], of(1).2);
        (0..u.2 * count).map(move |i| {
            UvVector::new(u.0 + u.1 * (i / count) as f64, v.0 + v.1 * (i % count) as f64)
        })
    }

    /// Whether a side may cross the rectangle from `low` to `high`. Only the bounding boxes of the
    /// sides are tested.
    pub(super) fn meets(&self, low: Uv, high: Uv) -> bool {
        let apart = |a: Uv, b: Uv| {
            a.x.max(b.x) < low.x
                || a.x.min(b.x) > high.x
                || a.y.max(b.y) < low.y
                || a.y.min(b.y) > high.y
        };
        if apart(self.low, self.high) {
            return false;
        }
        let strips = self.strip(low.y.max(self.low.y))..=self.strip(high.y.min(self.high.y));
        let sides = |strip: usize| self.strips[strip].iter().map(|&i| self.side(i as usize));
        strips.flat_map(sides).any(|(a, b)| !apart(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::is_inside;

    #[test]
    fn strips_find_what_all_sides_find() {
        let star = (0..200).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 200.0;
            let radius = 0.3 + 0.1 * (7.0 * angle).cos();
            Uv::new(0.5 + radius * angle.cos(), 0.5 + radius * angle.sin())
        });
        let star: Vec<Uv> = star.collect();
        let outline = SlabPolygon::new(star.iter().copied());
        for k in 0..10_000 {
            let p = Uv::new(f64::from(k % 100) / 99.0, f64::from(k / 100) / 99.0);
            assert_eq!(outline.contains(p), is_inside(p, &star), "{p}");
        }
    }
}
