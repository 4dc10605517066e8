//! The cells of a surface: between its break lines, cut up where it turns far between two.

use rayon::prelude::*;

use super::cell::Cell;
use crate::geometry::{Point, Uv, Vector};
use crate::spline::Patch;
use crate::spline::foot::Foot;

/// On average a first derivative changes by less than this share of itself over a cell:
/// then its cells tell about as much as if they were cut up further.
const MOST_CHANGE: f64 = 0.5;

/// A strip between two break lines is cut into so many at the most: cells that need more
/// are cut up when a point is near.
const MOST_PARTS: f64 = 32.0;

/// Derivatives on both sides of a line that differ by more than this share are those of
/// a sharp bend; of smooth surfaces they differ by the step across the line.
const SHARP: f64 = 1e-5;

/// Looks at both sides of a line are so many widths of a strip away from it.
const BESIDE: f64 = 1e-8;

/// The cells, and the lines that part them.
#[derive(Debug)]
pub(super) struct Grid {
    /// Lines u = const and v = const, the ends included.
    pub lines: [Vec<f64>; 2],
    /// Which of them the surface bends sharply or ends at.
    pub sharp: [Vec<bool>; 2],
    /// The cell (i, j) at `i * rows + j`.
    pub cells: Vec<Cell>,
    pub rows: usize,
}

impl Grid {
    pub fn new<S: Patch + ?Sized>(surface: &S) -> Self {
        let breaks = surface.breaks();
        let lines = [0, 1].map(|axis| lines(surface, &breaks, axis));
        let sharp = [0, 1].map(|axis| sharp(surface, &lines, axis));
        let rows = lines[1].len() - 1;
        let corner = |i: usize, j: usize| Uv::new(lines[0][i], lines[1][j]);
        let of = |n: usize| {
            let (i, j) = (n / rows, n % rows);
            Cell::measured(surface, corner(i, j), corner(i + 1, j + 1))
        };
        let count = (lines[0].len() - 1) * rows;
        let cells = (0..count).into_par_iter().with_min_len(64).map(of).collect();
        Grid { lines, sharp, cells, rows }
    }

    /// How many columns and rows of cells there are.
    pub fn shape(&self) -> [usize; 2] {
        [self.lines[0].len() - 1, self.rows]
    }

    /// The cell that holds a parameter point.
    pub fn find(&self, at: Uv) -> usize {
        let of = |k: usize| {
            let inner = &self.lines[k][1..self.lines[k].len() - 1];
            inner.partition_point(|&t| t <= at[k])
        };
        of(0) * self.rows + of(1)
    }

    /// At which sides of a cell, low and high in u and in v, the surface bends sharply or
    /// ends: there the nearest place need not be a foot.
    pub fn ends(&self, n: usize) -> [[bool; 2]; 2] {
        let at = [n / self.rows, n % self.rows];
        [0, 1].map(|k| [self.sharp[k][at[k]], self.sharp[k][at[k] + 1]])
    }

    /// The gradient of ½‖S − p‖² at a foot, in mm: 0 at an exact one. What leads out of the
    /// surface does not count.
    pub fn slope(&self, p: Point, foot: &Foot) -> f64 {
        let r = foot.jet.s - p;
        let along = |k: usize| {
            let derivative = [foot.jet.su, foot.jet.sv][k];
            let slope = r.dot(&derivative) / derivative.norm().max(f64::MIN_POSITIVE);
            let line = &self.lines[k];
            let (first, last) = (line[0], line[line.len() - 1]);
            let held = (foot.at[k] <= first && slope > 0.0) || (foot.at[k] >= last && slope < 0.0);
            if held { 0.0 } else { slope }
        };
        along(0).hypot(along(1))
    }
}

fn middles(lines: &[f64]) -> impl Iterator<Item = f64> {
    lines.windows(2).map(|w| 0.5 * (w[0] + w[1]))
}

fn place(axis: usize, along: f64, across: f64) -> Uv {
    if axis == 0 { Uv::new(along, across) } else { Uv::new(across, along) }
}

/// The lines of an axis.
fn lines<S: Patch + ?Sized>(surface: &S, breaks: &[Vec<f64>; 2], axis: usize) -> Vec<f64> {
    let strips: Vec<&[f64]> = breaks[axis].windows(2).collect();
    let parts = strips.par_iter().map(|strip| {
        let (length, middle) = (strip[1] - strip[0], 0.5 * (strip[0] + strip[1]));
        let change = |across: f64| {
            let jet = surface.jet(place(axis, middle, across));
            let (first, second) = [(jet.su, jet.suu), (jet.sv, jet.svv)][axis];
            let first = first.norm();
            if first > 0.0 { (second.norm() * length / first).min(MOST_PARTS) } else { 0.0 }
        };
        let across: Vec<f64> = middles(&breaks[1 - axis]).map(change).collect();
        let mean = across.iter().sum::<f64>() / across.len() as f64;
        (mean / MOST_CHANGE).ceil().clamp(1.0, MOST_PARTS) as usize
    });
    let parts: Vec<usize> = parts.collect();
    let inner = strips.iter().zip(parts).flat_map(|(strip, parts)| {
        (0..parts).map(move |i| strip[0] + (strip[1] - strip[0]) * i as f64 / parts as f64)
    });
    inner.chain(breaks[axis].last().copied()).collect()
}

/// Which lines of an axis the surface bends sharply or ends at.
fn sharp<S: Patch + ?Sized>(surface: &S, lines: &[Vec<f64>; 2], axis: usize) -> Vec<bool> {
    let line = &lines[axis];
    let is_sharp = |i: usize| {
        if i == 0 || i + 1 == line.len() {
            return true;
        }
        let step = BESIDE * (line[i] - line[i - 1]).min(line[i + 1] - line[i]);
        middles(&lines[1 - axis]).any(|across| {
            let [a, b] = [-step, step].map(|s| surface.jet(place(axis, line[i] + s, across)));
            let differ = |a: Vector, b: Vector| (a - b).norm() > SHARP * (a.norm() + b.norm());
            differ(a.su, b.su) || differ(a.sv, b.sv)
        })
    };
    (0..line.len()).into_par_iter().map(is_sharp).collect()
}
