//! The division of a scan into regions: merging, absorbing, and borders by likelihood.

use std::collections::{BTreeMap, BTreeSet};

use super::growth::Room;
use super::model::{MOST_OFF, MOST_SAMPLES, SurfaceModel, cheapest};
use super::scan::{CREASE, MOST_TURN, NoisyScan};
use super::seeds::FEWEST;
use crate::geometry::NONE;

/// The steps of the fit to the core of a region.
const CORE_STEPS: usize = 10;

/// The rounds of merging, each of pairs that have no region in common.
const MOST_MERGES: usize = 8;

/// The standard deviation of a filtered normal, in radians, and the most that an angle costs.
pub(super) const NORMAL_DEVIATION: f64 = 0.15;
const MOST_ANGLE_COST: f64 = 6.0;

/// What each neighbour of another region costs a vertex (Potts).
const FOREIGN: f64 = 0.6;

/// The rounds in which vertices change their region.
const BORDER_ROUNDS: usize = 6;

/// A region that has more other regions around it is not absorbed.
const MOST_NEIGHBOURS: usize = 12;

/// A region of the scan.
#[derive(Debug, Clone)]
pub(super) struct DividedPart {
    pub(super) model: SurfaceModel,
    pub(super) vertices: Vec<u32>,
}

/// Which vertices belong to which region.
pub(super) struct Division {
    /// The number of each vertex' region.
    pub(super) labels: Vec<u32>,
    /// The regions; those without vertices are gone.
    pub(super) parts: Vec<DividedPart>,
    /// Pairs of regions that are no single surface, with their numbers of vertices.
    refused: BTreeSet<[usize; 4]>,
}

impl Division {
    pub(super) fn new(count: usize) -> Self {
        Division { labels: vec![NONE; count], parts: Vec::new(), refused: BTreeSet::new() }
    }

    pub(super) fn add(&mut self, model: SurfaceModel, vertices: Vec<u32>) {
        let number = self.parts.len() as u32;
        vertices.iter().for_each(|&v| self.labels[v as usize] = number);
        self.parts.push(DividedPart { model, vertices });
    }

    /// Lists the vertices of the regions again.
    pub(super) fn list(&mut self) {
        self.parts.iter_mut().for_each(|part| part.vertices.clear());
        for (v, &label) in self.labels.iter().enumerate() {
            if label != NONE {
                self.parts[label as usize].vertices.push(v as u32);
            }
        }
    }

    pub(super) fn alive(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts.len()).filter(|&a| !self.parts[a].vertices.is_empty())
    }

    /// The pairs of regions that are at most one vertex apart, each with the mean cosine between their surfaces there.
    fn pairs(&self, scan: &NoisyScan) -> Vec<([u32; 2], f64)> {
        let mut found: BTreeMap<[u32; 2], (f64, f64)> = BTreeMap::new();
        let mut meet = |a: u32, b: u32, v: u32| {
            let [x, y] = [a, b].map(|label| &self.parts[label as usize].model);
            let normal = |m: &SurfaceModel| m.side * m.surface.distance(scan.point(v)).1;
            let entry = found.entry([a.min(b), a.max(b)]).or_default();
            entry.0 += normal(x).dot(&normal(y));
            entry.1 += 1.0;
        };
        for v in 0..scan.len() as u32 {
            let own = self.labels[v as usize];
            if own == NONE {
                continue;
            }
            for &w in scan.near(v) {
                match self.labels[w as usize] {
                    NONE => {
                        for &x in scan.near(w) {
                            let other = self.labels[x as usize];
                            if other != NONE && other > own {
                                meet(own, other, w);
                            }
                        }
                    }
                    other if other > own => meet(own, other, w),
                    _ => {}
                }
            }
        }
        found.into_iter().map(|(pair, (sum, count))| (pair, sum / count)).collect()
    }

    /// Merges neighbours that one surface explains at a lower cost.
    pub(super) fn merge(&mut self, scan: &NoisyScan, room: &mut Room) {
        for _ in 0..MOST_MERGES {
            let mut pairs = self.pairs(scan);
            // A single surface turns from each of the two no more than a vertex' normal may.
            pairs.retain(|&(_, cosine)| cosine > (2.0 * MOST_TURN).cos());
            let size = |label: u32| self.parts[label as usize].vertices.len();
            pairs.sort_by_key(|&(p, _)| (std::cmp::Reverse(size(p[0]).min(size(p[1]))), p));
            let mut is_touched = vec![false; self.parts.len()];
            let mut is_any = false;
            for ([a, b], _) in pairs.into_iter().map(|(p, c)| (p.map(|x| x as usize), c)) {
                if is_touched[a] || is_touched[b] {
                    continue;
                }
                let [x, y] = [&self.parts[a], &self.parts[b]];
                let key = [a, b, x.vertices.len(), y.vertices.len()];
                if !self.refused.insert(key) {
                    continue;
                }
                let separate = x.model.total(scan, &x.vertices) + y.model.total(scan, &y.vertices);
                let both: Vec<u32> = x.vertices.iter().chain(&y.vertices).copied().collect();
                let joint = cheapest(scan, &both, &[x.model, y.model]);
                let Some((model, total)) = joint.filter(|(_, total)| *total < separate) else {
                    continue;
                };
                if total < separate && model.is_accepted(scan, &both, &mut room.off) {
                    let from = std::mem::take(&mut self.parts[b].vertices);
                    from.into_iter().for_each(|v| self.labels[v as usize] = a as u32);
                    self.parts[a] = DividedPart { model, vertices: both };
                    is_touched[a] = true;
                    is_touched[b] = true;
                    is_any = true;
                }
            }
            if !is_any {
                break;
            }
        }
    }

    /// Gives up regions whose vertices their neighbours explain at a lower cost, the smallest first.
    pub(super) fn absorb(&mut self, scan: &NoisyScan, room: &mut Room) {
        let mut order: Vec<usize> = self.alive().collect();
        order.sort_by_key(|&a| (self.parts[a].vertices.len(), a));
        for a in order {
            if self.parts[a].vertices.is_empty() {
                continue;
            }
            let others = self.around(scan, room, a);
            if others.is_empty() || others.len() > MOST_NEIGHBOURS {
                continue;
            }
            let part = &self.parts[a];
            let most = part.model.total(scan, &part.vertices) * scan.common;
            let (mut cost, mut homes) = (0.0, Vec::with_capacity(part.vertices.len()));
            for &v in &part.vertices {
                let (mut least, mut home) = (MOST_OFF * MOST_OFF, NONE);
                for &other in &others {
                    let model = &self.parts[other as usize].model;
                    let d = scan.off(&model.surface, model.side, v);
                    if d * d < least {
                        (least, home) = (d * d, other);
                    }
                }
                cost += least;
                homes.push(home);
                if cost >= most {
                    break;
                }
            }
            if cost < most {
                let vertices = std::mem::take(&mut self.parts[a].vertices);
                for (&v, &home) in vertices.iter().zip(&homes) {
                    self.labels[v as usize] = home;
                    if home != NONE {
                        self.parts[home as usize].vertices.push(v);
                    }
                }
            }
        }
        self.list();
    }

    /// The regions within two edges of a region.
    fn around(&self, scan: &NoisyScan, room: &mut Room, a: usize) -> BTreeSet<u32> {
        room.clear();
        let vertices = &self.parts[a].vertices;
        let mut others = BTreeSet::new();
        for &v in vertices {
            for &w in scan.near(v) {
                if self.labels[w as usize] as usize != a && room.mark(w) {
                    let mut see = |label: u32| {
                        if label != NONE && label as usize != a {
                            others.insert(label);
                        }
                    };
                    see(self.labels[w as usize]);
                    scan.near(w).iter().for_each(|&x| see(self.labels[x as usize]));
                }
            }
        }
        others
    }

    /// Moves borders to where they are likeliest (iterated conditional modes: Besag, "On the statistical analysis of
    /// dirty pictures", 1986).
    pub(super) fn move_borders(&mut self, scan: &NoisyScan) {
        let none = 0.5 * MOST_OFF * MOST_OFF;
        for _ in 0..BORDER_ROUNDS {
            let mut is_any = false;
            let mut counts: Vec<(u32, usize)> = Vec::new();
            for v in 0..scan.len() as u32 {
                let own = self.labels[v as usize];
                let near = scan.near(v);
                counts.clear();
                for &w in near {
                    let label = self.labels[w as usize];
                    match counts.iter_mut().find(|(other, _)| *other == label) {
                        Some((_, count)) => *count += 1,
                        None => counts.push((label, 1)),
                    }
                }
                if counts.iter().all(|&(label, _)| label == own || label == NONE) && own == NONE
                    || counts.len() == 1 && counts[0].0 == own
                {
                    continue;
                }
                let mut best = (none + FOREIGN * near.len() as f64, NONE);
                for &(label, count) in counts.iter().filter(|c| c.0 != NONE) {
                    let model = &self.parts[label as usize].model;
                    let (d, cosine) = scan.residual(&model.surface, model.side, v);
                    let angle = cosine.clamp(-1.0, 1.0).acos() / NORMAL_DEVIATION;
                    let cost = (0.5 * d * d).min(2.0 * none)
                        + (0.5 * angle * angle).min(MOST_ANGLE_COST)
                        + FOREIGN * (near.len() - count) as f64;
                    if cost < best.0 {
                        best = (cost, label);
                    }
                }
                if best.1 != own {
                    self.labels[v as usize] = best.1;
                    is_any = true;
                }
            }
            if !is_any {
                break;
            }
        }
        self.list();
    }

    /// The vertices of a region that surely belong to it, if those are enough, otherwise all: those all of whose
    /// neighbours do, or if these are less than half, those that are clear of the surfaces beyond sharp borders. The
    /// middle of a thin blend alone looks flat, and the rows beside sharp borders bend a chamfer.
    pub(super) fn core(&self, scan: &NoisyScan, a: usize) -> Vec<u32> {
        let part = &self.parts[a];
        let least = 3 * part.model.kind().parameters() + 10;
        let is_own = |w: &u32| self.labels[*w as usize] as usize == a;
        // Vertices that were left over belong to the nearest region, but may not lie on its surface.
        let lies = |&v: &u32| part.model.cost_at(scan, v) < MOST_OFF * MOST_OFF;
        let lying: Vec<u32> = part.vertices.iter().copied().filter(lies).collect();
        let inside = lying.iter().copied().filter(|&v| scan.near(v).iter().all(is_own));
        let inside: Vec<u32> = inside.collect();
        if inside.len() >= least.max(lying.len() / 2) {
            return inside;
        }
        let is_clear = |&v: &u32| {
            let own = part.model.side * part.model.surface.distance(scan.point(v)).1;
            scan.near(v).iter().filter(|w| !is_own(w)).all(|&w| {
                let label = self.labels[w as usize];
                label == NONE || {
                    let other = &self.parts[label as usize].model;
                    let (d, g) = other.surface.distance(scan.point(v));
                    let is_smooth = other.side * g.dot(&own) > CREASE.cos();
                    is_smooth || d.abs() > MOST_OFF * scan.noise.at(v)
                }
            })
        };
        let clear: Vec<u32> = lying.iter().copied().filter(is_clear).collect();
        [clear, lying]
            .into_iter()
            .find(|some| some.len() >= least)
            .unwrap_or_else(|| part.vertices.clone())
    }

    /// Fits all regions to their cores, and chooses their kinds again.
    pub(super) fn fit_cores(&mut self, scan: &NoisyScan, room: &mut Room, choose: bool) {
        let alive: Vec<usize> = self.alive().collect();
        for a in alive {
            let core = self.core(scan, a);
            let part = &mut self.parts[a];
            if let Some(model) = part.model.refitted(scan, &core, MOST_SAMPLES, CORE_STEPS) {
                part.model = model;
            }
            if choose && core.len() >= FEWEST {
                let own = part.model.total(scan, &core);
                let other = cheapest(scan, &core, &[]);
                let better = other.filter(|(model, total)| {
                    *total < own
                        && model.kind() != part.model.kind()
                        && model.is_accepted(scan, &core, &mut room.off)
                });
                if let Some((model, _)) = better {
                    part.model = model;
                }
            }
        }
    }
}
