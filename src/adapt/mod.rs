//! Knots and fit, again and again until the tolerance holds, then with fewer knots
//! as long as it does.
//!
//! The paper takes κ and a depth from the user, and places knots once; so does
//! this where κ is named. Else the paper's knots for a κ of the tolerance (a mean,
//! where the tolerance bounds a maximum) are the start. Where the surface fitted
//! over them still misses points, knot spans are halved: a region that a
//! polynomial of its own fits need not be one that a spline, bound to its
//! neighbours, can follow. Where nobody named a tolerance, knots are weighed against the
//! noise instead. Between fits the samples' parameters are corrected, and from the last
//! one folds are taken out.

mod balance;
mod between;
mod correct;
mod doubt;
mod folds;
mod hold;
mod noise;
mod places;
mod search;
mod target;
mod weights;

use crate::course::{self, Course};
use crate::error::{Result, of};
use crate::geometry::Uv;
use crate::mesh::Parameterized;
use crate::spline::{KnotVector, Samples, Surface};
use crate::{fit, knots, rules};
use search::{Attempt, Search};
use target::Target;

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
    /// Whether knots are looked for that do, none having been named.
    fn are_searched(&self) -> bool {
        self.net.is_none() && self.kappa.is_none()
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.kappa.map_or(Ok(()), rules::length).map_err(of("kappa"))?;
        self.depth.map_or(Ok(()), rules::depth).map_err(of("depth"))?;
        rules::max_net(self.max_net).map_err(of("max_net"))?;
        let within = |net| rules::net(net, self.max_net);
        self.net.map_or(Ok(()), within).map_err(of("net"))
    }
}

/// How to adapt knots and fit.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// What is said about knots.
    pub knots: KnotOptions,
    /// How a surface is fitted over given knots.
    pub method: fit::Method,
    /// Whether the points have all their noise, smoothing being off. Points far from a fit may
    /// then be outliers, and a tolerance may be out of reach for the noise.
    pub noisy: bool,
}

/// The tolerance where nobody named one, in standard deviations of the noise, and the share of
/// normal noise that is beyond that.
pub(crate) const TOLERANCE_OF_NOISE: f64 = 3.0;
const BEYOND_IT: f64 = 0.0027;

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

impl Goal {
    /// What the `noise` lets one ask for, its standard deviation in mm.
    pub fn of_noise(noise: f64) -> Self {
        Goal { tolerance: TOLERANCE_OF_NOISE * noise, named: false, outliers: BEYOND_IT }
    }
}

/// How knots and fit turned out.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Adapted {
    /// The last fit.
    pub fit: fit::Report,
    /// The placement of knots by κ; `None` with a net of the user's.
    pub knots: Option<knots::Report>,
    /// κ, in mm; `None` with a net of the user's.
    pub kappa: Option<f64>,
    /// Fits made.
    pub rounds: usize,
    /// Where the surface is turned over; `None` for blended local fits, which are left as
    /// they are.
    pub folds: Option<Folds>,
    /// Mean distance, in mm, between a sample and the surface at the parameter that the
    /// sample was fitted with.
    pub mean_error: f64,
    /// The standard deviation of the noise, in mm, where the surface would have to follow that
    /// to keep a named tolerance: knots were put in no further.
    pub hindrance: Option<f64>,
}

impl Adapted {
    /// The same with all lengths times a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Adapted {
            kappa: self.kappa.map(|kappa| factor * kappa),
            mean_error: factor * self.mean_error,
            hindrance: self.hindrance.map(|noise| factor * noise),
            ..self
        }
    }
}

/// Where a surface is turned over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Folds {
    /// Places in which it is turned over somewhere.
    pub turned: usize,
    /// Places that were looked at, evenly spread over every knot cell.
    pub places: usize,
}

/// Fits a surface to the map's vertices, in mm over [0, 1]². The map's parameters are
/// corrected on the way.
///
/// # Errors
/// [`Error::Option`](crate::Error::Option): the goal is not one, or the knots for the
/// κ or depth that is named make a larger net than allowed.
/// [`Error::Singular`](crate::Error::Singular): the equations have no solution.
pub fn fit(map: &mut Parameterized, options: &Options, goal: &Goal) -> Result<(Surface, Adapted)> {
    fit_with(map, options, goal, &mut course::untold)
}

/// The same, telling how far it has come.
///
/// # Errors
/// Those of [`fit`](fn@fit), and what `course` answers.
pub fn fit_with(
    map: &mut Parameterized,
    options: &Options,
    goal: &Goal,
    course: &mut Course,
) -> Result<(Surface, Adapted)> {
    options.knots.check()?;
    rules::length(goal.tolerance).map_err(of("tolerance"))?;
    rules::share(goal.outliers).map_err(of("outliers"))?;
    let mut search = Search::new(Target::new(map), options, goal, course);
    let mut known = first(&mut search)?;
    let uv = search.corrected(&known.best);
    if search.wants_vertices(&known.best, &uv) {
        drop(search);
        map.uv = uv;
        between::bridge(map, &known.best.surface);
        search = Search::new(Target::new(map), options, goal, course);
        known = again(&mut search, known)?;
    }
    let (surface, adapted, uv) = finished(search, known)?;
    map.uv = uv;
    Ok((surface, adapted))
}

/// What a search has come to.
struct Known {
    best: Attempt,
    placed: Option<knots::Report>,
    rounds: usize,
}

/// Looks for knots.
fn first(search: &mut Search) -> Result<Known> {
    let (asked, named) = (&search.options.knots, search.goal.named);
    let (start, placed) = start(search)?;
    let mut best = search.attempt(start)?;
    if asked.are_searched() {
        best = match named {
            true => search.grow(best).and_then(|best| search.shrink(best))?,
            false => {
                let best = search.enrich(best).and_then(|best| search.thin(best))?;
                // Where smoothing is off, what is far may be outliers, and no shape.
                if search.options.noisy { best } else { search.grow(best)? }
            }
        };
    }
    if search.options.method != fit::Method::Blend {
        best = search.settle(best)?;
    }
    Ok(Known { best, placed, rounds: search.rounds })
}

/// Goes on over the same knots where the map has got more vertices.
fn again(search: &mut Search, known: Known) -> Result<Known> {
    search.rounds = known.rounds;
    let best = search.again(known.best)?;
    let best = search.settle(best)?;
    Ok(Known { best, rounds: search.rounds, ..known })
}

/// The surface without folds, as far as may be, and the parameters on it.
fn finished(mut search: Search, known: Known) -> Result<(Surface, Adapted, Vec<Uv>)> {
    let Known { mut best, placed, .. } = known;
    let (asked, goal) = (&search.options.knots, search.goal);
    let kappa = asked.net.is_none().then(|| asked.kappa.unwrap_or(goal.tolerance));
    let mut folds = None;
    if search.options.method != fit::Method::Blend {
        let (unfolded, turned) = search.unfold(best)?;
        let (unfolded, turned) = search.hold(unfolded, turned);
        let places = fit::jacobian_samples([&unfolded.surface.u, &unfolded.surface.v]);
        (best, folds) = (unfolded, Some(Folds { turned, places }));
    }
    search.target.set_uv(best.uv.clone());
    let adapted = Adapted {
        fit: best.fit,
        knots: placed,
        kappa,
        rounds: search.rounds,
        folds,
        mean_error: fit::mean_error(&best.surface, &search.target.samples),
        hindrance: search.hindrance,
    };
    let uv = search.corrected(&best);
    Ok((best.surface, adapted, uv))
}

/// The knots that a search starts with.
fn start(search: &Search) -> Result<([KnotVector; 2], Option<knots::Report>)> {
    let asked = &search.options.knots;
    if let Some(net) = asked.net {
        return Ok((net.map(|count| KnotVector::uniform(3, count)), None));
    }
    let kappa = asked.kappa.unwrap_or(search.goal.tolerance);
    let depth = asked.depth.unwrap_or_else(|| deepest(search.target.measured()));
    let (knots, report) = place(&search.target.trusted(), asked, kappa, depth)?;
    Ok((knots, Some(report)))
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
