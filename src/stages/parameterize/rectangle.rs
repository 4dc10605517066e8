//! The rectangle to which a patch is mapped, and the boundary on its sides.

use super::relax::Freedom;
use crate::geometry::{Point, Quarter, Uv};

/// A closed loop of vertices, four of which are the corners of a rectangle. The bottom, right, top
/// and left sides follow each other counter-clockwise.
pub(crate) struct Rectangle {
    /// The loop, starting at the first corner.
    outer: Vec<u32>,
    /// The positions of the corners in the loop, in ascending order.
    corners: [usize; 4],
}

impl Rectangle {
    /// The loop `outer` with four of its vertices, in its order, as corners.
    pub(super) fn new(outer: &[u32], corners: &[u32; 4]) -> Self {
        let position = |outer: &[u32], c| outer.iter().position(|&v| v == c).unwrap_or(0);
        let mut outer = outer.to_vec();
        let first = position(&outer, corners[0]);
        outer.rotate_left(first);
        let corners = corners.map(|c| position(&outer, c));
        Rectangle { outer, corners }
    }

    /// The vertices of each side, including both corners.
    fn sides(&self) -> [impl Iterator<Item = u32> + Clone + '_; 4] {
        let n = self.outer.len();
        [0, 1, 2, 3].map(|k| {
            let end = if k < 3 { self.corners[k + 1] } else { n };
            (self.corners[k]..=end).map(move |i| self.outer[i % n])
        })
    }

    /// The directions in which each of `count` vertices may move.
    pub(crate) fn freedom(&self, count: usize) -> Vec<Freedom> {
        let mut freedom = vec![Freedom::Full; count];
        for (side, along) in
            self.sides().into_iter().zip([Freedom::AlongX, Freedom::AlongY].repeat(2))
        {
            side.for_each(|v| freedom[v as usize] = along);
        }
        self.corners.iter().for_each(|&c| freedom[self.outer[c] as usize] = Freedom::None);
        freedom
    }

    /// Places the boundary by chord length on the sides of a rectangle. The rectangle has the given
    /// area, and its aspect ratio is that of the mean lengths of opposite sides. Returns width and
    /// height.
    pub(crate) fn lay(&self, points: &[Point], area: f64, at: &mut [Uv]) -> [f64; 2] {
        let chord = |(a, b): (u32, u32)| (points[b as usize] - points[a as usize]).norm();
        let chords = self.sides().map(|side| {
            let next = side.clone().skip(1);
            let lengths: Vec<f64> = side.zip(next).map(chord).collect();
            lengths
        });
        let totals = chords.each_ref().map(|c| c.iter().sum::<f64>().max(f64::MIN_POSITIVE));
        let aspect = ((totals[0] + totals[2]) / (totals[1] + totals[3])).sqrt();
        let [width, height] = [area.sqrt() * aspect, area.sqrt() / aspect];
        for (k, side) in self.sides().into_iter().enumerate() {
            let mut walked = 0.0;
            for (v, length) in side.zip(&chords[k]) {
                let t = walked / totals[k];
                let [x, y] = Quarter(k).turned(1.0, [t, 0.0]);
                at[v as usize] = Uv::new(x * width, y * height);
                walked += length;
            }
        }
        [width, height]
    }

    /// Scales positions in a rectangle to the unit square. The boundary is placed exactly on its
    /// sides.
    pub(crate) fn to_unit_square(&self, size: [f64; 2], at: &[Uv]) -> Vec<Uv> {
        let mut uv: Vec<Uv> = at.iter().map(|p| Uv::new(p.x / size[0], p.y / size[1])).collect();
        for (k, side) in self.sides().into_iter().enumerate() {
            for v in side {
                let p = &mut uv[v as usize];
                match k {
                    0 => p.y = 0.0,
                    1 => p.x = 1.0,
                    2 => p.y = 1.0,
                    _ => p.x = 0.0,
                }
            }
        }
        uv
    }
}
