//! Taking folds out of a fitted surface.
//!
//! Where samples are fewer than control points, or where the map is thin, a surface
//! that follows them closely may run back over itself within a knot span: its
//! normals turn over, though no sample is far from it. CAD systems offset such a
//! face to both of its sides. Samples say less than least squares take from them:
//! across the surface they hold it, along it they might slide (tangent distance
//! minimization: Wang, Pottmann, Liu, 2006). That leaves room enough to spread the
//! control points around a fold until none is left.
//!
//! Only control points near folds move. Each round is a Gauss–Newton step on the
//! samples' distances, across with full weight and along with little of it, a
//! thin-plate energy, and the squares of what the surface spreads too little.

mod places;
mod system;
mod work;

use super::cells::Cells;
use super::hold::Hold;
use crate::geometry::Uv;
use crate::spline::{Samples, Surface};
use places::{Places, Spot};
use work::Work;

/// Rounds at the most.
const ROUNDS: usize = 20;

/// Rounds after the first one without folds.
const SETTLING: usize = 3;

/// Weights of the thin-plate energy of a cell, of a mean cell's samples, to be tried in
/// turn: the first takes out most folds, the last keeps closest to the samples.
pub const STIFFNESSES: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// A surface with fewer folds.
#[derive(Debug)]
pub struct Unfolded {
    /// The surface, and the samples' parameters on it; `None` if there were no folds, or
    /// none could be taken out.
    pub found: Option<(Surface, Vec<Uv>)>,
    /// Places that were turned over, of 36 looked at in each cell.
    pub before: usize,
    /// Places that still are.
    pub after: usize,
}

/// Takes the samples' parameters and those that they should move to, and says which they
/// may move to.
pub type Slide<'a> = dyn Fn(Vec<Uv>, Vec<Uv>) -> Vec<Uv> + 'a;

/// Takes folds out of a surface that was fitted to samples, with one of the
/// [`STIFFNESSES`]. Samples that may not `slide` hold it in all directions.
pub fn unfold(
    surface: &Surface,
    samples: &Samples,
    holds: &[Hold],
    stiffness: f64,
    slide: &Slide,
) -> Unfolded {
    let cells = Cells::new(samples, [&surface.u, &surface.v]);
    let places = Places::new(&cells, holds, &surface.net);
    let mut spots = places.spots(&surface.net, |_, _| true);
    let before = turned(&spots);
    let mut best = Unfolded { found: None, before, after: before };
    if before == 0 {
        return best;
    }
    let mut work = Work::new(surface, &cells, holds, stiffness);
    let mut rounds = ROUNDS;
    while rounds > 0 {
        rounds -= 1;
        work.widen(&spots);
        if work.round(&spots, slide).is_none() {
            break;
        }
        spots = places.spots(&work.surface.net, |p, q| work.touches(p, q));
        let after = turned(&spots);
        if after == 0 && best.after > 0 {
            rounds = rounds.min(SETTLING);
        }
        // Later ones are closer to the samples.
        if after <= best.after {
            let found = Some((work.surface.clone(), work.uv.clone()));
            best = Unfolded { found, before, after };
        }
    }
    best
}

fn turned(spots: &[Spot]) -> usize {
    spots.iter().filter(|s| s.is_turned()).count()
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::spline::KnotVector;

    /// A bump over the unit square with samples all over it, and its net pushed back
    /// over itself along the surface in the middle.
    fn folded(push: f64) -> (Surface, Samples, Vec<Hold>) {
        let knots = KnotVector::uniform(3, 20);
        let height = |x: f64, y: f64| 4.0 * (3.0 * x).sin() * (2.0 * y).cos();
        let at = |n: usize| (knots.greville(n / 20), knots.greville(n % 20));
        let control = |(x, y): (f64, f64)| Vector::new(50.0 * x, 50.0 * y, height(x, y));
        let mut net: Vec<Vector> = (0..400).map(|n| control(at(n))).collect();
        net[9 * 20 + 10].x += push;
        net[11 * 20 + 10].x -= push;
        let surface = Surface::new(knots.clone(), knots.clone(), net);
        let (mut samples, mut holds) = (Samples::default(), Vec::new());
        for (x, y) in (0..1600).map(|n| ((n / 40) as f64 / 39.0, (n % 40) as f64 / 39.0)) {
            samples.points.push(Point::from(control((x, y))));
            samples.uv.push(Uv::new(x, y));
            samples.weights.push(1.0);
            let slopes = [
                Vector::new(50.0, 0.0, 12.0 * (3.0 * x).cos() * (2.0 * y).cos()),
                Vector::new(0.0, 50.0, -8.0 * (3.0 * x).sin() * (2.0 * y).sin()),
            ];
            let normal = slopes[0].cross(&slopes[1]).normalize();
            let edge = [x, y].map(|t| t == 0.0 || t == 1.0);
            let metric =
                if edge[0] || edge[1] { Matrix3::identity() } else { normal * normal.transpose() };
            holds.push(Hold { normal, metric, moves: edge.map(|edge| !edge) });
        }
        (surface, samples, holds)
    }

    #[test]
    fn a_fold_is_taken_out_and_the_shape_stays() {
        let (surface, samples, holds) = folded(6.0);
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let done = unfold(&surface, &samples, &holds, STIFFNESSES[0], &slide);
        assert!(done.before > 0 && done.after == 0, "{} {}", done.before, done.after);
        let (flat, uv) = done.found.unwrap();
        let off = |(uv, p): (&Uv, &Point)| (flat.point(*uv) - p).norm();
        let worst = uv.iter().zip(&samples.points).map(off).fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
        for n in 0..10_000 {
            let jet = flat.jet(Uv::new((n / 100) as f64 / 99.0, (n % 100) as f64 / 99.0));
            assert!(jet.su.cross(&jet.sv).z > 0.0, "{n}");
        }
    }

    #[test]
    fn a_surface_without_folds_stays() {
        let (surface, samples, holds) = folded(0.0);
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let done = unfold(&surface, &samples, &holds, STIFFNESSES[0], &slide);
        assert!(done.before == 0 && done.after == 0 && done.found.is_none());
    }

    #[test]
    fn samples_that_may_not_slide_hold_the_surface() {
        let (surface, samples, holds) = folded(6.0);
        let stay = |now: Vec<Uv>, _: Vec<Uv>| now;
        let done = unfold(&surface, &samples, &holds, STIFFNESSES[0], &stay);
        let (flat, uv) = done.found.unwrap();
        assert_eq!(uv, samples.uv);
        let off = |(uv, p): (&Uv, &Point)| (flat.point(*uv) - p).norm();
        let worst = uv.iter().zip(&samples.points).map(off).fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
    }
}
