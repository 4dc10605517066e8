//! The growth of a region from a seed, as each kind of surface.

use super::model::{MORE_STEPS, MOST_OFF, SurfaceModel};
use super::scan::{NoisyScan, some};
use super::seeds;
use super::starts::Neighbourhood;
use crate::geometry::NONE;
use crate::primitives::PrimitiveKind;
use crate::statistics::SIGNIFICANT;

/// The vertices of a fit while a region grows.
const MOST_SAMPLES: usize = 1500;

/// A region at most doubles before the next fit, or grows to this many vertices.
const FEWEST: usize = 60;

/// The most fits of a growth. Doubling as often reaches every size.
const MOST_FITS: usize = 20;

/// A growth ends when a fit changes the number of its vertices by less than this share.
const STABLE: f64 = 0.001;

/// A surface that keeps less than this share of its seed has left it.
const KEPT: f64 = 0.6;

/// The vertices of a seed that give starts.
const SEED_SAMPLES: usize = 150;

/// Marks and numbers for each vertex of a scan, used again and again.
pub(super) struct Room {
    marks: Vec<u32>,
    now: u32,
    known: Vec<u32>,
    distances: Vec<f64>,
    flood: u32,
    /// Room for one number a vertex: NaN where nothing is stored.
    pub(super) off: Vec<f64>,
}

impl Room {
    pub(super) fn new(count: usize) -> Self {
        Room {
            marks: vec![0; count],
            now: 0,
            known: vec![0; count],
            distances: vec![0.0; count],
            flood: 0,
            off: vec![f64::NAN; count],
        }
    }

    /// Forgets all marks.
    pub(super) fn clear(&mut self) {
        self.now += 1;
    }

    /// Marks a vertex. Returns whether it was not marked.
    pub(super) fn mark(&mut self, v: u32) -> bool {
        std::mem::replace(&mut self.marks[v as usize], self.now) != self.now
    }

    pub(super) fn has(&self, v: u32) -> bool {
        self.marks[v as usize] == self.now
    }

    /// The vertices that are connected to `v` by at most so many edges, among those that are allowed.
    pub(super) fn ball(
        &mut self,
        scan: &NoisyScan,
        v: u32,
        rings: usize,
        is_allowed: impl Fn(u32) -> bool,
    ) -> Vec<u32> {
        self.clear();
        self.mark(v);
        let mut found = vec![v];
        let mut from = 0;
        for _ in 0..rings {
            let to = found.len();
            for i in from..to {
                for &w in scan.near(found[i]) {
                    if is_allowed(w) && self.mark(w) {
                        found.push(w);
                    }
                }
            }
            from = to;
        }
        found
    }

    /// The distance of a vertex from the model of the present flood.
    fn distance(&mut self, scan: &NoisyScan, model: &SurfaceModel, v: u32) -> f64 {
        let at = v as usize;
        if self.known[at] != self.flood {
            self.known[at] = self.flood;
            self.distances[at] = scan.off(&model.surface, model.side, v);
        }
        self.distances[at]
    }

    /// Whether a vertex lies on a model, and the mean of it and its neighbours does. The mean tells an edge or a bend
    /// long before the single vertex does.
    fn joins(&mut self, scan: &NoisyScan, model: &SurfaceModel, means: &[f64], v: u32) -> bool {
        let own = self.distance(scan, model, v);
        if own.abs() > MOST_OFF {
            return false;
        }
        let (mut sum, mut count) = (own, 1);
        for &w in scan.near(v) {
            let d = self.distance(scan, model, w);
            if d.is_finite() {
                sum += d.clamp(-MOST_OFF, MOST_OFF);
                count += 1;
            }
        }
        (sum / count as f64).abs() < means[count.min(means.len() - 1)]
    }

    /// The vertices on a model that are connected with its core.
    fn flood(
        &mut self,
        scan: &NoisyScan,
        model: &SurfaceModel,
        means: &[f64],
        core: &[u32],
        most: usize,
        labels: &[u32],
    ) -> Vec<u32> {
        self.clear();
        self.flood += 1;
        let mut found = Vec::new();
        for &v in core {
            if labels[v as usize] == NONE && self.joins(scan, model, means, v) && self.mark(v) {
                found.push(v);
            }
        }
        let mut done = 0;
        while done < found.len() && found.len() < most {
            for &w in scan.near(found[done]) {
                if !self.has(w) && labels[w as usize] == NONE && self.joins(scan, model, means, w) {
                    self.mark(w);
                    found.push(w);
                }
            }
            done += 1;
        }
        found
    }
}

/// How far the mean of so many neighbours may be off.
pub(super) fn bounds_of_means(scan: &NoisyScan) -> Vec<f64> {
    let bound = |count: usize| SIGNIFICANT * scan.deviation_of_mean(count.max(1));
    (0..MOST_NEAR).map(bound).collect()
}

/// Vertices with more neighbours are treated as if they had so many.
const MOST_NEAR: usize = 32;

/// The cheapest region that grows from a seed: its model and vertices.
pub(super) fn grow(
    scan: &NoisyScan,
    room: &mut Room,
    means: &[f64],
    seed: &[u32],
    labels: &[u32],
) -> Option<(SurfaceModel, Vec<u32>)> {
    let around = Neighbourhood::new(scan, some(seed, SEED_SAMPLES));
    let mut grown: Vec<(SurfaceModel, Vec<u32>)> = Vec::new();
    for kind in PrimitiveKind::ALL {
        let Some(start) = SurfaceModel::best(scan, kind, &around, seed, SEED_SAMPLES) else {
            continue;
        };
        if start.is_accepted(scan, seed, &mut room.off) {
            grown.extend(grown_as(scan, room, means, start, seed, labels));
        }
    }
    room.clear();
    let mut all = Vec::new();
    for v in grown.iter().flat_map(|g| &g.1) {
        if room.mark(*v) {
            all.push(*v);
        }
    }
    let rated = grown.into_iter().map(|g| (g.0.total(scan, &all), g));
    rated.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, best)| best)
}

fn grown_as(
    scan: &NoisyScan,
    room: &mut Room,
    means: &[f64],
    start: SurfaceModel,
    seed: &[u32],
    labels: &[u32],
) -> Option<(SurfaceModel, Vec<u32>)> {
    let mut model = start;
    let mut now = seed.to_vec();
    for _ in 0..MOST_FITS {
        let most = FEWEST.max(2 * now.len());
        let next = room.flood(scan, &model, means, seed, most, labels);
        if (next.len() as f64) < KEPT * seed.len() as f64 {
            return None;
        }
        let change = next.len().abs_diff(now.len()) as f64;
        let is_stable = next.len() < most && change <= STABLE * now.len() as f64;
        now = next;
        model = model.refitted(scan, &now, MOST_SAMPLES, MORE_STEPS)?;
        if is_stable {
            break;
        }
    }
    let is_enough = now.len() >= seeds::FEWEST;
    (is_enough && model.is_accepted(scan, &now, &mut room.off)).then_some((model, now))
}
