//! The division of a surface into cells. Cell borders are the break lines of the surface; strips in
//! which the surface turns far are divided further.

use rayon::prelude::*;

use super::cell::SurfaceCell;
use crate::geometry::{Point, Uv, Vector};
use crate::spline::ParametricSurface;
use crate::spline::foot::Foot;

/// The mean change of a first derivative over a cell, as a share of the derivative. With smaller
/// cells the bounds would hardly improve.
const MOST_CHANGE: f64 = 0.5;

/// The largest number of parts into which a strip between two break lines is divided. Cells that
/// need a finer division are divided during a search.
const MOST_PARTS: f64 = 32.0;

/// The surface has a crease at a line if the derivatives on both sides differ by more than this
/// share. On smooth surfaces they differ by what they change across the step between the two
/// places.
const CREASE: f64 = 1e-5;

/// The distance of these two places from the line, as a share of the narrower strip.
const BESIDE: f64 = 1e-8;

/// The cells and the lines that separate them.
#[derive(Debug)]
pub(super) struct CellGrid {
    /// The lines u = const and v = const, including the ends.
    pub lines: [Vec<f64>; 2],
    /// Which of these lines are creases or ends of the surface.
    pub creases: [Vec<bool>; 2],
    /// The cells; cell (i, j) is at `i * rows + j`.
    pub cells: Vec<SurfaceCell>,
    pub rows: usize,
}

impl CellGrid {
    pub(super) fn new<S: ParametricSurface + ?Sized>(surface: &S) -> Self {
        let breaks = surface.breaks();
        let lines = [0, 1].map(|axis| lines(surface, &breaks, axis));
        let creases = [0, 1].map(|axis| creases(surface, &lines, axis));
        let rows = lines[1].len() - 1;
        let corner = |i: usize, j: usize| Uv::new(lines[0][i], lines[1][j]);
        let of = |n: usize| {
            let (i, j) = (n / rows, n % rows);
            SurfaceCell::measured(surface, corner(i, j), corner(i + 1, j + 1))
        };
        let count = (lines[0].len() - 1) * rows;
        let cells = (0..count).into_par_iter().with_min_len(64).map(of).collect();
        CellGrid { lines, creases, cells, rows }
    }

    /// The numbers of columns and rows of cells.
    pub(super) fn shape(&self) -> [usize; 2] {
        [self.lines[0].len() - 1, self.rows]
    }

    /// The cell that contains a parameter point.
    pub(crate) fn find(&self, at: Uv) -> usize {
        let of = |k: usize| {
            let inner = &self.lines[k][1..self.lines[k].len() - 1];
            inner.partition_point(|&t| t <= at[k])
        };
        of(0) * self.rows + of(1)
    }

    /// Which sides of a cell are creases or ends of the surface, low and high in u and in v. On
    /// such a side the nearest point need not be a foot point.
    pub(crate) fn ends(&self, n: usize) -> [[bool; 2]; 2] {
        let at = [n / self.rows, n % self.rows];
        [0, 1].map(|k| [self.creases[k][at[k]], self.creases[k][at[k] + 1]])
    }

    /// The remaining gradient of ½‖S − p‖² at an approximate foot point, in mm; 0 at an exact one.
    /// Components that lead out of the domain are ignored.
    pub(crate) fn remaining_gradient(&self, p: Point, foot: &Foot) -> f64 {
        let r = foot.jet.s - p;
        let along = |k: usize| {
            let derivative = [foot.jet.su, foot.jet.sv][k];
            let remaining_gradient = r.dot(&derivative) / derivative.norm().max(f64::MIN_POSITIVE);
            let line = &self.lines[k];
            let (first, last) = (line[0], line[line.len() - 1]);
            let held = (foot.at[k] <= first && remaining_gradient > 0.0)
                || (foot.at[k] >= last && remaining_gradient < 0.0);
            if held { 0.0 } else { remaining_gradient }
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

/// The lines of one axis.
fn lines<S: ParametricSurface + ?Sized>(
    surface: &S,
    breaks: &[Vec<f64>; 2],
    axis: usize,
) -> Vec<f64> {
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

/// Which lines of one axis are creases or ends of the surface.
fn creases<S: ParametricSurface + ?Sized>(
    surface: &S,
    lines: &[Vec<f64>; 2],
    axis: usize,
) -> Vec<bool> {
    let line = &lines[axis];
    let is_crease = |i: usize| {
        if i == 0 || i + 1 == line.len() {
            return true;
        }
        let step = BESIDE * (line[i] - line[i - 1]).min(line[i + 1] - line[i]);
        middles(&lines[1 - axis]).any(|across| {
            let [a, b] = [-step, step].map(|s| surface.jet(place(axis, line[i] + s, across)));
            let differ = |a: Vector, b: Vector| (a - b).norm() > CREASE * (a.norm() + b.norm());
            differ(a.su, b.su) || differ(a.sv, b.sv)
        })
    };
    (0..line.len()).into_par_iter().map(is_crease).collect()
}
