//! Regions whose vertices are off by more than the rounding, because edges of the model are.

use super::competition::{Claims, JOINT_STEPS};
use super::exact::ExactFacets;
use super::growth::{Evidence, GrownRegion, refitted, worst};
use super::search::{CURVED, near_axes};
use crate::geometry::{Point, range};
use crate::primitives::{FitOptions, OrientedPoint, Primitive, with_axis};

/// The facets of a region that are looked at for its axis.
const SAMPLE: usize = 300;

/// Whether a cone is a cylinder but for what loose edges put its vertices off.
fn is_nearly_cylinder(evidence: &ExactFacets, region: &GrownRegion) -> bool {
    let Primitive::Cone { origin, axis, angle, .. } = region.surface() else { return false };
    let along = region.vertices.iter().map(|&v| (evidence.sample(v).at - origin).dot(&axis));
    let [low, high] = range(along);
    let error = region.vertices.iter().map(|&v| evidence.error(v)).fold(0.0, f64::max);
    (high - low) * angle.tan() <= 2.0 * evidence.bound() * error
}

impl Claims {
    /// Joins loose regions with neighbours of any kind if one surface explains both as well as loose edges allow: cuts across
    /// a face with such edges leave pieces that are a little different each.
    pub(super) fn unify(&mut self, evidence: &ExactFacets) {
        self.simplify(evidence);
        self.join(evidence, Claims::common);
    }

    /// Makes loose regions simpler where loose edges allow it: on the axis of an exact region, or of a simpler kind.
    fn simplify(&mut self, evidence: &ExactFacets) {
        let exact = self.regions.iter().filter(|r| r.slack <= 1.0);
        let known: Vec<Primitive> = exact.map(GrownRegion::surface).collect();
        let bound = evidence.bound() * self.generous / evidence.slack;
        let all = self.regions.iter_mut();
        for region in all.filter(|r| r.slack > 1.0 || is_nearly_cylinder(evidence, r)) {
            let units = &region.units;
            let stride = units.len().div_ceil(SAMPLE).max(1);
            let faces: Vec<OrientedPoint> =
                units.iter().step_by(stride).map(|&f| evidence.facing(f)).collect();
            let points: Vec<Point> =
                region.vertices.iter().map(|&v| evidence.sample(v).at).collect();
            let kind = region.surface().kind();
            let axes = near_axes(&known, &faces);
            let own = region.surface().axis().map(|axis| (region.surface().origin(), axis));
            let mut trials: Vec<(Primitive, bool)> = Vec::new();
            for k in CURVED.into_iter().filter(|&k| k <= kind) {
                trials.extend(
                    axes.iter().filter_map(|&(o, a)| Some((with_axis(k, &points, o, a)?, true))),
                );
            }
            for k in CURVED.into_iter().filter(|&k| k < kind) {
                trials.extend(
                    own.iter().filter_map(|&(o, a)| Some((with_axis(k, &points, o, a)?, false))),
                );
            }
            let found = trials.into_iter().find_map(|(start, keeps_axis)| {
                let mut options = FitOptions { steps: JOINT_STEPS, ..FitOptions::default() };
                if keeps_axis {
                    options.fixed_centre = true;
                    options.frozen[..4].fill(true);
                }
                let fit = refitted(evidence, start, &region.vertices, &options)?;
                let chord =
                    |&f: &u32| evidence.faces(&fit.surface, region.side, evidence.facets.get(f));
                (fit.worst <= bound && region.units.iter().all(chord)).then_some(fit)
            });
            // The axis is known no better than the vertices tell.
            let free = FitOptions { steps: 0, ..FitOptions::default() };
            let found = found.and_then(|f| refitted(evidence, f.surface, &region.vertices, &free));
            if let Some(fit) = found {
                region.fit = fit;
                region.slack = region.slack.max(fit.worst / bound * self.generous);
            }
        }
    }

    /// The simplest surface that explains two regions of which at least one is loose.
    fn common(&self, evidence: &ExactFacets, a: usize, b: usize) -> Option<GrownRegion> {
        let [x, y] = [&self.regions[a], &self.regions[b]];
        if x.side != y.side || x.slack.max(y.slack) <= 1.0 {
            return None;
        }
        let bound = evidence.bound() * self.generous / evidence.slack;
        let units = [&x.units[..], &y.units[..]].concat();
        let mut vertices = [&x.vertices[..], &y.vertices[..]].concat();
        vertices.sort_unstable();
        vertices.dedup();
        let slack = x.slack.max(y.slack);
        for (exact, loose) in [(x, y), (y, x)] {
            if exact.slack <= 1.0 && worst(evidence, &exact.surface(), &loose.vertices) <= bound {
                return Some(GrownRegion { fit: exact.fit, side: x.side, slack, units, vertices });
            }
        }
        // A piece between loose borders can seem to be exact on a surface of its own.
        for (loose, piece) in [(x, y), (y, x)] {
            let bound = evidence.bound() * loose.slack / evidence.slack;
            let surface = loose.surface();
            let chord = |&f: &u32| evidence.faces(&surface, x.side, evidence.facets.get(f));
            if loose.slack > piece.slack
                && loose.units.len() > piece.units.len()
                && worst(evidence, &surface, &piece.vertices) <= bound
                && piece.units.iter().all(chord)
            {
                return Some(GrownRegion { fit: loose.fit, side: x.side, slack, units, vertices });
            }
        }
        if x.slack.min(y.slack) <= 1.0 {
            return None;
        }
        let points: Vec<Point> = vertices.iter().map(|&v| evidence.sample(v).at).collect();
        let most = x.surface().kind().max(y.surface().kind());
        for kind in CURVED.into_iter().filter(|&k| k <= most) {
            let starts = [x, y].into_iter().filter_map(|r| {
                let surface = r.surface();
                if surface.kind() == kind {
                    return Some(surface);
                }
                with_axis(kind, &points, surface.origin(), surface.axis()?)
            });
            for start in starts {
                let options = FitOptions { steps: JOINT_STEPS, ..FitOptions::default() };
                let Some(fit) = refitted(evidence, start, &vertices, &options) else { continue };
                let chord = |&f: &u32| evidence.faces(&fit.surface, x.side, evidence.facets.get(f));
                if fit.worst <= bound && units.iter().all(chord) {
                    return Some(GrownRegion { fit, side: x.side, slack, units, vertices });
                }
            }
        }
        None
    }
}
