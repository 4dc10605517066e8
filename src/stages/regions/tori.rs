//! Tori that hide behind their rings.

use super::exact::MOST_TURN;
use super::growth::{Evidence, GrownRegion};
use super::patches;
use super::search::{SeedSearch, TRIAL_STEPS, samples};
use super::significance::FoundRegion;
use crate::geometry::{Point, range};
use crate::primitives::{FitOptions, Primitive, PrimitiveKind, fit, with_axis};

impl SeedSearch<'_> {
    pub(super) fn torus_beyond(&mut self, other: &Primitive, seed: u32) -> Option<FoundRegion> {
        let leaves = |f: u32| {
            self.evidence.facets.get(f).corners.iter().any(|&v| {
                let s = self.evidence.sample(v);
                other.distance(s.at).0.abs() > self.evidence.bound() * s.error
            })
        };
        let patch = patches::beyond(self.evidence, seed, &|f| self.pool[f as usize], &leaves);
        (!patch.is_empty()).then(|| self.tried(PrimitiveKind::Torus, &patch, seed)).flatten()
    }

    /// The torus through a ring of facets and a facet of a neighbouring ring, on either side.
    pub(super) fn torus_of_rows(&mut self, row: &GrownRegion, seed: u32) -> Option<FoundRegion> {
        let surface = row.surface();
        let (origin, axis) = (surface.origin(), surface.axis()?);
        let height = |f: u32| (self.evidence.facets.get(f).centre - origin).dot(&axis);
        let ends = range(row.units.iter().map(|&f| height(f)));
        let mut inside = row.units.clone();
        inside.sort_unstable();
        let mut beside = [None; 2];
        for &f in &row.units {
            for b in &self.evidence.facets.get(f).borders {
                let is_next = b.dihedral <= MOST_TURN
                    && self.pool[b.facet as usize]
                    && inside.binary_search(&b.facet).is_err();
                if is_next {
                    let h = height(b.facet);
                    let side = usize::from(h > (ends[0] + ends[1]) / 2.0);
                    beside[side] = beside[side].or(Some(b.facet));
                }
            }
        }
        for next in beside.into_iter().flatten() {
            let patch = [&row.units[..], &[next]].concat();
            let samples = samples(self.evidence, &patch);
            let points: Vec<Point> = samples.iter().map(|s| s.at).collect();
            let Some(start) = with_axis(PrimitiveKind::Torus, &points, origin, axis) else {
                continue;
            };
            let options = FitOptions {
                steps: TRIAL_STEPS,
                goal: self.evidence.bound(),
                ..FitOptions::default()
            };
            let Some(fit) = fit(start, &samples, &options) else { continue };
            if fit.worst <= self.evidence.bound()
                && self.fits_patch(&fit.surface, &patch)
                && let Some(found) = self.region(fit, &patch, seed)
            {
                return Some(found);
            }
        }
        None
    }
}
