//! Boxes by the cell of a grid over space that their centre is in, to find the
//! near ones; large boxes in grids of wider cells.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::blocks::{Numbered, meet};
use crate::geometry::Point;
use crate::mesh::Buckets;

/// A place that reaches into more cells than this is near everything.
const MOST_CELLS: i64 = 1000;

/// Each level's cells are twice as wide as those of the one before.
const LEVELS: u32 = 40;

/// Boxes, by their lowest and highest corners, in buckets by a hash of the cell that
/// they are in.
pub struct Cells {
    width: f64,
    boxes: Vec<[Point; 2]>,
    buckets: Buckets,
    /// How many buckets there are, less one; a power of two less one.
    mask: usize,
    /// The levels that have boxes.
    levels: BTreeSet<u32>,
}

impl Cells {
    /// Boxes in cells of some width, or wider than they.
    pub fn new(boxes: Vec<[Point; 2]>, width: f64) -> Self {
        let mask = (boxes.len() / 2).next_power_of_two() - 1;
        let keys = boxes.par_iter().map(|place| {
            let (level, cell) = home(place, width);
            (level as u8, bucket(level, cell, mask) as u32)
        });
        let (mut levels, keys): (Vec<u8>, Vec<u32>) = keys.unzip();
        levels.dedup();
        let levels = levels.into_iter().map(u32::from).collect();
        let buckets = Buckets::new(mask + 1, keys.len(), |i| keys[i as usize]);
        Cells { width, boxes, buckets, mask, levels }
    }

    /// The boxes that meet one.
    pub fn meeting(&self, place: [Point; 2]) -> impl Iterator<Item = Numbered> + '_ {
        let near = self.levels.iter().flat_map(move |&level| self.near(level, place));
        let numbered = near.map(|number| (number, self.boxes[number as usize]));
        numbered.filter(move |b| meet(&b.1, &place))
    }

    /// The boxes of a level in the cells around a place.
    fn near(&self, level: u32, place: [Point; 2]) -> impl Iterator<Item = u32> + '_ {
        let width = width_of(level, self.width);
        let reach = nalgebra::Vector3::repeat(0.5 * width);
        let [low, high] = [place[0] - reach, place[1] + reach].map(|p| cell(p, width));
        let count = |k: usize| high[k].saturating_sub(low[k]).saturating_add(1);
        let many = (0..3).fold(1, |n: i64, k| n.saturating_mul(count(k))) > MOST_CELLS;
        let along = move |k: usize| low[k]..=high[k];
        let column = move |x: i64| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z]));
        let cells = (!many).then(|| along(0).flat_map(column)).into_iter().flatten();
        let is_at = move |number: u32, at: (u32, [i64; 3])| {
            home(&self.boxes[number as usize], self.width) == at
        };
        let within = cells.flat_map(move |cell| {
            let all = self.buckets.of(bucket(level, cell, self.mask)).iter().copied();
            all.filter(move |&number| is_at(number, (level, cell)))
        });
        let all = 0..if many { self.boxes.len() as u32 } else { 0 };
        let of_level =
            move |number: &u32| level_of(&self.boxes[*number as usize], self.width) == level;
        within.chain(all.filter(of_level))
    }
}

/// The level and the cell that a box is in.
fn home(place: &[Point; 2], width: f64) -> (u32, [i64; 3]) {
    let level = level_of(place, width);
    (level, cell(nalgebra::center(&place[0], &place[1]), width_of(level, width)))
}

fn level_of([low, high]: &[Point; 2], width: f64) -> u32 {
    ((high - low).max() / width).log2().ceil().clamp(0.0, f64::from(LEVELS)) as u32
}

fn width_of(level: u32, width: f64) -> f64 {
    width * f64::from(level).exp2()
}

fn cell(p: Point, width: f64) -> [i64; 3] {
    [0, 1, 2].map(|k| (p[k] / width).floor() as i64)
}

/// The bucket of a cell: neighbours along the first axis are next to each other, as
/// most scans have their points.
fn bucket(level: u32, [x, y, z]: [i64; 3], mask: usize) -> usize {
    let far = |n: i64, odd: i64| n.wrapping_mul(odd);
    let sum = x.wrapping_add(far(y, 73_856_093)).wrapping_add(far(z, 19_349_663));
    sum.wrapping_add(far(i64::from(level), 83_492_791)) as usize & mask
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
        let cells = Cells::new((0..100).map(|i| at(f64::from(i))).collect(), 2.0);
        assert_eq!(found(&cells, at(50.5)), [50, 51]);
        let everything = [-1e6, 1e6].map(|x| Point::new(x, x, x));
        assert_eq!(found(&cells, everything).len(), 100);
        let wide = Cells::new(vec![at(0.0), at(0.0).map(|p| p * 1e9)], 1e-3);
        assert_eq!(found(&wide, at(0.5)), [0, 1]);
    }
}
