//! Boxes by the cell of a grid over space that their centre is in, to find the
//! near ones; large boxes in grids of wider cells.

use foldhash::HashMap;

use super::blocks::{Numbered, meet};
use crate::geometry::Point;

/// A place that reaches into more cells than this is near everything.
const MOST_CELLS: i64 = 1000;

/// Each level's cells are twice as wide as those of the one before.
const LEVELS: usize = 40;

/// Boxes, by their lowest and highest corners.
pub struct Cells {
    width: f64,
    levels: Vec<HashMap<[i64; 3], Vec<Numbered>>>,
}

impl Cells {
    /// Boxes in cells of some width, or wider than they.
    pub fn new(boxes: impl Iterator<Item = [Point; 2]>, width: f64) -> Self {
        let mut all = Cells { width, levels: Vec::new() };
        for (number, [low, high]) in (0..).zip(boxes) {
            let level = ((high - low).max() / width).log2().ceil().clamp(0.0, LEVELS as f64);
            let level = level as usize;
            if all.levels.len() <= level {
                all.levels.resize_with(level + 1, HashMap::default);
            }
            let cell = cell(nalgebra::center(&low, &high), all.width_of(level));
            all.levels[level].entry(cell).or_default().push((number, [low, high]));
        }
        all
    }

    fn width_of(&self, level: usize) -> f64 {
        self.width * (level as f64).exp2()
    }

    /// The boxes that meet one.
    pub fn meeting(&self, place: [Point; 2]) -> impl Iterator<Item = &Numbered> + '_ {
        let near = (0..self.levels.len()).flat_map(move |level| self.near(level, place));
        near.filter(move |b| meet(&b.1, &place))
    }

    /// The boxes of a level in the cells around a place.
    fn near(&self, level: usize, place: [Point; 2]) -> impl Iterator<Item = &Numbered> + '_ {
        let (cells, width) = (&self.levels[level], self.width_of(level));
        let reach = nalgebra::Vector3::repeat(0.5 * width);
        let [low, high] = [place[0] - reach, place[1] + reach].map(|p| cell(p, width));
        let count = |k: usize| high[k].saturating_sub(low[k]).saturating_add(1);
        let many = (0..3).fold(1, |n: i64, k| n.saturating_mul(count(k))) > MOST_CELLS;
        let along = move |k: usize| low[k]..=high[k];
        let column = move |x: i64| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z]));
        let keys = (!many).then(|| along(0).flat_map(column)).into_iter().flatten();
        let all = cells.values().take(if many { usize::MAX } else { 0 });
        keys.filter_map(|key| cells.get(&key)).chain(all).flatten()
    }
}

fn cell(p: Point, width: f64) -> [i64; 3] {
    [0, 1, 2].map(|k| (p[k] / width).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_boxes_are_found() {
        let at = |x: f64| [Point::new(x, 0.0, 0.0), Point::new(x + 1.0, 1.0, 1.0)];
        let found = |cells: &Cells, place: [Point; 2]| {
            let mut found: Vec<u32> = cells.meeting(place).map(|b| b.0).collect();
            found.sort_unstable();
            found
        };
        let cells = Cells::new((0..100).map(|i| at(f64::from(i))), 2.0);
        assert_eq!(found(&cells, at(50.5)), [50, 51]);
        let everything = [-1e6, 1e6].map(|x| Point::new(x, x, x));
        assert_eq!(found(&cells, everything).len(), 100);
        let wide = Cells::new([at(0.0), at(0.0).map(|p| p * 1e9)].into_iter(), 1e-3);
        assert_eq!(found(&wide, at(0.5)), [0, 1]);
    }
}
