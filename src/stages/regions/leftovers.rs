//! What becomes of facets that no region holds.

use std::f64::consts::FRAC_PI_2;
use std::rc::Rc;

use super::competition::Claims;
use super::exact::{ExactFacets, MOST_TURN};
use super::facets::Border;
use super::growth::Evidence;
use crate::geometry::NONE;

/// A small facet that continues a region smoothly may be off by so many times the bound: it is one whose corners a
/// neighbour's rounding has moved.
const SMOOTH_SLACK: f64 = 4.0;

const SMALL_FACET: usize = 2;

/// The facets of a region that are looked at for its largest sagitta.
const SAMPLE: usize = 300;

/// Regions, each with the triangles of a facet that lie on its surface.
type Homes = Vec<(u32, Vec<u32>)>;

impl Claims {
    /// Gives left-over facets to the regions beside them on whose surfaces they lie. With `is_generous`, small facets may
    /// be a little off.
    pub(super) fn absorb(&mut self, evidence: &ExactFacets, is_generous: bool) {
        let all = 0..self.regions.len() as u32;
        let largest: Vec<f64> = all.map(|r| self.largest_sagitta(evidence, r)).collect();
        let free = (0..self.of.len() as u32).filter(|&f| self.of[f as usize] == NONE).collect();
        self.spread(evidence, free, is_generous, |claims, evidence, f| {
            let open = evidence.facets.get(f).borders.iter().filter(|b| !b.is_sharp);
            let mut beside: Vec<u32> = open.map(|b| claims.of[b.facet as usize]).collect();
            beside.retain(|&r| r != NONE);
            beside.sort_unstable();
            beside.dedup();
            let takes = |&r: &u32| claims.takes(evidence, f, r, largest[r as usize], is_generous);
            beside.into_iter().find(takes)
        });
        for region in &mut self.regions {
            region.vertices.sort_unstable();
            region.vertices.dedup();
        }
    }

    /// Gives the left-over facets around one region to it that lie on its surface.
    pub(super) fn absorb_into(&mut self, evidence: &ExactFacets, region: u32) {
        let largest = self.largest_sagitta(evidence, region);
        let units = &self.regions[region as usize].units;
        let around = units.iter().flat_map(|&f| evidence.facets.get(f).borders.iter());
        let around = around.filter(|b| !b.is_sharp).map(|b| b.facet).collect();
        self.spread(evidence, around, false, |claims, evidence, f| {
            claims.takes(evidence, f, region, largest, false).then_some(region)
        });
        let vertices = &mut self.regions[region as usize].vertices;
        vertices.sort_unstable();
        vertices.dedup();
    }

    /// Gives each free facet of a queue to the region that `home` names, and looks at its neighbours then.
    fn spread(
        &mut self,
        evidence: &ExactFacets,
        mut queue: Vec<u32>,
        is_generous: bool,
        home: impl Fn(&Claims, &ExactFacets, u32) -> Option<u32>,
    ) {
        let mut done = 0;
        while let Some(&f) = queue.get(done) {
            done += 1;
            if self.of[f as usize] != NONE {
                continue;
            }
            if let Some(home) = home(self, evidence, f) {
                let facet = evidence.facets.get(f);
                self.of[f as usize] = home;
                let region = &mut self.regions[home as usize];
                region.units.push(f);
                if !is_generous {
                    region.vertices.extend(&facet.corners);
                }
                let open = facet.borders.iter().filter(|b| !b.is_sharp).map(|b| b.facet);
                queue.extend(open.filter(|&f| self.of[f as usize] == NONE));
            }
        }
    }

    /// The largest distance of a facet of a region from its surface.
    fn largest_sagitta(&self, evidence: &ExactFacets, region: u32) -> f64 {
        let region = &self.regions[region as usize];
        let stride = region.units.len().div_ceil(SAMPLE).max(1);
        let sagitta = |&f: &u32| evidence.sagitta(&region.surface(), evidence.facets.get(f));
        region.units.iter().step_by(stride).map(sagitta).fold(0.0, f64::max)
    }

    /// Whether a left-over facet beside a region belongs to it. `largest` is the largest sagitta of the region.
    fn takes(
        &self,
        evidence: &ExactFacets,
        f: u32,
        region: u32,
        largest: f64,
        is_generous: bool,
    ) -> bool {
        let facet = evidence.facets.get(f);
        let surface = self.regions[region as usize].surface();
        (facet.triangles.len() == 1
            || evidence.is_as_flat(evidence.sagitta(&surface, facet), largest, facet))
            && self.holds(evidence, f, region, is_generous)
    }

    /// Cuts left-over facets whose triangles lie on the surfaces of several regions beside them: where a profile changes its
    /// bend the last facet of one arc and the first one of the next lie in one plane, and so do the strips of a tube at the top of a
    /// bend. Returns whether there were any.
    pub(super) fn cut(&mut self, evidence: &mut ExactFacets) -> bool {
        let free = (0..self.of.len() as u32).filter(|&f| self.of[f as usize] == NONE);
        let cuts: Vec<(u32, Homes)> =
            free.filter_map(|f| Some((f, self.homes(evidence, f)?))).collect();
        if cuts.is_empty() {
            return false;
        }
        for (f, homes) in cuts {
            let (regions, groups): (Vec<u32>, Vec<Vec<u32>>) = homes.into_iter().unzip();
            let numbers = Rc::make_mut(&mut evidence.facets).cut(evidence.mesh, f, groups);
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
        Rc::make_mut(&mut evidence.facets).rejoin(evidence.mesh);
        evidence.closed = vec![false; evidence.facets.all.len()].into();
        true
    }

    /// The triangles of a facet by the regions that hold them, if there are several and no triangle is left.
    fn homes(&self, evidence: &ExactFacets, f: u32) -> Option<Homes> {
        let facet = evidence.facets.get(f);
        let smooth = facet.borders.iter().filter(|b| b.dihedral <= MOST_TURN);
        let mut beside: Vec<u32> = smooth.map(|b| self.of[b.facet as usize]).collect();
        beside.retain(|&r| r != NONE);
        beside.sort_unstable();
        beside.dedup();
        if beside.len() < 2 {
            return None;
        }
        let mut homes: Homes = beside.into_iter().map(|r| (r, Vec::new())).collect();
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
        let on = |slack: f64| {
            let bound = slack / evidence.slack * evidence.bound();
            move |v: &u32| {
                let s = evidence.sample(*v);
                surface.distance(s.at).0.abs() <= bound * s.error
            }
        };
        if is_generous {
            let is_smooth = facet
                .borders
                .iter()
                .any(|b| b.dihedral <= MOST_TURN && self.of[b.facet as usize] == region);
            if !is_smooth || facet.triangles.len() > SMALL_FACET {
                return false;
            }
        }
        // A face that is found may have wider facets where its border is complicated.
        // Meshers cut single triangles askew, but not so far that they face the other way.
        let most = if facet.triangles.len() == 1 { FRAC_PI_2 } else { MOST_TURN };
        // A mesher folds a triangle over the one beside it where a fan meets in an apex.
        let is_inside = || {
            let of = |b: &Border| self.of[b.facet as usize] == region;
            facet.triangles.len() == 1 && facet.borders.iter().all(of)
        };
        let turns = || evidence.turns_at_most(most, &surface, growth.side, facet);
        let corners = || facet.corners.iter();
        let slack = if is_generous { SMOOTH_SLACK.max(growth.slack) } else { growth.slack };
        // Loose edges move one corner of two triangles in a plane.
        let is_moved = || {
            let most = SMOOTH_SLACK.max(self.generous);
            let off = corners().filter(|v| !on(slack)(v)).count();
            is_generous && (off <= 1 || facet.triangles.len() == 1) && corners().all(on(most))
        };
        (corners().all(on(slack)) || is_moved()) && (turns() || is_inside())
    }
}
