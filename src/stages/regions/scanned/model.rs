//! Surfaces as explanations of noisy vertices: fits, acceptance, and cost.

use super::scan::{NoisyScan, some};
use super::starts::Neighbourhood;
use crate::geometry::SAME_SIDE;
use crate::primitives::{FitOptions, FitSample, Primitive, PrimitiveFit, PrimitiveKind, fit};
use crate::statistics::SIGNIFICANT;

/// A misfit below this share of the noise is none: it may be significant where there are many vertices, but castings
/// and scanners have such errors.
const RELEVANT: f64 = 0.35;

/// A vertex that is so many standard deviations off does not belong to a surface, and costs no more than that.
pub(super) const MOST_OFF: f64 = SIGNIFICANT;

/// The smallest radius that vertices can show, in edges.
pub(super) const LEAST_RADIUS: f64 = 0.3;

/// A radius that is larger than so many diagonals of the scan is that of a simpler surface.
const MOST_RADIUS: f64 = 5.0;

/// A cone that is nearer than this to a cylinder or a plane is one, in radians.
const LEAST_ANGLE: f64 = 0.005;

/// The vertices that suffice to choose between starts.
const FEW_SAMPLES: usize = 150;

/// The vertices that suffice to choose a kind, and those of a final fit.
const CHOICE_SAMPLES: usize = 600;
pub(super) const MOST_SAMPLES: usize = 10_000;

/// The steps of a fit from a rough start, and of one that follows more data.
const FIRST_STEPS: usize = 8;
pub(super) const MORE_STEPS: usize = 6;

/// A surface and the side of it that is outside.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfaceModel {
    pub(super) surface: Primitive,
    pub(super) side: f64,
}

impl SurfaceModel {
    pub(super) fn kind(&self) -> PrimitiveKind {
        self.surface.kind()
    }

    /// The model fitted again to vertices. `None` if it degenerates.
    pub(super) fn refitted(
        &self,
        scan: &NoisyScan,
        vertices: &[u32],
        most: usize,
        steps: usize,
    ) -> Option<SurfaceModel> {
        let samples = scan.samples(vertices, most);
        let found = fitted(scan, self.surface, &samples, steps)?;
        let side = scan.side(&found.surface, vertices);
        Some(SurfaceModel { surface: found.surface, side })
    }

    /// The best model of a kind for vertices.
    pub(super) fn best(
        scan: &NoisyScan,
        kind: PrimitiveKind,
        around: &Neighbourhood,
        vertices: &[u32],
        most: usize,
    ) -> Option<SurfaceModel> {
        let few = scan.samples(vertices, FEW_SAMPLES);
        let fits =
            around.starts(kind).into_iter().filter_map(|s| fitted(scan, s, &few, FIRST_STEPS));
        let found = fits.min_by(|a, b| a.squares.total_cmp(&b.squares))?;
        let model = SurfaceModel { surface: found.surface, side: 1.0 };
        if vertices.len() > FEW_SAMPLES {
            return model.refitted(scan, vertices, most, MORE_STEPS);
        }
        Some(SurfaceModel { side: scan.side(&found.surface, vertices), ..model })
    }

    /// Whether noise explains how far the vertices are off: neither their mean square nor the agreement of neighbours
    /// is larger by more than chance and by more than what is relevant. `off` is room for one number a vertex of the
    /// scan.
    pub(super) fn is_accepted(&self, scan: &NoisyScan, vertices: &[u32], off: &mut [f64]) -> bool {
        let (count, parameters) = (vertices.len(), self.kind().parameters());
        if count <= parameters + 3 {
            return false;
        }
        let mut squares = 0.0;
        for &v in vertices {
            let d = scan.residual(&self.surface, self.side, v).0;
            off[v as usize] = d;
            squares += d * d;
        }
        let (mut products, mut pairs) = (0.0, 0);
        for &v in vertices {
            for &w in scan.near(v).iter().filter(|&&w| w > v) {
                let other = off[w as usize];
                if !other.is_nan() {
                    products += off[v as usize] * other;
                    pairs += 1;
                }
            }
        }
        vertices.iter().for_each(|&v| off[v as usize] = f64::NAN);
        let free = (count - parameters) as f64;
        let [one, two] = scan.noise.correlation;
        let spread = 1.0 + 6.0 * one * one + 12.0 * two * two;
        let excess = squares / free - 1.0;
        let excess_at = excess * (free / (2.0 * spread)).sqrt();
        let pairs = f64::from(pairs).max(1.0);
        let agreement = products / pairs - one;
        let agreement_at = agreement / (spread * scan.common / pairs).sqrt();
        let relevant = RELEVANT.max(scan.noise.bias / scan.noise.deviation).powi(2);
        !(agreement_at > SIGNIFICANT && agreement > relevant
            || excess_at > SIGNIFICANT && excess > 2.0 * relevant)
    }

    /// What a vertex costs: its squared distance in standard deviations, bounded, because a vertex that is farther off
    /// belongs to another surface.
    pub(super) fn cost_at(&self, scan: &NoisyScan, v: u32) -> f64 {
        let (d, cosine) = scan.residual(&self.surface, self.side, v);
        let most = MOST_OFF * MOST_OFF;
        if cosine > SAME_SIDE { (d * d).min(most) } else { most }
    }

    /// What vertices cost, as a logarithm of likelihood.
    pub(super) fn cost(&self, scan: &NoisyScan, vertices: &[u32]) -> f64 {
        vertices.iter().map(|&v| self.cost_at(scan, v)).sum::<f64>() / scan.common
    }

    /// The cost of the parameters of a surface of so many vertices (Schwarz, "Estimating the dimension of a model",
    /// 1978), and of its kind.
    pub(super) fn description(&self, scan: &NoisyScan, count: usize) -> f64 {
        let independent = (count as f64 / scan.common).max(2.0);
        self.kind().parameters() as f64 * independent.ln() + rarity(self.kind())
    }

    /// The whole cost of vertices that are one region.
    pub(super) fn total(&self, scan: &NoisyScan, vertices: &[u32]) -> f64 {
        self.cost(scan, vertices) + self.description(scan, vertices.len())
    }
}

/// A kind costs twice the logarithm of how rare it is among the faces of parts.
fn rarity(kind: PrimitiveKind) -> f64 {
    let share: f64 = match kind {
        PrimitiveKind::Plane => 0.55,
        PrimitiveKind::Cylinder => 0.35,
        PrimitiveKind::Cone => 0.045,
        PrimitiveKind::Torus => 0.05,
        PrimitiveKind::Sphere => 0.012,
    };
    -2.0 * share.ln()
}

/// Fits a surface. `None` if it degenerates.
pub(super) fn fitted(
    scan: &NoisyScan,
    start: Primitive,
    samples: &[FitSample],
    steps: usize,
) -> Option<PrimitiveFit> {
    if samples.len() <= start.kind().parameters() {
        return None;
    }
    let found = fit(start, samples, &FitOptions { steps, ..FitOptions::default() })?;
    is_sane(scan, &found.surface).then_some(found)
}

pub(super) fn is_sane(scan: &NoisyScan, surface: &Primitive) -> bool {
    let is_radius = |r: f64| r > LEAST_RADIUS * scan.edge && r < MOST_RADIUS * scan.diagonal;
    match *surface {
        Primitive::Plane { .. } => true,
        Primitive::Cylinder { radius, .. } | Primitive::Sphere { radius, .. } => is_radius(radius),
        Primitive::Cone { angle, .. } => {
            angle > LEAST_ANGLE && angle < std::f64::consts::FRAC_PI_2 - LEAST_ANGLE
        }
        Primitive::Torus { major, minor, .. } => is_radius(major) && is_radius(minor),
    }
}

/// The best model of any kind for vertices, with its total cost on them. `known` are surfaces that may be near.
pub(super) fn cheapest(
    scan: &NoisyScan,
    vertices: &[u32],
    known: &[SurfaceModel],
) -> Option<(SurfaceModel, f64)> {
    let around = Neighbourhood::new(scan, some(vertices, FEW_SAMPLES));
    let mut best: Option<(SurfaceModel, f64)> = None;
    for kind in PrimitiveKind::ALL {
        let near = known.iter().filter(|m| m.kind() == kind);
        let near = near.filter_map(|m| m.refitted(scan, vertices, CHOICE_SAMPLES, FIRST_STEPS));
        let all = near.chain(SurfaceModel::best(scan, kind, &around, vertices, CHOICE_SAMPLES));
        let rated = all.map(|model| (model.total(scan, vertices), model));
        let Some((mut total, mut model)) = rated.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        // A fit to a sample of the vertices costs more than the best one by about this.
        let count = vertices.len() as f64;
        let gain = SIGNIFICANT * kind.parameters() as f64 * count / CHOICE_SAMPLES as f64;
        let may_win = best.as_ref().is_none_or(|(_, least)| total - gain < *least);
        if vertices.len() > CHOICE_SAMPLES
            && may_win
            && let Some(better) = model.refitted(scan, vertices, MOST_SAMPLES, MORE_STEPS)
        {
            (total, model) = (better.total(scan, vertices), better);
        }
        if best.as_ref().is_none_or(|(_, least)| total < *least) {
            best = Some((model, total));
        }
    }
    best
}
