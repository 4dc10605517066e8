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

mod coupled;
mod jacobian;
mod system;
mod terms;
mod work;

use super::cells::Cells;
use super::tangent_distance::TangentDistance;
use crate::geometry::Uv;
use crate::spline::{Samples, Surface};
use jacobian::{JacobianSample, JacobianSamples};

pub use jacobian::count as jacobian_samples;
use work::Work;

/// Rounds at the most with one stiffness, and those among them in which samples that may
/// not slide hold the surface in all directions.
const ROUNDS: usize = 16;
const FIRM: usize = 8;

/// Rounds of a mend at the least: each takes half of the way, so that a sixty-fourth is left.
const MENDING: usize = 6;

/// Rounds after the first one without folds.
const SETTLING: usize = 3;

/// Weights of the thin-plate energy of a cell, of a mean cell's samples, one after the
/// other: the first takes out most folds, the last keeps closest to the samples.
pub const STIFFNESSES: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// What a surface with folds has become.
#[derive(Debug)]
pub struct Unfolded {
    /// Places that were turned over, of 36 in each cell, each looked at around it, too,
    /// where the surface spreads little.
    pub before: usize,
    /// Surfaces with fewer of them, each closer to the samples than those before.
    pub found: Vec<UnfoldedSurface>,
}

/// A surface with fewer folds.
#[derive(Debug)]
pub struct UnfoldedSurface {
    /// The surface.
    pub surface: Surface,
    /// The samples' parameters on it.
    pub uv: Vec<Uv>,
    /// Places that are turned over.
    pub folds: usize,
}

/// Takes the samples' parameters and those that they should move to, and says which they
/// may move to.
pub type Slide<'a> = dyn Fn(Vec<Uv>, Vec<Uv>) -> Vec<Uv> + 'a;

/// The share of a surface's places that are turned over.
pub fn inverted_share(surface: &Surface, samples: &Samples, holds: &[TangentDistance]) -> f64 {
    let inverted = inverted_samples(surface, samples, holds);
    inverted as f64 / jacobian_samples([&surface.u, &surface.v]) as f64
}

/// How many of a surface's places are turned over.
pub fn inverted_samples(surface: &Surface, samples: &Samples, holds: &[TangentDistance]) -> usize {
    let cells = Cells::new(samples, [&surface.u, &surface.v]);
    let places = JacobianSamples::new(&cells, holds, &surface.net);
    inverted_among(&places.spots(&surface.net, |_, _| true))
}

/// Takes folds out of a surface that was fitted to samples, with one of `stiffnesses`
/// after the other. Samples that may not `slide` hold it in all directions, as far as
/// folds do not stay for that.
pub fn unfold(
    surface: &Surface,
    samples: &Samples,
    holds: &[TangentDistance],
    slide: &Slide,
    stiffnesses: &[f64],
) -> Unfolded {
    let cells = Cells::new(samples, [&surface.u, &surface.v]);
    let places = JacobianSamples::new(&cells, holds, &surface.net);
    let spots = places.spots(&surface.net, |_, _| true);
    let before = inverted_among(&spots);
    if before == 0 {
        return Unfolded { before, found: Vec::new() };
    }
    let mut work = Work::new(surface, &cells, holds);
    let mut soften = Soften { places: &places, spots, slide };
    let found = stiffnesses.iter().map_while(|&stiffness| soften.step(&mut work, stiffness));
    Unfolded { before, found: found.filter(|found| found.folds < before).collect() }
}

/// What a surface is mended by.
pub struct Mending<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// What it is to be nearer to.
    pub samples: &'a Samples,
    /// The first of these, by which it is told where the surface is turned over.
    pub vertices: &'a Samples,
    /// How the samples hold it.
    pub holds: &'a [TangentDistance],
    /// Where they may move to.
    pub slide: &'a Slide<'a>,
    /// Where it is mended.
    pub around: &'a [Uv],
}

/// Brings a surface nearer to its samples around some parameter points, where it is to have
/// no more places that are turned over than before. Only the control points around these
/// points move, and those around folds that this makes. `None` if it cannot be.
pub fn mend(of: &Mending, stiffness: f64) -> Option<UnfoldedSurface> {
    let knots = [&of.surface.u, &of.surface.v];
    let cells = Cells::new(of.samples, knots);
    let seen = Cells::new(of.vertices, knots);
    let places = JacobianSamples::new(&seen, &of.holds[..of.vertices.len()], &of.surface.net);
    let mut work = Work::new(of.surface, &cells, of.holds);
    work.free_around(of.around);
    let mut spots = places.spots(&of.surface.net, |p, q| work.touches(p, q));
    let before = inverted_among(&spots);
    let mut best = None;
    for round in 0..ROUNDS {
        work.round(stiffness, &spots, of.slide)?;
        spots = places.spots(&work.surface.net, |p, q| work.touches(p, q));
        let folds = inverted_among(&spots);
        if folds > before {
            work.widen(&spots);
            continue;
        }
        best = Some(UnfoldedSurface { surface: work.surface.clone(), uv: work.uv.clone(), folds });
        if round + 1 >= MENDING {
            break;
        }
    }
    best
}

/// Folds on their way out.
struct Soften<'a> {
    places: &'a JacobianSamples<'a>,
    spots: Vec<JacobianSample>,
    slide: &'a Slide<'a>,
}

impl Soften<'_> {
    /// Rounds with one stiffness, and the best that came of them; `None` if nothing did.
    fn step(&mut self, work: &mut Work, stiffness: f64) -> Option<UnfoldedSurface> {
        let mut best: Option<UnfoldedSurface> = None;
        let mut last = ROUNDS;
        let mut round = 0;
        while round < last {
            work.widen(&self.spots);
            if round >= FIRM {
                work.ease(&self.spots);
            }
            round += 1;
            if work.round(stiffness, &self.spots, self.slide).is_none() {
                break;
            }
            self.spots = self.places.spots(&work.surface.net, |p, q| work.touches(p, q));
            let folds = inverted_among(&self.spots);
            if folds == 0 && best.as_ref().is_none_or(|best| best.folds > 0) {
                last = last.min(round + SETTLING);
            }
            // Later ones are closer to the samples.
            if best.as_ref().is_none_or(|best| folds <= best.folds) {
                best = Some(UnfoldedSurface {
                    surface: work.surface.clone(),
                    uv: work.uv.clone(),
                    folds,
                });
            }
        }
        best
    }
}

fn inverted_among(spots: &[JacobianSample]) -> usize {
    spots.iter().filter(|s| s.is_inverted()).count()
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::spline::KnotVector;

    /// A bump over the unit square with samples all over it, and two rows of its net pushed
    /// towards each other along the surface in the middle.
    fn folded(push: f64, rows: [usize; 2]) -> (Surface, Samples, Vec<TangentDistance>) {
        let knots = KnotVector::uniform(3, 20);
        let height = |x: f64, y: f64| 4.0 * (3.0 * x).sin() * (2.0 * y).cos();
        let at = |n: usize| (knots.greville(n / 20), knots.greville(n % 20));
        let control = |(x, y): (f64, f64)| Vector::new(50.0 * x, 50.0 * y, height(x, y));
        let mut net: Vec<Vector> = (0..400).map(|n| control(at(n))).collect();
        net[rows[0] * 20 + 10].x += push;
        net[rows[1] * 20 + 10].x -= push;
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
            holds.push(TangentDistance { normal, metric, moves: edge.map(|edge| !edge) });
        }
        (surface, samples, holds)
    }

    #[test]
    fn a_fold_is_taken_out_and_the_shape_stays() {
        let (surface, samples, holds) = folded(6.0, [9, 11]);
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let mut done = unfold(&surface, &samples, &holds, &slide, &STIFFNESSES);
        let UnfoldedSurface { surface: flat, uv, folds } = done.found.swap_remove(0);
        assert!(done.before > 0 && folds == 0, "{} {folds}", done.before);
        let off = |(uv, p): (&Uv, &Point)| (flat.point(*uv) - p).norm();
        let worst = uv.iter().zip(&samples.points).map(off).fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
        for n in 0..10_000 {
            let jet = flat.jet(Uv::new((n / 100) as f64 / 99.0, (n % 100) as f64 / 99.0));
            assert!(jet.su.cross(&jet.sv).z > 0.0, "{n}");
        }
    }

    #[test]
    fn a_surface_is_mended_around_a_place_and_stays_elsewhere() {
        let (surface, samples, holds) = folded(0.0, [9, 11]);
        let mut dented = surface.clone();
        dented.net[9 * 20 + 10].z += 1.0;
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let at = Uv::new(dented.u.greville(9), dented.v.greville(10));
        let of = Mending {
            surface: &dented,
            samples: &samples,
            vertices: &samples,
            holds: &holds,
            slide: &slide,
            around: &[at],
        };
        let mended = mend(&of, STIFFNESSES[2]).unwrap();
        let off = |of: &Surface| (of.point(at) - surface.point(at)).norm();
        assert!(off(&mended.surface) < 0.1 * off(&dented), "{}", off(&mended.surface));
        assert_eq!(mended.folds, 0);
        // Four rows and columns around the cell move, and the four that reach into it.
        for n in (0..400).filter(|n| (n / 20_usize).abs_diff(8) > 8) {
            assert_eq!(mended.surface.net[n], dented.net[n], "{n}");
        }
    }

    #[test]
    fn a_fold_narrower_than_places_are_apart_is_found() {
        for (push, turns) in [(3.3, false), (3.55, true)] {
            let (surface, samples, holds) = folded(push, [9, 10]);
            let turned = |n: usize| {
                let [u, v] = [n / 200, n % 200].map(|k| 0.4 + 0.001 * k as f64);
                let jet = surface.jet(Uv::new(u, v));
                jet.su.cross(&jet.sv).z < 0.0
            };
            assert_eq!((0..40_000).any(turned), turns, "{push}");
            assert_eq!(super::inverted_share(&surface, &samples, &holds) > 0.0, turns, "{push}");
        }
    }

    #[test]
    fn a_surface_without_folds_stays() {
        let (surface, samples, holds) = folded(0.0, [9, 11]);
        let slide = |_: Vec<Uv>, wanted: Vec<Uv>| wanted;
        let done = unfold(&surface, &samples, &holds, &slide, &STIFFNESSES);
        assert!(done.before == 0 && done.found.is_empty());
    }

    #[test]
    fn samples_that_may_not_slide_hold_the_surface() {
        let (surface, samples, holds) = folded(6.0, [9, 11]);
        let stay = |now: Vec<Uv>, _: Vec<Uv>| now;
        let mut done = unfold(&surface, &samples, &holds, &stay, &STIFFNESSES);
        let UnfoldedSurface { surface: flat, uv, .. } = done.found.swap_remove(0);
        assert_eq!(uv, samples.uv);
        let off = |(uv, p): (&Uv, &Point)| (flat.point(*uv) - p).norm();
        let worst = uv.iter().zip(&samples.points).map(off).fold(0.0, f64::max);
        assert!(worst < 0.2, "{worst}");
    }
}
