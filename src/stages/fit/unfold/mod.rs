//! Removal of folds from a fitted surface.
//!
//! The input is a surface, its samples and their tangent-distance terms. The output is surfaces
//! with fewer folds, each closer to the samples than the one before.
//!
//! Where there are fewer samples than control points, or where the map is narrow, a surface that
//! follows the samples closely may fold back over itself within a knot span. Its normals are
//! inverted there although no sample is far from it. CAD systems offset such a face to both of its
//! sides. Plain least squares constrain the surface more than the samples do: a sample holds the
//! surface in the normal direction, but it may slide along it (tangent distance minimization: Wang,
//! Pottmann, Liu 2006). This freedom is enough to spread the control points around a fold until the
//! fold is gone.
//!
//! Only control points near folds move. Each round is a Gauss–Newton step on three terms: the
//! tangent distances of the samples, a thin-plate energy, and the squares by which Jacobian
//! determinants fall short of a least value.

mod coupled;
mod jacobian;
mod system;
mod terms;
mod work;

use super::knot_cells::KnotCells;
use super::tangent_distance::TangentDistance;
use crate::geometry::Uv;
use crate::spline::{Samples, Surface};
use jacobian::{JacobianSample, JacobianSamples};

pub(crate) use jacobian::count as jacobian_samples;
use work::Work;

/// The largest number of rounds with one stiffness. In half of them samples that may not slide hold the
/// surface in all directions.
const MAX_ROUNDS: usize = 16;

/// The least number of rounds of a mend. Each round takes half of a step, so that a sixty-fourth of
/// the way is left.
const MIN_MENDING: usize = 6;

/// The number of rounds after the first round without folds. They bring the surface closer to the
/// samples.
const SETTLING: usize = 3;

/// Weights of the thin-plate energy of a cell, relative to the samples of a mean cell. They are
/// used one after the other. The first removes most folds, and the last stays closest to the
/// samples.
pub(crate) const STIFFNESSES: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// The result of [`unfold`].
#[derive(Debug)]
pub(crate) struct Unfolded {
    /// The number of inverted Jacobian samples of the original surface. There are 36 samples in
    /// each cell. Around a sample with a small Jacobian determinant, finer samples are tested, too.
    pub before: usize,
    /// Surfaces with fewer inverted samples. Each one is closer to the samples than the one before.
    pub found: Vec<UnfoldedSurface>,
}

/// A surface with fewer folds.
#[derive(Debug)]
pub(crate) struct UnfoldedSurface {
    /// The surface.
    pub surface: Surface,
    /// The parameters of the samples on the surface.
    pub uv: Vec<Uv>,
    /// The number of inverted Jacobian samples.
    pub folds: usize,
}

/// A function that takes the current and the wanted parameters of the samples and returns the
/// parameters that they may have. It keeps the map of the samples from folding.
pub(crate) type Slide<'a> = dyn Fn(Vec<Uv>, Vec<Uv>) -> Vec<Uv> + 'a;

/// The share of a surface's Jacobian samples that are inverted.
pub(crate) fn inverted_share(
    surface: &Surface,
    samples: &Samples,
    holds: &[TangentDistance],
) -> f64 {
    let inverted = inverted_samples(surface, samples, holds);
    inverted as f64 / jacobian_samples([&surface.u, &surface.v]) as f64
}

/// The number of a surface's Jacobian samples that are inverted.
pub(crate) fn inverted_samples(
    surface: &Surface,
    samples: &Samples,
    holds: &[TangentDistance],
) -> usize {
    let cells = KnotCells::new(samples, [&surface.u, &surface.v]);
    let jacobians = JacobianSamples::new(&cells, holds, &surface.net);
    inverted_among(&jacobians.flagged(&surface.net, |_, _| true))
}

/// Removes folds from a surface that was fitted to samples. It uses the `stiffnesses` one after the
/// other. Samples that `slide` does not let move hold the surface in all directions, unless a fold
/// remains because of that.
pub(crate) fn unfold(
    surface: &Surface,
    samples: &Samples,
    holds: &[TangentDistance],
    slide: &Slide,
    stiffnesses: &[f64],
) -> Unfolded {
    let cells = KnotCells::new(samples, [&surface.u, &surface.v]);
    let jacobians = JacobianSamples::new(&cells, holds, &surface.net);
    let flagged = jacobians.flagged(&surface.net, |_, _| true);
    let before = inverted_among(&flagged);
    if before == 0 {
        return Unfolded { before, found: Vec::new() };
    }
    let mut work = Work::new(surface, &cells, holds);
    let mut removal = FoldRemoval { jacobians: &jacobians, flagged, slide };
    let found = stiffnesses.iter().map_while(|&stiffness| removal.step(&mut work, stiffness));
    Unfolded { before, found: found.filter(|found| found.folds < before).collect() }
}

/// The input of [`mend`].
pub(crate) struct Mending<'a> {
    /// The surface.
    pub surface: &'a Surface,
    /// The samples that the surface should be nearer to.
    pub samples: &'a Samples,
    /// The first of the samples. Their normals decide where the surface is inverted.
    pub vertices: &'a Samples,
    /// The tangent-distance terms of the samples.
    pub holds: &'a [TangentDistance],
    /// Decides to which parameters the samples may move.
    pub slide: &'a Slide<'a>,
    /// The parameter points around which the surface is mended.
    pub around: &'a [Uv],
}

/// Brings a surface nearer to its samples around some parameter points. The result has no more
/// inverted Jacobian samples than before. Only the control points around these points move, and
/// those around new folds. `None` if this is not possible.
pub(crate) fn mend(of: &Mending, stiffness: f64) -> Option<UnfoldedSurface> {
    let knots = [&of.surface.u, &of.surface.v];
    let cells = KnotCells::new(of.samples, knots);
    let seen = KnotCells::new(of.vertices, knots);
    let jacobians = JacobianSamples::new(&seen, &of.holds[..of.vertices.len()], &of.surface.net);
    let mut work = Work::new(of.surface, &cells, of.holds);
    work.free_around(of.around);
    let mut flagged = jacobians.flagged(&of.surface.net, |p, q| work.touches(p, q));
    let before = inverted_among(&flagged);
    let mut best = None;
    for round in 0..MAX_ROUNDS {
        work.round(stiffness, &flagged, of.slide)?;
        flagged = jacobians.flagged(&work.surface.net, |p, q| work.touches(p, q));
        let folds = inverted_among(&flagged);
        if folds > before {
            work.widen(&flagged);
            continue;
        }
        best = Some(UnfoldedSurface { surface: work.surface.clone(), uv: work.uv.clone(), folds });
        if round + 1 >= MIN_MENDING {
            break;
        }
    }
    best
}

/// The state of the removal of folds.
struct FoldRemoval<'a> {
    jacobians: &'a JacobianSamples<'a>,
    flagged: Vec<JacobianSample>,
    slide: &'a Slide<'a>,
}

impl FoldRemoval<'_> {
    /// Runs rounds with one stiffness and returns the best surface. `None` if there is none.
    fn step(&mut self, work: &mut Work, stiffness: f64) -> Option<UnfoldedSurface> {
        let mut best: Option<UnfoldedSurface> = None;
        let mut last = MAX_ROUNDS;
        let mut round = 0;
        while round < last {
            work.widen(&self.flagged);
            if round >= MAX_ROUNDS / 2 {
                work.ease(&self.flagged);
            }
            round += 1;
            if work.round(stiffness, &self.flagged, self.slide).is_none() {
                break;
            }
            self.flagged = self.jacobians.flagged(&work.surface.net, |p, q| work.touches(p, q));
            let folds = inverted_among(&self.flagged);
            if folds == 0 && best.as_ref().is_none_or(|best| best.folds > 0) {
                last = last.min(round + SETTLING);
            }
            // Later surfaces are closer to the samples.
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

fn inverted_among(flagged: &[JacobianSample]) -> usize {
    flagged.iter().filter(|s| s.is_inverted()).count()
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::spline::KnotVector;

    /// A bump over the unit square with samples everywhere. In the middle, two rows of its net are
    /// pushed towards each other along the surface.
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
        // The four rows and columns of the cell move, and four more on each side.
        for n in (0..400).filter(|n| (n / 20_usize).abs_diff(8) > 8) {
            assert_eq!(mended.surface.net[n], dented.net[n], "{n}");
        }
    }

    #[test]
    fn a_fold_narrower_than_the_distance_of_samples_is_found() {
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
