//! The search for curved faces: seeds, and the surfaces tried on their patches.

use super::SLACK_STEP;
use super::borders;
use super::exact::{ExactFacets, MOST_TURN};
use super::facets::Facet;
use super::growth::{Evidence, GrownRegion, RegionMarks, grow, refitted};
use super::patches::{self, PATCHES};
use super::significance::{FoundRegion, Tests, judged, loosened};
use crate::geometry::{Point, Vector};
use crate::primitives::{
    FitOptions, FitSample, OrientedPoint, Primitive, PrimitiveFit, PrimitiveKind, fit, starts,
    with_axis,
};

/// The order in which kinds are preferred if they explain as much: two circles fit all of them, and the ruled ones are
/// nearest to the facets.
pub(super) const CURVED: [PrimitiveKind; 4] =
    [PrimitiveKind::Cylinder, PrimitiveKind::Cone, PrimitiveKind::Sphere, PrimitiveKind::Torus];

/// A kind explains as much as another one if it reaches this share of its area: of 20 rows of facets one may belong to
/// the neighbour as well.
const AS_MUCH: f64 = 0.95;

/// The steps of a fit that may not come near at all, and of a torus, whose starts are worse.
pub(super) const TRIAL_STEPS: usize = 25;
const TORUS_STEPS: usize = 60;

/// A smooth piece is given up after so many failing seeds in a row, plus twice the root of its facets. The sum over all
/// pieces grows less than linearly.
const FAILURES: usize = 50;

/// The same for searches with larger errors, whose surfaces grow far over free-form faces before they are refused. Faces with
/// loose edges are small pieces of their own, so few seeds find them.
const LOOSE_FAILURES: usize = 12;

/// Growths of a failing seed over so many facets in all cost as much as its fits, and count as one failure more. So the work of a
/// piece is bounded by that of its fits.
const SEED_WORK: usize = 1000;

/// A torus whose circle is so many diagonals of the part wide is a simpler surface by rounding.
const MOST_MAJOR: f64 = 10.0;

/// The known axes that are tried for a patch, those first that its normals meet best.
const MOST_AXES: usize = 3;

pub(super) struct SeedSearch<'a> {
    pub(super) evidence: &'a ExactFacets<'a>,
    /// FacetMesh that may belong to a curved face and are not explained yet.
    pub(super) pool: Vec<bool>,
    tests: Tests,
    pub(super) known: Vec<Primitive>,
    marks: RegionMarks,
    diagonal: f64,
    /// Facets of smooth pieces in which an earlier search with the same errors found nothing.
    hopeless: Vec<bool>,
    /// The facets that growths have looked at for the seed in hand.
    grown: usize,
    /// The factor by which errors at the ends of faces may be larger than those of the file.
    generous: f64,
}

impl<'a> SeedSearch<'a> {
    /// A search among the facets that are open, with the surfaces that are known already. No seed is tried in the facets
    /// that an earlier search has found hopeless.
    pub(super) fn new(
        evidence: &'a ExactFacets<'a>,
        known: Vec<Primitive>,
        mut hopeless: Vec<bool>,
        generous: f64,
    ) -> Self {
        let facets = &evidence.facets.all;
        let is_curved = |f: &Facet| !f.is_flat && f.borders.iter().any(|b| b.dihedral <= MOST_TURN);
        let open = facets.iter().zip(evidence.closed.iter());
        let pool: Vec<bool> = open.map(|(f, closed)| !closed && is_curved(f)).collect();
        let size = pool.iter().filter(|&&x| x).count();
        let tests = Tests {
            of_patches: (CURVED.len() * PATCHES * size).max(1) as f64,
            of_faces: (CURVED.len() * borders::closed_pieces(evidence, &pool)).max(1) as f64,
        };
        let marks = RegionMarks::new(facets.len(), evidence.mesh.errors.len());
        let diagonal = evidence.mesh.mesh.diagonal();
        hopeless.resize(facets.len(), false);
        SeedSearch { evidence, pool, tests, known, marks, diagonal, hopeless, grown: 0, generous }
    }

    /// Judges a region by the number of tests of this search.
    pub(super) fn judged(&self, growth: GrownRegion) -> Option<FoundRegion> {
        if growth.slack > self.evidence.slack {
            return loosened(&self.evidence.with_slack(growth.slack), growth);
        }
        judged(self.evidence, growth, &self.known, &self.tests)
    }

    pub(super) fn marks(&mut self) -> &mut RegionMarks {
        &mut self.marks
    }

    /// Facets in which neither this search nor one before it found anything.
    pub(super) fn into_hopeless(self) -> Vec<bool> {
        self.hopeless
    }

    /// Finds the regions of all seeds. They may overlap.
    pub(super) fn run(&mut self) -> Vec<FoundRegion> {
        let facets = &self.evidence.facets.all;
        let pieces = self.smooth_pieces();
        let mut allowed: Vec<usize> = vec![0; facets.len()];
        (0..facets.len()).filter(|&f| self.pool[f]).for_each(|f| allowed[pieces[f]] += 1);
        let is_loose = self.evidence.slack > 1.0;
        allowed.iter_mut().for_each(|n| {
            *n = if is_loose { LOOSE_FAILURES } else { FAILURES + 2 * n.isqrt() };
        });
        let mut left = allowed.clone();
        let mut is_hopeless = vec![true; facets.len()];
        let mut failures = vec![0u8; facets.len()];
        let mut found = Vec::new();
        for seed in self.order() {
            let (at, piece) = (seed as usize, pieces[seed as usize]);
            if !self.pool[at] || failures[at] >= 2 || left[piece] == 0 || self.hopeless[at] {
                continue;
            }
            self.grown = 0;
            if let Some(best) = self.best_at(seed) {
                best.growth.units.iter().for_each(|&f| self.pool[f as usize] = false);
                self.known.push(best.growth.surface());
                left[piece] = allowed[piece];
                is_hopeless[piece] = false;
                if let Some(wider) = self.wider(&best) {
                    wider.growth.units.iter().for_each(|&f| self.pool[f as usize] = false);
                    found.push(wider);
                }
                found.push(best);
            } else {
                left[piece] = left[piece].saturating_sub(1 + self.grown / SEED_WORK);
                failures[at] = 2;
                facets[at].borders.iter().for_each(|b| {
                    failures[b.facet as usize] = 2.min(failures[b.facet as usize] + 1)
                });
            }
        }
        self.hopeless.iter_mut().zip(&pieces).for_each(|(h, &piece)| *h |= is_hopeless[piece]);
        found
    }

    /// The regions of seeds that are spread over the facets, `most` of them if their growths are short.
    pub(super) fn sounded(mut self, most: usize) -> Vec<FoundRegion> {
        let seeds = self.order();
        let mut found = Vec::new();
        let mut left = most;
        for seed in seeds.iter().copied().step_by(seeds.len().div_ceil(most).max(1)) {
            if !self.pool[seed as usize] || left == 0 {
                continue;
            }
            self.grown = 0;
            match self.best_at(seed) {
                Some(best) => {
                    best.growth.units.iter().for_each(|&f| self.pool[f as usize] = false);
                    found.push(best);
                }
                None => left = left.saturating_sub(1 + self.grown / SEED_WORK),
            }
        }
        found
    }

    /// What becomes of a region with larger errors: it is cut to pieces by a border that is a little off. The first errors count
    /// with which it reaches as far as with the next larger ones, because a surface that comes near a free-form face reaches
    /// the further the larger they are.
    fn wider(&mut self, found: &FoundRegion) -> Option<FoundRegion> {
        let exact = &found.growth;
        let mut last = exact.clone();
        loop {
            let is_last = last.slack >= self.generous;
            let slack = SLACK_STEP * last.slack;
            let slack = if is_last { slack } else { slack.min(self.generous) };
            let view = self.evidence.with_slack(slack);
            let grown = grow(&view, exact.fit, exact.side, &exact.units, &mut self.marks)?;
            if last.units.len() as f64 >= AS_MUCH * grown.units.len() as f64 {
                break;
            }
            if is_last {
                return None;
            }
            last = grown;
        }
        if last.slack <= exact.slack {
            return None;
        }
        loosened(&self.evidence.with_slack(last.slack), last)
    }

    /// The best region that holds a seed.
    fn best_at(&mut self, seed: u32) -> Option<FoundRegion> {
        let mut best: Vec<FoundRegion> = Vec::new();
        let patches = patches::around(self.evidence, seed, &|f| self.pool[f as usize]);
        for (number, (patch, is_near)) in patches.iter().enumerate() {
            for kind in CURVED {
                if best.iter().any(|b| b.growth.surface().kind() == kind) {
                    continue;
                }
                let ruled = |b: &FoundRegion| {
                    matches!(
                        b.growth.surface().kind(),
                        PrimitiveKind::Cylinder | PrimitiveKind::Cone
                    )
                };
                let skip = !is_near || largest(&best).is_some_and(ruled);
                if kind == PrimitiveKind::Torus && skip {
                    continue;
                }
                best.extend(self.tried(kind, patch, seed));
            }
            let most = best.iter().map(|b| b.growth.units.len()).max().unwrap_or(0);
            let only_spheres =
                best.iter().all(|b| b.growth.surface().kind() == PrimitiveKind::Sphere);
            if most >= 2 * patch.len() && (number >= 4 || !only_spheres) {
                break;
            }
        }
        if let Some(other) = largest(&best).map(|b| b.growth.clone()) {
            // Two neighbouring rings of a torus lie on a common sphere and on a common cone, and a row along its tube
            // nearly on a cylinder.
            match other.surface() {
                Primitive::Sphere { .. } => best.extend(self.torus_beyond(&other.surface(), seed)),
                Primitive::Torus { .. } => {}
                _ => {
                    let found = self.torus_of_rows(&other, seed);
                    best.extend(found.or_else(|| self.torus_beyond(&other.surface(), seed)));
                }
            }
        }
        let most = largest(&best)?.area;
        best.retain(|b| b.area >= AS_MUCH * most);
        best.into_iter().min_by_key(|b| b.growth.surface().kind())
    }

    /// The first significant region of a kind that grows from a patch and holds the seed.
    pub(super) fn tried(
        &mut self,
        kind: PrimitiveKind,
        patch: &[u32],
        seed: u32,
    ) -> Option<FoundRegion> {
        let samples = samples(self.evidence, patch);
        let spare = usize::from(matches!(kind, PrimitiveKind::Sphere | PrimitiveKind::Torus));
        if samples.len() < kind.parameters() + spare {
            return None;
        }
        let steps = if kind == PrimitiveKind::Torus { TORUS_STEPS } else { TRIAL_STEPS };
        let options = FitOptions { steps, goal: self.evidence.bound(), ..FitOptions::default() };
        for start in self.starts(kind, patch, &samples) {
            let Some(fit) = fit(start, &samples, &options) else { continue };
            if fit.worst > self.evidence.bound() || !self.fits_patch(&fit.surface, patch) {
                continue;
            }
            if let Some(found) = self.region(fit, patch, seed) {
                return Some(found);
            }
        }
        None
    }

    /// The starts of a kind on a patch: about known axes first.
    fn starts(&self, kind: PrimitiveKind, patch: &[u32], samples: &[FitSample]) -> Vec<Primitive> {
        let points: Vec<Point> = samples.iter().map(|s| s.at).collect();
        let faces: Vec<OrientedPoint> = patch
            .iter()
            .map(|&f| {
                let facet = self.evidence.facets.get(f);
                OrientedPoint { centre: facet.centre, normal: facet.normal, area: facet.area }
            })
            .collect();
        let mut all: Vec<Primitive> = Vec::new();
        if matches!(kind, PrimitiveKind::Torus | PrimitiveKind::Cone) {
            let axes = near_axes(&self.known, &faces);
            all.extend(axes.into_iter().filter_map(|(o, a)| with_axis(kind, &points, o, a)));
        }
        all.extend(starts(kind, &points, &faces, &[]));
        all
    }

    /// Whether the facets of a patch may be chords of a surface.
    pub(super) fn fits_patch(&self, surface: &Primitive, patch: &[u32]) -> bool {
        if let Primitive::Torus { major, .. } = *surface
            && major > MOST_MAJOR * self.diagonal
        {
            return false;
        }
        let evidence = self.evidence;
        let side = evidence.side(surface, patch);
        if !patch.iter().all(|&f| evidence.faces(surface, side, evidence.facets.get(f))) {
            return false;
        }
        if !matches!(surface.kind(), PrimitiveKind::Cylinder | PrimitiveKind::Cone) {
            return true;
        }
        let mut sagittas: Vec<f64> =
            patch.iter().map(|&f| evidence.sagitta(surface, evidence.facets.get(f))).collect();
        sagittas.sort_unstable_by(f64::total_cmp);
        let middle = sagittas[(sagittas.len() - 1) / 2];
        let error = |&f: &u32| evidence.facets.get(f).error;
        let worst = patch.iter().max_by(|a, b| error(a).total_cmp(&error(b)));
        let (Some(&worst), Some(&largest)) = (worst, sagittas.last()) else { return false };
        evidence.is_as_flat(largest, middle, evidence.facets.get(worst))
    }

    /// Grows a region of a surface that fits a patch, as a simpler kind if that fits as well, and judges it.
    pub(super) fn region(
        &mut self,
        fit: PrimitiveFit,
        patch: &[u32],
        seed: u32,
    ) -> Option<FoundRegion> {
        let side = self.evidence.side(&fit.surface, patch);
        let growth = grow(self.evidence, fit, side, patch, &mut self.marks)?;
        self.grown += growth.units.len();
        let growth = self.simplified(growth);
        growth.units.contains(&seed).then(|| self.judged(growth)).flatten()
    }

    /// The region as a simpler kind if all its corners lie on one: a richer kind explains nothing more.
    pub(super) fn simplified(&mut self, growth: GrownRegion) -> GrownRegion {
        let kind = growth.surface().kind();
        for simpler in CURVED.into_iter().filter(|&k| k < kind) {
            // A sphere is no special case of a cone, nor is a torus without a common axis.
            if let Some(other) = self.as_kind(&growth, simpler) {
                return other;
            }
        }
        growth
    }

    fn as_kind(&mut self, growth: &GrownRegion, kind: PrimitiveKind) -> Option<GrownRegion> {
        let stride = growth.units.len().div_ceil(MOST_FACINGS).max(1);
        let some: Vec<u32> = growth.units.iter().copied().step_by(stride).collect();
        let samples = samples(self.evidence, &some);
        let options =
            FitOptions { steps: TRIAL_STEPS, goal: self.evidence.bound(), ..FitOptions::default() };
        for start in self.starts(kind, &some, &samples) {
            let Some(found) = refitted(self.evidence, start, &growth.vertices, &options) else {
                continue;
            };
            if found.worst <= self.evidence.bound()
                && self.fits_patch(&found.surface, &growth.units)
            {
                let side = self.evidence.side(&found.surface, &growth.units);
                return grow(self.evidence, found, side, &growth.units, &mut self.marks);
            }
        }
        None
    }
}

/// The facets of a region that suffice for a start.
const MOST_FACINGS: usize = 60;

fn largest(found: &[FoundRegion]) -> Option<&FoundRegion> {
    found.iter().max_by(|a, b| a.area.total_cmp(&b.area))
}

/// The corners of some facets, each once, in the order of their numbers.
pub(super) fn samples(evidence: &ExactFacets, facets: &[u32]) -> Vec<FitSample> {
    let mut corners: Vec<u32> =
        facets.iter().flat_map(|&f| evidence.vertices(f)).copied().collect();
    corners.sort_unstable();
    corners.dedup();
    corners.into_iter().map(|v| evidence.sample(v)).collect()
}

/// Known axes that the normals of all faces come near to meeting, the nearest first, each line once.
pub(super) fn near_axes(known: &[Primitive], faces: &[OrientedPoint]) -> Vec<(Point, Vector)> {
    let area: f64 = faces.iter().map(|f| f.area).sum();
    let mut rated: Vec<(f64, Point, Vector)> = Vec::new();
    for surface in known {
        let Some(axis) = surface.axis() else { continue };
        let origin = surface.origin();
        let miss = |f: &OrientedPoint| {
            let q = f.centre - origin;
            let across = q - q.dot(&axis) * axis;
            f.area * f.normal.dot(&axis.cross(&across)).abs() / across.norm().max(f64::MIN_POSITIVE)
        };
        let miss = faces.iter().map(miss).sum::<f64>() / area;
        // A facet that is cut askew misses the axis by half a step at most.
        if miss < 0.5 * MOST_TURN {
            rated.push((miss, origin, axis));
        }
    }
    rated.sort_by(|a, b| a.0.total_cmp(&b.0));
    rated.dedup_by(|a, b| a.0 == b.0);
    rated.into_iter().take(MOST_AXES).map(|(_, origin, axis)| (origin, axis)).collect()
}
