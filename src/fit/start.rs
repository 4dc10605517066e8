//! Where conjugate gradients start on a large net: at the fit of a net of a quarter
//! as many spans in u and in v to one sample a cell, which has itself started so.
//!
//! What is left to do is what the coarser net cannot follow and what is noise; most of
//! the way from nothing is gone at a sixteenth of the cost. The coarser knots are among
//! the finer ones, so that its surface is one over these, too.

use super::cells::Cells;
use super::normal::{Equations, Lane};
use crate::spline::{KnotVector, Samples};

/// So many of a net's spans make one of the coarser net.
const MERGED: usize = 4;

/// Spans in u and in v from which on a start pays.
const LEAST: usize = 24;

/// The net to start at, from the samples' origin; zeros for nets that are small, or whose
/// coarser ones samples do not determine.
pub fn of(cells: &Cells) -> Vec<Lane> {
    coarse(cells).unwrap_or_else(|| {
        vec![Lane::zeros(); cells.spans.each_ref().map(|s| s.all.len() + 3).iter().product()]
    })
}

fn coarse(cells: &Cells) -> Option<Vec<Lane>> {
    if cells.counts().iter().any(|&count| count < LEAST) {
        return None;
    }
    let knots = cells.knots.map(merged);
    let samples = one_a_cell(cells);
    let coarse = Cells::new(&samples, [&knots[0], &knots[1]]);
    let (net, _) = super::optimum(&Equations::new(&coarse), &coarse).ok()?;
    let shift = (coarse.origin - cells.origin).push(0.0);
    let net = net.iter().map(|p| p + shift).collect();
    Some(refined(net, &knots, cells.knots))
}

/// Every fourth knot.
fn merged(knots: &KnotVector) -> KnotVector {
    let breaks = knots.breaks();
    let last = breaks.len() - 1;
    let kept: Vec<f64> = (0..last).step_by(MERGED).chain([last]).map(|i| breaks[i]).collect();
    KnotVector::clamped(3, &kept, 1)
}

/// The first sample of every cell that has any.
fn one_a_cell(cells: &Cells) -> Samples {
    let [across, down] = cells.counts();
    let of = cells.samples;
    let mut some = Samples { open: of.open, ..Samples::default() };
    for at in 0..across * down {
        if let Some(&i) = cells.indices(at / down, at % down).first() {
            let i = i as usize;
            some.points.push(of.points[i]);
            some.uv.push(of.uv[i]);
            some.weights.push(of.weights[i]);
        }
    }
    some
}

/// The same surface over more knots, along v and then along u.
fn refined(net: Vec<Lane>, from: &[KnotVector; 2], to: [&KnotVector; 2]) -> Vec<Lane> {
    let [nu, nv] = from.each_ref().map(KnotVector::functions);
    let [more_u, more_v] = to.map(KnotVector::functions);
    let rows: Vec<Lane> = net.chunks(nv).flat_map(|row| inserted(row, &from[1], to[1])).collect();
    let mut all = vec![Lane::zeros(); more_u * more_v];
    for j in 0..more_v {
        let column: Vec<Lane> = (0..nu).map(|i| rows[i * more_v + j]).collect();
        let column = inserted(&column, &from[0], to[0]);
        column.into_iter().enumerate().for_each(|(i, p)| all[i * more_v + j] = p);
    }
    all
}

/// A curve's control points over more knots: blossoms of the piece where a new function
/// begins (Oslo algorithm: Cohen, Lyche, Riesenfeld, 1980).
fn inserted(control: &[Lane], from: &KnotVector, to: &KnotVector) -> Vec<Lane> {
    let at = |i: usize| {
        let knots = &to.knots()[i..i + 4];
        from.blossom(from.span(knots[0]), control, &knots[1..])
    };
    (0..to.functions()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Uv, Vector};
    use crate::spline::Surface;

    #[test]
    fn more_knots_leave_the_surface_as_it_was() {
        let breaks: Vec<f64> = (0..=50).map(|i| (f64::from(i) / 50.0).powf(1.3)).collect();
        let fine = KnotVector::clamped(3, &breaks, 1);
        let coarse = [merged(&fine), merged(&KnotVector::uniform(3, 33))];
        let count = coarse[0].functions() * coarse[1].functions();
        let net: Vec<Lane> = (0..count)
            .map(|i| Lane::new((i % 7) as f64, (i % 5) as f64, (i % 11) as f64, 0.0))
            .collect();
        let fine = [fine, KnotVector::uniform(3, 33)];
        let more = refined(net.clone(), &coarse, [&fine[0], &fine[1]]);
        let surface = |knots: &[KnotVector; 2], net: &[Lane]| {
            let net: Vec<Vector> = net.iter().map(|p| p.xyz()).collect();
            Surface::new(knots[0].clone(), knots[1].clone(), net)
        };
        let (before, after) = (surface(&coarse, &net), surface(&fine, &more));
        for i in 0..400 {
            let at = Uv::new(f64::from(i % 20) / 19.0, f64::from(i / 20) / 19.0);
            assert!((before.point(at) - after.point(at)).norm() < 1e-12, "{at}");
        }
    }
}
