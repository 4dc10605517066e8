//! Surfaces without folds that keep the target.

use super::between;
use super::search::{Attempt, LEAST_AREA, Search};
use crate::error::Result;
use crate::fit::{self, STIFFNESSES};
use crate::geometry::Uv;

/// How often at the most knots make room for a surface without folds; once, after there
/// has been one with fewer.
const ROOM: usize = 8;

/// The share of points that may go beyond an unnamed tolerance for a surface without folds.
const GIVEN_UP: f64 = 0.01;

/// The share of points beyond a named tolerance from which on neither gentler ways nor knots
/// bring them back.
const HOPELESS: f64 = 0.1;

/// The share of the surface that is turned over where the scan, or its map, is crumpled, and
/// the mesh between the vertices no guide.
const CRUMPLED: f64 = 0.3;

/// What became of an attempt's folds.
struct Unfolding {
    /// How many places are turned over.
    folds: usize,
    /// The attempt with fewer of them that keeps the target, …
    found: Option<Attempt>,
    /// … or the last one that does not, but might.
    lost: Option<Attempt>,
}

impl Search<'_> {
    /// Takes out folds as far as that does not lose the target; where a named one would be
    /// lost, knots make room for it. Returns how many places stay turned over, too.
    pub fn unfold(&mut self, start: Attempt) -> Result<(Attempt, usize)> {
        let mut finer: Option<Attempt> = None;
        let mut before = None;
        let mut best: Option<(Attempt, usize)> = None;
        for round in 0..=ROOM {
            let now = finer.as_ref().unwrap_or(&start);
            let Unfolding { folds, found, lost } = self.unfolding(now);
            before.get_or_insert(folds);
            let is_second = best.is_some();
            if let Some(found) = found
                && best.as_ref().is_none_or(|(_, least)| folds < *least)
            {
                best = Some((found, folds));
            }
            let is_done = folds == 0 || is_second || round == ROOM;
            let pays = !is_done && self.may_make_room() && self.met(now);
            let Some(lost) = lost.filter(|_| pays) else { break };
            let knots = self.finer(&lost);
            if knots == [now.surface.u.clone(), now.surface.v.clone()] {
                break;
            }
            self.resume(now);
            let next = self.attempt(knots)?;
            let mut next = self.grow(next)?;
            if !self.met(&next) {
                break;
            }
            self.hold_on(&mut next, &lost);
            finer = Some(next);
        }
        Ok(best.unwrap_or((start, before.unwrap_or(0))))
    }

    /// Whether vertices that are missing, with the samples at `uv`, show in an attempt: it
    /// leaves the mesh there, or has folds, which it might leave when these are taken out,
    /// but not so many that it is [`CRUMPLED`].
    pub fn wants_vertices(&mut self, attempt: &Attempt, uv: &[Uv]) -> bool {
        let (surface, map) = (&attempt.surface, self.target.map);
        if self.options.method == fit::Method::Blend || !between::are_sparse(map, uv, surface) {
            return false;
        }
        self.take_up(attempt, LEAST_AREA);
        let folded = fit::inverted_share(surface, &self.target.samples, &self.holds);
        let misses = || {
            let left = self.target.left(surface, uv, self.goal.tolerance, 1.0).len();
            left as f64 / self.target.measured_triangles.len().max(1) as f64
        };
        folded < CRUMPLED && (folded > 0.0 || misses() > self.goal.outliers)
    }

    /// Gives weight to the points that an attempt without folds has `lost`.
    fn hold_on(&mut self, next: &mut Attempt, lost: &Attempt) {
        self.target.weights.clone_from(&lost.weights);
        self.target.press(&lost.feet, self.goal.tolerance);
        let pressed = next.weights.iter_mut().zip(&self.target.weights);
        pressed.for_each(|(weight, pressed)| *weight = weight.max(*pressed));
    }

    /// Whether a tolerance is named, and no net.
    fn may_make_room(&self) -> bool {
        self.goal.named && self.options.knots.are_searched()
    }

    /// Tries to take folds out over the same net; where a tolerance is named, in gentler
    /// ways, too, that start with less stiffness.
    fn unfolding(&mut self, start: &Attempt) -> Unfolding {
        self.take_up(start, LEAST_AREA);
        let mut tried = Unfolding { folds: usize::MAX, found: None, lost: None };
        let ways = if self.goal.named { STIFFNESSES.len() } else { 1 };
        for way in 0..ways {
            if let Some(lost) = &tried.lost {
                self.target.press(&lost.feet, self.goal.tolerance);
            }
            self.unfolding_with(start, &STIFFNESSES[way..], &mut tried);
            let is_hopeless = tried.found.is_none() && tried.lost.is_none();
            if tried.folds == 0 || is_hopeless {
                break;
            }
        }
        tried
    }

    /// Tries one way to take folds out.
    fn unfolding_with(&self, start: &Attempt, stiffnesses: &[f64], tried: &mut Unfolding) {
        let slide = |now: Vec<Uv>, wanted: Vec<Uv>| self.target.slid(now, wanted, LEAST_AREA);
        let most = start.beyond.0.max(self.spared())
            + if self.goal.named { 0 } else { self.share(GIVEN_UP) };
        let samples = &self.target.samples;
        let unfolded = fit::unfold(&start.surface, samples, &self.holds, &slide, stiffnesses);
        tried.folds = tried.folds.min(unfolded.before);
        for fit::UnfoldedSurface { surface, uv, folds } in unfolded.found {
            let attempt = self.attempted(surface, uv, start.fit);
            let beyond = attempt.beyond;
            // Later ones are closer to the samples.
            if beyond.0 > most {
                tried.lost = (beyond.0 <= self.share(HOPELESS)).then_some(attempt);
            } else if folds <= tried.folds {
                (tried.folds, tried.found) = (folds, Some(attempt));
            }
        }
    }
}
