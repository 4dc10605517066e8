//! The most likely surface through the points around a hole: a smoothing spline over a
//! chart.
//!
//! It minimises Σ |f(uᵢ) − pᵢ|² + λ₂ J₂(f) + λ₄ J₄(f), where Jₘ is the integral
//! over the chart of the squared m-th derivatives. J₂ is the thin-plate energy, which keeps
//! wide holes flat; J₄ is the energy of fourth order, which continues the curvature across
//! them. λ₂ and λ₄ are found by restricted maximum likelihood (REML; Wahba 1985, "A comparison
//! of GCV and GML for choosing the smoothing parameter", and Patterson & Thompson 1971), which
//! takes f for a random function and the deviations for independent. The spline interpolates
//! clean points, and averages noisy ones over as many as the shape allows.
//!
//! f is a quartic tensor-product B-spline on a uniform grid that covers the points and the
//! hole.

mod grid;
mod overlaps;
mod stiffness;

use crate::geometry::Uv;
use grid::Grid;
use stiffness::{Exponents, PenalizedSystem};

/// A grid is refined only if the finer one has no more than about this many functions, because
/// the time of the fit grows with the power 1.5 of their number.
const MOST_FUNCTIONS: usize = 4000;

/// With an exponent of at least this the energies smooth over more than a cell, so a finer
/// grid would give the same surface.
const FREE_OF_GRID: i32 = -8;

/// The energies of a spline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Energies {
    /// Those of both orders. The curvature continues across a hole.
    Both,
    /// That of second order. A surface that is known badly does not swing out.
    Second,
}

/// A smoothing spline with `D` components.
pub(crate) struct SmoothingSpline<const D: usize> {
    grid: Grid,
    /// The coefficients of the functions of the grid.
    coefficients: Vec<[f64; D]>,
}

impl<const D: usize> SmoothingSpline<D> {
    /// Fits `points` on a grid with cells of the width `cell`. The grid covers the points, the
    /// cells for whose centre and width `also` is true, and their neighbours. The energies
    /// shall smooth, not the grid: it is refined, down to cells of the width `narrowest`,
    /// until they do. `None` if there are too few points.
    pub(super) fn fit(
        points: &[(Uv, [f64; D])],
        also: impl Fn(Uv, f64) -> bool,
        mut cell: f64,
        narrowest: f64,
        energies: Energies,
    ) -> Option<Self> {
        let mut start = Exponents::first(energies);
        loop {
            let grid = Grid::new(points, &also, cell)?;
            let sample = grid.sample();
            let mut equations = PenalizedSystem::new(sample.as_ref().unwrap_or(&grid), points)?;
            let stiffness = equations.most_likely(start, energies)?;
            let finer = (0.5 * cell).max(narrowest);
            let is_free = stiffness.0.max(stiffness.1) >= FREE_OF_GRID;
            if is_free || finer > 0.99 * cell || 4 * grid.count > MOST_FUNCTIONS {
                if sample.is_some() {
                    equations = PenalizedSystem::new(&grid, points)?;
                }
                let coefficients = equations.coefficients(stiffness)?;
                return Some(SmoothingSpline { grid, coefficients });
            }
            // The same stiffness, on a grid of half the width.
            start = stiffness.on_half_the_width(energies);
            cell = finer;
        }
    }

    /// The value at `uv`, or `None` outside of the grid.
    pub(crate) fn at(&self, uv: Uv) -> Option<[f64; D]> {
        let (functions, values) = self.grid.functions(uv)?;
        let mut sum = [0.0; D];
        for (f, value) in functions.iter().zip(values) {
            for (s, c) in sum.iter_mut().zip(self.coefficients[*f as usize]) {
                *s += value * c;
            }
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(f: impl Fn(f64, f64) -> f64) -> Vec<(Uv, [f64; 1])> {
        let grid = (-40..=40).flat_map(|i| (-40..=40).map(move |j| (i, j)));
        let places = grid.map(|(i, j)| Uv::new(f64::from(i) / 20.0, f64::from(j) / 20.0));
        places.filter(|p| p.coords.norm() > 1.0).map(|p| (p, [f(p.x, p.y)])).collect()
    }

    fn inside() -> Vec<Uv> {
        let angle = |k: i32| 0.1 * f64::from(k);
        let at = |k: i32| Uv::new(angle(k).cos(), angle(k).sin()) * (0.016 * f64::from(k));
        (0..60).map(at).collect()
    }

    #[test]
    fn a_clean_surface_is_continued_over_the_hole() {
        let f = |x: f64, y: f64| (1.3 * x).sin() * (0.8 * y).cos();
        let spline =
            SmoothingSpline::fit(&ring(f), |p, _| p.coords.norm() < 1.0, 0.3, 0.1, Energies::Both)
                .unwrap();
        for p in inside() {
            let [z] = spline.at(p).unwrap();
            assert!((z - f(p.x, p.y)).abs() < 2e-3, "{p} {z} {}", f(p.x, p.y));
        }
    }

    #[test]
    fn noise_is_averaged() {
        let mut state = 7u64;
        let mut noise = || {
            let uniform = (0..12).map(|_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 33) as f64 / (1u64 << 31) as f64
            });
            0.05 * (uniform.sum::<f64>() - 6.0)
        };
        let f = |x: f64, y: f64| 0.3 * x * x - 0.2 * x * y;
        let mut points = ring(f);
        points.iter_mut().for_each(|p| p.1[0] += noise());
        let spline =
            SmoothingSpline::fit(&points, |p, _| p.coords.norm() < 1.0, 0.3, 0.1, Energies::Both)
                .unwrap();
        let squares = points.iter().map(|(p, z)| (spline.at(*p).unwrap()[0] - z[0]).powi(2));
        let deviation = (squares.sum::<f64>() / points.len() as f64).sqrt();
        assert!((deviation - 0.05).abs() < 0.005, "{deviation}");
        for p in inside() {
            let [z] = spline.at(p).unwrap();
            assert!((z - f(p.x, p.y)).abs() < 0.03, "{p} {z} {}", f(p.x, p.y));
        }
    }
}
