//! Whether a surface that facets lie on is more than chance.

use super::borders::{ends_abruptly, is_bordered, straight_edges, tangent_neighbours};
use super::coincidences::{independent, is_coaxial, is_extruded};
use super::exact::ExactFacets;
use super::growth::GrownRegion;
use crate::primitives::{Primitive, PrimitiveKind};

/// A region of facets on one surface.
#[derive(Debug, Clone)]
pub(super) struct FoundRegion {
    pub(super) growth: GrownRegion,
    pub(super) area: f64,
    /// Vertices, straight edges on the surface and tangent neighbours minus parameters: what the region explains.
    pub(super) weight: f64,
}

/// The false surfaces that one part may have on average.
const FALSE_ALARMS: f64 = 1e-3;

/// Coincidences are never rarer than this share of the rounding, below which distances are not uniform.
const LEAST_DISTANCE: f64 = 0.3;

/// The facets and neighbours that are looked at for a median.
const SAMPLE: usize = 200;

/// Judges a region. `known` are the surfaces accepted so far; `tests` is the number of surfaces that the search of the
/// whole part tries. `None` if chance explains the region.
pub(super) fn judged(
    evidence: &ExactFacets,
    growth: GrownRegion,
    known: &[Primitive],
    tests: f64,
) -> Option<FoundRegion> {
    let surface = growth.surface();
    let kind = surface.kind();
    if growth.units.len() < 2 || is_extruded(evidence, &growth) && kind != PrimitiveKind::Cylinder {
        return None;
    }
    if evidence.slack > 1.0 && !is_bordered(evidence, &growth) {
        return None;
    }
    let tangent = tangent_neighbours(evidence, &growth);
    let ruled = matches!(kind, PrimitiveKind::Cylinder | PrimitiveKind::Cone);
    if ruled && growth.units.len() < 3 && tangent < 2 {
        return None;
    }
    let mut coincidences = independent(evidence, &growth) + tangent as f64;
    if known.iter().any(|other| is_coaxial(evidence, &growth, other)) {
        coincidences += 2.0;
    }
    let sagittas = growth
        .units
        .iter()
        .step_by(growth.units.len().div_ceil(SAMPLE))
        .map(|&f| evidence.sagitta(&surface, evidence.facets.get(f)));
    let sagitta = median(sagittas.collect())?;
    let error = typical_error(evidence, &growth);
    let chance = (growth.fit.worst.max(LEAST_DISTANCE) * error / sagitta).max(f64::MIN_POSITIVE);
    let is_chance = tests.log10() + coincidences * chance.log10() >= FALSE_ALARMS.log10();
    if coincidences <= 0.0
        || chance >= 0.5
        || is_chance
        || evidence.slack <= 1.0 && !ends_abruptly(evidence, &growth)
    {
        return None;
    }
    let area = growth.units.iter().map(|&f| evidence.facets.get(f).area).sum();
    let weight = (growth.vertices.len() + straight_edges(evidence, &growth) + tangent) as f64
        - kind.parameters() as f64;
    Some(FoundRegion { growth, area, weight })
}

pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

pub(super) fn typical_error(evidence: &ExactFacets, growth: &GrownRegion) -> f64 {
    let stride = growth.vertices.len().div_ceil(SAMPLE).max(1);
    let errors = growth.vertices.iter().step_by(stride).map(|&v| evidence.error(v));
    median(errors.collect()).unwrap_or(0.0)
}
