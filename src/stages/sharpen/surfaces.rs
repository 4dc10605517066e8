//! The surfaces and how exactly the scan tells them.

use super::Work;
use crate::geometry::{NONE, VertexId};
use crate::primitives::{
    Covariance, FitOptions, FitSample, Motions, PrimitiveFit, Uncertainty, fit,
};

/// A fit needs so many vertices for each parameter. Of regions with fewer inner ones all vertices count.
const FEWEST_EACH: usize = 3;

/// The steps of a fit, which starts at a surface that was fitted before.
const STEPS: usize = 10;

/// A surface with the motions that the scan allows.
pub(super) struct FittedSurface {
    pub motions: Motions,
    pub covariance: Covariance,
    /// The standard deviations of its parameters, if the scan tells them.
    pub uncertainty: Option<Uncertainty>,
    /// How many independent vertices it rests on.
    pub weight: f64,
}

impl Work<'_> {
    /// Fits all surfaces to the vertices inside of their regions.
    pub(super) fn fitted(&mut self) -> Vec<FittedSurface> {
        let count = self.surfaces.len();
        let mut all: Vec<Vec<u32>> = vec![Vec::new(); count];
        let mut inner: Vec<Vec<u32>> = vec![Vec::new(); count];
        for v in 0..self.mesh.points.len() as u32 {
            let around = self.rings.triangles(VertexId(v));
            let regions = self.around(v);
            regions.iter().for_each(|&r| all[r as usize].push(v));
            let is_whole = around.iter().all(|&t| self.of[t as usize] != NONE);
            if let ([r], true) = (&regions[..], is_whole) {
                inner[*r as usize].push(v);
            }
        }
        let error = self.noise * self.correlation.sqrt();
        let mut fits = Vec::with_capacity(count);
        for r in 0..count {
            let start = self.surfaces[r].surface;
            let enough = FEWEST_EACH * start.kind().parameters();
            let used = if inner[r].len() >= enough { &inner[r] } else { &all[r] };
            let sample = |&v: &u32| FitSample { at: self.mesh.points[v as usize], error };
            let samples: Vec<FitSample> = used.iter().map(sample).collect();
            let is_known = samples.len() >= enough;
            let steps = if is_known { STEPS } else { 0 };
            let found = fit(start, &samples, &FitOptions { steps, ..FitOptions::default() });
            let weight = samples.len() as f64 / self.correlation;
            fits.push(match found {
                Some(PrimitiveFit { surface, motions, covariance, .. }) => {
                    self.surfaces[r].surface = surface;
                    // A surface that was not fitted has the deviations of too few vertices.
                    let uncertainty = Uncertainty::of(&motions, &covariance).filter(|_| is_known);
                    let uncertainty = uncertainty.map(|of| of.with_bias(self.bias));
                    FittedSurface { motions, covariance, uncertainty, weight: weight.max(1.0) }
                }
                None => FittedSurface {
                    motions: Motions::new(start, start.origin(), false),
                    covariance: Covariance::zeros(),
                    uncertainty: None,
                    weight: 1.0,
                },
            });
        }
        fits
    }
}
