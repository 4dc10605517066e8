//! Fit of a bicubic B-spline surface to points with parameters.
//!
//! The input is samples with parameters and weights, and two knot vectors. The output is the
//! surface. There are three methods: blended local fits (Tekumalla and Cohen 2005, section 3.5),
//! the global least-squares fit by a sparse direct solver, and the same least-squares problem
//! solved by preconditioned conjugate gradients.

mod blend;
mod conjugate;
mod fairing;
mod knot_cells;
mod moments;
mod normal;
mod precondition;
mod start;
mod strips;
mod tangent_distance;
mod unfold;
mod weight;

use knot_cells::KnotCells;
use normal::{NormalEquations, PaddedPoint};
use precondition::Preconditioner;
use weight::Metric;

pub(crate) use tangent_distance::TangentDistance;
pub(crate) use unfold::{
    Mending, STIFFNESSES, UnfoldedSurface, inverted_samples, inverted_share, jacobian_samples,
    mend, unfold,
};

use crate::error::{Error, Result};
use crate::geometry::BLOCK;
use crate::spline::{KnotVector, Samples, Surface};
use rayon::prelude::*;

/// The method of the fit. The default is [`Method::Refined`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Blended local fits (Tekumalla and Cohen 2005). They are the fastest and the least accurate.
    Blend,
    /// Least squares by conjugate gradients. The error is within 0.1 % of the optimum.
    #[default]
    Refined,
    /// Least squares by a sparse direct solver. It needs the most time and memory.
    Global,
}

/// The result of a fit besides the surface.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Report {
    /// The method that was used.
    pub method: Method,
    /// The number of steps of conjugate gradients. It is 0 for the other methods.
    pub steps: usize,
}

/// Fits a surface over the given knot vectors in u and v. Both must be cubic.
///
/// # Errors
/// [`Error::Empty`] if there are no samples. [`Error::Input`] if a knot vector is not cubic or the
/// samples are invalid. [`Error::Singular`] if the equations have no solution.
pub fn fit(samples: &Samples, knots: [KnotVector; 2], method: Method) -> Result<(Surface, Report)> {
    samples.check()?;
    let [u, v] = knots;
    if [&u, &v].iter().any(|k| k.degree() != 3) {
        return Err(Error::Input("a knot vector is not cubic"));
    }
    let cells = KnotCells::new(samples, [&u, &v]);
    let (net, steps) = match method {
        Method::Blend => blend(&cells)?,
        Method::Refined => optimum(&NormalEquations::new(&cells), &cells)?,
        Method::Global => (NormalEquations::new(&cells).solve_directly()?, 0),
    };
    let net = net.iter().map(|p| p.xyz() + cells.origin).collect();
    let surface = Surface::new(u, v, net);
    Ok((surface, Report { method, steps }))
}

/// Fits a surface again with tangent distances (Wang, Pottmann, Liu 2006): distances normal to the
/// surface count fully, and distances along it count little, so that samples may slide. This is
/// one Gauss–Newton step that the tangential distances damp. For `stuck` samples the distances in
/// all directions count fully. `None` if the equations have no solution.
pub(crate) fn refit(
    surface: &Surface,
    samples: &Samples,
    holds: &[TangentDistance],
    stuck: &[bool],
) -> Option<Surface> {
    let metric = |(hold, &stuck): (&TangentDistance, &bool)| Metric::from(&hold.of(stuck));
    let metrics: Vec<Metric> = holds.par_iter().zip(stuck).map(metric).collect();
    let cells = KnotCells::new(samples, [&surface.u, &surface.v]).with_metrics(&metrics);
    let equations = NormalEquations::<Metric>::new(&cells);
    let even = equations.mean();
    let inverse = match Preconditioner::new(&even, &cells.spans).ok()? {
        Some(inverse) => inverse,
        None => Preconditioner::direct(&even).ok()?,
    };
    let start = surface.net.iter().map(|p| (p - cells.origin).push(0.0)).collect();
    let (net, ..) = conjugate::improve(&equations, &inverse, start)?;
    let net = net.iter().map(|p| p.xyz() + cells.origin).collect();
    Some(Surface::new(surface.u.clone(), surface.v.clone(), net))
}

/// The mean distance in mm between the samples and the surface at their parameters.
pub fn mean_error(surface: &Surface, samples: &Samples) -> f64 {
    let at = samples.uv.par_iter().zip(&samples.points);
    let off: Vec<f64> = at.map(|(&at, p)| (surface.point(at) - p).norm()).collect();
    off.iter().sum::<f64>() / off.len().max(1) as f64
}

/// Blended local fits. The fairing term determines the control points that have no samples.
fn blend(cells: &KnotCells) -> Result<(Vec<PaddedPoint>, usize)> {
    let (net, weights) = blend::fit(cells);
    if weights.iter().all(|&w| w > 0.0) {
        return Ok((net, 0));
    }
    optimum(&NormalEquations::holding(&net, &weights, cells), cells)
}

/// The solution by conjugate gradients, or by the direct solver if they take too many steps.
fn optimum(equations: &NormalEquations, cells: &KnotCells) -> Result<(Vec<PaddedPoint>, usize)> {
    let inverse = Preconditioner::new(equations, &cells.spans)?;
    let solve = |inverse| conjugate::solve(equations, &inverse, start::of(cells));
    match inverse.and_then(solve) {
        Some(solution) => Ok(solution),
        None => Ok((equations.solve_directly()?, 0)),
    }
}

/// The number of rows of `width` control points that a task processes.
fn tasks(width: usize) -> usize {
    (BLOCK / width).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Uv, Vector};
    use crate::spline::foot_point;

    fn wavy() -> Samples {
        let at = |i: usize| (i as f64 + 0.5) / 60.0;
        let mut s = Samples::default();
        for (u, v) in (0..3600).map(|i| (at(i / 60), at(i % 60))) {
            s.points.push(Point::new(100.0 * u, 80.0 * v, 4.0 * (6.0 * u).sin() * (5.0 * v).cos()));
            s.uv.push(Uv::new(u, v));
            s.weights.push(1.0);
        }
        s
    }

    fn uneven(n: usize) -> KnotVector {
        let breaks: Vec<f64> = (0..=n).map(|i| (i as f64 / n as f64).powf(1.4)).collect();
        KnotVector::clamped(3, &breaks, 1)
    }

    #[test]
    fn every_method_reproduces_a_spline_of_its_space() {
        let mut s = wavy();
        let knots = [uneven(5), uneven(7)];
        let (truth, _) = fit(&s, knots.clone(), Method::Global).unwrap();
        // The fairing term moves the surface by some 1e-5 of its relief.
        s.points = s.uv.iter().map(|&at| truth.point(at)).collect();
        for (method, limit) in [(Method::Global, 1e-4), (Method::Refined, 1e-4)] {
            let (surface, _) = fit(&s, knots.clone(), method).unwrap();
            let error = mean_error(&surface, &s);
            assert!(error < limit, "{method:?} {error}");
        }
        // One pass of blending reproduces a bicubic polynomial, not a spline.
        s.points = s.uv.iter().map(|&a| Point::new(a.x, a.y, a.x.powi(3) * a.y.powi(2))).collect();
        let (surface, _) = fit(&s, knots, Method::Blend).unwrap();
        assert!(mean_error(&surface, &s) < 1e-7);
    }

    #[test]
    fn refined_is_the_global_optimum() {
        let s = wavy();
        let error = |m| mean_error(&fit(&s, [uneven(9), uneven(9)], m).unwrap().0, &s);
        let (blend, refined, global) =
            (error(Method::Blend), error(Method::Refined), error(Method::Global));
        assert!((refined / global - 1.0).abs() < 1e-3, "{refined} {global}");
        assert!(blend >= global, "{blend} {global}");
    }

    /// The root mean square distance between the samples and their foot points.
    fn off(surface: &Surface, s: &Samples) -> f64 {
        let squares =
            s.points.iter().zip(&s.uv).map(|(&p, &at)| foot_point(surface, p, at).1.powi(2));
        (squares.sum::<f64>() / s.len() as f64).sqrt()
    }

    #[test]
    fn samples_that_slide_are_followed_closer() {
        // A map that runs unevenly over a smooth sheet.
        let mut s = wavy();
        for at in &mut s.uv {
            let (u, v) = (at.x, at.y);
            *at = Uv::new(u + 0.01 * (40.0 * u).sin(), v + 0.01 * (37.0 * (u + v)).sin());
            *at = at.map(|t| t.clamp(0.0, 1.0));
        }
        let (first, _) = fit(&s, [uneven(9), uneven(9)], Method::Refined).unwrap();
        let normal = |p: &Point| {
            let (u, v) = (p.x / 100.0, p.y / 80.0);
            let slope = [
                0.24 * (6.0 * u).cos() * (5.0 * v).cos(),
                -0.25 * (6.0 * u).sin() * (5.0 * v).sin(),
            ];
            Vector::new(-slope[0], -slope[1], 1.0).normalize()
        };
        let hold = |p: &Point| {
            let normal = normal(p);
            TangentDistance { normal, metric: normal * normal.transpose(), moves: [true; 2] }
        };
        let holds: Vec<TangentDistance> = s.points.iter().map(hold).collect();
        s.uv = s.points.iter().zip(&s.uv).map(|(&p, &at)| foot_point(&first, p, at).0).collect();
        let refitted = |stuck: bool| {
            let stuck = vec![stuck; s.len()];
            off(&refit(&first, &s, &holds, &stuck).unwrap(), &s)
        };
        let (again, _) = fit(&s, [uneven(9), uneven(9)], Method::Refined).unwrap();
        let (plain, stuck, slid) = (off(&again, &s), refitted(true), refitted(false));
        assert!((stuck / plain - 1.0).abs() < 0.01, "{stuck} {plain}");
        assert!(slid < 0.95 * plain, "{slid} {plain}");
    }

    #[test]
    fn cells_without_points_are_bridged() {
        let s = wavy();
        let mut sparse = Samples::default();
        for i in 0..s.len() {
            if (s.uv[i] - Uv::new(0.5, 0.5)).norm() > 0.25 {
                sparse.points.push(s.points[i]);
                sparse.uv.push(s.uv[i]);
                sparse.weights.push(1.0);
            }
        }
        for method in [Method::Blend, Method::Refined, Method::Global] {
            let (surface, _) = fit(&sparse, [uneven(12), uneven(12)], method).unwrap();
            let p = surface.point(Uv::new(0.5, 0.5));
            assert!((p - Point::new(50.0, 40.0, 0.0)).norm() < 12.0, "{method:?}: {p}");
        }
    }
}
