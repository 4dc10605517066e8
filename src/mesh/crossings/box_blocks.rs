//! Bounding boxes in compact blocks, to find all pairs that overlap.

use crate::geometry::{FEW, Point};

/// The number of a box, and its lowest and highest corner.
pub(crate) type NumberedBox = (u32, [Point; 2]);

/// Some boxes that are near each other, and the box around them.
pub(crate) struct BoxBlock {
    pub extent: [Point; 2],
    pub members: Vec<NumberedBox>,
}

/// All boxes in blocks. The blocks are sorted by where they begin along `axis`.
pub(crate) struct BoxBlocks {
    pub blocks: Vec<BoxBlock>,
    axis: usize,
}

impl BoxBlocks {
    pub(crate) fn new(mut boxes: Vec<NumberedBox>) -> Self {
        let axis = widest(around(&boxes));
        let mut blocks = Vec::with_capacity(2 * boxes.len() / FEW + 1);
        divide(&mut boxes, &mut blocks);
        blocks.sort_by(|s, t| s.extent[0][axis].total_cmp(&t.extent[0][axis]));
        BoxBlocks { blocks, axis }
    }

    /// Calls `found` once for each pair of boxes that overlap.
    pub(crate) fn pairs(&self, mut found: impl FnMut(u32, u32)) {
        for (k, block) in self.blocks.iter().enumerate() {
            within(&block.members, &mut found);
            for other in &self.blocks[k + 1..] {
                if other.extent[0][self.axis] > block.extent[1][self.axis] {
                    break;
                }
                between(block, other, &mut found);
            }
        }
    }
}

fn within(members: &[NumberedBox], found: &mut impl FnMut(u32, u32)) {
    for (k, (number, place)) in members.iter().enumerate() {
        let later = members[k + 1..].iter().filter(|other| overlap(place, &other.1));
        later.for_each(|other| found(*number, other.0));
    }
}

fn between(block: &BoxBlock, other: &BoxBlock, found: &mut impl FnMut(u32, u32)) {
    if overlap(&block.extent, &other.extent) {
        for (number, place) in block.members.iter().filter(|m| overlap(&m.1, &other.extent)) {
            let overlapping = other.members.iter().filter(|m| overlap(place, &m.1));
            overlapping.for_each(|m| found(*number, m.0));
        }
    }
}

/// Whether two boxes have a point in common.
pub(crate) fn overlap(s: &[Point; 2], t: &[Point; 2]) -> bool {
    (0..3).all(|k| (s[0][k] <= t[1][k]) & (t[0][k] <= s[1][k]))
}

/// The box around some boxes.
pub(crate) fn around(boxes: &[NumberedBox]) -> [Point; 2] {
    let none = [Point::new(f64::MAX, f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN, f64::MIN)];
    boxes.iter().fold(none, |sum, (_, [low, high])| [sum[0].inf(low), sum[1].sup(high)])
}

fn widest([low, high]: [Point; 2]) -> usize {
    (high - low).imax()
}

/// Halves the boxes along the widest axis until a block takes them.
fn divide(boxes: &mut [NumberedBox], blocks: &mut Vec<BoxBlock>) {
    let extent = around(boxes);
    if boxes.len() <= FEW {
        blocks.push(BoxBlock { extent, members: boxes.to_vec() });
        return;
    }
    let (axis, half) = (widest(extent), boxes.len() / 2);
    let place = |(_, [low, high]): &NumberedBox| low[axis] + high[axis];
    boxes.select_nth_unstable_by(half, |s, t| place(s).total_cmp(&place(t)));
    let (low, high) = boxes.split_at_mut(half);
    divide(low, blocks);
    divide(high, blocks);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_overlapping_pairs_are_found_once() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let mut place = || {
            let low = Point::new(random(), 3.0 * random(), 0.3 * random());
            [low, low + 0.2 * random().powi(3) * crate::geometry::Vector::new(1.0, 1.0, 1.0)]
        };
        let boxes: Vec<NumberedBox> = (0..500).map(|number| (number, place())).collect();
        let mut found = Vec::new();
        BoxBlocks::new(boxes.clone()).pairs(|s, t| found.push((s.min(t), s.max(t))));
        found.sort_unstable();
        let all = (0..500).flat_map(|s| (s + 1..500).map(move |t| (s, t)));
        let overlapping =
            |&(s, t): &(u32, u32)| overlap(&boxes[s as usize].1, &boxes[t as usize].1);
        let expected: Vec<_> = all.filter(overlapping).collect();
        assert!(expected.len() > 100 && found == expected);
    }
}
