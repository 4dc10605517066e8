//! Local fits: a plane by weighted principal components, and a quadric over it.

use nalgebra::{Cholesky, Const, DimName, Matrix3, SMatrix, SVector};

use crate::geometry::{NEGLIGIBLE, Point, ROUNDING, Vector, plane_axes};

/// The weight of a point at the squared distance `squared`, where `radius` is the distance of the
/// farthest point: exp(−4 d²/r²). It is 2 % at the radius, so that points enter and leave a
/// neighbourhood without a jump, and a quarter of the points has half of the weight.
pub(super) fn weight(squared: f64, radius: f64) -> f64 {
    (-4.0 * squared / (radius * radius)).exp()
}

/// The plane through the weighted mean of some points.
pub(super) struct PrincipalPlane {
    /// The unit normal: the direction in which the points extend least.
    pub normal: Vector,
    /// Whether the points lie on a line as far as numbers can tell.
    pub is_line: bool,
}

impl PrincipalPlane {
    /// Fits the plane to points, given by their weights and their places relative to any point.
    pub(super) fn fit(points: impl Iterator<Item = (f64, Vector)>) -> Self {
        let (mut total, mut sum, mut squares) = (0.0, Vector::zeros(), [0.0; 6]);
        for (w, d) in points {
            total += w;
            let wd = w * d;
            sum += wd;
            let products = [wd.x * d.x, wd.y * d.y, wd.z * d.z, wd.x * d.y, wd.y * d.z, wd.z * d.x];
            squares.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        }
        let mean = sum / total;
        let [xx, yy, zz, xy, yz, zx] = squares.map(|s| s / total);
        let eigen = (Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) - mean * mean.transpose())
            .symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_unstable_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let [_, second, first] = order.map(|k| eigen.eigenvalues[k]);
        let normal = eigen.eigenvectors.column(order[0]).into_owned();
        PrincipalPlane { normal, is_line: second <= NEGLIGIBLE * first }
    }
}

/// A quadric over a plane, fitted by weighted least squares.
pub(super) struct Quadric {
    /// The height of the quadric over the origin of the plane.
    pub height: f64,
    /// The unit normal of the quadric there.
    pub normal: Vector,
}

/// Points about a quadric.
pub(super) struct Scatter {
    /// An estimate without bias of the variance of their noise along the normal.
    pub variance: f64,
    /// The mean curvature of the quadric.
    pub curvature: f64,
}

/// A neighbour in the plane, in units of the radius: the monomials 1, x, y, x², xy and y², the
/// height and the weight.
struct QuadricRow {
    monomials: SVector<f64, 6>,
    height: f64,
    weight: f64,
}

impl QuadricRow {
    fn new(d: Vector, (x, y): (Vector, Vector), normal: Vector) -> Self {
        let (u, v) = (d.dot(&x), d.dot(&y));
        // The distance in the plane, and not that in space: otherwise points far above and below
        // would count less, and the noise would look smaller than it is.
        let weight = weight(u * u + v * v, 1.0);
        let monomials = SVector::from([1.0, u, v, u * u, u * v, v * v]);
        QuadricRow { monomials, height: d.dot(&normal), weight }
    }

    fn first<const N: usize>(&self) -> SVector<f64, N> {
        SVector::from_fn(|k, _| self.monomials[k])
    }
}

/// The neighbours of one place, as the rows of a least-squares problem. They are kept to be filled
/// again for the next place.
#[derive(Default)]
pub(super) struct QuadricRows(Vec<QuadricRow>);

impl QuadricRows {
    /// Fills the rows with points around `origin`.
    fn fill(
        &mut self,
        origin: Point,
        normal: Vector,
        radius: f64,
        points: impl Iterator<Item = Point>,
    ) {
        let axes = plane_axes(normal);
        let inverse = 1.0 / radius;
        self.0.clear();
        self.0.extend(points.map(|p| QuadricRow::new((p - origin) * inverse, axes, normal)));
    }

    /// Fits a quadric over the plane through `origin` with this unit `normal`. A plane is fitted
    /// in place of the quadric where the points do not determine one at the origin: its height
    /// there would vary more than that of a single point. `None` if not even a plane is determined.
    pub(super) fn fit(
        &mut self,
        origin: Point,
        normal: Vector,
        radius: f64,
        points: impl Iterator<Item = Point>,
    ) -> Option<Quadric> {
        self.fill(origin, normal, radius, points);
        let [height, by_x, by_y] = self.solve::<6>().or_else(|| self.solve::<3>())?;
        let (x, y) = plane_axes(normal);
        let normal = (normal - by_x * x - by_y * y).normalize();
        Some(Quadric { height: radius * height, normal })
    }

    /// How the points lie about a quadric. `None` if they are too few or too uneven for one.
    pub(crate) fn scatter(
        &mut self,
        origin: Point,
        normal: Vector,
        radius: f64,
        points: impl Iterator<Item = Point>,
    ) -> Option<Scatter> {
        self.fill(origin, normal, radius, points);
        let (factor, c) = self.system::<6>()?;
        let (mut squares, mut freedom, mut total) = (0.0, 0.0, 0.0);
        for row in &self.0 {
            let b = row.first::<6>();
            squares += row.weight * (row.height - b.dot(&c)).powi(2);
            // The expectation of Σ w r² is σ² (Σ w − Σ w² bᵀ G⁻¹ b).
            freedom += row.weight - row.weight.powi(2) * b.dot(&factor.solve(&b));
            total += row.weight;
        }
        // Otherwise the residuals are rounding errors.
        (freedom > NEGLIGIBLE * total).then(|| Scatter {
            variance: radius * radius * squares / freedom,
            curvature: (c[3] + c[5]) / radius,
        })
    }

    /// The factor of the normal equations of the first N monomials, and the coefficients.
    fn system<const N: usize>(&self) -> Option<(Cholesky<f64, Const<N>>, SVector<f64, N>)>
    where
        Const<N>: DimName,
    {
        let mut gram = SMatrix::<f64, N, N>::zeros();
        let mut right = SVector::<f64, N>::zeros();
        for row in &self.0 {
            let b = row.first::<N>();
            let weighted = row.weight * b;
            // The lower triangle is all that the factorization reads.
            for j in 0..N {
                for i in j..N {
                    gram[(i, j)] += b[j] * weighted[i];
                }
            }
            right.axpy(row.height, &weighted, 1.0);
        }
        // It makes the factorization of a singular matrix succeed, and changes a fit that is determined
        // by nothing.
        let damping = ROUNDING * gram.trace();
        (0..N).for_each(|i| gram[(i, i)] += damping);
        let factor = gram.cholesky()?;
        let coefficients = factor.solve(&right);
        Some((factor, coefficients))
    }

    /// The height and the two slopes at the origin. `None` if the points do not determine them.
    fn solve<const N: usize>(&self) -> Option<[f64; 3]>
    where
        Const<N>: DimName,
    {
        let (factor, c) = self.system::<N>()?;
        let influence = factor.solve(&SVector::from_fn(|i, _| f64::from(u8::from(i == 0))));
        let square = |row: &QuadricRow| (row.weight * row.first::<N>().dot(&influence)).powi(2);
        // The variance of the height at the origin, if that of the points is 1.
        let variance: f64 = self.0.iter().map(square).sum();
        (variance <= 1.0).then(|| [c[0], c[1], c[2]])
    }
}
