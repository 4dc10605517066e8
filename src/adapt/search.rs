//! The search for knots over which a fit reaches its goal.

use super::target::{Feet, Target};
use super::{Goal, Options};
use crate::course::Course;
use crate::error::Result;
use crate::fit::TangentDistance;
use crate::geometry::Uv;
use crate::knots::Bounds;
use crate::spline::{KnotVector, Surface};
use crate::{fit, knots, rules};

/// A round that does not bring the number of points beyond the target down to this
/// share, nor the worst of them, is idle.
const WORTHWHILE: f64 = 0.95;

/// Idle rounds that may follow each other: a round may add a few knots only.
const PATIENCE: usize = 4;

/// The share of the knot lines that is tried to be done without at first, and the
/// one that is not worth another fit.
const FIRST_SHARE: f64 = 0.25;
const LAST_SHARE: f64 = 0.02;

/// Presses of one net at the most, the share of points beyond the target that are
/// not too many for it, and the share of them left that makes another one pay.
const PRESSES: usize = 3;
const PRESSED_SHARE: f64 = 0.1;
const PRESSING_PAYS: f64 = 0.7;

/// The share of its area that every triangle of the map keeps when parameters are
/// corrected, and the one while folds are taken out.
pub(super) const FIRM_AREA: f64 = 0.2;
pub(super) const LEAST_AREA: f64 = 1e-3;

/// Corrections of the parameters over a net that stays, at the most, and the rms
/// below which, of that before, another one pays.
const CORRECTIONS: usize = 5;
const PAYS: f64 = 0.97;

/// A slide that leaves more than this share of the rms is idle. After so many of them the
/// samples slide no more.
const IDLE_SLIDE: f64 = 0.93;
const PATIENCE_WITH_SLIDES: usize = 2;

/// The share of the time left that is left after another fit, as a rule.
const LEFT: f64 = 0.85;

/// A surface, the parameters it was fitted with, and how far it is off.
#[derive(Clone)]
pub struct Attempt {
    pub surface: Surface,
    pub fit: fit::Report,
    pub uv: Vec<Uv>,
    pub(super) weights: Vec<f64>,
    pub(super) feet: Feet,
    /// Measured vertices beyond the tolerance, and the farthest.
    pub(super) beyond: (usize, f64),
}

/// The samples as they stand between fits.
pub struct Search<'a> {
    /// What is fitted.
    pub target: Target<'a>,
    pub(super) holds: Vec<TangentDistance>,
    idle_slides: usize,
    pub(super) options: &'a Options,
    pub(super) goal: &'a Goal,
    /// Fits made.
    pub rounds: usize,
    /// The standard deviation of noise that keeps surfaces from a named tolerance.
    pub hindrance: Option<f64>,
    course: &'a mut Course<'a>,
}

impl<'a> Search<'a> {
    /// A search that has made no fit yet.
    pub fn new(
        target: Target<'a>,
        options: &'a Options,
        goal: &'a Goal,
        course: &'a mut Course<'a>,
    ) -> Self {
        let holds = target.holds();
        let (rounds, idle_slides, hindrance) = (0, 0, None);
        let mut search =
            Search { holds, idle_slides, target, options, goal, rounds, hindrance, course };
        let (limit, most) = search.doubts();
        search.target.doubt_unseen(limit, most);
        search
    }

    /// A fit over the given knots.
    pub fn attempt(&mut self, knots: [KnotVector; 2]) -> Result<Attempt> {
        // How many fits will follow nobody knows: each is the same share of what is left.
        (self.course)(1.0 - LEFT.powi(self.rounds as i32))?;
        let (mut surface, fit) = fit::fit(&self.target.samples, knots, self.options.method)?;
        self.target.pin_corners(&mut surface);
        let mut feet = self.target.feet(&surface);
        self.rounds += 1;
        if self.options.method == fit::Method::Refined {
            (surface, feet) = self.slide(surface, feet);
        }
        let (uv, weights) = (self.target.uv().to_vec(), self.target.weights.clone());
        if self.goal.named {
            let last = self.target.corrected(uv.clone(), feet.uv.clone(), FIRM_AREA);
            self.target.stay_at_loops(&surface, &last, &mut feet);
        }
        let beyond = feet.beyond(self.goal.tolerance);
        Ok(Attempt { surface, fit, uv, weights, feet, beyond })
    }

    /// An attempt at a surface that came of another one, with the samples at `uv`.
    pub(super) fn attempted(&self, surface: Surface, mut uv: Vec<Uv>, fit: fit::Report) -> Attempt {
        uv.truncate(self.target.uv().len());
        let mut feet = self.target.feet_from(&surface, &uv);
        let uv = self.target.corrected(uv, feet.uv.clone(), LEAST_AREA);
        if self.goal.named {
            self.target.stay_at_loops(&surface, &uv, &mut feet);
        }
        let beyond = feet.beyond(self.goal.tolerance);
        Attempt { surface, fit, uv, weights: self.target.weights.clone(), feet, beyond }
    }

    /// A fit over the knots of an attempt at a map that has got more vertices since.
    pub fn again(&mut self, before: Attempt) -> Result<Attempt> {
        let weights = self.target.weights.iter_mut().zip(&before.weights);
        weights.for_each(|(weight, before)| *weight = *before);
        self.target.give_weights();
        let knots = [before.surface.u.clone(), before.surface.v.clone()];
        let now = self.attempt(knots)?;
        match self.goal.named && self.options.knots.are_searched() {
            true => self.grow(now),
            false => Ok(now),
        }
    }

    /// The parameters that the samples of an attempt may move to, towards their feet; after
    /// blended local fits they stay.
    pub fn corrected(&self, of: &Attempt) -> Vec<Uv> {
        match self.options.method {
            fit::Method::Blend => of.uv.clone(),
            _ => self.target.corrected(of.uv.clone(), of.feet.uv.clone(), FIRM_AREA),
        }
    }

    /// Lets the samples slide along a surface that is fitted to them across, unless that
    /// has turned out idle.
    fn slide(&mut self, surface: Surface, feet: Feet) -> (Surface, Feet) {
        if self.idle_slides >= PATIENCE_WITH_SLIDES {
            return (surface, feet);
        }
        let uv = self.target.uv().to_vec();
        let (limit, most) = self.doubts();
        self.target.doubt(&feet.distances, limit, most);
        self.target.correct(&feet, FIRM_AREA);
        let stuck = self.target.stuck(&feet);
        let samples = &self.target.samples;
        if let Some(mut next) = fit::refit(&surface, samples, &self.holds, &stuck) {
            self.target.pin_corners(&mut next);
            let there = self.target.feet(&next);
            let (before, after) = (self.target.rms(&feet), self.target.rms(&there));
            self.idle_slides += usize::from(after > IDLE_SLIDE * before);
            if after < before {
                return (next, there);
            }
        }
        self.target.set_uv(uv);
        (surface, feet)
    }

    /// Takes up the parameters and weights of an attempt, the parameters corrected, and
    /// looks which samples are outliers of it.
    pub(super) fn resume(&mut self, from: &Attempt) {
        self.take_up(from, FIRM_AREA);
    }

    pub(super) fn take_up(&mut self, from: &Attempt, least_area: f64) {
        self.target.set_uv(from.uv.clone());
        self.doubt(from);
        self.target.correct(&from.feet, least_area);
    }

    /// Presses the surface on the points that it misses, as long as that helps: least
    /// squares leave single points far off that the net could reach.
    pub(super) fn press(&mut self, mut best: Attempt) -> Result<Attempt> {
        let few = self.share(PRESSED_SHARE);
        for _ in 0..PRESSES {
            if self.met(&best) || best.beyond.0 > few {
                break;
            }
            self.resume(&best);
            self.target.press(&best.feet, self.goal.tolerance);
            let next = self.attempt([best.surface.u.clone(), best.surface.v.clone()])?;
            if next.beyond.0 as f64 > PRESSING_PAYS * best.beyond.0 as f64 {
                break;
            }
            best = next;
        }
        Ok(best)
    }

    pub(super) fn met(&self, attempt: &Attempt) -> bool {
        attempt.beyond.0 <= self.spared()
    }

    /// How many points may be beyond the tolerance.
    pub(super) fn spared(&self) -> usize {
        self.share(self.goal.outliers)
    }

    /// How many points a share of the measured ones is.
    pub(super) fn share(&self, share: f64) -> usize {
        (share * self.target.measured() as f64) as usize
    }

    /// Puts in knots until the tolerance is met or nothing helps.
    pub fn grow(&mut self, start: Attempt) -> Result<Attempt> {
        let mut best = self.press(start)?;
        let mut last: Option<Attempt> = None;
        let (mut idle, mut misfit) = (0, None);
        loop {
            let now = last.as_ref().unwrap_or(&best);
            if self.met(now) || idle > PATIENCE {
                break;
            }
            self.hindrance = self.hindering_noise(now, &mut misfit);
            if self.hindrance.is_some() {
                break;
            }
            let knots = self.finer(now);
            if knots == [now.surface.u.clone(), now.surface.v.clone()] {
                break;
            }
            self.resume(now);
            let next = self.attempt(knots)?;
            let next = self.press(next)?;
            let gained = (next.beyond.0 as f64) <= WORTHWHILE * best.beyond.0 as f64
                || next.beyond.1 <= WORTHWHILE * best.beyond.1;
            idle = if gained { 0 } else { idle + 1 };
            if next.beyond < best.beyond {
                best = next;
                last = None;
            } else {
                last = Some(next);
            }
        }
        Ok(best)
    }

    /// The knots of an attempt and those that it wants where it misses points.
    pub(super) fn finer(&self, now: &Attempt) -> [KnotVector; 2] {
        self.finer_with(now, std::iter::empty())
    }

    /// The same with more misses.
    pub(super) fn finer_with(
        &self,
        now: &Attempt,
        more: impl Iterator<Item = knots::Miss>,
    ) -> [KnotVector; 2] {
        let asked = &self.options.knots;
        let bounds = Bounds {
            depth: asked.depth.unwrap_or(rules::MOST_HALVINGS),
            most: if self.goal.named { asked.max_net } else { self.most_for_noise() },
            price: 0.0,
        };
        let mut misses = self.target.misses(&now.feet, self.goal.tolerance);
        misses.extend(more);
        knots::insert(&now.surface, &misses, self.target.reach(), &bounds)
    }

    /// Takes out knot lines as long as the tolerance stays met.
    pub fn shrink(&mut self, start: Attempt) -> Result<Attempt> {
        match self.met(&start) {
            true => self.take_out(start, |search, _, next| search.met(next)),
            false => Ok(start),
        }
    }

    /// Takes out knot lines as long as what is left `does`, beside the best so far.
    pub(super) fn take_out(
        &mut self,
        start: Attempt,
        does: impl Fn(&Self, &Attempt, &Attempt) -> bool,
    ) -> Result<Attempt> {
        let mut best = start;
        let mut share = FIRST_SHARE;
        while share >= LAST_SHARE {
            let (knots, count) = knots::remove(&best.surface, share);
            if count == 0 {
                break;
            }
            self.resume(&best);
            let next = self.attempt(knots)?;
            let next = if self.goal.named { self.press(next)? } else { next };
            if does(self, &best, &next) {
                best = next;
            } else {
                share *= 0.5;
            }
        }
        Ok(best)
    }

    /// Corrects the parameters over the same net as long as it pays.
    pub fn settle(&mut self, start: Attempt) -> Result<Attempt> {
        let mut best = start;
        for _ in 0..CORRECTIONS {
            self.resume(&best);
            let next = self.attempt([best.surface.u.clone(), best.surface.v.clone()])?;
            let (before, after) = (self.target.rms(&best.feet), self.target.rms(&next.feet));
            if self.met(&best) && !self.met(&next) || after >= before {
                break;
            }
            best = next;
            if after > PAYS * before {
                break;
            }
        }
        Ok(best)
    }
}
