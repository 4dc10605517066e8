//! Where the noise of a scan differs from that of the whole.
//!
//! A scanner has more noise on steep or dark places. The calmer ones of the patches around a place,
//! which hold no edge, tell its noise. Where even these miss the shape, the others are worse than
//! noise makes them, or residuals agree from neighbour to neighbour more than the noise does. Such a
//! place says nothing.

use rayon::prelude::*;

use super::estimate::{Estimate, significance};
use super::patch::{EVEN, NoisePatch};
use crate::geometry::Point;
use crate::mesh::{Mesh, Neighbours};
use crate::statistics::{CALM, MeanSquare, SIGNIFICANT, deviation_at, outlying, quantile};

/// The number of patches without common vertices around a place. The standard deviation of the noise
/// that they tell is 4 % of it.
const AROUND: f64 = 24.0;

/// The noise around some places.
#[derive(Debug)]
pub(super) struct LocalNoise {
    places: Neighbours,
    /// The standard deviation at each place, as a multiple of that of the whole.
    factors: Vec<f64>,
}

impl LocalNoise {
    /// Looks at the patches of a scan with so many vertices. `None` if its noise is the same
    /// everywhere as far as they tell.
    pub(super) fn new(mesh: &Mesh, patches: &[NoisePatch], estimate: &Estimate) -> Option<Self> {
        let apart = (patches.len() * EVEN) as f64 / mesh.points.len() as f64;
        let count = (AROUND * apart.max(1.0)).ceil() as usize;
        // A part of the scan must differ from the rest of it.
        if 2 * count > patches.len() {
            return None;
        }
        let all: Vec<PatchNoise> = patches.iter().map(|p| PatchNoise::new(p, estimate)).collect();
        let points: Vec<Point> = patches.iter().map(|patch| mesh.point(patch.middle)).collect();
        let places = Neighbours::new(&points);
        let limit = outlying((points.len() as f64 / apart.max(1.0)) as usize);
        let factor = |found: &mut Vec<(u32, f64)>, &p: &Point| {
            places.nearest_n(p, count, found);
            let around: Vec<&PatchNoise> = found.iter().map(|f| &all[f.0 as usize]).collect();
            factor(&around, limit)
        };
        let factors: Vec<f64> = points.par_iter().map_init(Vec::new, factor).collect();
        factors.iter().any(|&f| f != 1.0).then_some(LocalNoise { places, factors })
    }

    /// The standard deviation at a place, as a multiple of that of the whole.
    pub(crate) fn factor(&self, p: Point) -> f64 {
        self.factors[self.places.nearest(p)]
    }
}

/// What one patch says about the noise around it.
struct PatchNoise {
    /// The mean square as a multiple of that of the noise of the whole scan.
    square: f64,
    freedom: f64,
    /// By how much neighbouring residuals agree more than those of the noise.
    agreement: f64,
}

impl PatchNoise {
    fn new(patch: &NoisePatch, estimate: &Estimate) -> Self {
        let (square, freedom) = estimate.relative(patch);
        PatchNoise { square, freedom, agreement: estimate.agreement(patch) }
    }
}

/// The standard deviation of the noise around a place, as a multiple of that of the whole: 1 unless
/// the patches around it differ by more than `limit` standard deviations.
fn factor(around: &[&PatchNoise], limit: f64) -> f64 {
    let count = around.len() as f64;
    let mut squares: Vec<f64> = around.iter().map(|patch| patch.square).collect();
    let freedom = around.iter().map(|patch| patch.freedom).sum::<f64>() / count;
    let mut noise = |share: f64| {
        let square = quantile(&mut squares, share)? / MeanSquare(freedom).quantile(share);
        Some(square.max(f64::MIN_POSITIVE).ln())
    };
    let [Some(calm), Some(usual)] = [noise(CALM), noise(0.5)] else {
        return 1.0;
    };
    let deviation = deviation_at(CALM) * (2.0 / (freedom * AROUND)).sqrt();
    if calm.abs() <= limit * deviation {
        return 1.0;
    }
    let agreement = significance(around.iter().map(|patch| patch.agreement));
    let agrees = agreement * (AROUND / count).sqrt() > SIGNIFICANT;
    let is_shape = calm > 0.0 && (agrees || usual - calm > SIGNIFICANT * deviation);
    if is_shape { 1.0 } else { (0.5 * calm).exp() }
}
