//! Knots and fit, again and again until the tolerance holds.
//!
//! The paper takes κ and a depth from the user, and places knots once. Here κ
//! follows from the tolerance (κ bounds a mean, the tolerance a maximum), and
//! where the fitted surface still misses points the knot spans that hold them
//! are halved: a region that a polynomial of its own fits need not be one that
//! a spline, bound to its neighbours, can follow.

use crate::deviation::{Deviation, Face};
use crate::error::{Error, Result};
use crate::spline::{KnotVector, Samples, Surface};
use crate::{Options, fit, knots};

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

/// What the fit must reach.
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

/// κ as a share of the tolerance.
const KAPPA_SHARE: f64 = 0.5;

/// Measured points a control point at the least, where the user named no
/// tolerance: more control points would follow the noise.
const POINTS_A_CONTROL_POINT: usize = 4;

/// Without a named tolerance, a round that does not bring the number of points
/// beyond it down to this share is idle, and more than a few end it.
const WORTHWHILE: f64 = 0.9;

/// Idle rounds that may follow each other: a round may add a few knots only.
const PATIENCE: usize = 2;

/// Fits a surface to the samples; the first `measured` of them were measured.
pub fn fit(
    samples: &Samples,
    measured: usize,
    options: &Options,
    goal: &Goal,
) -> Result<(Surface, Adapted)> {
    let asked = &options.knots;
    if let Some([m, n]) = asked.net {
        check_net(m, n, asked.max_net)?;
        let (surface, fit) = fit::fit(
            samples,
            [KnotVector::uniform(3, m), KnotVector::uniform(3, n)],
            options.method,
        )?;
        let mean_error = fit::mean_error(&surface, samples);
        return Ok((surface, Adapted { fit, knots: None, kappa: 0.0, rounds: 1, mean_error }));
    }
    let place = knots::Options {
        kappa: asked.kappa.unwrap_or(KAPPA_SHARE * goal.tolerance),
        depth: asked.depth.unwrap_or_else(|| deepest(measured)),
    };
    let (mut knots, report) = knots::place(samples, &place);
    let mut best: Option<(Misses, Surface, Adapted)> = None;
    let mut idle = 0;
    for rounds in 1.. {
        let [m, n] = knots.each_ref().map(KnotVector::functions);
        let too_many = !goal.named && m * n * POINTS_A_CONTROL_POINT > measured;
        if best.is_some() && (too_many || m * n > asked.max_net) {
            break;
        }
        check_net(m, n, asked.max_net)?;
        let (surface, fit) = fit::fit(samples, knots.clone(), options.method)?;
        let off = deviation(&surface, samples, measured);
        let misses = Misses::count(&off, goal);
        let least = best.as_ref().map_or(f64::INFINITY, |b| b.0.beyond as f64);
        idle = if misses.beyond as f64 <= WORTHWHILE * least { 0 } else { idle + 1 };
        if best.as_ref().is_none_or(|b| misses < b.0) {
            let knots = Some(report.clone());
            let mean_error = fit::mean_error(&surface, samples);
            let adapted = Adapted { fit, knots, kappa: place.kappa, rounds, mean_error };
            best = Some((misses, surface, adapted));
        }
        let given_up = !goal.named && idle > PATIENCE;
        if misses.beyond <= misses.spared || given_up || asked.kappa.is_some() {
            break;
        }
        let missed = |i: &usize| off.distances[*i] > goal.tolerance;
        let finer =
            knots::halve(&knots, (0..measured).filter(missed).map(|i| samples.uv[i]), place.depth);
        if finer == knots {
            break;
        }
        knots = finer;
    }
    best.map(|(_, surface, adapted)| (surface, adapted)).ok_or(Error::Singular("fit"))
}

/// The depth at which a region of an even scan has one to four points.
fn deepest(measured: usize) -> u32 {
    ((measured as f64 / 4.0).sqrt().log2().ceil() as u32).clamp(2, 12)
}

fn check_net(m: usize, n: usize, most: usize) -> Result<()> {
    if m < 4 || n < 4 {
        return Err(Error::Net(format!(
            "a bicubic net has at least 4 × 4 control points, not {m} × {n}"
        )));
    }
    if m.saturating_mul(n) > most {
        return Err(Error::Net(format!(
            "a net of {m} × {n} control points exceeds the bound of {most}"
        )));
    }
    Ok(())
}

fn deviation(surface: &Surface, samples: &Samples, measured: usize) -> Deviation {
    let face = Face::new(surface, std::iter::empty());
    face.deviation(&samples.points[..measured], &samples.uv[..measured])
}

/// How far a fit is from its goal: first by the number of points that miss the
/// tolerance, then by the worst of them.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
struct Misses {
    beyond: usize,
    worst: f64,
    /// How many points may miss it.
    spared: usize,
}

impl Misses {
    fn count(off: &Deviation, goal: &Goal) -> Self {
        let spared = (goal.outliers * off.distances.len() as f64) as usize;
        Misses { beyond: off.beyond(goal.tolerance), worst: off.max, spared }
    }
}
