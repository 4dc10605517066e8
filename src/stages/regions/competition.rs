//! Which region gets a facet that several explain, which regions are one, and what becomes of what is left.

use super::exact::ExactFacets;
use super::growth::{Evidence, GrownRegion, pieces, refitted};
use super::search::SeedSearch;
use super::significance::FoundRegion;
use crate::geometry::NONE;
use crate::primitives::FitOptions;

/// The steps of a joint fit of two regions that are one.
pub(super) const JOINT_STEPS: usize = 10;

/// The regions of a mesh, and for each facet the number of its region.
pub(super) struct Claims {
    pub(super) regions: Vec<GrownRegion>,
    pub(super) of: Vec<u32>,
    /// The factor by which errors at the ends of faces may be larger than those of the file.
    pub(super) generous: f64,
}

/// Lets regions compete: the one that explains most comes first. What loses facets is cut into connected pieces that must
/// be significant again. The regions join those that are there.
pub(super) fn compete(
    evidence: &ExactFacets,
    search: &mut SeedSearch,
    found: Vec<FoundRegion>,
    claims: &mut Claims,
) {
    let mut left = found;
    let first = |f: &FoundRegion| f.growth.units.iter().copied().min();
    left.sort_by(|a, b| b.weight.total_cmp(&a.weight).then_with(|| first(a).cmp(&first(b))));
    let mut at = 0;
    while at < left.len() {
        let next = left[at].clone();
        at += 1;
        let free: Vec<u32> =
            next.growth.units.iter().copied().filter(|&f| claims.of[f as usize] == NONE).collect();
        if free.len() < next.growth.units.len() {
            for piece in pieces(evidence, &free, search.marks()) {
                let side = next.growth.side;
                let mut growth =
                    GrownRegion::new(evidence, next.growth.fit, side, &piece, search.marks());
                growth.slack = next.growth.slack;
                left.extend(search.judged(growth));
            }
            left[at..].sort_by(|a, b| {
                b.weight.total_cmp(&a.weight).then_with(|| first(a).cmp(&first(b)))
            });
            continue;
        }
        let number = claims.regions.len() as u32;
        next.growth.units.iter().for_each(|&f| claims.of[f as usize] = number);
        claims.regions.push(next.growth);
        // What lies on its surface and is askew between its facets is no evidence for another one.
        claims.absorb_into(evidence, number);
    }
}

impl Claims {
    /// The numbers of the regions next to a region, in ascending order.
    pub(super) fn beside(&self, evidence: &ExactFacets, region: usize) -> Vec<usize> {
        let mut beside: Vec<usize> = Vec::new();
        for &f in &self.regions[region].units {
            for b in evidence.facets.get(f).borders.iter().filter(|b| !b.is_sharp) {
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
        self.join(evidence, Claims::joint);
    }

    /// Joins neighbours until no two have a region in `common`.
    pub(super) fn join(
        &mut self,
        evidence: &ExactFacets,
        common: fn(&Claims, &ExactFacets, usize, usize) -> Option<GrownRegion>,
    ) {
        let mut at = 0;
        while at < self.regions.len() {
            let found = self
                .beside(evidence, at)
                .into_iter()
                .find_map(|other| Some((other, common(self, evidence, at, other)?)));
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

    fn joint(&self, evidence: &ExactFacets, a: usize, b: usize) -> Option<GrownRegion> {
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
        is_one.then_some(GrownRegion { fit, side: x.side, slack, is_told: false, units, vertices })
    }

    pub(super) fn drop_empty(&mut self) {
        self.regions.retain(|r| !r.units.is_empty());
        for (number, region) in self.regions.iter().enumerate() {
            region.units.iter().for_each(|&f| self.of[f as usize] = number as u32);
        }
    }
}
