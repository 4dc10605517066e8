//! The rims of a hole projected to a plane, and a test whether a point is in the hole.

use crate::geometry::{FEW, Uv, UvVector, ray_crosses, uv_bounds};

/// The rims as closed polygons. Their sides are sorted into strips across the longer axis.
pub(crate) struct RimOutlines {
    strips: Vec<Vec<(Uv, Uv)>>,
    low: f64,
    width: f64,
    is_wide: bool,
}

impl RimOutlines {
    pub(super) fn new(outlines: &[Vec<Uv>]) -> Self {
        let [low, high] = uv_bounds(&outlines.concat());
        let size = high - low;
        let is_wide = size.x > size.y;
        // A strip has about this many sides if they are spread evenly.
        let count = outlines.iter().map(Vec::len).sum::<usize>() / FEW + 1;
        let width = (size.max() / count as f64).max(f64::MIN_POSITIVE);
        let low = if is_wide { low.x } else { low.y };
        let mut all = RimOutlines { strips: vec![Vec::new(); count], low, width, is_wide };
        for outline in outlines {
            for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
                let (a, b) = (all.turned(*a), all.turned(*b));
                let [first, last] = [a.y.min(b.y), a.y.max(b.y)].map(|y| all.strip(y));
                all.strips[first..=last].iter_mut().for_each(|strip| strip.push((a, b)));
            }
        }
        all
    }

    /// Swaps the axes if needed, so that y is the longer one.
    fn turned(&self, p: Uv) -> Uv {
        if self.is_wide { p.yx() } else { p }
    }

    fn strip(&self, y: f64) -> usize {
        (((y - self.low) / self.width) as usize).min(self.strips.len() - 1)
    }

    /// Whether `p` is in the hole, or a rim vertex is in the square of side `width` around
    /// `p`.
    pub(crate) fn is_in_or_near(&self, p: Uv, width: f64) -> bool {
        let p = self.turned(p);
        let near = |q: Uv| (q - p).abs() <= UvVector::repeat(0.5 * width);
        let [first, last] = [p.y - 0.5 * width, p.y + 0.5 * width].map(|y| self.strip(y));
        let mut around = self.strips[first..=last].iter().flatten();
        let crossed = |side: &&(Uv, Uv)| ray_crosses(p, **side);
        around.any(|side| near(side.0))
            || self.strips[self.strip(p.y)].iter().filter(crossed).count() % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::is_inside;

    #[test]
    fn a_point_in_an_odd_number_of_outlines_is_inside() {
        let circle = |radius: f64| {
            let at = |k: i32| {
                let angle = std::f64::consts::TAU * f64::from(k) / 90.0;
                Uv::new(radius * angle.cos(), radius * (angle.sin() + 0.1 * (7.0 * angle).cos()))
            };
            (0..90).map(at).collect::<Vec<_>>()
        };
        let outlines = [circle(3.0), circle(1.0)];
        let all = RimOutlines::new(&outlines);
        for p in (-35..=35).flat_map(|i| (-40..40).map(move |j| (i, j))) {
            let p = Uv::new(0.1 * f64::from(p.0) + 0.013, 0.1 * f64::from(p.1) + 0.007);
            let inside = outlines.iter().filter(|o| is_inside(p, o)).count() % 2 == 1;
            assert_eq!(all.is_in_or_near(p, 0.0), inside, "{p}");
        }
        assert!(
            all.is_in_or_near(Uv::new(3.2, 0.3), 0.6) && !all.is_in_or_near(Uv::new(3.2, 0.3), 0.2)
        );
    }
}
