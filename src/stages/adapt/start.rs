//! The state that a search starts with.

use super::options::KnotOptions;
use super::problem::Problem;
use super::state::State;
use crate::error::{Result, of};
use crate::rules;
use crate::spline::{KnotVector, Samples};
use crate::stages::knots;

/// The map as it is, over the knots of the paper, or over a uniform net if the user named one.
pub(crate) fn start(problem: &Problem) -> Result<(State, Option<knots::Report>)> {
    let asked = &problem.options.knots;
    let state = State::new(problem);
    if let Some(net) = asked.net {
        let knots = net.map(|count| KnotVector::uniform(3, count));
        return Ok((State { knots, ..state }, None));
    }
    let kappa = asked.kappa.unwrap_or(problem.goal.tolerance);
    let depth = asked.depth.unwrap_or_else(|| deepest(problem.measured()));
    let samples = without(state.samples(problem), &state.outliers);
    let (knots, report) = place(&samples, asked, kappa, depth)?;
    Ok((State { knots, ..state }, Some(report)))
}

/// The depth of subdivision at which a region of an even scan has one to four points.
fn deepest(measured: usize) -> u32 {
    ((measured as f64 / 4.0).sqrt().log2().ceil() as u32).clamp(2, 12)
}

/// The paper's knots. If neither κ nor depth is named, these are only the start,
/// and as deep as the bound on the net allows.
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
        match rules::net(net, asked.largest_net()) {
            Ok(()) => return Ok((knots, report)),
            Err(fault) if named || depth == 0 => return Err(of("net")(fault)),
            Err(_) => depth -= 1,
        }
    }
}

/// The samples that are no outliers.
fn without(samples: Samples, outliers: &[usize]) -> Samples {
    if outliers.is_empty() {
        return samples;
    }
    let mut left = vec![true; samples.len()];
    outliers.iter().for_each(|&v| left[v] = false);
    let left = || (0..left.len()).filter(|&v| left[v]);
    Samples {
        points: left().map(|v| samples.points[v]).collect(),
        uv: left().map(|v| samples.uv[v]).collect(),
        weights: left().map(|v| samples.weights[v]).collect(),
        open: samples.open,
    }
}
