//! Whether a surface that facets lie on is more than chance.

use super::borders::{ends_abruptly, is_bordered, straight_edges, tangent_neighbours};
use super::coincidences::{has_even_steps, independent, is_coaxial, is_extruded};
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

/// The false surfaces that one part may have on average: the usual level of significance. A false one does little harm,
/// because its vertices lie on it within the rounding. Only coarse roundings and short arcs come near this level.
const FALSE_ALARMS: f64 = 0.05;

/// How many surfaces the search of a part tries.
pub(super) struct Tests {
    /// Any surfaces on any patches.
    pub(super) of_patches: f64,
    /// Surfaces of all the facets between two creases or flat faces. Such pieces are few.
    pub(super) of_faces: f64,
}

/// A chord that turns by an angle has an eighth of it as its sagitta. The next corner of a profile of chance, which may turn there
/// by any such angle, is off by the whole; that of a smooth surface by little more than the sagitta.
const SAGITTAS_OF_TURN: f64 = 8.0;

/// Mirror images have one coincidence in common whatever their shape: four vertices of a symmetric trapezoid lie on a circle.
const FEWEST_COINCIDENCES: f64 = 2.0;

/// Coincidences are never rarer than this share of the rounding, below which distances are not uniform.
const LEAST_DISTANCE: f64 = 0.3;

/// The facets and neighbours that are looked at for a median.
const SAMPLE: usize = 200;

/// Judges a region. `known` are the surfaces accepted so far; `tests` are the numbers of surfaces that the search of the
/// whole part tries. `None` if chance explains the region.
pub(super) fn judged(
    evidence: &ExactFacets,
    growth: GrownRegion,
    known: &[Primitive],
    tests: &Tests,
) -> Option<FoundRegion> {
    let surface = growth.surface();
    let kind = surface.kind();
    if growth.units.len() < 2 || is_extruded(evidence, &growth) && kind != PrimitiveKind::Cylinder {
        return None;
    }
    if !has_even_steps(evidence, &growth) {
        return None;
    }
    let is_bordered = is_bordered(evidence, &growth);
    if evidence.slack > 1.0 && !is_bordered {
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
    let sagitta = median_sagitta(evidence, &growth)?;
    let error = typical_error(evidence, &growth);
    let is_exact = evidence.slack <= 1.0;
    let (tests, usual) = if is_bordered && is_exact {
        (tests.of_faces, SAGITTAS_OF_TURN * sagitta)
    } else {
        (tests.of_patches, sagitta)
    };
    let chance = (growth.fit.worst.max(LEAST_DISTANCE) * error / usual).max(f64::MIN_POSITIVE);
    let is_chance = tests.log10() + coincidences * chance.log10() >= FALSE_ALARMS.log10();
    if coincidences < FEWEST_COINCIDENCES
        || chance >= 0.5
        || is_chance
        || evidence.slack <= 1.0 && !ends_abruptly(evidence, &growth)
    {
        return None;
    }
    Some(weighed(evidence, growth, tangent, 1.0))
}

/// Whether chance does not explain that `on` of `all` points lie within the rounding of a surface that so many parameters were
/// fitted to, if each may be off by `loose` times as much: the number of false alarms of Moisan and Stival (2004).
pub(super) fn is_told(on: usize, all: usize, fitted: usize, loose: f64) -> bool {
    if on <= fitted {
        return false;
    }
    let tests = choices(all, on) + choices(on, fitted);
    tests - (on - fitted) as f64 * loose.log10() < FALSE_ALARMS.log10()
}

/// The decimal logarithm of the number of ways to choose `some` of `all`.
fn choices(all: usize, some: usize) -> f64 {
    (1..=some).map(|i| ((all - some + i) as f64 / i as f64).log10()).sum()
}

/// Weighs a region that was found with smaller errors and has grown with larger ones. Each vertex says less by the digits that
/// the errors take away.
pub(super) fn loosened(evidence: &ExactFacets, growth: GrownRegion) -> Option<FoundRegion> {
    if growth.units.len() < 2
        || !has_even_steps(evidence, &growth)
        || !ends_abruptly(evidence, &growth)
    {
        return None;
    }
    let errors = median_sagitta(evidence, &growth)? / typical_error(evidence, &growth);
    let digits = errors.ln() / (errors * evidence.slack).ln();
    let tangent = tangent_neighbours(evidence, &growth);
    (digits > 0.0).then(|| weighed(evidence, growth, tangent, digits))
}

/// A region with its area, and with what it explains at so many digits for each vertex, as a share of those of the file.
fn weighed(
    evidence: &ExactFacets,
    growth: GrownRegion,
    tangent: usize,
    digits: f64,
) -> FoundRegion {
    let area = growth.units.iter().map(|&f| evidence.facets.get(f).area).sum();
    let explained = growth.vertices.len() + straight_edges(evidence, &growth) + tangent;
    let weight = digits * (explained as f64 - growth.surface().kind().parameters() as f64);
    FoundRegion { growth, area, weight }
}

fn median_sagitta(evidence: &ExactFacets, growth: &GrownRegion) -> Option<f64> {
    let surface = growth.surface();
    let some = growth.units.iter().step_by(growth.units.len().div_ceil(SAMPLE).max(1));
    median(some.map(|&f| evidence.sagitta(&surface, evidence.facets.get(f))).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_points_on_a_surface_than_chance_puts_there_tell_it() {
        // Of 330 points that are off by up to eight times the rounding, some forty lie within it whatever the surface is.
        assert!(!is_told(41, 330, 7, 8.0));
        assert!(!is_told(70, 330, 7, 8.0));
        assert!(is_told(150, 330, 7, 8.0));
        assert!(is_told(12, 18, 5, 64.0));
        assert!(!is_told(7, 18, 5, 64.0));
        assert!(!is_told(5, 5, 5, 64.0));
    }
}
