//! Least squares of orthogonal distances: Gauss–Newton with Levenberg's damping.

use super::motions::{Covariance, MotionRow, Motions};
use super::{MOST_PARAMETERS, Primitive};
use crate::geometry::{Point, Vector};

/// A point to be fitted, and how exactly it is known.
#[derive(Debug, Clone, Copy)]
pub struct FitSample {
    /// The place.
    pub at: Point,
    /// The unit of its distance: a bound of its error, or a standard deviation.
    pub error: f64,
}

/// How to fit.
#[derive(Debug, Clone, Copy)]
pub struct FitOptions {
    /// The most steps.
    pub steps: usize,
    /// Ends a fit that gains too little to come within this many errors. Zero: fit to the end.
    pub goal: f64,
    /// Motions that are not made.
    pub frozen: [bool; MOST_PARAMETERS],
    /// Whether radii change about a fixed centre (needed where shifts are frozen).
    pub fixed_centre: bool,
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions { steps: 40, goal: 0.0, frozen: [false; MOST_PARAMETERS], fixed_centre: false }
    }
}

/// A fitted surface.
#[derive(Debug, Clone, Copy)]
pub struct PrimitiveFit {
    /// The surface.
    pub surface: Primitive,
    /// The largest distance of a point, in units of its error.
    pub worst: f64,
    /// The sum of squares of the distances, in units of the errors.
    pub squares: f64,
    /// The motions that the covariance speaks of.
    pub motions: Motions,
    /// The covariance of the motions for independent errors of one unit each.
    pub covariance: Covariance,
}

impl PrimitiveFit {
    /// The standard deviation of the surface's place next to a point, for errors of one unit.
    pub(crate) fn deviation_at(&self, p: Point) -> f64 {
        let row = self.motions.row(p).1;
        (row.transpose() * self.covariance * row)[(0, 0)].max(0.0).sqrt()
    }
}

/// The sums of one pass over the points.
struct FitEquations {
    matrix: Covariance,
    right: MotionRow,
    squares: f64,
    worst: f64,
    motions: Motions,
}

impl FitEquations {
    fn new(surface: Primitive, samples: &[FitSample], pivot: Point, options: &FitOptions) -> Self {
        let motions = Motions::new(surface, pivot, options.fixed_centre);
        let n = surface.kind().parameters();
        let mut sums = FitEquations {
            matrix: Covariance::zeros(),
            right: MotionRow::zeros(),
            squares: 0.0,
            worst: 0.0,
            motions,
        };
        for sample in samples {
            let (d, row) = motions.row(sample.at);
            let (d, row) = (d / sample.error, row / sample.error);
            sums.squares += d * d;
            sums.worst = sums.worst.max(d.abs());
            for i in 0..n {
                sums.right[i] -= row[i] * d;
                for j in 0..=i {
                    sums.matrix[(i, j)] += row[i] * row[j];
                }
            }
        }
        for i in 0..MOST_PARAMETERS {
            if options.frozen[i] {
                sums.right[i] = 0.0;
                sums.matrix.row_mut(i).fill(0.0);
                sums.matrix.column_mut(i).fill(0.0);
            }
            for j in 0..i {
                sums.matrix[(j, i)] = sums.matrix[(i, j)];
            }
        }
        sums
    }

    /// The lengths of the columns, 1 for those that are not there.
    fn scales(&self) -> MotionRow {
        let root = |x: f64| if x > 0.0 { x.sqrt() } else { 1.0 };
        MotionRow::from_fn(|i, _| root(self.matrix[(i, i)]))
    }

    /// The matrix with columns of length 1 and a damped diagonal.
    fn scaled(&self, scales: &MotionRow, damping: f64) -> Covariance {
        Covariance::from_fn(|i, j| {
            let value = self.matrix[(i, j)] / (scales[i] * scales[j]);
            if i != j {
                value
            } else if self.matrix[(i, i)] > 0.0 {
                1.0 + damping
            } else {
                1.0
            }
        })
    }

    fn step(&self, damping: f64) -> Option<MotionRow> {
        let scales = self.scales();
        let factor = self.scaled(&scales, damping).cholesky()?;
        let step = factor.solve(&self.right.component_div(&scales)).component_div(&scales);
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    /// The inverse; motions that the points do not determine get a large variance.
    fn covariance(&self) -> Covariance {
        let scales = self.scales();
        let inverse = self.scaled(&scales, UNDETERMINED).cholesky().map(|f| f.inverse());
        let inverse = inverse.unwrap_or_else(Covariance::identity);
        let is_there = |i: usize| self.matrix[(i, i)] > 0.0;
        Covariance::from_fn(|i, j| {
            let value = inverse[(i, j)] / (scales[i] * scales[j]);
            if is_there(i) && is_there(j) { value } else { 0.0 }
        })
    }
}

/// The share added to the diagonal of a scaled matrix before its inversion. It is the rounding of sums of
/// products, so it changes no variance that these can tell.
const UNDETERMINED: f64 = 1e-14;

/// Levenberg's damping starts low, because starts are good. It grows a hundredfold after a step that fails and
/// shrinks a hundredfold after one that succeeds. Ten of them reach from Gauss–Newton to a tiny gradient step.
const FIRST_DAMPING: f64 = 1e-8;
const LEAST_DAMPING: f64 = 1e-14;
const DAMPING_FACTOR: f64 = 100.0;
const MOST_RAISES: usize = 6;

/// A fit has converged if it gained less than this share twice in a row.
const CONVERGED: f64 = 1e-6;

/// Exact data converge quadratically. A fit that has not come within its goal is given up if three steps in a row
/// gained less than fourfold.
const GAIN: f64 = 0.25;
const SLOW_STEPS: usize = 3;

/// Fits a surface to points by least squares of the distances in units of the points' errors. `None` if there is
/// no point, or if the start is not finite.
pub fn fit(start: Primitive, samples: &[FitSample], options: &FitOptions) -> Option<PrimitiveFit> {
    if samples.is_empty() {
        return None;
    }
    let sum: Vector = samples.iter().map(|s| s.at.coords).sum();
    let pivot = Point::from(sum / samples.len() as f64);
    let mut now = FitEquations::new(start, samples, pivot, options);
    if !now.squares.is_finite() {
        return None;
    }
    let (mut damping, mut still, mut slow) = (FIRST_DAMPING, 0, 0);
    for _ in 0..options.steps {
        let Some(next) = better(&now, &mut damping, samples, pivot, options) else { break };
        damping = (damping / DAMPING_FACTOR).max(LEAST_DAMPING);
        let gain = now.squares - next.squares;
        still = if gain <= CONVERGED * next.squares { still + 1 } else { 0 };
        let is_slow = next.squares > GAIN * now.squares && next.worst > options.goal;
        slow = if is_slow { slow + 1 } else { 0 };
        now = next;
        if still >= 2 || now.squares == 0.0 || options.goal > 0.0 && slow >= SLOW_STEPS {
            break;
        }
    }
    let covariance = now.covariance();
    let (worst, squares, motions) = (now.worst, now.squares, now.motions);
    Some(PrimitiveFit { surface: motions.surface(), worst, squares, motions, covariance })
}

/// The equations after a step that does not make the sum of squares larger.
fn better(
    now: &FitEquations,
    damping: &mut f64,
    samples: &[FitSample],
    pivot: Point,
    options: &FitOptions,
) -> Option<FitEquations> {
    for _ in 0..MOST_RAISES {
        let moved = now.step(*damping).and_then(|step| now.motions.moved(&step));
        if let Some(surface) = moved {
            let next = FitEquations::new(surface, samples, pivot, options);
            if next.squares <= now.squares {
                return Some(next);
            }
        }
        *damping = (*damping * DAMPING_FACTOR).max(CONVERGED);
    }
    None
}
