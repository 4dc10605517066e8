//! The fit of the inside of one face.

use super::MEASURED;
use crate::geometry::{Uv, Vector};
use crate::solve::least_squares::SparseNormal;
use crate::spline::{KnotVector, Samples, Surface, foot_point_moving, last_step};

/// The number of outer rows of control points on each side that stay. The first one is the track, and the
/// second one has the tangent planes along it.
pub(super) const FIXED: usize = 2;

/// The rounds of control points and foot points. The faces are near the points before, so that later
/// rounds change little.
const ROUNDS: usize = 2;

/// The weight of fairing, beside the mean weight of the points of a control point. It is larger than that of a
/// net, as there may be one point for a control point only. With a thirtieth of it, faces are farther from the
/// triangles between points than before, and more of them turn over. With three times as much, more points miss
/// the tolerance.
const FAIRING: f64 = 0.03;

/// What a face is fitted to.
pub(super) struct FaceTarget<'a> {
    pub samples: &'a Samples,
    /// The factor of the weight of fairing.
    pub firmness: f64,
    pub tolerance: f64,
}

/// A face, and where it misses the tolerance.
pub(super) struct FaceFit {
    pub surface: Surface,
    /// The foot points of all samples.
    pub feet: Vec<Uv>,
    /// The numbers of the measured samples beyond the tolerance, in ascending order.
    pub beyond: Vec<usize>,
}

impl FaceFit {
    /// A surface near the samples.
    pub(super) fn of(surface: Surface, target: &FaceTarget) -> Self {
        FaceFit::near(surface, target, &target.samples.uv)
    }

    /// A surface whose foot points are near the `starts`.
    fn near(surface: Surface, target: &FaceTarget, starts: &[Uv]) -> Self {
        let step = last_step(&surface);
        let mut fit =
            FaceFit { feet: Vec::with_capacity(starts.len()), beyond: Vec::new(), surface };
        let points = target.samples.points.iter().zip(&target.samples.weights);
        for (number, ((&p, &weight), &start)) in points.zip(starts).enumerate() {
            let (at, off) = foot_point_moving(&fit.surface, p, start, [true; 2], step);
            fit.feet.push(at);
            if weight >= MEASURED && off > target.tolerance {
                fit.beyond.push(number);
            }
        }
        fit
    }

    /// The number of samples beyond the tolerance among the first ones.
    pub(crate) fn beyond_of(&self, first: usize) -> usize {
        self.beyond.partition_point(|&number| number < first)
    }

    /// The number of control points inside, which a fit moves.
    pub(crate) fn inner(&self) -> usize {
        self.surface.shape().map(|count| count.saturating_sub(2 * FIXED)).iter().product()
    }

    /// The face with other control points inside, over finer knots. `None` if they cannot be found.
    pub(crate) fn again(&self, knots: [KnotVector; 2], target: &FaceTarget) -> Option<FaceFit> {
        let mut inside = Inside::new(self.surface.over(knots))?;
        let mut fit = FaceFit::near(inside.fitted(target, &self.feet)?, target, &self.feet);
        for _ in 1..ROUNDS {
            fit = FaceFit::near(inside.fitted(target, &fit.feet)?, target, &fit.feet);
        }
        Some(fit)
    }
}

/// The equations for the moves of the inner control points of a face.
struct Inside {
    surface: Surface,
    /// The numbers of inner control points in u and in v.
    shape: [usize; 2],
    equations: SparseNormal,
}

impl Inside {
    /// `None` if there is no inner control point, or not enough memory.
    fn new(surface: Surface) -> Option<Self> {
        let [m, n] = surface.shape().map(|count| count.saturating_sub(2 * FIXED));
        if m * n == 0 {
            return None;
        }
        let degree = surface.u.degree();
        let column = |k: usize| {
            let (i, j) = (k / n, k % n);
            let rows = i..(i + degree + 1).min(m);
            let beside = j.saturating_sub(degree)..(j + degree + 1).min(n);
            rows.flat_map(|i| beside.clone().map(move |j| i * n + j))
                .filter(|&row| row >= k)
                .collect()
        };
        let equations = SparseNormal::new((0..m * n).map(column).collect())?;
        Some(Inside { surface, shape: [m, n], equations })
    }

    /// The number of the unknown move of control point (i, j). `None` if the point stays.
    fn unknown(&self, i: usize, j: usize) -> Option<usize> {
        let [m, n] = self.shape;
        let (i, j) = (i.wrapping_sub(FIXED), j.wrapping_sub(FIXED));
        (i < m && j < n).then(|| i * n + j)
    }

    /// The surface that is nearest to the samples at their feet. Moves of neighbouring control points differ little.
    fn fitted(&mut self, target: &FaceTarget, feet: &[Uv]) -> Option<Surface> {
        self.equations.clear();
        let samples = target.samples;
        let mut total = 0.0;
        for ((p, &at), &weight) in samples.points.iter().zip(feet).zip(&samples.weights) {
            let row = self.row(at);
            self.equations.add_row(&row, weight, p - self.surface.point(at));
            total += weight;
        }
        let [m, n] = self.shape;
        let weight = target.firmness * FAIRING * total / (m * n) as f64;
        for (i, j) in (0..m * n).map(|k| (k / n + FIXED, k % n + FIXED)) {
            let beside = [(i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)];
            let beside = beside.iter().filter_map(|&(i, j)| Some((self.unknown(i, j)?, -0.25)));
            let own = self.unknown(i, j).map(|own| (own, 1.0));
            let row: Vec<(usize, f64)> = own.into_iter().chain(beside).collect();
            self.equations.add_row(&row, weight, Vector::zeros());
        }
        let moves = self.equations.solve()?;
        let mut surface = self.surface.clone();
        let count = surface.v.functions();
        for (k, step) in moves.into_iter().enumerate() {
            surface.net[(k / n + FIXED) * count + k % n + FIXED] += step;
        }
        Some(surface)
    }

    /// The move of the surface at a place, as a combination of the unknown moves.
    fn row(&self, at: Uv) -> Vec<(usize, f64)> {
        let (bu, bv) = (self.surface.u.basis(at.x), self.surface.v.basis(at.y));
        let degree = self.surface.u.degree();
        let all = (0..=degree).flat_map(|i| (0..=degree).map(move |j| (i, j)));
        let weight = |(i, j): (usize, usize)| {
            let unknown = self.unknown(bu.first + i, bv.first + j)?;
            Some((unknown, bu.derivative[0][i] * bv.derivative[0][j]))
        };
        all.filter_map(weight).collect()
    }
}
