//! Which region gets a facet that several explain, which regions are one, and what becomes of what is left.

use super::exact::{ExactFacets, MOST_TURN};
use super::growth::{Evidence, Growth, pieces, refitted, worst};
use super::search::{CURVED, Search, near_axes};
use super::significance::Found;
use crate::geometry::{NONE, Point};
use crate::primitives::{Facing, FitOptions, Primitive, with_axis};

/// The steps of a joint fit of two regions that are one.
const JOINT_STEPS: usize = 10;

/// A small facet that continues a region smoothly may be off by so many times the bound: it is one whose corners a
/// neighbour's rounding has moved.
const SMOOTH_SLACK: f64 = 4.0;
const SMALL_FACET: usize = 2;

/// Larger facets are faces of their own and are not cut.
const MOST_CUT: usize = 64;

/// The facets of a region that are looked at for its largest sagitta.
const SAMPLE: usize = 300;

/// The regions of a mesh, and for each facet the number of its region.
pub(super) struct Claims {
    pub(super) regions: Vec<Growth>,
    pub(super) of: Vec<u32>,
    /// The factor by which errors at the ends of faces may be larger than those of the file.
    pub(super) generous: f64,
}

/// Lets regions compete: the one that explains most comes first. What loses facets is cut into connected pieces that must
/// be significant again. The regions join those that are there.
pub(super) fn settle(evidence: &ExactFacets, search: &mut Search, found: Vec<Found>, claims: &mut Claims) {
    let Claims { regions, of, .. } = claims;
    let mut left = found;
    let first = |f: &Found| f.growth.units.iter().copied().min();
    left.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(first(a).cmp(&first(b))));
    let mut at = 0;
    while at < left.len() {
        let next = left[at].clone();
        at += 1;
        let free: Vec<u32> =
            next.growth.units.iter().copied().filter(|&f| of[f as usize] == NONE).collect();
        if free.len() < next.growth.units.len() {
            for piece in pieces(evidence, &free, search.marks()) {
                let side = next.growth.side;
                let growth = Growth::new(evidence, next.growth.fit, side, &piece, search.marks());
                left.extend(search.judged(growth));
            }
            left[at..].sort_by(|a, b| b.weight.total_cmp(&a.weight).then(first(a).cmp(&first(b))));
            continue;
        }
        let number = regions.len() as u32;
        next.growth.units.iter().for_each(|&f| of[f as usize] = number);
        regions.push(next.growth);
    }
}

impl Claims {
    /// The numbers of the regions next to a region, in ascending order.
    fn beside(&self, evidence: &ExactFacets, region: usize) -> Vec<usize> {
        let mut beside: Vec<usize> = Vec::new();
        for &f in &self.regions[region].units {
            for b in &evidence.facets.get(f).borders {
                let other = self.of[b.facet as usize];
                if other != NONE && other as usize != region {
                    beside.push(other as usize);
                }
            }
        }
        beside.sort_unstable();
        beside.dedup();
        beside
    }

    /// Joins neighbours of one kind and side that one surface explains.
    pub(super) fn merge(&mut self, evidence: &ExactFacets) {
        let mut at = 0;
        while at < self.regions.len() {
            let found = self
                .beside(evidence, at)
                .into_iter()
                .find_map(|other| Some((other, self.joint(evidence, at, other)?)));
            match found {
                Some((other, joint)) => {
                    self.regions[at] = joint;
                    self.regions[other].units.clear();
                    self.regions[other].vertices.clear();
                    let number = at as u32;
                    self.regions[at].units.iter().for_each(|&f| self.of[f as usize] = number);
                }
                None => at += 1,
            }
        }
        self.drop_empty();
    }

    fn joint(&self, evidence: &ExactFacets, a: usize, b: usize) -> Option<Growth> {
        let [x, y] = [&self.regions[a], &self.regions[b]];
        if x.side != y.side || x.surface().kind() != y.surface().kind() {
            return None;
        }
        let (big, small) = if x.vertices.len() >= y.vertices.len() { (x, y) } else { (y, x) };
        let mut vertices = [&x.vertices[..], &y.vertices[..]].concat();
        vertices.sort_unstable();
        vertices.dedup();
        let options = FitOptions { steps: JOINT_STEPS, ..FitOptions::default() };
        let fit = refitted(evidence, big.surface(), &vertices, &options)?;
        let units = [&big.units[..], &small.units[..]].concat();
        let slack = x.slack.max(y.slack);
        let is_one = fit.worst <= evidence.bound() * slack / evidence.slack;
        is_one.then_some(Growth { fit, side: x.side, slack, units, vertices })
    }

    /// Joins loose regions with neighbours of any kind if one surface explains both as well as loose edges allow: cuts across
    /// a face with such edges leave pieces that are a little different each.
    pub(super) fn unify(&mut self, evidence: &ExactFacets) {
        self.simplify(evidence);
        let mut at = 0;
        while at < self.regions.len() {
            let found = self.beside(evidence, at).into_iter().find_map(|other| {
                Some((other, self.common(evidence, at, other)?))
            });
            match found {
                Some((other, joint)) => {
                    self.regions[at] = joint;
                    self.regions[other].units.clear();
                    self.regions[other].vertices.clear();
                    let number = at as u32;
                    self.regions[at].units.iter().for_each(|&f| self.of[f as usize] = number);
                }
                None => at += 1,
            }
        }
        self.drop_empty();
    }

    /// Makes loose regions simpler where loose edges allow it: on the axis of an exact region, or of a simpler kind.
    fn simplify(&mut self, evidence: &ExactFacets) {
        let exact = self.regions.iter().filter(|r| r.slack <= 1.0);
        let known: Vec<Primitive> = exact.map(Growth::surface).collect();
        let bound = evidence.bound() * self.generous / evidence.slack;
        for region in self.regions.iter_mut().filter(|r| r.slack > 1.0) {
            let units = &region.units;
            let stride = units.len().div_ceil(SAMPLE).max(1);
            let faces: Vec<Facing> =
                units.iter().step_by(stride).map(|&f| evidence.facing(f)).collect();
            let points: Vec<Point> =
                region.vertices.iter().map(|&v| evidence.sample(v).at).collect();
            let kind = region.surface().kind();
            let axes = near_axes(&known, &faces);
            let own = region.surface().axis().map(|axis| (region.surface().origin(), axis));
            let mut trials: Vec<(Primitive, bool)> = Vec::new();
            for k in CURVED.into_iter().filter(|&k| k <= kind) {
                trials.extend(axes.iter().filter_map(|&(o, a)| Some((with_axis(k, &points, o, a)?, true))));
            }
            for k in CURVED.into_iter().filter(|&k| k < kind) {
                trials.extend(own.iter().filter_map(|&(o, a)| Some((with_axis(k, &points, o, a)?, false))));
            }
            let found = trials.into_iter().find_map(|(start, keeps_axis)| {
                let mut options = FitOptions { steps: JOINT_STEPS, ..FitOptions::default() };
                if keeps_axis {
                    options.fixed_centre = true;
                    options.frozen[..4].fill(true);
                }
                let fit = refitted(evidence, start, &region.vertices, &options)?;
                let chord = |&f: &u32| evidence.faces(&fit.surface, region.side, evidence.facets.get(f));
                (fit.worst <= bound && region.units.iter().all(chord)).then_some(fit)
            });
            if let Some(fit) = found {
                region.fit = fit;
            }
        }
    }

    /// The simplest surface that explains two regions of which at least one is loose.
    fn common(&self, evidence: &ExactFacets, a: usize, b: usize) -> Option<Growth> {
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
                return Some(Growth { fit: exact.fit, side: x.side, slack, units, vertices });
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
                    return Some(Growth { fit, side: x.side, slack, units, vertices });
                }
            }
        }
        None
    }

    fn drop_empty(&mut self) {
        self.regions.retain(|r| !r.units.is_empty());
        for (number, region) in self.regions.iter().enumerate() {
            region.units.iter().for_each(|&f| self.of[f as usize] = number as u32);
        }
    }

    /// Gives left-over facets to the regions beside them on whose surfaces they lie. With `is_generous`, small facets may
    /// be a little off.
    pub(super) fn absorb(&mut self, evidence: &ExactFacets, is_generous: bool) {
        let largest: Vec<f64> = self
            .regions
            .iter()
            .map(|r| {
                let stride = r.units.len().div_ceil(SAMPLE).max(1);
                let sagitta = |&f: &u32| evidence.sagitta(&r.surface(), evidence.facets.get(f));
                r.units.iter().step_by(stride).map(sagitta).fold(0.0, f64::max)
            })
            .collect();
        let mut queue: Vec<u32> =
            (0..self.of.len() as u32).filter(|&f| self.of[f as usize] == NONE).collect();
        let mut done = 0;
        while let Some(&f) = queue.get(done) {
            done += 1;
            if self.of[f as usize] != NONE {
                continue;
            }
            let facet = evidence.facets.get(f);
            let mut beside: Vec<u32> =
                facet.borders.iter().map(|b| self.of[b.facet as usize]).collect();
            beside.retain(|&r| r != NONE);
            beside.sort_unstable();
            beside.dedup();
            let home = beside.into_iter().find(|&r| {
                let region = &self.regions[r as usize];
                let surface = region.surface();
                (is_generous && facet.triangles.len() == 1
                    || evidence.is_as_flat(
                        evidence.sagitta(&surface, facet),
                        largest[r as usize],
                        facet,
                    ))
                    && self.holds(evidence, f, r, is_generous)
            });
            if let Some(home) = home {
                self.of[f as usize] = home;
                let region = &mut self.regions[home as usize];
                region.units.push(f);
                if !is_generous {
                    region.vertices.extend(&facet.corners);
                }
                let next = facet.borders.iter().map(|b| b.facet);
                queue.extend(next.filter(|&f| self.of[f as usize] == NONE));
            }
        }
        for region in &mut self.regions {
            region.vertices.sort_unstable();
            region.vertices.dedup();
        }
    }

    /// Cuts left-over facets whose triangles lie on the surfaces of several regions beside them: where a profile changes its
    /// bend the last facet of one arc and the first one of the next lie in one plane.
    pub(super) fn cut(&mut self, evidence: &mut ExactFacets) {
        let free = (0..self.of.len() as u32).filter(|&f| self.of[f as usize] == NONE);
        let cuts: Vec<(u32, Vec<(u32, Vec<u32>)>)> =
            free.filter_map(|f| Some((f, self.homes(evidence, f)?))).collect();
        if cuts.is_empty() {
            return;
        }
        for (f, homes) in cuts {
            let (regions, groups): (Vec<u32>, Vec<Vec<u32>>) = homes.into_iter().unzip();
            let numbers = evidence.facets.cut(evidence.mesh, f, groups);
            self.of.resize(evidence.facets.all.len(), NONE);
            for (number, home) in numbers.into_iter().zip(regions) {
                self.of[number as usize] = home;
                let region = &mut self.regions[home as usize];
                region.units.push(number);
                region.vertices.extend(&evidence.facets.get(number).corners);
                region.vertices.sort_unstable();
                region.vertices.dedup();
            }
        }
        evidence.facets.rejoin(evidence.mesh);
        evidence.closed.resize(evidence.facets.all.len(), false);
    }

    /// The triangles of a facet by the regions that hold them, if there are several and no triangle is left.
    fn homes(&self, evidence: &ExactFacets, f: u32) -> Option<Vec<(u32, Vec<u32>)>> {
        let facet = evidence.facets.get(f);
        let smooth = facet.borders.iter().filter(|b| b.dihedral <= MOST_TURN);
        let mut beside: Vec<u32> = smooth.map(|b| self.of[b.facet as usize]).collect();
        beside.retain(|&r| r != NONE);
        beside.sort_unstable();
        beside.dedup();
        if beside.len() < 2 || facet.triangles.len() > MOST_CUT {
            return None;
        }
        let mut homes: Vec<(u32, Vec<u32>)> = beside.into_iter().map(|r| (r, Vec::new())).collect();
        for &t in &facet.triangles {
            let home = homes.iter_mut().find(|(r, _)| {
                let region = &self.regions[*r as usize];
                let surface = region.surface();
                let corners = evidence.mesh.corners(t);
                corners.iter().all(|&v| {
                    let s = evidence.sample(v);
                    let (d, n) = surface.distance(s.at);
                    let turned = region.side * n.dot(&facet.normal);
                    d.abs() <= evidence.bound() * s.error && turned >= MOST_TURN.cos()
                })
            });
            home?.1.push(t);
        }
        homes.retain(|(_, triangles)| !triangles.is_empty());
        (homes.len() >= 2).then_some(homes)
    }

    /// Whether a facet lies on the surface of a region beside it.
    fn holds(&self, evidence: &ExactFacets, f: u32, region: u32, is_generous: bool) -> bool {
        let facet = evidence.facets.get(f);
        let growth = &self.regions[region as usize];
        let surface = growth.surface();
        let slack = match (is_generous, facet.triangles.len()) {
            (true, 1) => SMOOTH_SLACK.max(self.generous),
            (true, _) => SMOOTH_SLACK.max(growth.slack),
            (false, _) => growth.slack,
        } / evidence.slack;
        if is_generous {
            let is_smooth = facet
                .borders
                .iter()
                .any(|b| b.dihedral <= MOST_TURN && self.of[b.facet as usize] == region);
            if !is_smooth || facet.triangles.len() > SMALL_FACET {
                return false;
            }
        }
        let on = |&v: &u32| {
            let s = evidence.sample(v);
            surface.distance(s.at).0.abs() <= slack * evidence.bound() * s.error
        };
        // A face that is found may have wider facets where its border is complicated.
        facet.corners.iter().all(on)
            && evidence.turns_at_most(MOST_TURN, &surface, growth.side, facet)
    }
}
