//! One round of the removal of folds: it assembles the equations around folds, solves them and
//! moves the control points and the samples' parameters.

use rayon::prelude::*;

use super::Slide;
use super::jacobian::JacobianSample;
use super::system::BlockSystem;
use super::terms::Terms;
use crate::geometry::Uv;
use crate::spline::spans::PAIRS;
use crate::spline::{Surface, foot_point_moving, last_step};
use crate::stages::fit::fairing;
use crate::stages::fit::knot_cells::KnotCells;
use crate::stages::fit::tangent_distance::TangentDistance;

/// The share of a Gauss–Newton step that is taken. Full steps overshoot because the Jacobian
/// determinant is not linear.
const DAMPING: f64 = 0.5;

/// The weight that keeps control points in place that no other term determines, as a share of the
/// samples in a mean cell.
const ANCHOR: f64 = 1e-6;

/// The number of rows and columns around cells with folds that move, too.
const AROUND: usize = 4;

/// The current state of the surface and its samples.
pub(crate) struct Work<'a> {
    /// The current surface.
    pub surface: Surface,
    pub cells: &'a KnotCells<'a>,
    pub holds: &'a [TangentDistance],
    /// The current parameters of the samples.
    pub uv: Vec<Uv>,
    /// The samples that may not slide.
    pub stuck: Vec<bool>,
    /// The control points that move.
    free: Vec<bool>,
    /// The equations of the last round, reused if the same control points are free.
    system: Option<BlockSystem>,
    /// The cells whose stuck samples need not hold the surface in all directions.
    pub eased: Vec<bool>,
    /// The number of samples in a mean cell, which weights are relative to. Samples that stand for several points
    /// count once.
    pub weight: f64,
    /// The half lengths of the spans in u and in v, in mm: parameters times the mean length of the
    /// net.
    pub halves: [Vec<f64>; 2],
    /// The area of a mean cell in mm².
    pub area: f64,
    /// For each span, the integrals of products of its basis functions, of their first derivatives
    /// and of their second derivatives.
    pub energies: [Vec<[[[f64; 4]; 4]; 3]>; 2],
}

impl<'a> Work<'a> {
    /// The state before the first round.
    pub(super) fn new(
        surface: &Surface,
        cells: &'a KnotCells<'a>,
        holds: &'a [TangentDistance],
    ) -> Self {
        let samples = cells.samples;
        let [across, down] = cells.counts();
        let lengths = net_lengths(surface);
        let halves: [Vec<f64>; 2] = [0, 1].map(|axis| {
            let spans = cells.spans[axis].all.iter();
            spans.map(|s| s.half() * lengths[axis]).collect()
        });
        let mean = |halves: &Vec<f64>| 2.0 * halves.iter().sum::<f64>() / halves.len() as f64;
        Work {
            surface: surface.clone(),
            cells,
            holds,
            uv: samples.uv.clone(),
            stuck: vec![false; samples.len()],
            free: vec![false; surface.net.len()],
            system: None,
            eased: vec![false; across * down],
            weight: samples.weights.len() as f64 / (across * down) as f64,
            area: mean(&halves[0]) * mean(&halves[1]),
            halves,
            energies: cells.spans.each_ref().map(|spans| {
                spans.all.iter().map(|span| fairing::energies(span).map(full)).collect()
            }),
        }
    }

    fn width(&self) -> usize {
        self.surface.v.functions()
    }

    /// Frees the control points around Jacobian samples.
    pub(crate) fn widen(&mut self, flagged: &[JacobianSample]) {
        self.free_cells(flagged.iter().map(|s| s.cell));
    }

    /// Frees the control points around parameter points.
    pub(crate) fn free_around(&mut self, at: &[Uv]) {
        let [u, v] = &self.cells.spans;
        self.free_cells(at.iter().map(|at| [u.find(at.x), v.find(at.y)]));
    }

    /// Frees the control points around cells.
    fn free_cells(&mut self, cells: impl Iterator<Item = [usize; 2]>) {
        let [rows, width] = self.surface.shape();
        for [p, q] in cells {
            for i in p.saturating_sub(AROUND)..(p + 4 + AROUND).min(rows) {
                let from = i * width + q.saturating_sub(AROUND);
                self.free[from..i * width + (q + 4 + AROUND).min(width)].fill(true);
            }
        }
        for corner in [0, width - 1, (rows - 1) * width, rows * width - 1] {
            self.free[corner] = false;
        }
    }

    /// Lets stuck samples hold the surface only in the normal direction around samples that remain
    /// inverted.
    pub(crate) fn ease(&mut self, flagged: &[JacobianSample]) {
        let [across, down] = self.cells.counts();
        for [p, q] in flagged.iter().filter(|s| s.is_inverted()).map(|s| s.cell) {
            for p in p.saturating_sub(1)..(p + 2).min(across) {
                self.eased[p * down + q.saturating_sub(1)..p * down + (q + 2).min(down)].fill(true);
            }
        }
    }

    /// Whether a control point of cell (p, q) is free.
    pub(crate) fn touches(&self, p: usize, q: usize) -> bool {
        (p..p + 4).any(|i| self.free[i * self.width() + q..][..4].iter().any(|&f| f))
    }

    /// Takes one step. `None` if the equations have no solution.
    pub(crate) fn round(
        &mut self,
        stiffness: f64,
        flagged: &[JacobianSample],
        slide: &Slide,
    ) -> Option<()> {
        let mut system = match self.system.take().filter(|system| system.is_for(&self.free)) {
            Some(system) => system.cleared(),
            None => BlockSystem::new(self.width(), &self.free)?,
        };
        let moves = self.moving();
        let near = self.near(&moves);
        let terms = Terms { work: self, stiffness, flagged, moves: &moves, near: &near };
        for first in 0..4 {
            system.strips(first).into_par_iter().for_each(|strip| terms.add(strip));
        }
        system.anchor(ANCHOR * self.weight);
        let steps = system.solve()?;
        for (&at, step) in system.free.iter().zip(steps) {
            self.surface.net[at] += DAMPING * step;
        }
        self.system = Some(system);
        let last = last_step(&self.surface);
        let foot = |&i: &usize| {
            let p = self.cells.samples.points[i];
            foot_point_moving(&self.surface, p, self.uv[i], self.holds[i].moves, last).0
        };
        let near: Vec<usize> = near.into_iter().flatten().map(|(_, i)| i).collect();
        let feet: Vec<Uv> = near.par_iter().map(foot).collect();
        let mut wanted = self.uv.clone();
        near.iter().zip(&feet).for_each(|(&i, foot)| wanted[i] = *foot);
        self.uv = slide(std::mem::take(&mut self.uv), wanted);
        near.iter().zip(feet).for_each(|(&i, foot)| self.stuck[i] |= self.uv[i] != foot);
        Some(())
    }

    /// Whether each cell moves, row by row.
    fn moving(&self) -> Vec<bool> {
        let [across, down] = self.cells.counts();
        (0..across * down).map(|c| self.touches(c / down, c % down)).collect()
    }

    /// The samples in cells that move, strip by strip and cell by cell. Each has the number of its
    /// cell in the strip.
    fn near(&self, moves: &[bool]) -> Vec<Vec<(usize, usize)>> {
        let [u, v] = &self.cells.spans;
        let [across, down] = self.cells.counts();
        let cells: Vec<_> = self.uv.par_iter().map(|at| (u.find(at.x), v.find(at.y))).collect();
        let mut near = vec![Vec::new(); across];
        for (i, (p, q)) in cells.into_iter().enumerate().filter(|(_, (p, q))| moves[p * down + q]) {
            near[p].push((q, i));
        }
        near.par_iter_mut().for_each(|of| of.sort_unstable());
        near
    }
}

/// Converts sums over [`PAIRS`] to a symmetric matrix.
fn full(pairs: [f64; 10]) -> [[f64; 4]; 4] {
    let mut matrix = [[0.0; 4]; 4];
    for ((a, c), value) in PAIRS.into_iter().zip(pairs) {
        matrix[a][c] = value;
        matrix[c][a] = value;
    }
    matrix
}

/// The mean lengths of a net's rows along u and along v, in mm per unit of the parameter.
fn net_lengths(surface: &Surface) -> [f64; 2] {
    let [rows, width] = surface.shape();
    let step = |a: usize, b: usize| (surface.net[b] - surface.net[a]).norm();
    let along = (0..(rows - 1) * width).map(|k| step(k, k + width)).sum::<f64>() / width as f64;
    let inner = (0..rows * width).filter(|k| (k + 1) % width > 0);
    let across = inner.map(|k| step(k, k + 1)).sum::<f64>() / rows as f64;
    let range = |(low, high): (f64, f64)| high - low;
    [along / range(surface.u.range()), across / range(surface.v.range())]
}
