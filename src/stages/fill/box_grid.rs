//! A hash grid of bounding boxes, to find those that overlap a given box. A box is kept in
//! the cell that has its centre; larger boxes are kept in grids with wider cells.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::geometry::Point;
use crate::mesh::Buckets;
use crate::mesh::crossings::{NumberedBox, overlap};

/// A query over more cells than this uses a tree. It changes the time only.
const MOST_CELLS: i64 = 1000;

/// Boxes by their lowest and highest corners, in buckets by a hash of their cell.
pub(crate) struct BoxGrid {
    width: f64,
    boxes: Vec<[Point; 2]>,
    buckets: Buckets,
    /// The number of buckets, a power of two, minus one.
    mask: usize,
    /// The grids that have boxes, by how often their cells are doubled.
    levels: BTreeSet<u32>,
    /// All boxes, for queries over many cells. Made by the first such query.
    tree: OnceLock<RTree<Entry>>,
}

/// A box in the tree, with its number.
type Entry = GeomWithData<Rectangle<[f64; 3]>, u32>;

impl BoxGrid {
    /// Boxes in a grid whose finest cells have this width.
    pub(super) fn new(boxes: Vec<[Point; 2]>, width: f64) -> Self {
        let mask = (boxes.len() / 2).next_power_of_two() - 1;
        let keys = boxes.par_iter().map(|place| {
            let (level, cell) = home(place, width);
            (level as u8, bucket(level, cell, mask) as u32)
        });
        let (mut levels, keys): (Vec<u8>, Vec<u32>) = keys.unzip();
        levels.dedup();
        let levels = levels.into_iter().map(u32::from).collect();
        let buckets = Buckets::new(mask + 1, keys.len(), |i| keys[i as usize]);
        BoxGrid { width, boxes, buckets, mask, levels, tree: OnceLock::new() }
    }

    /// The boxes that overlap a given one.
    pub(crate) fn overlapping(&self, place: [Point; 2]) -> impl Iterator<Item = NumberedBox> + '_ {
        let is_large = self.levels.iter().any(|&level| self.reached(level, place).is_none());
        let levels = self.levels.iter().filter(move |_| !is_large);
        let near = levels.flat_map(move |&level| self.near(level, place));
        let corners = AABB::from_corners(place[0].into(), place[1].into());
        let met = is_large.then(|| self.tree().locate_in_envelope_intersecting(corners));
        let met: Vec<u32> = met.into_iter().flatten().map(|entry| entry.data).collect();
        let numbered = near.chain(met).map(|number| (number, self.boxes[number as usize]));
        numbered.filter(move |b| overlap(&b.1, &place))
    }

    fn tree(&self) -> &RTree<Entry> {
        self.tree.get_or_init(|| {
            let entry = |(&[low, high], number): (&[Point; 2], u32)| {
                GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), number)
            };
            RTree::bulk_load(self.boxes.iter().zip(0..).map(entry).collect())
        })
    }

    /// The lowest and the highest cell of a level that can have boxes overlapping `place`.
    /// `None` if there are too many between them.
    fn reached(&self, level: u32, place: [Point; 2]) -> Option<[[i64; 3]; 2]> {
        let width = width_of(level, self.width);
        let reach = nalgebra::Vector3::repeat(0.5 * width);
        let [low, high] = [place[0] - reach, place[1] + reach].map(|p| cell(p, width));
        let count = |k: usize| high[k].saturating_sub(low[k]).saturating_add(1);
        let cells = (0..3).fold(1, |n: i64, k| n.saturating_mul(count(k)));
        (cells <= MOST_CELLS).then_some([low, high])
    }

    /// The boxes of a level in the cells around `place`.
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

/// The level and the cell of a box.
fn home(place: &[Point; 2], width: f64) -> (u32, [i64; 3]) {
    let level = level_of(place, width);
    (level, cell(nalgebra::center(&place[0], &place[1]), width_of(level, width)))
}

fn level_of([low, high]: &[Point; 2], width: f64) -> u32 {
    ((high - low).max() / width).log2().ceil().clamp(0.0, f64::from(u8::MAX)) as u32
}

fn width_of(level: u32, width: f64) -> f64 {
    width * f64::from(level).exp2()
}

fn cell(p: Point, width: f64) -> [i64; 3] {
    [0, 1, 2].map(|k| (p[k] / width).floor() as i64)
}

/// The bucket of a cell. Neighbours along x are in neighbouring buckets, because most
/// scanners number their points along lines.
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
        let found = |cells: &BoxGrid, place: [Point; 2]| {
            let mut found: Vec<u32> = cells.overlapping(place).map(|b| b.0).collect();
            found.sort_unstable();
            found
        };
        let cells = BoxGrid::new((0..100).map(|i| at(f64::from(i))).collect(), 2.0);
        assert_eq!(found(&cells, at(50.5)), [50, 51]);
        let everything = [-1e6, 1e6].map(|x| Point::new(x, x, x));
        assert_eq!(found(&cells, everything).len(), 100);
        let wide = BoxGrid::new(vec![at(0.0), at(0.0).map(|p| p * 1e9)], 1e-3);
        assert_eq!(found(&wide, at(0.5)), [0, 1]);
    }
}
