//! Snapping: surfaces are moved to simple places as long as every vertex stays within the rounding of the file. Where edges of the model
//! are off a surface by more than that, its vertices stay as near to it as they were.
//!
//! Nothing that the file says is changed: a surface before and after a snap explain the same numbers. The order is
//! directions, axes and values of single surfaces, then all tangencies at once.

mod directions;
mod lines;
mod round_values;
mod tangency;

use super::tessellation::MOST_ERRORS;
use super::{RegionOrigin, Regions, Tessellation};
use crate::primitives::{FitOptions, FitSample, Primitive, PrimitiveKind, fit};

/// What was snapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SnapKind {
    /// The direction became that of an axis of the world.
    World,
    /// The direction became that of another region.
    Parallel,
    /// The direction became perpendicular to those of other regions.
    Perpendicular,
    /// The axis became that of another region.
    Coaxial,
    /// An axis, an offset or a centre went to a round place.
    Place,
    /// A radius or an angle became a round number.
    Value,
    /// The surface touches its neighbours tangentially.
    Tangent,
}

/// One snap: a region's surface before and after it, in the unit of the mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Snap {
    /// The number of the region.
    pub region: u32,
    /// What was snapped.
    pub kind: SnapKind,
    /// The surface before.
    pub before: Primitive,
    /// The surface after.
    pub after: Primitive,
}

/// A vertex may be off a snapped surface by so many times the bound of a free fit: a quarter for the shift of the fit itself,
/// which has fewer parameters left.
const SNAPPED_SLACK: f64 = 1.25;

/// The vertices of a region that a fit uses.
const MOST_SAMPLES: usize = 2500;

/// The steps of a fit of the parameters that are left.
const STEPS: usize = 8;

/// A region while it is snapped.
struct Snapping {
    region: u32,
    surface: Primitive,
    samples: Vec<FitSample>,
    /// The typical error of a vertex.
    error: f64,
    /// How many times the bound the farthest vertex is off. Edges of the model may be off its surfaces by more than the rounding.
    looseness: f64,
    /// How exactly the direction is known (rad).
    direction_error: f64,
}

impl Snapping {
    fn new(mesh: &Tessellation, regions: &Regions, number: usize) -> Self {
        let region = &regions.regions[number];
        let sample = |&v: &u32| FitSample { at: mesh.point(v), error: mesh.error(v) };
        let mut samples: Vec<FitSample> = region.vertices.iter().map(sample).collect();
        let errors_off = |s: &FitSample| region.surface.distance(s.at).0.abs() / s.error;
        let looseness =
            samples.iter().map(errors_off).fold(MOST_ERRORS * region.slack, f64::max) / MOST_ERRORS;
        let is_loose = |s: &&mut FitSample| !region.is_told || errors_off(s) > MOST_ERRORS;
        samples.iter_mut().filter(is_loose).for_each(|s| s.error *= looseness);
        let mut errors: Vec<f64> = samples.iter().map(|s| s.error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        let turns = match region.surface.kind() {
            PrimitiveKind::Sphere => 0.0,
            _ => region.covariance[(0, 0)].max(region.covariance[(1, 1)]).max(0.0).sqrt(),
        };
        Snapping {
            region: number as u32,
            surface: region.surface,
            error: errors.get(errors.len() / 2).copied().unwrap_or(0.0),
            looseness,
            direction_error: if region.is_told { turns } else { turns * looseness },
            samples,
        }
    }

    /// Whether all vertices lie on a surface within the rounding.
    fn allows(&self, surface: &Primitive) -> bool {
        let bound = MOST_ERRORS * SNAPPED_SLACK;
        self.samples.iter().all(|s| surface.distance(s.at).0.abs() <= bound * s.error)
    }

    /// The surface with its free motions fitted again.
    fn refitted(&self, surface: Primitive, frozen: &[usize]) -> Option<Primitive> {
        let mut options = FitOptions { steps: STEPS, fixed_centre: true, ..FitOptions::default() };
        frozen.iter().for_each(|&k| options.frozen[k] = true);
        let stride = self.samples.len().div_ceil(MOST_SAMPLES).max(1);
        let some: Vec<FitSample> = self.samples.iter().step_by(stride).copied().collect();
        fit(surface, &some, &options).map(|fit| fit.surface)
    }

    /// Takes a surface over if its vertices allow it. Returns whether it did.
    fn take(&mut self, surface: Primitive, kind: SnapKind, snaps: &mut Vec<Snap>) -> bool {
        if surface == self.surface || !self.allows(&surface) {
            return surface == self.surface;
        }
        snaps.push(Snap { region: self.region, kind, before: self.surface, after: surface });
        self.surface = surface;
        true
    }
}

/// Snaps all regions but left-over facets. `unit` is the length of the mesh's unit in that of the file, in which round
/// numbers are round.
pub(super) fn snap(mesh: &Tessellation, regions: &mut Regions, unit: f64) -> Vec<Snap> {
    let mut snaps = Vec::new();
    let numbers =
        (0..regions.regions.len()).filter(|&r| regions.regions[r].origin != RegionOrigin::Facet);
    let mut all: Vec<Snapping> = numbers.map(|r| Snapping::new(mesh, regions, r)).collect();
    directions::snap(&mut all, &mut snaps);
    lines::snap(&mut all, unit, &mut snaps);
    round_values::snap(&mut all, unit, &mut snaps);
    tangency::snap(mesh, regions, &mut all, &mut snaps);
    for snapping in all {
        regions.regions[snapping.region as usize].surface = snapping.surface;
    }
    snaps
}
