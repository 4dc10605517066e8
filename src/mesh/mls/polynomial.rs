//! The polynomial over a reference plane, fitted by weighted least squares.

use nalgebra::{Cholesky, Const, DimName, SMatrix, SVector};

use super::{ReferencePlane, Sample};
use crate::geometry::{Point, Vector, plane_axes};

/// A polynomial over a plane, centred at the origin of the plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polynomial {
    plane: ReferencePlane,
    axes: (Vector, Vector),
    /// The coefficients of the monomials, in the order of `monomials` and in units of h.
    coefficients: [f64; MONOMIALS],
    h: f64,
    /// The variance of the value at the origin, if the points have variance 1.
    pub variance: f64,
}

/// The number of monomials up to the fourth degree.
const MONOMIALS: usize = 15;

/// The monomials as means over the points of a sample. The first 3 are linear, the first 6
/// quadratic, the first 10 cubic, and all 15 quartic. `spread` is the covariance xx, xy, yy.
/// Moments of higher order are those of a normal distribution.
fn monomials(x: f64, y: f64, [xx, xy, yy]: [f64; 3]) -> [f64; MONOMIALS] {
    let (x2, y2) = (x * x, y * y);
    [
        1.0,
        x,
        y,
        x2 + xx,
        x * y + xy,
        y2 + yy,
        x * (x2 + 3.0 * xx),
        x2 * y + xx * y + 2.0 * x * xy,
        x * y2 + yy * x + 2.0 * y * xy,
        y * (y2 + 3.0 * yy),
        x2 * (x2 + 6.0 * xx) + 3.0 * xx * xx,
        x2 * x * y + 3.0 * (x2 * xy + x * y * xx + xx * xy),
        x2 * y2 + xx * y2 + yy * x2 + 4.0 * x * y * xy + xx * yy + 2.0 * xy * xy,
        x * y2 * y + 3.0 * (y2 * xy + x * y * yy + yy * xy),
        y2 * (y2 + 6.0 * yy) + 3.0 * yy * yy,
    ]
}

impl Polynomial {
    /// Fits the polynomial of the highest total degree that the points determine: four, three, two
    /// or one. A polynomial is determined if the variance of its value at the origin is below that
    /// of a single point. Components that would oscillate beside the points are damped. A cubic,
    /// for example, oscillates between the three rows of a line scanner that are in reach. The
    /// fourth degree is not used where the points lie to one side, as at a boundary, because it
    /// would oscillate freely.
    pub(crate) fn fit(plane: &ReferencePlane, around: &[Sample], h: f64) -> Option<Polynomial> {
        let axes = plane_axes(plane.normal);
        let rows: Vec<FitRow> = around.iter().map(|p| FitRow::new(p, plane, axes, h)).collect();
        let means = means(&rows);
        let probes = probes(means);
        let full = || solve::<15>(&rows, &probes);
        let full = if is_one_sided(means) { None } else { full() };
        let (coefficients, variance) = full
            .or_else(|| solve::<10>(&rows, &probes))
            .or_else(|| solve::<6>(&rows, &probes))
            .or_else(|| solve::<3>(&rows, &probes))?;
        Some(Polynomial { plane: *plane, axes, coefficients, h, variance })
    }

    /// The point of the polynomial above `p` along the normal of the plane, and its unit normal.
    pub(crate) fn at(&self, p: Point) -> (Point, Vector) {
        let n = self.plane.normal;
        let (e1, e2) = self.axes;
        let d = (p - self.plane.origin) / self.h;
        let (x, y) = (d.dot(&e1), d.dot(&e2));
        let c = &self.coefficients;
        let row = monomials(x, y, [0.0; 3]);
        let height: f64 = row.iter().zip(c).map(|(m, c)| m * c).sum();
        let (x2, xy, y2) = (x * x, x * y, y * y);
        let by_x = [
            1.0,
            2.0 * x,
            y,
            3.0 * x2,
            2.0 * xy,
            y2,
            4.0 * x * x2,
            3.0 * x * xy,
            2.0 * x * y2,
            y * y2,
        ];
        let by_y = [
            1.0,
            x,
            2.0 * y,
            x2,
            2.0 * xy,
            3.0 * y2,
            x * x2,
            2.0 * x2 * y,
            3.0 * xy * y,
            4.0 * y * y2,
        ];
        let sum = |terms: [f64; 10], which: [usize; 10]| -> f64 {
            terms.iter().zip(which).map(|(t, k)| t * c[k]).sum()
        };
        let dx = sum(by_x, [1, 3, 4, 6, 7, 8, 10, 11, 12, 13]);
        let dy = sum(by_y, [2, 4, 5, 7, 8, 9, 11, 12, 13, 14]);
        let foot = p + self.h * (height - d.dot(&n)) * n;
        (foot, (n - dx * e1 - dy * e2).normalize())
    }
}

/// A sample in the frame of the plane, in units of h.
struct FitRow {
    monomials: [f64; MONOMIALS],
    height: f64,
    weight: f64,
    count: f64,
}

impl FitRow {
    fn new(p: &Sample, plane: &ReferencePlane, (e1, e2): (Vector, Vector), h: f64) -> Self {
        let d = (p.at - plane.origin) / h;
        let spread = if p.weight > 1.0 {
            let spread = p.covariance() / (h * h);
            let (s1, s2) = (spread * e1, spread * e2);
            [s1.dot(&e1), s1.dot(&e2), s2.dot(&e2)]
        } else {
            [0.0; 3]
        };
        FitRow {
            monomials: monomials(d.dot(&e1), d.dot(&e2), spread),
            height: d.dot(&plane.normal),
            weight: p.weight * (-d.norm_squared()).exp(),
            count: p.weight,
        }
    }

    fn first<const N: usize>(&self) -> SVector<f64, N> {
        first(&self.monomials)
    }

    /// The weight of its noise. The mean of several points has less noise in proportion to their
    /// number.
    fn noise(&self) -> f64 {
        self.weight * self.weight / self.count
    }
}

/// The largest allowed variance of the polynomial's value beside the mean of the points.
const MAX_PROBE_VARIANCE: f64 = 4.0;

/// The distance of the places beside the mean of the points, in standard deviations of the points.
/// With this value, none of the places lies on one of a few equally spaced rows.
const PROBE_DISTANCE: f64 = 0.75;

/// The weighted means of the first six monomials.
fn means(rows: &[FitRow]) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for row in rows {
        sums.iter_mut().zip(row.monomials).for_each(|(sum, m)| *sum += row.weight * m);
    }
    sums.map(|sum| sum / sums[0])
}

/// Whether the mean of the points is farther from the origin than a fifth of h.
fn is_one_sided([_, x, y, ..]: [f64; 6]) -> bool {
    5.0 * x.hypot(y) > 1.0
}

/// Four places around the mean of the points, two along each column of a square root of their
/// covariance. At least one of these directions leads away from any row.
fn probes([_, x, y, xx, xy, yy]: [f64; 6]) -> [[f64; 2]; 4] {
    let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y);
    let first = xx.max(f64::MIN_POSITIVE).sqrt();
    let across = xy / first;
    let second = (yy - across * across).max(0.0).sqrt();
    let [a, b, c] = [first, across, second].map(|part| PROBE_DISTANCE * part);
    [[x + a, y + b], [x - a, y - b], [x, y + c], [x, y - c]]
}

/// A fit: its coefficients, and its variance at the origin.
type Fitted = ([f64; MONOMIALS], f64);

/// Values that are added to the diagonal of a Gram matrix, as shares of its trace. The smallest one
/// that keeps the fit from oscillating is used, because more damping distorts the shape that the
/// points determine.
const DAMPINGS: [f64; 6] = [1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3];

/// The factor of a damped Gram matrix for which the fit does not oscillate at the `probes`,
/// and the variance of the fit at the origin.
fn damped<const N: usize>(
    gram: &SMatrix<f64, N, N>,
    rows: &[FitRow],
    probes: &[[f64; 2]],
) -> Option<(Cholesky<f64, Const<N>>, f64)>
where
    Const<N>: DimName,
{
    for share in DAMPINGS {
        let damp = SMatrix::from_diagonal_element(share * gram.trace());
        let factor = (gram + damp).cholesky()?;
        let variance = |b: SVector<f64, N>| {
            let solved = factor.solve(&b);
            rows.iter().map(|r| r.noise() * r.first::<N>().dot(&solved).powi(2)).sum::<f64>()
        };
        let at_origin = variance(first(&monomials(0.0, 0.0, [0.0; 3])));
        if at_origin.is_nan() || at_origin > 1.0 {
            return None;
        }
        let is_stable = |&[x, y]: &[f64; 2]| {
            let b = first(&monomials(x, y, [0.0; 3]));
            // bᵀ G⁻¹ b is an upper bound that is cheap to compute.
            leverage(&factor, b) <= MAX_PROBE_VARIANCE || variance(b) <= MAX_PROBE_VARIANCE
        };
        if probes.iter().all(is_stable) {
            return Some((factor, at_origin));
        }
    }
    None
}

/// bᵀ G⁻¹ b, computed as |L⁻¹ b|².
fn leverage<const N: usize>(factor: &Cholesky<f64, Const<N>>, mut b: SVector<f64, N>) -> f64
where
    Const<N>: DimName,
{
    factor.l_dirty().solve_lower_triangular_unchecked_mut(&mut b);
    b.norm_squared()
}

/// The first N monomials.
fn first<const N: usize>(monomials: &[f64; MONOMIALS]) -> SVector<f64, N> {
    SVector::from_fn(|i, _| monomials[i])
}

/// The weighted least-squares fit of the first N monomials, or `None` if it oscillates at the
/// origin or at one of the `probes`.
fn solve<const N: usize>(rows: &[FitRow], probes: &[[f64; 2]]) -> Option<Fitted>
where
    Const<N>: DimName,
{
    if rows.len() < N {
        return None;
    }
    let mut gram = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for row in rows {
        let b = row.first();
        let weighted = row.weight * b;
        for j in 0..N {
            gram.column_mut(j).axpy(b[j], &weighted, 1.0);
        }
        right.axpy(row.height, &weighted, 1.0);
    }
    let (factor, variance) = damped(&gram, rows, probes)?;
    let c = factor.solve(&right);
    Some((std::array::from_fn(|i| if i < N { c[i] } else { 0.0 }), variance))
}
