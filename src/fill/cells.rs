//! Boxes by the cell of a grid over space that their centre is in, to find the
//! near ones; large boxes in grids of wider cells.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::blocks::{Numbered, meet};
use crate::geometry::Point;
use crate::mesh::Buckets;

/// What is near a place that reaches into more cells than this is told by a tree.
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
    /// All boxes, for places much larger than they; made for the first of these.
    tree: OnceLock<RTree<Entry>>,
}

/// A box in the tree, with its number.
type Entry = GeomWithData<Rectangle<[f64; 3]>, u32>;

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
        Cells { width, boxes, buckets, mask, levels, tree: OnceLock::new() }
    }

    /// The boxes that meet one.
    pub fn meeting(&self, place: [Point; 2]) -> impl Iterator<Item = Numbered> + '_ {
        let is_large = self.levels.iter().any(|&level| self.reached(level, place).is_none());
        let levels = self.levels.iter().filter(move |_| !is_large);
        let near = levels.flat_map(move |&level| self.near(level, place));
        let corners = AABB::from_corners(place[0].into(), place[1].into());
        let met = is_large.then(|| self.tree().locate_in_envelope_intersecting(corners));
        let met: Vec<u32> = met.into_iter().flatten().map(|entry| entry.data).collect();
        let numbered = near.chain(met).map(|number| (number, self.boxes[number as usize]));
        numbered.filter(move |b| meet(&b.1, &place))
    }

    fn tree(&self) -> &RTree<Entry> {
        self.tree.get_or_init(|| {
            let entry = |(&[low, high], number): (&[Point; 2], u32)| {
                GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), number)
            };
            RTree::bulk_load(self.boxes.iter().zip(0..).map(entry).collect())
        })
    }

    /// The lowest and the highest of a level's cells around a place, unless they are too
    /// many.
    fn reached(&self, level: u32, place: [Point; 2]) -> Option<[[i64; 3]; 2]> {
        let width = width_of(level, self.width);
        let reach = nalgebra::Vector3::repeat(0.5 * width);
        let [low, high] = [place[0] - reach, place[1] + reach].map(|p| cell(p, width));
        let count = |k: usize| high[k].saturating_sub(low[k]).saturating_add(1);
        let cells = (0..3).fold(1, |n: i64, k| n.saturating_mul(count(k)));
        (cells <= MOST_CELLS).then_some([low, high])
    }

    /// The boxes of a level in the cells around a place.
    fn near(&self, level: u32, place: [Point; 2]) -> impl Iterator<Item = u32> + '_ {
        let cells = self.reached(level, place).map(|[low, high]| {
            let along = move |k: usize| low[k]..=high[k];
            let column = move |x: i64| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z]));
            along(0).flat_map(column)
        });
        let is_at = move |number: u32, at: (u32, [i64; 3])| {
            home(&self.boxes[number as usize], self.width) == at
        };
        cells.into_iter().flatten().flat_map(move |cell| {
            let all = self.buckets.of(bucket(level, cell, self.mask)).iter().copied();
            all.filter(move |&number| is_at(number, (level, cell)))
        })
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
