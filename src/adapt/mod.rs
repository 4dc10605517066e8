//! Knots and fit, again and again until the tolerance holds, then with fewer knots
//! as long as it does.
//!
//! The paper takes κ and a depth from the user, and places knots once; so does
//! this where κ is named. Else the paper's knots for a κ of the tolerance (a mean,
//! where the tolerance bounds a maximum) are the start. Where the surface fitted
//! over them still misses points, knot spans are halved: a region that a
//! polynomial of its own fits need not be one that a spline, bound to its
//! neighbours, can follow. Between fits the samples' parameters are corrected.

mod correct;
mod target;

use crate::error::{Result, of};
use crate::geometry::Uv;
use crate::parameterize::Parameterized;
use crate::spline::{KnotVector, Samples, Surface};
use crate::{Options, fit, knots, rules};
use target::{Feet, Target};

/// What the user says about knots.
#[derive(Debug, Clone)]
pub struct KnotOptions {
    /// κ in mm; `None`: from the tolerance.
    pub kappa: Option<f64>,
    /// Recursion bound; `None`: from the number of points.
    pub depth: Option<u32>,
    /// A uniform net that overrides both.
    pub net: Option<[usize; 2]>,
    /// Control points at the most.
    pub max_net: usize,
}

impl Default for KnotOptions {
    fn default() -> Self {
        KnotOptions { kappa: None, depth: None, net: None, max_net: 250_000 }
    }
}

impl KnotOptions {
    pub(crate) fn check(&self) -> Result<()> {
        self.kappa.map_or(Ok(()), rules::length).map_err(of("kappa"))?;
        self.depth.map_or(Ok(()), rules::depth).map_err(of("depth"))?;
        rules::max_net(self.max_net).map_err(of("max_net"))?;
        let within = |net| rules::net(net, self.max_net);
        self.net.map_or(Ok(()), within).map_err(of("net"))
    }
}

/// What the fit must reach.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// In mm.
    pub tolerance: f64,
    /// Whether the user named it.
    pub named: bool,
    /// Share of points that may exceed it.
    pub outliers: f64,
}

/// How knots and fit turned out.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Adapted {
    /// The last fit.
    pub fit: fit::Report,
    /// The placement of knots by κ; `None` with a net of the user's.
    pub knots: Option<knots::Report>,
    /// κ, in mm.
    pub kappa: f64,
    /// Fits made.
    pub rounds: usize,
    /// Mean distance, in mm, between a sample and the surface at the sample's
    /// parameter.
    pub mean_error: f64,
}

/// Without a named tolerance the target is this share of it: the face should
/// not take part of the noise for shape, but neither add to what smoothing left.
const UNNAMED_SHARE: f64 = 0.6;

/// Measured points a control point at the least, where the user named no
/// tolerance. Smoothing looks at dozens of points at a time, so that nets as fine as
/// this do not follow noise yet, but finer ones have nothing left to follow.
const POINTS_A_CONTROL_POINT: usize = 2;

/// Halvings beyond those that leave one to four points of an even scan, where scans
/// are denser or the map is crushed.
const DEEPER: u32 = 2;

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

/// Corrections of the parameters over a net that stays, at the most, and the rms
/// below which, of that before, another one pays.
const CORRECTIONS: usize = 5;
const PAYS: f64 = 0.97;

/// Fits a surface to the map's vertices, in mm over [0, 1]². The map's parameters are
/// corrected on the way. Of the options, those on knots and on the method are looked
/// at.
///
/// # Errors
/// [`Error::Option`](crate::Error::Option): the goal is not one, or the knots for the
/// κ or depth that is named make a larger net than allowed.
/// [`Error::Singular`](crate::Error::Singular): the equations have no solution.
pub fn fit(map: &mut Parameterized, options: &Options, goal: &Goal) -> Result<(Surface, Adapted)> {
    rules::length(goal.tolerance).map_err(of("tolerance"))?;
    rules::share(goal.outliers).map_err(of("outliers"))?;
    let asked = &options.knots;
    let mut search = Search { target: Target::new(map), options, goal, rounds: 0 };
    let kappa = asked.kappa.unwrap_or(goal.tolerance);
    let measured = search.target.measured();
    let (start, placed) = match asked.net {
        Some(net) => (net.map(|count| KnotVector::uniform(3, count)), None),
        None => {
            let depth = asked.depth.unwrap_or_else(|| deepest(measured));
            let (knots, report) = place(&search.target.samples, asked, kappa, depth)?;
            (knots, Some(report))
        }
    };
    let mut best = search.attempt(start)?;
    if asked.net.is_none() && asked.kappa.is_none() {
        best = search.grow(best)?;
        best = search.shrink(best)?;
    }
    if options.method != fit::Method::Blend {
        best = search.settle(best)?;
    }
    search.target.samples.uv = best.uv;
    let adapted = Adapted {
        fit: best.fit,
        knots: placed,
        kappa: if asked.net.is_none() { kappa } else { 0.0 },
        rounds: search.rounds,
        mean_error: fit::mean_error(&best.surface, &search.target.samples),
    };
    map.uv = search.target.samples.uv;
    Ok((best.surface, adapted))
}

/// A surface, the parameters it was fitted with, and how far it is off.
struct Attempt {
    surface: Surface,
    fit: fit::Report,
    uv: Vec<Uv>,
    weights: Vec<f64>,
    feet: Feet,
    /// Measured vertices beyond the target, and the farthest.
    beyond: (usize, f64),
}

struct Search<'a> {
    target: Target<'a>,
    options: &'a Options,
    goal: &'a Goal,
    rounds: usize,
}

impl Search<'_> {
    /// Distance, in mm, that the fit is to keep.
    fn limit(&self) -> f64 {
        if self.goal.named { self.goal.tolerance } else { UNNAMED_SHARE * self.goal.tolerance }
    }

    fn attempt(&mut self, knots: [KnotVector; 2]) -> Result<Attempt> {
        let (mut surface, fit) = fit::fit(&self.target.samples, knots, self.options.method)?;
        self.target.pin_corners(&mut surface);
        let feet = self.target.feet(&surface);
        self.rounds += 1;
        let beyond = feet.beyond(self.limit());
        let (uv, weights) = (self.target.samples.uv.clone(), self.target.samples.weights.clone());
        Ok(Attempt { surface, fit, uv, weights, feet, beyond })
    }

    /// Takes up the parameters and weights of an attempt, the parameters corrected.
    fn resume(&mut self, from: &Attempt) {
        self.target.samples.uv.clone_from(&from.uv);
        self.target.samples.weights.clone_from(&from.weights);
        self.target.correct(&from.feet);
    }

    /// Presses the surface on the points that it misses, as long as that helps: least
    /// squares leave single points far off that the net could reach.
    fn press(&mut self, mut best: Attempt) -> Result<Attempt> {
        let few = (PRESSED_SHARE * self.target.measured() as f64) as usize;
        for _ in 0..PRESSES {
            if !self.goal.named || self.met(&best) || best.beyond.0 > few {
                break;
            }
            self.resume(&best);
            self.target.press(&best.feet, self.limit());
            let next = self.attempt([best.surface.u.clone(), best.surface.v.clone()])?;
            if next.beyond.0 as f64 > PRESSING_PAYS * best.beyond.0 as f64 {
                break;
            }
            best = next;
        }
        Ok(best)
    }

    fn met(&self, attempt: &Attempt) -> bool {
        let spared = self.goal.outliers * self.target.measured() as f64;
        attempt.beyond.0 as f64 <= spared
    }

    /// Puts in knots until the target is met or nothing helps.
    fn grow(&mut self, start: Attempt) -> Result<Attempt> {
        let asked = &self.options.knots;
        let measured = self.target.measured();
        let (depth, most) = match self.goal.named {
            true => (asked.depth.unwrap_or(rules::MOST_HALVINGS), asked.max_net),
            false => (
                asked.depth.unwrap_or_else(|| deepest(measured) + DEEPER),
                asked.max_net.min(measured / POINTS_A_CONTROL_POINT),
            ),
        };
        let mut best = self.press(start)?;
        let mut last: Option<Attempt> = None;
        let mut idle = 0;
        loop {
            let now = last.as_ref().unwrap_or(&best);
            if self.met(now) || idle > PATIENCE {
                break;
            }
            let misses = self.target.misses(&now.feet, self.limit());
            let knots = knots::insert(&now.surface, &misses, self.target.reach(), depth, most);
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

    /// Takes out knot lines as long as the target stays met.
    fn shrink(&mut self, start: Attempt) -> Result<Attempt> {
        let mut best = start;
        if !self.met(&best) {
            return Ok(best);
        }
        let mut share = FIRST_SHARE;
        while share >= LAST_SHARE {
            let (knots, count) = knots::remove(&best.surface, share);
            if count == 0 {
                break;
            }
            self.resume(&best);
            let next = self.attempt(knots)?;
            let next = self.press(next)?;
            if self.met(&next) {
                best = next;
            } else {
                share *= 0.5;
            }
        }
        Ok(best)
    }

    /// Corrects the parameters over the same net as long as it pays.
    fn settle(&mut self, start: Attempt) -> Result<Attempt> {
        let mut best = start;
        for _ in 0..CORRECTIONS {
            self.resume(&best);
            let next = self.attempt([best.surface.u.clone(), best.surface.v.clone()])?;
            let (before, after) = (best.feet.rms(), next.feet.rms());
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

/// The paper's knots. Where neither κ nor depth is named these are only the start,
/// and as deep as the bound on the net lets them.
fn place(
    samples: &Samples,
    asked: &KnotOptions,
    kappa: f64,
    mut depth: u32,
) -> Result<([KnotVector; 2], knots::Report)> {
    loop {
        let (knots, report) = knots::place(samples, &knots::Options { kappa, depth });
        let net = knots.each_ref().map(KnotVector::functions);
        let named = asked.kappa.is_some() || asked.depth.is_some();
        match rules::net(net, asked.max_net) {
            Ok(()) => return Ok((knots, report)),
            Err(fault) if named || depth == 0 => return Err(of("net")(fault)),
            Err(_) => depth -= 1,
        }
    }
}

/// The depth at which a region of an even scan has one to four points.
fn deepest(measured: usize) -> u32 {
    ((measured as f64 / 4.0).sqrt().log2().ceil() as u32).clamp(2, 12)
}
