//! The order of the points: along a Morton curve, without repeated points.
//!
//! Points that follow each other in this order are near each other in space, so every later loop
//! reads memory that it has just read. The order depends on the coordinates alone. Two files with
//! the same points in different orders therefore have the same result.

use rayon::prelude::*;

use crate::geometry::{Point, Vector, bounds};

/// The distinct points of a cloud in Morton order, around zero and at most about one unit long.
pub(super) struct Ordered {
    /// The points.
    pub points: Vec<Point>,
    /// For each point the first point of the cloud that is at this place.
    pub first: Vec<u32>,
    /// For each point of the cloud its number in `points`.
    pub number: Vec<u32>,
    /// What takes `points` back to the coordinates of the cloud.
    pub frame: WorkFrame,
    grid: MortonGrid,
}

/// The cubic grid along which points are ordered.
#[derive(Debug, Clone, Copy)]
struct MortonGrid {
    low: Point,
    /// Cells in a unit of length.
    scale: f64,
}

/// The map from the coordinates of the cloud to those of the work: times a power of two, then
/// moved. Without it the square of a very long or a very short distance would not be a number.
#[derive(Debug, Clone, Copy)]
pub(super) struct WorkFrame {
    factor: f64,
    middle: Vector,
}

impl WorkFrame {
    /// The map for points at these positions.
    pub(super) fn new(positions: &[[f64; 3]]) -> Self {
        let largest = positions.par_iter().map(largest_coordinate).reduce(|| 0.0, f64::max);
        let mut frame = WorkFrame { factor: inverse_size(largest), middle: Vector::zeros() };
        let [low, high] = bounds(positions.iter().map(|&p| frame.inward(p)));
        frame.middle = 0.5 * (low.coords + high.coords);
        frame
    }

    /// The coordinates of the work for a point of the cloud.
    pub(crate) fn inward(&self, p: [f64; 3]) -> Point {
        Point::from(Vector::from(p) * self.factor - self.middle)
    }

    /// The coordinates of the cloud for a point of the work.
    pub(crate) fn outward(&self, p: &Point) -> [f64; 3] {
        ((p.coords + self.middle) / self.factor).into()
    }

    /// A length of the work in the unit of the cloud.
    pub(crate) fn length(&self, of_work: f64) -> f64 {
        of_work / self.factor
    }

    /// A length in the unit of the cloud as one of the work.
    pub(crate) fn work_length(&self, of_cloud: f64) -> f64 {
        of_cloud * self.factor
    }
}

fn largest_coordinate(p: &[f64; 3]) -> f64 {
    p.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// A power of two that brings `size` to about one.
fn inverse_size(size: f64) -> f64 {
    // Beyond this exponent the power or its inverse is not a normal number.
    let most = -f64::from(f64::MIN_EXP);
    if size > 0.0 { (-size.log2().floor().clamp(-most, most)).exp2() } else { 1.0 }
}

impl Ordered {
    pub(super) fn new(positions: &[[f64; 3]]) -> Self {
        let frame = WorkFrame::new(positions);
        let at = |i: u32| frame.inward(positions[i as usize]);
        let grid = MortonGrid::new((0..positions.len() as u32).map(at));
        let mut sorted: Vec<(u64, u32)> =
            (0..positions.len() as u32).into_par_iter().map(|i| (grid.code(&at(i)), i)).collect();
        let place = |i: u32| positions[i as usize];
        let by_place = |i: u32, j: u32| {
            let (a, b) = (place(i), place(j));
            let axes = (0..3).map(|k| a[k].partial_cmp(&b[k]));
            axes.flatten().find(|o| o.is_ne()).unwrap_or(i.cmp(&j))
        };
        sorted.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then_with(|| by_place(a.1, b.1)));
        let mut ordered = Ordered {
            points: Vec::with_capacity(positions.len()),
            first: Vec::with_capacity(positions.len()),
            number: vec![0; positions.len()],
            frame,
            grid,
        };
        for (_, i) in sorted {
            if ordered.first.last().is_none_or(|&last| place(last) != place(i)) {
                ordered.first.push(i);
                ordered.points.push(at(i));
            }
            ordered.number[i as usize] = ordered.first.len() as u32 - 1;
        }
        ordered
    }

    /// The first point in each cube that holds points, and the edge of the cubes: the longest one that is not longer
    /// than asked. Halves of the extent of the cloud are tried.
    pub(super) fn cubes(&self, longest: f64) -> (Vec<u32>, f64) {
        let levels = (longest * self.grid.scale).log2().floor().clamp(0.0, LEVELS) as u32;
        let cube = |i: usize| self.grid.code(&self.points[i]) >> (3 * levels);
        let is_first = |&i: &usize| i == 0 || cube(i) != cube(i - 1);
        let numbers = (0..self.points.len()).into_par_iter();
        let first = numbers.filter(is_first).map(|i| i as u32).collect();
        (first, f64::from(1 << levels) / self.grid.scale)
    }
}

impl MortonGrid {
    fn new(points: impl Iterator<Item = Point>) -> Self {
        let [low, high] = bounds(points);
        let extent = (high - low).amax();
        MortonGrid { low, scale: if extent > 0.0 { f64::from(CELLS) / extent } else { 0.0 } }
    }

    /// The place of a point in the order.
    fn code(&self, point: &Point) -> u64 {
        let cell = (point - self.low) * self.scale;
        (0..3).map(|k| spread(cell[k] as u64) << k).sum()
    }
}

/// The largest cell along an axis: of cells up to it, three numbers fit a u64.
pub(super) const CELLS: u32 = (1 << 21) - 1;

/// The number of times that the cells can be doubled.
const LEVELS: f64 = 20.0;

/// The 21 lowest bits, each three places after the last one.
fn spread(x: u64) -> u64 {
    let x = x & 0x1f_ffff;
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}
