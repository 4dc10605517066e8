//! Knot placement by hierarchical subdivision (Tekumalla & Cohen 2005, section 3.4). Points with
//! parameters go in; the knot vectors of a bicubic surface come out.
//!
//! A region of the domain is halved in u and v until a bicubic polynomial fits its points with a
//! mean error of at most κ, or until a depth is reached. The sides of all regions, extended across
//! the domain, are the knots. After a fit, `insert` adds knots where more are needed and
//! `remove` removes those with little effect.

mod change;
mod jumps;

use std::collections::BTreeSet;

use nalgebra::{Matrix3xX, SMatrix, SVector};
use rayon::prelude::*;

use crate::geometry::{BLOCK, Uv, Vector, uv_bounds};
use crate::spline::{KnotVector, Samples};

pub(crate) use change::{InsertionLimits, Miss, insert, remove};

/// The options of knot placement.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// The κ of the paper, in mm: a region is not divided if the mean Euclidean distance of its
    /// points from its polynomial is at most this. A value below the noise divides every region
    /// down to `depth`; a large value leaves details unresolved.
    pub kappa: f64,
    /// The largest number of halvings; 0 leaves a single region. Each further halving may double
    /// the number of knots in both directions.
    pub depth: u32,
}

/// The result of knot placement.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The number of regions that were not divided further.
    pub regions: usize,
    /// The number of these regions whose mean error exceeds κ.
    pub above_kappa: usize,
    /// The largest number of halvings that was made.
    pub depth: u32,
}

/// Regions with fewer points than this are not divided. A bicubic polynomial has 16 coefficients,
/// so it would nearly interpolate fewer points.
const MIN_POINTS: usize = 32;

/// Places the knots of a bicubic surface over [0, 1]², first in u, then in v.
pub fn place(samples: &Samples, options: &Options) -> ([KnotVector; 2], Report) {
    let mut points: Vec<ParameterPoint> =
        samples.uv.par_iter().zip(&samples.points).map(|(&uv, p)| (uv, p.coords)).collect();
    let root = Region { low: Uv::origin(), size: 1.0, depth: 0 };
    let division = divide(&mut points, root, options);
    let report = Report {
        regions: division.regions,
        above_kappa: division.above_kappa,
        depth: division.depth,
    };
    let [low, high] = uv_bounds(&samples.uv);
    let knots = [0, 1].map(|axis| {
        let unit = (1u64 << MAX_DEPTH) as f64;
        let inner = division.cuts[axis].iter().map(|&c| c as f64 / unit);
        // Outside the range of the points the surface is only extrapolated.
        let inner = inner.filter(|&c| low[axis] < c && c < high[axis]);
        let breaks: Vec<f64> =
            std::iter::once(0.0).chain(inner).chain(std::iter::once(1.0)).collect();
        KnotVector::clamped(3, &breaks, 1)
    });
    (knots, report)
}

/// The depth at which cuts would no longer be exact binary fractions.
const MAX_DEPTH: u32 = 40;

/// A point with its parameter point.
type ParameterPoint = (Uv, Vector);

struct Region {
    low: Uv,
    size: f64,
    depth: u32,
}

/// The cuts in u and v in units of 2^−MAX_DEPTH, and the counts of regions.
#[derive(Default)]
struct Division {
    cuts: [BTreeSet<u64>; 2],
    regions: usize,
    above_kappa: usize,
    depth: u32,
}

fn divide(points: &mut [ParameterPoint], region: Region, options: &Options) -> Division {
    let fits = mean_error(points, &region) <= options.kappa;
    let depth = options.depth.min(MAX_DEPTH - 1);
    if fits || region.depth >= depth || points.len() < MIN_POINTS {
        let above_kappa = usize::from(!fits);
        return Division { regions: 1, above_kappa, depth: region.depth, ..Division::default() };
    }
    let half = 0.5 * region.size;
    let middle = region.low + nalgebra::Vector2::repeat(half);
    let (left, right) = split(points, |uv| uv.x < middle.x);
    let (a, b) = split(left, |uv| uv.y < middle.y);
    let (c, d) = split(right, |uv| uv.y < middle.y);
    let child = |x: f64, y: f64| Region { low: Uv::new(x, y), size: half, depth: region.depth + 1 };
    let low = region.low;
    let both = |p: &mut [_], q: &mut [_], x: f64| {
        let (r, s) = (child(x, low.y), child(x, middle.y));
        rayon::join(|| divide(p, r, options), || divide(q, s, options))
    };
    let ((a, b), (c, d)) = rayon::join(|| both(a, b, low.x), || both(c, d, middle.x));
    let mut all = Division::default();
    for part in [a, b, c, d] {
        all.regions += part.regions;
        all.above_kappa += part.above_kappa;
        all.depth = all.depth.max(part.depth);
        for (cuts, more) in all.cuts.iter_mut().zip(part.cuts) {
            cuts.extend(more);
        }
    }
    let unit = (1u64 << MAX_DEPTH) as f64;
    all.cuts[0].insert((middle.x * unit) as u64);
    all.cuts[1].insert((middle.y * unit) as u64);
    all
}

/// Moves the points for which `first` holds to the front. The order within both parts is kept, so
/// sums over them are the same in every run.
fn split(
    points: &mut [ParameterPoint],
    first: impl Fn(Uv) -> bool + Sync,
) -> (&mut [ParameterPoint], &mut [ParameterPoint]) {
    let count = points.par_iter().filter(|p| first(p.0)).count();
    points.par_sort_by_key(|p| !first(p.0));
    points.split_at_mut(count)
}

/// The mean distance of the points from their bicubic least-squares polynomial.
fn mean_error(points: &[ParameterPoint], region: &Region) -> f64 {
    if points.is_empty() {
        return 0.0;
    }
    let basis = |uv: Uv| {
        let [u, v] = [uv.x - region.low.x, uv.y - region.low.y].map(|t| legendre(t / region.size));
        SVector::<f64, 16>::from_fn(|i, _| u[i / 4] * v[i % 4])
    };
    let sums = |points: &[ParameterPoint]| {
        let mut gram = SMatrix::<f64, 16, 16>::zeros();
        let mut right = SMatrix::<f64, 16, 3>::zeros();
        for (uv, p) in points {
            let b = basis(*uv);
            gram.ger(1.0, &b, &b, 1.0);
            right.ger(1.0, &b, p, 1.0);
        }
        (gram, right)
    };
    let blocks: Vec<_> = points.par_chunks(BLOCK).map(sums).collect();
    let mut gram: SMatrix<f64, 16, 16> = blocks.iter().map(|block| block.0).sum();
    let right: SMatrix<f64, 16, 3> = blocks.iter().map(|block| block.1).sum();
    // Where the points do not determine all coefficients, the smallest ones are taken.
    gram += SMatrix::<f64, 16, 16>::identity() * (1e-10 * gram.trace());
    let Some(factor) = gram.cholesky() else { return f64::INFINITY };
    let c: Matrix3xX<f64> = Matrix3xX::from_columns(
        &factor.solve(&right).row_iter().map(|r| r.transpose()).collect::<Vec<_>>(),
    );
    let off = |(uv, p): &ParameterPoint| (&c * basis(*uv) - p).norm();
    let blocks: Vec<f64> =
        points.par_chunks(BLOCK).map(|block| block.iter().map(off).sum()).collect();
    blocks.iter().sum::<f64>() / points.len() as f64
}

/// The Legendre polynomials of degree 0 to 3 over [0, 1].
fn legendre(t: f64) -> [f64; 4] {
    let x = 2.0 * t - 1.0;
    [1.0, x, 1.5 * x * x - 0.5, (2.5 * x * x - 1.5) * x]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn sheet(z: impl Fn(f64, f64) -> f64) -> Samples {
        let at = |i: usize| (i as f64 + 0.5) / 60.0;
        let mut s = Samples::default();
        for (u, v) in (0..3600).map(|i| (at(i / 60), at(i % 60))) {
            s.points.push(Point::new(100.0 * u, 100.0 * v, z(u, v)));
            s.uv.push(Uv::new(u, v));
            s.weights.push(1.0);
        }
        s
    }

    #[test]
    fn a_bicubic_needs_no_knot() {
        let s = sheet(|u, v| 40.0 * u * u * u * v * v * v - 20.0 * u * v);
        let ([u, v], report) = place(&s, &Options { kappa: 1e-6, depth: 5 });
        assert_eq!((u.functions(), v.functions(), report.regions), (4, 4, 1));
    }

    #[test]
    fn knots_gather_where_the_detail_is() {
        let s = sheet(|u, v| 5.0 * (-((u - 0.1).powi(2) + (v - 0.1).powi(2)) * 400.0).exp());
        let ([u, _], report) = place(&s, &Options { kappa: 0.02, depth: 4 });
        let fine = u.breaks().iter().filter(|&&b| b < 0.5).count();
        let coarse = u.breaks().iter().filter(|&&b| b > 0.5).count();
        assert!(fine > 2 * coarse, "{:?}", u.breaks());
        assert!(report.depth >= 3);
    }

    #[test]
    fn no_knot_lies_beyond_the_points() {
        let mut s = sheet(|u, v| 3.0 * (9.0 * u).sin() * (7.0 * v).cos());
        s.uv.iter_mut().for_each(|at| *at = at.map(|t| 0.3 + 0.3 * t));
        let ([u, _], _) = place(&s, &Options { kappa: 0.01, depth: 6 });
        let breaks = u.breaks();
        let inner = &breaks[1..breaks.len() - 1];
        assert!(inner.len() > 3 && inner[0] > 0.3 && inner[inner.len() - 1] < 0.6, "{inner:?}");
    }

    #[test]
    fn a_smaller_kappa_places_no_fewer_knots() {
        let s = sheet(|u, v| 3.0 * (9.0 * u).sin() * (7.0 * v).cos());
        let count = |kappa| place(&s, &Options { kappa, depth: 4 }).1.regions;
        assert!(count(1.0) < count(0.01));
    }
}
