//! The noise of a whole scan: its variance, and its correlation between neighbours.
//!
//! Residuals of independent errors do not agree between neighbours more than the fit makes them, and
//! polynomials of a higher degree leave as much of them as their degrees of freedom say. Where this
//! does not hold for quadrics, the errors are correlated, or quadrics miss the shape. Polynomials of
//! the third degree then tell which: if it holds for them, it was the shape. Otherwise the covariances
//! are unmixed from the products of the quadrics' residuals.

use nalgebra::{Matrix3, Vector3};

use super::patch::{DEGREES, EVEN, NoisePatch, Residuals};
use crate::geometry::MOST_ROUNDS;
use crate::statistics::{CALM, MeanSquare, SIGNIFICANT, normal_at, quantile};

/// Patches whose mean square is larger than that of this share of patches of pure noise may hold an
/// edge, and are left out. What that takes off the mean is known, so the value only weighs edges that
/// go unseen against patches that are lost: with 0.997, the noise of parts with many small faces is
/// found up to 13 % too large, and with 0.95 up to 6 %.
const PURE: f64 = 0.95;

/// The noise of a scan along its normals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    /// The covariances of vertices that are 0, 1 and 2 edges apart.
    pub covariances: Vector3<f64>,
    /// The position of the degree whose residuals gave them.
    degree: usize,
    /// The variance that polynomials of the fourth degree leave, as a share of what they would
    /// leave of this noise: at least so much. It is nearly 1 for noise, and less for a shape that the
    /// others miss, or where there are too few patches to tell.
    pub remaining: f64,
}

impl Estimate {
    /// Measures the noise on the patches of a scan with so many vertices. `None` without patches.
    pub(super) fn new(patches: &[NoisePatch], vertices: usize) -> Option<Self> {
        let apart = (vertices as f64 / (patches.len() * EVEN) as f64).min(1.0);
        for degree in 0..DEGREES - 1 {
            let (estimate, kept) = Estimate::converged(patches, degree, |kept, mean| {
                let [squares, freedom] =
                    sums(kept, |p| [p.fits[degree].sums[0], p.fits[degree].expected[0]]);
                Some(Vector3::new(squares / freedom / mean, 0.0, 0.0))
            })?;
            let agreements = kept.iter().map(|p| estimate.agreement(p));
            let lost = kept
                .iter()
                .map(|p| p.fits[degree].mean_square() - p.fits[DEGREES - 1].mean_square());
            // Once quadrics have spoken against independent errors, cubics must speak for them clearly.
            let limit = SIGNIFICANT / (degree + 1) as f64 / apart.sqrt();
            if significance(agreements) < limit && significance(lost) < limit {
                return Some(estimate.with_remaining(&kept, apart));
            }
        }
        let (estimate, kept) = Estimate::converged(patches, 0, unmixed)?;
        Some(estimate.with_remaining(&kept, apart))
    }

    /// Repeats the `fit` of the covariances to patches that may be pure noise, given also the mean
    /// of their relative squares, until the selection does not change.
    fn converged(
        patches: &[NoisePatch],
        degree: usize,
        fit: impl Fn(&[&NoisePatch], f64) -> Option<Vector3<f64>>,
    ) -> Option<(Self, Vec<&NoisePatch>)> {
        let of = |p: &NoisePatch| p.fits[degree];
        let mut squares: Vec<f64> = patches.iter().map(|p| of(p).mean_square()).collect();
        let freedom = patches.iter().map(|p| of(p).expected[0]).sum::<f64>() / squares.len() as f64;
        let smallest = quantile(&mut squares, CALM)?;
        let start = smallest / MeanSquare(freedom).quantile(CALM);
        let covariances = Vector3::new(start.max(f64::MIN_POSITIVE), 0.0, 0.0);
        let mut now = Estimate { covariances, degree, remaining: 1.0 };
        let mut kept = Vec::new();
        for _ in 0..MOST_ROUNDS {
            let before = kept.len();
            let mean;
            (kept, mean) = now.selected(patches);
            let Some(covariances) = fit(&kept, mean).filter(|_| !kept.is_empty()) else { break };
            now.covariances = covariances;
            now.covariances[0] = covariances[0].max(f64::MIN_POSITIVE);
            if kept.len() == before {
                break;
            }
        }
        Some((now, kept))
    }

    /// The patches that may be pure noise, and the mean of their relative mean squares if they are.
    /// The others hold an edge.
    fn selected<'a>(&self, patches: &'a [NoisePatch]) -> (Vec<&'a NoisePatch>, f64) {
        let (mut kept, mut sum) = (Vec::new(), 0.0);
        let pure = normal_at(PURE);
        for patch in patches {
            let (square, freedom) = self.relative(patch);
            let limit = MeanSquare(freedom).at(pure);
            if square <= limit {
                kept.push(patch);
                sum += MeanSquare(freedom).mean_below(limit);
            }
        }
        let mean = sum / kept.len().max(1) as f64;
        (kept, mean)
    }

    fn with_remaining(self, kept: &[&NoisePatch], apart: f64) -> Self {
        let last = |p: &NoisePatch| -> Residuals { p.fits[DEGREES - 1] };
        let [left, freedom] = sums(kept, |p| [last(p).sums[0], last(p).expected[0]]);
        let [_, agreeing] = sums(kept, |p| last(p).expected);
        let expected = self.covariances[0] * freedom + self.covariances[1] * agreeing;
        // Of overlapping patches only so many degrees of freedom are independent.
        let deviation = (2.0 / (apart * freedom).max(f64::MIN_POSITIVE)).sqrt();
        let share = left / expected.max(f64::MIN_POSITIVE);
        let shape = self.most_shape(kept, apart);
        Estimate { remaining: share * (1.0 - SIGNIFICANT * deviation) * (1.0 - shape), ..self }
    }

    /// The largest share of shape in the residuals of independent errors by which neighbours may agree
    /// as they do. Shape alone is the same at both.
    fn most_shape(&self, kept: &[&NoisePatch], apart: f64) -> f64 {
        if self.is_correlated() {
            return 0.0;
        }
        let share = |p: &&NoisePatch| {
            let Residuals { expected, .. } = p.fits[self.degree];
            self.agreement(p) / (p.neighbours - expected[1] / expected[0])
        };
        let [sum, squares] = sums(kept, |p| [share(&p), share(&p).powi(2)]);
        let count = kept.len().max(1) as f64;
        (sum / count + SIGNIFICANT * (squares / apart).sqrt() / count).clamp(0.0, 1.0)
    }

    /// Whether the errors of neighbours are not independent.
    fn is_correlated(&self) -> bool {
        self.covariances[1] != 0.0 || self.covariances[2] != 0.0
    }

    /// The mean square of a patch as a multiple of what this noise leaves, and its degrees of freedom.
    pub(crate) fn relative(&self, patch: &NoisePatch) -> (f64, f64) {
        if !self.is_correlated() {
            let Residuals { sums, expected } = patch.fits[self.degree];
            return (sums[0] / (self.covariances[0] * expected[0]), expected[0]);
        }
        let mixed = patch.mixing * self.covariances;
        let freedom = mixed[0] * mixed[0] / self.covariances.dot(&mixed);
        (patch.moments[0] / mixed[0].max(f64::MIN_POSITIVE), freedom.max(1.0))
    }

    /// By how much neighbouring residuals of a patch agree more than those of this noise, as a share
    /// of their mean square.
    pub(crate) fn agreement(&self, patch: &NoisePatch) -> f64 {
        let Residuals { sums, expected } = patch.fits[self.degree];
        if !self.is_correlated() {
            return sums[1] / sums[0] - expected[1] / expected[0];
        }
        let mixed = patch.mixing * self.covariances;
        patch.moments[1] / patch.moments[0] - mixed[1] / mixed[0]
    }

    /// The standard deviation.
    pub(super) fn deviation(&self) -> f64 {
        self.covariances[0].sqrt()
    }

    /// The correlations of vertices that are one edge and two edges apart.
    pub(crate) fn correlation(&self) -> [f64; 2] {
        [1, 2].map(|k| self.covariances[k] / self.covariances[0])
    }
}

/// The sums over patches.
fn sums(patches: &[&NoisePatch], of: impl Fn(&NoisePatch) -> [f64; 2]) -> [f64; 2] {
    patches.iter().map(|p| of(p)).fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]])
}

/// The sum of independent values with mean 0, in its standard deviations.
pub(super) fn significance(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let squares: f64 = values.clone().map(|x| x * x).sum();
    if squares > 0.0 { values.sum::<f64>() / squares.sqrt() } else { 0.0 }
}

/// The covariances that explain the products of the quadrics' residuals, if these are `mean` times
/// what they would be of all patches.
fn unmixed(patches: &[&NoisePatch], mean: f64) -> Option<Vector3<f64>> {
    let mixing: Matrix3<f64> = patches.iter().map(|patch| patch.mixing).sum();
    let moments: Vector3<f64> = patches.iter().map(|patch| patch.moments).sum();
    let all = mixing.lu().solve(&moments)? / mean;
    (all[0] > 0.0).then(|| all.map(|covariance| covariance.clamp(0.0, all[0])))
}
