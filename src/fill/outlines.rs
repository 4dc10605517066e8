//! The rims of a hole in the plane, and what they enclose.

use crate::geometry::{Uv, UvVector, ray_crosses, uv_bounds};

/// Closed outlines, their sides in strips by height.
pub struct Outlines {
    strips: Vec<Vec<(Uv, Uv)>>,
    low: f64,
    height: f64,
}

impl Outlines {
    pub fn new(outlines: &[Vec<Uv>]) -> Self {
        let sides: Vec<(Uv, Uv)> = outlines
            .iter()
            .flat_map(|o| o.iter().copied().zip(o.iter().copied().cycle().skip(1)))
            .collect();
        let [low, high] = uv_bounds(&outlines.concat()).map(|p| p.y);
        // About as many strips as sides along one side of a square.
        let count = (sides.len() / 4).clamp(1, 1000);
        let height = ((high - low) / count as f64).max(f64::MIN_POSITIVE);
        let mut all = Outlines { strips: vec![Vec::new(); count], low, height };
        for (a, b) in sides {
            let [first, last] = [a.y.min(b.y), a.y.max(b.y)].map(|y| all.strip(y));
            all.strips[first..=last].iter_mut().for_each(|strip| strip.push((a, b)));
        }
        all
    }

    fn strip(&self, y: f64) -> usize {
        (((y - self.low) / self.height) as usize).min(self.strips.len() - 1)
    }

    /// Whether a place is enclosed, or within a square of half a `width` around
    /// it a side begins.
    pub fn reach(&self, p: Uv, width: f64) -> bool {
        let near = |q: Uv| (q - p).abs() <= UvVector::repeat(0.5 * width);
        let [first, last] = [p.y - 0.5 * width, p.y + 0.5 * width].map(|y| self.strip(y));
        let mut around = self.strips[first..=last].iter().flatten();
        around.any(|side| near(side.0)) || self.enclose(p)
    }

    fn enclose(&self, p: Uv) -> bool {
        self.strips[self.strip(p.y)].iter().filter(|side| ray_crosses(p, **side)).count() % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::is_inside;

    #[test]
    fn a_place_is_enclosed_by_an_odd_number_of_outlines() {
        let circle = |radius: f64| {
            let at = |k: i32| {
                let angle = std::f64::consts::TAU * f64::from(k) / 90.0;
                Uv::new(radius * angle.cos(), radius * (angle.sin() + 0.1 * (7.0 * angle).cos()))
            };
            (0..90).map(at).collect::<Vec<_>>()
        };
        let outlines = [circle(3.0), circle(1.0)];
        let all = Outlines::new(&outlines);
        for p in (-35..=35).flat_map(|i| (-40..40).map(move |j| (i, j))) {
            let p = Uv::new(0.1 * f64::from(p.0) + 0.013, 0.1 * f64::from(p.1) + 0.007);
            let inside = outlines.iter().filter(|o| is_inside(p, o)).count() % 2 == 1;
            assert_eq!(all.reach(p, 0.0), inside, "{p}");
        }
        assert!(all.reach(Uv::new(3.2, 0.3), 0.6) && !all.reach(Uv::new(3.2, 0.3), 0.2));
    }
}
