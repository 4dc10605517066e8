//! Regions whose vertices are off by more than the rounding, because edges of the model are.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::coincidences::{SAME_PLACE, is_coaxial};
use super::competition::{Claims, JOINT_STEPS};
use super::exact::ExactFacets;
use super::growth::{Evidence, GrownRegion, RegionMarks, grow, refitted, worst};
use super::search::{CURVED, near_axes};
use super::significance::is_told;
use crate::geometry::{NONE, Point, Vector, range};
use crate::primitives::{
    FitOptions, FitSample, OrientedPoint, Primitive, PrimitiveFit, fit, with_axis,
};

/// The facets of a region that are looked at for its axis.
const SAMPLE: usize = 300;

/// The steps of each fit while errors shrink by half. With six, one of seventeen parts that were tried has other faces.
const FOLLOWING_STEPS: usize = 3;

/// One of so many inner vertices may be off, as at mistakes of the mesh. Where edges were loose, nearly none was, and where a kernel
/// had approximated the surface, about half of them. Three and four give the same faces on the parts that were measured.
const MOST_INNER_OFF: usize = 3;

/// The vertices of a loose region, of which some may be as exact as the file.
struct LooseVertices {
    /// The vertices with the errors of the file.
    exact: Vec<FitSample>,
    /// For each of them whether it is off the surface by more.
    is_loose: Vec<bool>,
    /// Whether those that are not tell the surface, as chance does not put so many on it.
    is_told: bool,
}

impl LooseVertices {
    /// Compares the vertices of a region with a surface that so many parameters were fitted to.
    fn new(
        evidence: &ExactFacets,
        region: &GrownRegion,
        surface: &Primitive,
        fitted: usize,
    ) -> Self {
        let of = |&v: &u32| {
            let sample = evidence.sample(v);
            FitSample { error: sample.error / evidence.slack, ..sample }
        };
        let exact: Vec<FitSample> = region.vertices.iter().map(of).collect();
        let off = |s: &FitSample| surface.distance(s.at).0.abs() / (evidence.bound() * s.error);
        let is_loose: Vec<bool> = exact.iter().map(|s| off(s) > 1.0).collect();
        let exactly = exact.iter().zip(&is_loose).filter(|of| !of.1).map(|of| of.0);
        let middle = exact.iter().map(|s| s.at.coords).sum::<Vector>() / exact.len() as f64;
        let [on, all] = [orbits(exactly, middle), orbits(exact.iter(), middle)];
        let most = exact.iter().map(off).fold(1.0, f64::max);
        let is_told = is_told(on, all, fitted, most);
        LooseVertices { exact, is_loose, is_told }
    }

    /// The vertices, with the errors of those that are loose so many times as large.
    fn with(&self, slack: f64) -> impl Iterator<Item = FitSample> {
        let of = move |(s, &is_loose): (&FitSample, &bool)| match is_loose {
            true => FitSample { error: slack * s.error, ..*s },
            false => *s,
        };
        self.exact.iter().zip(&self.is_loose).map(of)
    }
}

/// How many of some points are no mirror images of each other in planes across or between the axes of the coordinates. The rounding of
/// an image is that of the point, so that images say nothing new.
fn orbits<'a>(all: impl Iterator<Item = &'a FitSample>, middle: Vector) -> usize {
    let key = |s: &FitSample| {
        let mut place = (s.at.coords - middle).map(|x| (x.abs() / (SAME_PLACE * s.error)).round());
        place.as_mut_slice().sort_unstable_by(f64::total_cmp);
        [place.x, place.y, place.z].map(f64::to_bits)
    };
    all.map(key).collect::<BTreeSet<_>>().len()
}

/// The surface of those vertices of a region that loose edges did not put off, if they tell it. What is off by more counts less
/// and less, as the errors shrink to those of the file. Loose edges put off no inner vertex.
fn sharpened(
    evidence: &ExactFacets,
    region: &GrownRegion,
    start: Primitive,
    options: &FitOptions,
    is_inner: &dyn Fn(u32) -> bool,
) -> Option<PrimitiveFit> {
    let steps = FitOptions { steps: FOLLOWING_STEPS, ..*options };
    let mut surface = start;
    let mut slack = region.slack;
    while slack > 1.0 {
        slack *= 0.5;
        let of = |&v: &u32| {
            let FitSample { at, error } = evidence.sample(v);
            let error = slack * error / evidence.slack;
            let off = if is_inner(v) { 0.0 } else { surface.distance(at).0 };
            FitSample { at, error: error.hypot(off) }
        };
        let weighed: Vec<FitSample> = region.vertices.iter().map(of).collect();
        surface = fit(surface, &weighed, &steps)?.surface;
    }
    let frozen = options.frozen.iter().filter(|of| **of).count();
    let fitted = surface.kind().parameters().saturating_sub(frozen);
    let all = LooseVertices::new(evidence, region, &surface, fitted);
    let inner = region.vertices.iter().zip(&all.is_loose).filter(|(v, _)| is_inner(**v));
    let [count, off] = [inner.clone().count(), inner.filter(|(_, is_loose)| **is_loose).count()];
    if !all.is_told || MOST_INNER_OFF * off > count {
        return None;
    }
    // A loose edge puts all its vertices off together, so that many of them say no more than one.
    let count = all.is_loose.iter().filter(|of| **of).count() as f64;
    let weighed: Vec<FitSample> = all.with(evidence.slack * count.sqrt()).collect();
    let found = fit(surface, &weighed, options)?;
    let on = |s: FitSample| found.surface.distance(s.at).0.abs() <= evidence.bound() * s.error;
    let chord = |&f: &u32| evidence.faces(&found.surface, region.side, evidence.facets.get(f));
    if !all.with(evidence.slack).all(on) || !region.units.iter().all(chord) {
        return None;
    }
    // Its parameters are known no better than the vertices tell.
    let free = FitOptions { steps: 0, ..FitOptions::default() };
    fit(found.surface, &weighed, &free)
}

/// Whether a cone is a cylinder but for what loose edges put its few vertices off: no more than two for each of its parameters.
fn is_nearly_cylinder(evidence: &ExactFacets, region: &GrownRegion) -> bool {
    let surface = region.surface();
    let Primitive::Cone { origin, axis, angle, .. } = surface else { return false };
    let along = region.vertices.iter().map(|&v| (evidence.sample(v).at - origin).dot(&axis));
    let [low, high] = range(along);
    let error = region.vertices.iter().map(|&v| evidence.error(v)).fold(0.0, f64::max);
    region.vertices.len() <= 2 * surface.kind().parameters()
        && (high - low) * angle.tan() <= 2.0 * evidence.bound() * error
}

impl Claims {
    /// Joins loose regions with neighbours of any kind if one surface explains both as well as loose edges allow: cuts across
    /// a face with such edges leave pieces that are a little different each.
    pub(super) fn unify(&mut self, evidence: &ExactFacets, marks: &mut RegionMarks) {
        self.clarify(evidence);
        let before = self.of.clone();
        self.join(evidence, Claims::common);
        self.regrow(evidence, &before, marks);
        self.clarify(evidence);
    }

    /// For each vertex the number of the region that holds all triangles around it, or `NONE`.
    fn inside(&self, evidence: &ExactFacets) -> Vec<u32> {
        let mut inside: Vec<Option<u32>> = vec![None; evidence.mesh.errors.len()];
        for (f, facet) in evidence.facets.all.iter().enumerate() {
            let number = self.of[f];
            for v in facet.triangles.iter().flat_map(|&t| evidence.mesh.corners(t)) {
                let of = &mut inside[v as usize];
                *of = Some(if of.is_none_or(|before| before == number) { number } else { NONE });
            }
        }
        inside.into_iter().map(|of| of.unwrap_or(NONE)).collect()
    }

    /// Lets loose regions that were several before grow over facets that no region holds. Joined pieces tell their surface better
    /// than each of them did.
    fn regrow(&mut self, evidence: &ExactFacets, before: &[u32], marks: &mut RegionMarks) {
        let closed = self.of.iter().map(|&r| r != NONE).collect::<Vec<_>>();
        let mut view = ExactFacets { closed: closed.into(), ..evidence.clone() };
        for number in 0..self.regions.len() {
            let region = &self.regions[number];
            let first = region.units.first().map(|&f| before[f as usize]);
            let is_joined = region.units.iter().any(|&f| Some(before[f as usize]) != first);
            if !is_joined || region.is_exact() {
                continue;
            }
            let Some(grown) = grow(&view, region.fit, region.side, &region.units, marks) else {
                continue;
            };
            if grown.units.len() <= region.units.len() {
                continue;
            }
            let closed = Rc::make_mut(&mut view.closed);
            for &f in &region.units {
                (self.of[f as usize], closed[f as usize]) = (NONE, false);
            }
            for &f in &grown.units {
                (self.of[f as usize], closed[f as usize]) = (number as u32, true);
            }
            self.regions[number] = grown;
        }
    }

    /// Gives loose regions the surfaces that most of their vertices tell exactly. Where loose edges allow it they become simpler:
    /// on the axis of an exact region, or of a simpler kind.
    fn clarify(&mut self, evidence: &ExactFacets) {
        let known = self.axes(evidence);
        let bound = evidence.bound() * self.generous / evidence.slack;
        let inside = self.inside(evidence);
        for (number, region) in self.regions.iter_mut().enumerate() {
            if region.is_exact() && !is_nearly_cylinder(evidence, region) {
                continue;
            }
            let is_inner = |v: u32| inside[v as usize] == number as u32;
            let options = FitOptions { steps: JOINT_STEPS, ..FitOptions::default() };
            if let Some(fit) = sharpened(evidence, region, region.surface(), &options, &is_inner) {
                (region.fit, region.is_told) = (fit, true);
            }
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
                let rough = refitted(evidence, start, &region.vertices, &options)?;
                let chord =
                    |&f: &u32| evidence.faces(&rough.surface, region.side, evidence.facets.get(f));
                if rough.worst > bound || !region.units.iter().all(chord) {
                    return None;
                }
                let fine = sharpened(evidence, region, rough.surface, &options, &is_inner);
                // The axis is known no better than the vertices tell.
                let free = FitOptions { steps: 0, ..FitOptions::default() };
                let rough = || refitted(evidence, rough.surface, &region.vertices, &free);
                match fine {
                    Some(fit) => Some((fit, true)),
                    None if region.is_told => None,
                    None => Some((rough()?, false)),
                }
            });
            if let Some((fit, is_told)) = found {
                let worst = worst(evidence, &fit.surface, &region.vertices);
                (region.fit, region.is_told) = (fit, is_told);
                region.slack = region.slack.max(worst / bound * self.generous);
            }
        }
    }

    /// The surfaces of exact regions that have an axis, each axis once, as that region tells it which tells it best.
    fn axes(&self, evidence: &ExactFacets) -> Vec<Primitive> {
        let turn = |r: &&GrownRegion| r.fit.covariance[(0, 0)].max(r.fit.covariance[(1, 1)]);
        let has_axis = |r: &&GrownRegion| r.surface().axis().is_some() && r.is_exact();
        let mut exact: Vec<&GrownRegion> = self.regions.iter().filter(has_axis).collect();
        exact.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
        let mut known: Vec<Primitive> = Vec::new();
        for region in exact {
            if !known.iter().any(|other| is_coaxial(evidence, region, other)) {
                known.push(region.surface());
            }
        }
        known
    }

    /// The simplest surface that explains two regions of which at least one is loose.
    fn common(&self, evidence: &ExactFacets, a: usize, b: usize) -> Option<GrownRegion> {
        let [x, y] = [&self.regions[a], &self.regions[b]];
        if x.slack.max(y.slack) <= 1.0 {
            return None;
        }
        let bound = evidence.bound() * self.generous / evidence.slack;
        let units = [&x.units[..], &y.units[..]].concat();
        let mut vertices = [&x.vertices[..], &y.vertices[..]].concat();
        vertices.sort_unstable();
        vertices.dedup();
        let slack = x.slack.max(y.slack);
        for (exact, loose) in [(x, y), (y, x)] {
            let (surface, side) = (exact.surface(), exact.side);
            let holds = || {
                evidence.side(&surface, &loose.units) == side
                    && worst(evidence, &surface, &loose.vertices) <= bound
            };
            if exact.is_exact() && holds() {
                return Some(GrownRegion {
                    fit: exact.fit,
                    side,
                    slack,
                    is_told: true,
                    units,
                    vertices,
                });
            }
        }
        if x.side != y.side {
            return None;
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
                return Some(GrownRegion {
                    fit: loose.fit,
                    side: x.side,
                    slack,
                    is_told: loose.is_told,
                    units,
                    vertices,
                });
            }
        }
        let points: Vec<Point> = vertices.iter().map(|&v| evidence.sample(v).at).collect();
        let most = x.surface().kind().max(y.surface().kind());
        // A piece that seems to be exact is no more than a part of a simpler surface.
        let exact = [x, y].into_iter().filter(|r| r.slack <= 1.0).map(|r| r.surface().kind());
        let below = exact.min();
        let kinds = CURVED.into_iter().filter(|&k| k <= most && below.is_none_or(|b| k < b));
        for kind in kinds {
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
                    return Some(GrownRegion {
                        fit,
                        side: x.side,
                        slack,
                        is_told: false,
                        units,
                        vertices,
                    });
                }
            }
        }
        None
    }
}
