//! The growth of a region: one loop for every kind of evidence.

use crate::geometry::NONE;
use crate::primitives::{FitOptions, FitSample, Primitive, PrimitiveFit, fit};

/// What a region grows by: facets of a clean mesh, or vertices of a noisy one.
pub(super) trait Evidence {
    /// What the tests of one growth remember.
    type Memory;

    /// The memory for a growth that begins with some units.
    fn begin(&self, surface: &Primitive, seed: &[u32]) -> Self::Memory;

    /// Calls `visit` for every neighbour of a unit.
    fn neighbours(&self, unit: u32, visit: &mut dyn FnMut(u32));

    /// The vertices of a unit that must lie on its surface.
    fn vertices(&self, unit: u32) -> &[u32];

    /// Place and error of a vertex.
    fn sample(&self, vertex: u32) -> FitSample;

    /// The number of errors that a vertex may be off.
    fn bound(&self) -> f64;

    /// The factor by which the errors are larger than those of the file.
    fn slack(&self) -> f64;

    /// Whether a unit lies on the surface of a growth. With `is_settled` the fit is the last one, so it needs no
    /// allowance for extrapolation.
    fn joins(
        &self,
        unit: u32,
        growth: &GrownRegion,
        memory: &mut Self::Memory,
        is_settled: bool,
    ) -> bool;
}

/// A region that grows.
#[derive(Debug, Clone)]
pub(super) struct GrownRegion {
    pub(super) fit: PrimitiveFit,
    /// +1 if the mesh's normals are the surface's, -1 if they are opposite.
    pub(super) side: f64,
    /// The factor by which the errors are larger than those of the file.
    pub(super) slack: f64,
    /// Whether those vertices that loose edges did not put off tell the surface. Only the others are off by more than the rounding.
    pub(super) is_told: bool,
    pub(super) units: Vec<u32>,
    pub(super) vertices: Vec<u32>,
}

/// RegionMarks of units and vertices, kept between growths.
pub(super) struct RegionMarks {
    units: Vec<u32>,
    vertices: Vec<u32>,
    now: u32,
}

impl RegionMarks {
    pub(super) fn new(units: usize, vertices: usize) -> Self {
        RegionMarks { units: vec![NONE; units], vertices: vec![NONE; vertices], now: 0 }
    }

    /// Forgets all marks.
    pub(super) fn clear(&mut self) {
        self.now += 1;
    }

    /// RegionMarks a unit. Returns whether it was not marked.
    pub(super) fn unit(&mut self, unit: u32) -> bool {
        std::mem::replace(&mut self.units[unit as usize], self.now) != self.now
    }

    pub(super) fn has_unit(&self, unit: u32) -> bool {
        self.units[unit as usize] == self.now
    }

    fn vertex(&mut self, vertex: u32) -> bool {
        std::mem::replace(&mut self.vertices[vertex as usize], self.now) != self.now
    }
}

/// A surface is fitted again when it has this many times as many vertices: the extrapolation to so few more is safe.
const REFIT_GROWTH: f64 = 1.3;

/// The most vertices of a fit. Their mean is known to 2 % of their error.
const MOST_SAMPLES: usize = 2500;

/// A region at most doubles before the next fit, so a part that is not seen yet is never more than half of it.
/// At least so many units are added at a time.
const FEWEST_ADDED: usize = 8;

/// The steps of a fit that only follows more data.
const FOLLOWING_STEPS: usize = 15;

impl GrownRegion {
    pub(super) fn new<E: Evidence>(
        evidence: &E,
        fit: PrimitiveFit,
        side: f64,
        seed: &[u32],
        marks: &mut RegionMarks,
    ) -> Self {
        let slack = evidence.slack();
        let [units, vertices] = [Vec::new(), Vec::new()];
        let mut growth = GrownRegion { fit, side, slack, is_told: false, units, vertices };
        marks.clear();
        seed.iter().for_each(|&unit| growth.add(evidence, unit, marks));
        growth
    }

    pub(super) fn surface(&self) -> Primitive {
        self.fit.surface
    }

    /// Whether its surface is as exact as the file.
    pub(super) fn is_exact(&self) -> bool {
        self.slack <= 1.0 || self.is_told
    }

    fn add<E: Evidence>(&mut self, evidence: &E, unit: u32, marks: &mut RegionMarks) {
        if marks.unit(unit) {
            self.units.push(unit);
            let new = evidence.vertices(unit).iter().filter(|&&v| marks.vertex(v));
            self.vertices.extend(new);
        }
    }

    /// Fits the surface again. Returns whether all vertices lie on it.
    pub(super) fn refit<E: Evidence>(&mut self, evidence: &E) -> bool {
        let options = FitOptions { steps: FOLLOWING_STEPS, ..FitOptions::default() };
        match refitted(evidence, self.fit.surface, &self.vertices, &options) {
            Some(fit) => {
                self.fit = fit;
                fit.worst <= evidence.bound()
            }
            None => false,
        }
    }
}

/// Fits a surface to vertices, to a sample of them if they are many. `worst` is that of all vertices.
pub(super) fn refitted<E: Evidence>(
    evidence: &E,
    start: Primitive,
    vertices: &[u32],
    options: &FitOptions,
) -> Option<PrimitiveFit> {
    let stride = vertices.len().div_ceil(MOST_SAMPLES).max(1);
    let samples: Vec<FitSample> =
        vertices.iter().step_by(stride).map(|&v| evidence.sample(v)).collect();
    let mut found = fit(start, &samples, options)?;
    if stride > 1 {
        found.worst = worst(evidence, &found.surface, vertices);
    }
    Some(found)
}

/// The largest distance of vertices from a surface, in units of their errors.
pub(super) fn worst<E: Evidence>(evidence: &E, surface: &Primitive, vertices: &[u32]) -> f64 {
    let off = |&v: &u32| {
        let sample = evidence.sample(v);
        surface.distance(sample.at).0.abs() / sample.error
    };
    vertices.iter().map(off).fold(0.0, f64::max)
}

/// Grows a region from a seed whose vertices lie on a surface. Returns the largest connected piece that the last fit
/// explains, or `None` if a fit fails.
pub(super) fn grow<E: Evidence>(
    evidence: &E,
    start: PrimitiveFit,
    side: f64,
    seed: &[u32],
    marks: &mut RegionMarks,
) -> Option<GrownRegion> {
    let mut growth = GrownRegion::new(evidence, start, side, seed, marks);
    let mut memory = evidence.begin(&start.surface, seed);
    let mut fitted = 0;
    loop {
        if growth.vertices.len() as f64 > REFIT_GROWTH * fitted as f64 {
            if !growth.refit(evidence) {
                return None;
            }
            fitted = growth.vertices.len();
        }
        if !spread(evidence, &mut growth, &mut memory, marks) {
            break;
        }
    }
    let before = growth.fit;
    if !growth.refit(evidence) {
        growth.fit = before;
    }
    let kept: Vec<u32> = growth
        .units
        .iter()
        .copied()
        .filter(|&u| evidence.joins(u, &growth, &mut memory, true))
        .collect();
    if kept.len() < growth.units.len() {
        let piece = pieces(evidence, &kept, marks).into_iter().next()?;
        growth = GrownRegion::new(evidence, growth.fit, side, &piece, marks);
    }
    (!growth.units.is_empty()).then_some(growth)
}

/// Adds neighbours that lie on the surface, until none is left or the region has doubled. Returns whether any was.
fn spread<E: Evidence>(
    evidence: &E,
    growth: &mut GrownRegion,
    memory: &mut E::Memory,
    marks: &mut RegionMarks,
) -> bool {
    let before = growth.units.len();
    let most = before + before.max(FEWEST_ADDED);
    let mut refused: Vec<u32> = Vec::new();
    let mut done = 0;
    let mut around = Vec::new();
    while done < growth.units.len() && growth.units.len() < most {
        around.clear();
        evidence.neighbours(growth.units[done], &mut |unit| around.push(unit));
        done += 1;
        for &unit in &around {
            if !marks.has_unit(unit) {
                if evidence.joins(unit, growth, memory, false) {
                    growth.add(evidence, unit, marks);
                } else {
                    // Each is looked at once a round.
                    marks.unit(unit);
                    refused.push(unit);
                }
            }
        }
    }
    refused.iter().for_each(|&unit| marks.units[unit as usize] = NONE);
    growth.units.len() > before
}

/// The connected pieces of some units, the largest first, of equal ones the one with the lowest number.
pub(super) fn pieces<E: Evidence>(
    evidence: &E,
    units: &[u32],
    marks: &mut RegionMarks,
) -> Vec<Vec<u32>> {
    marks.clear();
    units.iter().for_each(|&u| {
        marks.unit(u);
    });
    let mut order = units.to_vec();
    order.sort_unstable();
    let mut found = Vec::new();
    for first in order {
        if !marks.has_unit(first) {
            continue;
        }
        marks.units[first as usize] = NONE;
        let mut piece = vec![first];
        let mut done = 0;
        while let Some(&unit) = piece.get(done) {
            done += 1;
            evidence.neighbours(unit, &mut |other| {
                if marks.has_unit(other) {
                    marks.units[other as usize] = NONE;
                    piece.push(other);
                }
            });
        }
        found.push(piece);
    }
    found.sort_by_key(|piece| std::cmp::Reverse(piece.len()));
    found
}
