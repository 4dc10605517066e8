//! Taking folds out of a fitted surface.
//!
//! Where samples are fewer than control points, or where the map is thin, a surface
//! that follows them closely may run back over itself within a knot span: its
//! normals turn over, though no sample is far from it. CAD systems offset such a
//! face to both of its sides. Samples say less than least squares take from them:
//! across the surface they hold it, along it they might slide (tangent distance
//! minimization: Wang, Pottmann, Liu, 2006). That leaves room enough to spread the
//! control points around a fold until none is left.
//!
//! Only control points near folds move. Each round is a Gauss–Newton step on the
//! samples' distances, across with full weight and along with little of it, a
//! thin-plate energy, and the squares of what the surface spreads too little.

mod places;
mod system;

use nalgebra::Matrix3;
use rayon::prelude::*;

use super::cells::Cells;
use super::fairing;
use super::spans::PAIRS;
use crate::geometry::{Uv, Vector};
use crate::spline::{Samples, Surface, foot_point_moving};
use places::{ACROSS, Places, Spot};
use system::System;

/// Rounds at the most.
const ROUNDS: usize = 20;

/// Rounds after the first one without folds.
const SETTLING: usize = 3;

/// The share of a step that is taken: folds are not linear.
const SHARE: f64 = 0.5;

/// Weight of a sample's distance along the surface, of that across it.
const ALONG: f64 = 0.05;

/// Weights of the thin-plate energy of a cell, of a mean cell's samples, to be tried in
/// turn: the first takes out most folds, the last keeps closest to the samples.
pub const STIFFNESSES: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// The weight of what a cell spreads too little.
const SPREAD: f64 = 3.0;

/// What keeps control points in place that nothing else holds.
const ANCHOR: f64 = 1e-6;

/// How many rows and columns around the cells with folds move, too.
const AROUND: usize = 4;

/// A surface with fewer folds.
#[derive(Debug)]
pub struct Unfolded {
    /// The surface, and the samples' parameters on it; `None` if there were no folds, or
    /// none could be taken out.
    pub found: Option<(Surface, Vec<Uv>)>,
    /// Places that were turned over, of 36 looked at in each cell.
    pub before: usize,
    /// Places that still are.
    pub after: usize,
}

/// How a sample holds a surface.
#[derive(Debug, Clone, Copy)]
pub struct Hold {
    /// The normal of what was measured there, of length 1.
    pub normal: Vector,
    /// The matrix of the squared distance that it is held by: of a plane, a line or a
    /// point.
    pub metric: Matrix3<f64>,
    /// Which of its parameters may change.
    pub moves: [bool; 2],
}

/// Takes the samples' parameters and those that they should move to, and says which they
/// may move to.
pub type Slide<'a> = dyn Fn(Vec<Uv>, Vec<Uv>) -> Vec<Uv> + 'a;

/// Takes folds out of a surface that was fitted to samples, with one of the
/// [`STIFFNESSES`]. Samples that may not `slide` hold it in all directions.
pub fn unfold(
    surface: &Surface,
    samples: &Samples,
    holds: &[Hold],
    stiffness: f64,
    slide: &Slide,
) -> Unfolded {
    let cells = Cells::new(samples, [&surface.u, &surface.v]);
    let places = Places::new(&cells, holds, &surface.net);
    let mut spots = places.spots(&surface.net, |_, _| true);
    let before = turned(&spots);
    let mut best = Unfolded { found: None, before, after: before };
    if before == 0 {
        return best;
    }
    let mut work = Work::new(surface, &cells, holds, stiffness);
    let mut rounds = ROUNDS;
    while rounds > 0 {
        rounds -= 1;
        work.widen(&spots);
        if work.round(&spots, slide).is_none() {
            break;
        }
        spots = places.spots(&work.surface.net, |p, q| work.touches(p, q));
        let after = turned(&spots);
        if after == 0 && best.after > 0 {
            rounds = rounds.min(SETTLING);
        }
        // Later ones are closer to the samples.
        if after <= best.after {
            let found = Some((work.surface.clone(), work.uv.clone()));
            best = Unfolded { found, before, after };
        }
    }
    best
}

fn turned(spots: &[Spot]) -> usize {
    spots.iter().filter(|s| s.is_turned()).count()
}

struct Work<'a> {
    surface: Surface,
    cells: &'a Cells<'a>,
    holds: &'a [Hold],
    stiffness: f64,
    uv: Vec<Uv>,
    /// Samples that may not slide.
    stuck: Vec<bool>,
    /// Control points that move.
    free: Vec<bool>,
    /// Samples' weight in a mean cell.
    weight: f64,
    /// Half lengths of the spans in u and in v, in mm: parameters times the mean length
    /// of the net.
    halves: [Vec<f64>; 2],
}

impl<'a> Work<'a> {
    fn new(surface: &Surface, cells: &'a Cells<'a>, holds: &'a [Hold], stiffness: f64) -> Self {
        let samples = cells.samples;
        let [across, down] = cells.counts();
        let lengths = net_lengths(surface);
        let halves = [0, 1].map(|axis| {
            let spans = cells.spans[axis].all.iter();
            spans.map(|s| s.half() * lengths[axis]).collect()
        });
        Work {
            surface: surface.clone(),
            cells,
            holds,
            stiffness,
            uv: samples.uv.clone(),
            stuck: vec![false; samples.len()],
            free: vec![false; surface.net.len()],
            weight: samples.weights.len() as f64 / (across * down) as f64,
            halves,
        }
    }

    fn width(&self) -> usize {
        self.surface.v.functions()
    }

    /// Frees the control points around spots.
    fn widen(&mut self, spots: &[Spot]) {
        let [rows, width] = self.surface.shape();
        for [p, q] in spots.iter().map(|s| s.cell) {
            for i in p.saturating_sub(AROUND)..(p + 4 + AROUND).min(rows) {
                let from = i * width + q.saturating_sub(AROUND);
                self.free[from..i * width + (q + 4 + AROUND).min(width)].fill(true);
            }
        }
        for corner in [0, width - 1, (rows - 1) * width, rows * width - 1] {
            self.free[corner] = false;
        }
    }

    /// Whether cell (p, q) moves.
    fn touches(&self, p: usize, q: usize) -> bool {
        (p..p + 4).any(|i| self.free[i * self.width() + q..][..4].iter().any(|&f| f))
    }

    /// One step; `None` if there is no solution.
    fn round(&mut self, spots: &[Spot], slide: &dyn Fn(Vec<Uv>, Vec<Uv>) -> Vec<Uv>) -> Option<()> {
        let mut system = System::new(self.width(), &self.free);
        let near = self.near();
        for &i in &near {
            self.add_sample(&mut system, i);
        }
        self.add_plate(&mut system);
        for spot in spots {
            self.add_spot(&mut system, spot);
        }
        for at in 0..self.free.len() {
            system.couple(at, at, &(Matrix3::identity() * (ANCHOR * self.weight)));
        }
        let steps = system.solve()?;
        for (&at, step) in system.free.iter().zip(steps) {
            self.surface.net[at] += SHARE * step;
        }
        let foot = |&i: &usize| {
            let p = self.cells.samples.points[i];
            foot_point_moving(&self.surface, p, self.uv[i], self.holds[i].moves).0
        };
        let feet: Vec<Uv> = near.par_iter().map(foot).collect();
        let mut wanted = self.uv.clone();
        near.iter().zip(&feet).for_each(|(&i, foot)| wanted[i] = *foot);
        self.uv = slide(std::mem::take(&mut self.uv), wanted);
        near.iter().zip(feet).for_each(|(&i, foot)| self.stuck[i] |= self.uv[i] != foot);
        Some(())
    }

    /// The samples in cells that move.
    fn near(&self) -> Vec<usize> {
        let [across, down] = self.cells.counts();
        let moves: Vec<bool> =
            (0..across * down).map(|c| self.touches(c / down, c % down)).collect();
        let [u, v] = &self.cells.spans;
        let is_near = |i: &usize| moves[u.find(self.uv[*i].x) * down + v.find(self.uv[*i].y)];
        (0..self.uv.len()).into_par_iter().filter(is_near).collect()
    }

    fn add_sample(&self, system: &mut System, i: usize) {
        let (at, hold) = (self.uv[i], &self.holds[i]);
        let (bu, bv) = (self.surface.u.basis(at.x), self.surface.v.basis(at.y));
        let weight = self.cells.samples.weights[i];
        let metric = match self.stuck[i] {
            true => Matrix3::identity() * weight,
            false => weight * (Matrix3::identity() * ALONG + hold.metric * (1.0 - ALONG)),
        };
        let off = metric * (self.cells.samples.points[i] - self.surface.point(at));
        let functions: [(usize, f64); 16] = std::array::from_fn(|k| {
            let (a, b) = (k / 4, k % 4);
            let value = bu.derivative[0][a] * bv.derivative[0][b];
            ((bu.first + a) * self.width() + bv.first + b, value)
        });
        for (k, &(a, x)) in functions.iter().enumerate() {
            system.pull(a, off * x);
            functions[k..].iter().for_each(|&(b, y)| system.couple(a, b, &(metric * (x * y))));
        }
    }

    /// The thin-plate energy of the cells that move.
    fn add_plate(&self, system: &mut System) {
        let [across, down] = self.cells.counts();
        let energies = self.cells.spans.each_ref().map(|spans| -> Vec<_> {
            spans.all.iter().map(|span| fairing::energies(span).map(full)).collect()
        });
        for (p, q) in (0..across).flat_map(|p| (0..down).map(move |q| (p, q))) {
            if !self.touches(p, q) {
                continue;
            }
            let (x, y) = (self.halves[0][p], self.halves[1][q]);
            let weight = self.stiffness * self.weight * x.min(y).powi(4);
            let scales = [x.powi(-4), 2.0 / (x * y).powi(2), y.powi(-4)];
            let (u, v) = (&energies[0][p], &energies[1][q]);
            let value = |a: usize, b: usize| {
                let of = |k: usize| scales[k] * u[2 - k][a / 4][b / 4] * v[k][a % 4][b % 4];
                weight * (of(0) + of(1) + of(2))
            };
            let number = |a: usize| (p + a / 4) * self.width() + q + a % 4;
            for a in 0..16 {
                let bend: Vector = (0..16).map(|b| self.surface.net[number(b)] * value(a, b)).sum();
                system.pull(number(a), -bend);
                for b in a..16 {
                    let block = Matrix3::identity() * value(a, b);
                    system.couple(number(a), number(b), &block);
                }
            }
        }
    }

    /// What the surface spreads too little at a spot.
    fn add_spot(&self, system: &mut System, spot: &Spot) {
        let weight = SPREAD * self.weight * self.area() / (ACROSS * ACROSS) as f64;
        let [u, v] = &spot.functions;
        let [p, q] = spot.cell;
        let across = spot.slopes[1].cross(&spot.facing);
        let along = spot.facing.cross(&spot.slopes[0]);
        let gradient: [(usize, Vector); 16] = std::array::from_fn(|k| {
            let (a, b) = (k / 4, k % 4);
            let at = (p + a) * self.width() + q + b;
            (at, across * (u[1][a] * v[0][b]) + along * (u[0][a] * v[1][b]))
        });
        let missing = places::LEAST - spot.spread;
        for (k, (a, x)) in gradient.iter().enumerate() {
            system.pull(*a, weight * missing * x);
            for (b, y) in &gradient[k..] {
                system.couple(*a, *b, &(weight * x * y.transpose()));
            }
        }
    }

    /// Area of a mean cell, in mm².
    fn area(&self) -> f64 {
        let mean = |halves: &[f64]| 2.0 * halves.iter().sum::<f64>() / halves.len() as f64;
        mean(&self.halves[0]) * mean(&self.halves[1])
    }
}

/// Sums over [`PAIRS`] as a symmetric matrix.
fn full(pairs: [f64; 10]) -> [[f64; 4]; 4] {
    let mut matrix = [[0.0; 4]; 4];
    for ((a, c), value) in PAIRS.into_iter().zip(pairs) {
        matrix[a][c] = value;
        matrix[c][a] = value;
    }
    matrix
}

/// Mean lengths of a net's rows along u and along v, in mm a unit of the parameter.
fn net_lengths(surface: &Surface) -> [f64; 2] {
    let [rows, width] = surface.shape();
    let step = |a: usize, b: usize| (surface.net[b] - surface.net[a]).norm();
    let along = (0..(rows - 1) * width).map(|k| step(k, k + width)).sum::<f64>() / width as f64;
    let inner = (0..rows * width).filter(|k| (k + 1) % width > 0);
    let across = inner.map(|k| step(k, k + 1)).sum::<f64>() / rows as f64;
    let range = |(low, high): (f64, f64)| high - low;
    [along / range(surface.u.range()), across / range(surface.v.range())]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::spline::KnotVector;

    /// A bump over the unit square with samples all over it, and its net pushed back
    /// over itself along the surface in the middle.
    fn folded(push: f64) -> (Surface, Samples, Vec<Hold>) {
        let knots = KnotVector::uniform(3, 20);
        let height = |x: f64, y: f64| 4.0 * (3.0 * x).sin() * (2.0 * y).cos();
        let at = |n: usize| (knots.greville(n / 20), knots.greville(n % 20));
        let control = |(x, y): (f64, f64)| Vector::new(50.0 * x, 50.0 * y, height(x, y));
        let mut net: Vec<Vector> = (0..400).map(|n| control(at(n))).collect();
        net[9 * 20 + 10].x += push;
        net[11 * 20 + 10].x -= push;
        let surface = Surface::new(knots.clone(), knots.clone(), net);
        let (mut samples, mut holds) = (Samples::default(), Vec::new());
        for (x, y) in (0..1600).map(|n| ((n / 40) as f64 / 39.0, (n % 40) as f64 / 39.0)) {
            samples.points.push(Point::from(control((x, y))));
            samples.uv.push(Uv::new(x, y));
            samples.weights.push(1.0);
            let slopes = [
                Vector::new(50.0, 0.0, 12.0 * (3.0 * x).cos() * (2.0 * y).cos()),
                Vector::new(0.0, 50.0, -8.0 * (3.0 * x).sin() * (2.0 * y).sin()),
            ];
            let normal = slopes[0].cross(&slopes[1]).normalize();
            let edge = [x, y].map(|t| t == 0.0 || t == 1.0);
            let metric =
                if edge[0] || edge[1] { Matrix3::identity() } else { normal * normal.transpose() };
            holds.push(Hold { normal, metric, moves: edge.map(|edge| !edge) });
        }
        (surface, samples, holds)
    }

    #[test]
    fn a_fold_is_taken_out_and_the_shape_stays() {
        let (surface, samples, holds) = folded(6.0);
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let done = unfold(&surface, &samples, &holds, STIFFNESSES[0], &slide);
        assert!(done.before > 0 && done.after == 0, "{} {}", done.before, done.after);
        let (flat, uv) = done.found.unwrap();
        let off = |(uv, p): (&Uv, &Point)| (flat.point(*uv) - p).norm();
        let worst = uv.iter().zip(&samples.points).map(off).fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
        for n in 0..10_000 {
            let jet = flat.jet(Uv::new((n / 100) as f64 / 99.0, (n % 100) as f64 / 99.0));
            assert!(jet.su.cross(&jet.sv).z > 0.0, "{n}");
        }
    }

    #[test]
    fn a_surface_without_folds_stays() {
        let (surface, samples, holds) = folded(0.0);
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let done = unfold(&surface, &samples, &holds, STIFFNESSES[0], &slide);
        assert!(done.before == 0 && done.after == 0 && done.found.is_none());
    }

    #[test]
    fn samples_that_may_not_slide_hold_the_surface() {
        let (surface, samples, holds) = folded(6.0);
        let stay = |now: Vec<Uv>, _: Vec<Uv>| now;
        let done = unfold(&surface, &samples, &holds, STIFFNESSES[0], &stay);
        let (flat, uv) = done.found.unwrap();
        assert_eq!(uv, samples.uv);
        let off = |(uv, p): (&Uv, &Point)| (flat.point(*uv) - p).norm();
        let worst = uv.iter().zip(&samples.points).map(off).fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
    }
}
