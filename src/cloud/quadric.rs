//! Local fits: a plane by weighted principal components, and a quadric over it.

use nalgebra::{SMatrix, SVector};

use crate::geometry::{Point, Vector, plane_axes};

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

/// The second extent of points on a line is at most this share of the first one. Variances of
/// a sheet that is a thousand times as long as wide are at a ratio of 1e-6.
const LINE_RATIO: f64 = 1e-6;

impl PrincipalPlane {
    /// Fits the plane to points, given by their weights and their places relative to any point.
    pub fn fit(points: impl Iterator<Item = (f64, Vector)>) -> Self {
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
        let m =
            nalgebra::Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) - mean * mean.transpose();
        let eigen = m.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_unstable_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let normal = eigen.eigenvectors.column(order[0]).into_owned();
        let extents = order.map(|k| eigen.eigenvalues[k]);
        PrincipalPlane { normal, is_line: extents[1] <= LINE_RATIO * extents[2] }
    }
}

/// The coefficients of 1, x, y, x², xy and y².
type Coefficients6 = SVector<f64, 6>;

/// A quadric over a plane, fitted by weighted least squares.
pub(super) struct Quadric {
    /// The height of the quadric over the origin of the plane.
    pub height: f64,
    /// The unit normal of the quadric there.
    pub normal: Vector,
    /// An estimate without bias of the variance of the heights of the points, or `None` if the
    /// points are too few for one.
    pub variance: Option<f64>,
}

/// A neighbour in the plane: its coordinates in units of the radius, and its weight.
struct Row {
    terms: Coefficients6,
    height: f64,
    weight: f64,
}

impl Row {
    fn new(d: Vector, (x, y): (Vector, Vector), normal: Vector) -> Self {
        let (u, v) = (d.dot(&x), d.dot(&y));
        // The distance in the plane, and not that in space: otherwise points far above and below
        // would count less, and the noise would look smaller than it is.
        let weight = weight(u * u + v * v, 1.0);
        Row {
            terms: SVector::from([1.0, u, v, u * u, u * v, v * v]),
            height: d.dot(&normal),
            weight,
        }
    }
}

/// Rows of one fit, to be used again.
#[derive(Default)]
pub(super) struct Rows(Vec<Row>);

impl Quadric {
    /// Fits a quadric over the plane through `origin` with this unit `normal`. A plane is fitted
    /// in place of the quadric where the points do not determine one at the origin: its height
    /// there would vary more than that of a single point. `None` if not even a plane is determined.
    pub fn fit(
        origin: Point,
        normal: Vector,
        radius: f64,
        points: impl Iterator<Item = Point>,
        rows: &mut Rows,
    ) -> Option<Quadric> {
        let axes = plane_axes(normal);
        let inverse = 1.0 / radius;
        rows.0.clear();
        rows.0.extend(points.map(|p| Row::new((p - origin) * inverse, axes, normal)));
        let solved = solve::<6>(&rows.0).or_else(|| solve::<3>(&rows.0))?;
        let [height, by_x, by_y] = solved.first;
        Some(Quadric {
            height: radius * height,
            normal: (normal - by_x * axes.0 - by_y * axes.1).normalize(),
            variance: solved.variance.map(|v| v * radius * radius),
        })
    }
}

/// The height and the two slopes at the origin, and the variance of the points' heights.
struct Solved {
    first: [f64; 3],
    variance: Option<f64>,
}

/// The fit of the first N terms. `None` if they are not determined.
fn solve<const N: usize>(rows: &[Row]) -> Option<Solved> {
    let mut gram = SMatrix::<f64, N, N>::zeros();
    // Σ w² b bᵀ, from which the variance of the fit follows.
    let mut noise = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    let (mut total, mut squares) = (0.0, 0.0);
    for row in rows {
        let b = row.terms.fixed_rows::<N>(0);
        for j in 0..N {
            let wb = row.weight * b[j];
            for i in j..N {
                gram[(i, j)] += wb * b[i];
                noise[(i, j)] += row.weight * wb * b[i];
            }
            right[j] += wb * row.height;
        }
        total += row.weight;
        squares += row.weight * row.height * row.height;
    }
    noise.fill_upper_triangle_with_lower_triangle();
    let damping = 1e-12 * gram.trace();
    (0..N).for_each(|i| gram[(i, i)] += damping);
    let factor = nalgebra::Cholesky::new(gram)?;
    let c = factor.solve(&right);
    let spread = factor.solve(&noise);
    let at_origin = factor.solve(&SVector::<f64, N>::from_fn(|i, _| f64::from(u8::from(i == 0))));
    // The variance of the height at the origin, if that of the points is 1.
    let certainty = at_origin.dot(&(noise * at_origin));
    if certainty.is_nan() || certainty > 1.0 {
        return None;
    }
    // The expectation of Σ w r² is σ² (Σ w − Σ w² bᵀ G⁻¹ b).
    let freedom = total - spread.trace();
    let residual = (squares - right.dot(&c)).max(0.0);
    let variance = (freedom > LEAST_FREEDOM * total).then(|| residual / freedom);
    Some(Solved { first: [c[0], c[1], c[2]], variance })
}

/// Below this share of degrees of freedom the residuals are rounding errors.
const LEAST_FREEDOM: f64 = 1e-3;
