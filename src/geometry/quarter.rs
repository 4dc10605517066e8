//! Turns of a square by quarters, for squares whose sides are numbered counter-clockwise from the bottom one.

use std::ops::Sub;

/// A turn of the square [0, end]² by quarters, counter-clockwise: as many as the number of the side to which
/// it takes side 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Quarter(pub usize);

impl Quarter {
    /// The place to which the turn takes (x, y). With an `end` of zero the coordinates are those of a
    /// direction.
    pub(crate) fn turned<T: Copy + Sub<Output = T>>(self, end: T, [x, y]: [T; 2]) -> [T; 2] {
        match self.0 {
            0 => [x, y],
            1 => [end - y, x],
            2 => [end - x, end - y],
            _ => [y, end - x],
        }
    }

    /// The place that the turn takes to (x, y).
    pub(crate) fn turned_back<T: Copy + Sub<Output = T>>(self, end: T, place: [T; 2]) -> [T; 2] {
        Quarter((4 - self.0) % 4).turned(end, place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn side_0_becomes_the_side_of_the_number_and_comes_back() {
        let starts = [[0, 0], [7, 0], [7, 7], [0, 7]];
        for k in 0..4 {
            assert_eq!(Quarter(k).turned(7, [0, 0]), starts[k]);
            assert_eq!(Quarter(k).turned(7, [7, 0]), starts[(k + 1) % 4]);
            assert_eq!(Quarter(k).turned_back(7, Quarter(k).turned(7, [2, 3])), [2, 3]);
        }
    }
}
