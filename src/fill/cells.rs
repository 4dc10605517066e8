//! Boxes by the cells of a grid over space that they reach, to find the near
//! ones.

use foldhash::{HashMap, HashMapExt};

use crate::geometry::Point;

/// A box that reaches into more cells than this is near everything.
const MOST_CELLS: i64 = 64;

/// Boxes, by number.
pub struct Cells {
    width: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
    large: Vec<u32>,
}

impl Cells {
    /// Boxes, by their lowest and highest corners, in cells of some width.
    pub fn new(boxes: impl Iterator<Item = [Point; 2]>, width: f64) -> Self {
        let mut all = Cells { width, cells: HashMap::new(), large: Vec::new() };
        for (number, [low, high]) in boxes.enumerate() {
            match all.reach([low, high]) {
                Some(reached) => {
                    for cell in each(reached) {
                        all.cells.entry(cell).or_default().push(number as u32);
                    }
                }
                None => all.large.push(number as u32),
            }
        }
        all
    }

    /// Puts the numbers of the boxes that may meet one into `found`, ascending.
    pub fn near(&self, place: [Point; 2], found: &mut Vec<u32>) {
        found.clear();
        match self.reach(place) {
            Some(reached) => {
                found.extend(each(reached).filter_map(|c| self.cells.get(&c)).flatten());
                found.extend(&self.large);
            }
            None => found.extend(self.cells.values().flatten().chain(&self.large)),
        }
        found.sort_unstable();
        found.dedup();
    }

    /// The first and the last cell that a box reaches; `None` if there are many
    /// between them.
    fn reach(&self, place: [Point; 2]) -> Option<[[i64; 3]; 2]> {
        let [low, high] = place.map(|p| [0, 1, 2].map(|k| (p[k] / self.width).floor() as i64));
        let count = |k: usize| high[k].saturating_sub(low[k]).saturating_add(1);
        let many = (0..3).fold(1, |n: i64, k| n.saturating_mul(count(k)));
        (many <= MOST_CELLS).then_some([low, high])
    }
}

fn each([low, high]: [[i64; 3]; 2]) -> impl Iterator<Item = [i64; 3]> {
    let along = move |k: usize| low[k]..=high[k];
    along(0).flat_map(move |x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_boxes_are_found() {
        let at = |x: f64| [Point::new(x, 0.0, 0.0), Point::new(x + 1.0, 1.0, 1.0)];
        let cells = Cells::new((0..100).map(|i| at(f64::from(i))), 2.0);
        let mut found = Vec::new();
        cells.near(at(50.5), &mut found);
        assert!(found.contains(&50) && found.contains(&51) && found.len() < 8, "{found:?}");
        cells.near([Point::new(-1e6, -1e6, -1e6), Point::new(1e6, 1e6, 1e6)], &mut found);
        assert_eq!(found.len(), 100);
        let wide = Cells::new([at(0.0), at(0.0).map(|p| p * 1e9)].into_iter(), 1e-3);
        wide.near(at(5.0), &mut found);
        assert_eq!(found, [0, 1]);
    }
}
