//! A rectangle of the parameter plane with bounds on the derivatives of the surface in it.

use crate::geometry::{Point, Uv, Vector};
use crate::spline::foot::Foot;
use crate::spline::{Jet, ParametricSurface};

/// The places along each side of a cell, from −1 to 1, at which second derivatives are sampled. The
/// last one lies just before the end, because the surface may have a knot there.
const NODES: [f64; 4] = [-1.0, -0.5, 0.5, 1.0 - 1e-9];

/// The Lebesgue constant of the nodes: between the nodes, a cubic is at most this many times as
/// large as at the nodes. Bounds from samples at the nodes therefore hold for bicubic pieces. For
/// other surfaces they are measured and not proved.
const LEBESGUE: f64 = 5.0 / 3.0;

/// A cell. The surface stays within [`SurfaceCell::spread`] of the parallelogram `centre + x ·
/// sides[0] + y · sides[1]` with x and y from −1 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfaceCell {
    pub low: Uv,
    pub high: Uv,
    pub centre: Point,
    /// The first derivatives at the centre, times half the side of the cell, in mm.
    pub sides: [Vector; 2],
    /// Bounds on the second derivatives uu, uv and vv, times the products of half sides, in mm.
    pub bend: [f64; 3],
}

/// Bounds on the first and second derivatives of the surface. The parameters are scaled so that
/// half a side of the cell has the length of the vector in [`SurfaceCell::sides`], in mm.
#[derive(Debug, Clone, Copy)]
pub(super) struct DerivativeBounds {
    /// A lower bound on the distance of two points whose scaled parameters are 1 apart; 0 if none
    /// is known.
    pub least: f64,
    /// An upper bound on this distance.
    pub most: f64,
    /// A bound on the second derivative in any direction, in 1/mm.
    pub bend: f64,
}

impl DerivativeBounds {
    /// Computes the bounds from the first derivatives at the centre, their variation over the cell,
    /// and the second derivatives.
    pub(super) fn new(sides: &[Vector; 2], differ: [f64; 2], bend: [f64; 3]) -> Self {
        let [a, b] = [0, 1].map(|k| sides[k].norm());
        let share = |x: f64, y: f64| if x == 0.0 { 0.0 } else { x / y.max(f64::MIN_POSITIVE) };
        let cosine = share(sides[0].dot(&sides[1]).abs(), a * b).min(1.0);
        let differ = share(differ[0], a).hypot(share(differ[1], b));
        let [uu, uv, vv] = [share(bend[0], a * a), share(bend[1], a * b), share(bend[2], b * b)];
        DerivativeBounds {
            least: ((1.0 - cosine).sqrt() - differ).max(0.0),
            most: (1.0 + cosine).sqrt() + differ,
            bend: 0.5 * (uu + vv) + (0.5 * (uu - vv)).hypot(uv),
        }
    }

    /// A distance below which ‖S − p‖² is convex around a foot point, so that no other foot point
    /// is as near. By the Taylor series at a foot point f at distance d, ‖S(x) − p‖² ≥ d² + (least²
    /// − d · bend) · ‖x − f‖².
    pub(crate) fn reach(&self) -> f64 {
        let square = self.least * self.least;
        if self.bend > 0.0 {
            square / self.bend
        } else {
            if square > 0.0 { f64::INFINITY } else { 0.0 }
        }
    }
}

impl SurfaceCell {
    /// The cell between two corners of the parameter plane. The surface must be smooth in it.
    pub(super) fn measured<S: ParametricSurface + ?Sized>(surface: &S, low: Uv, high: Uv) -> Self {
        let half = 0.5 * (high - low);
        let middle = nalgebra::center(&low, &high);
        let centre = surface.jet(middle);
        let mut samples = [[Vector::zeros(); 16]; 3];
        for (n, look) in (0..16).map(|n| (n, [NODES[n / 4], NODES[n % 4]])) {
            let at = Uv::new(middle.x + half.x * look[0], middle.y + half.y * look[1]);
            let jet = surface.jet(at);
            samples[0][n] = jet.suu * (half.x * half.x);
            samples[1][n] = jet.suv * (half.x * half.y);
            samples[2][n] = jet.svv * (half.y * half.y);
        }
        // A second derivative is linear in its own parameter, so the nodes bound it in this
        // direction.
        let factors = [LEBESGUE, LEBESGUE * LEBESGUE, LEBESGUE];
        let bend = std::array::from_fn(|k| longest(&samples[k], factors[k]));
        SurfaceCell::at(low, high, &centre, bend)
    }

    fn at(low: Uv, high: Uv, centre: &Jet, bend: [f64; 3]) -> Self {
        let half = 0.5 * (high - low);
        let sides = [centre.su * half.x, centre.sv * half.y];
        SurfaceCell { low, high, centre: centre.s, sides, bend }
    }

    /// Divides the cell into four quarters, or into two halves if one side is much shorter.
    pub(crate) fn split<S: ParametricSurface + ?Sized>(
        &self,
        surface: &S,
    ) -> impl Iterator<Item = SurfaceCell> {
        let [a, b] = [0, 1].map(|k| self.sides[k].norm());
        let cuts = [a >= 0.5 * b, b >= 0.5 * a].map(|cut| if cut { 2 } else { 1 });
        let scale = cuts.map(|n| 1.0 / f64::from(n));
        let [uu, uv, vv] = self.bend;
        let bend = [uu * scale[0] * scale[0], uv * scale[0] * scale[1], vv * scale[1] * scale[1]];
        let at = move |i: i32, k: usize, from: f64, to: f64| {
            if i == cuts[k] { to } else { from + (to - from) * f64::from(i) * scale[k] }
        };
        let (low, high) = (self.low, self.high);
        (0..cuts[0] * cuts[1]).map(move |n| {
            let (i, j) = (n / cuts[1], n % cuts[1]);
            let corner = |i, j| Uv::new(at(i, 0, low.x, high.x), at(j, 1, low.y, high.y));
            let (low, high) = (corner(i, j), corner(i + 1, j + 1));
            SurfaceCell::at(low, high, &surface.jet(nalgebra::center(&low, &high)), bend)
        })
    }

    /// A bound in mm on the distance of the surface from the parallelogram.
    pub(crate) fn spread(&self) -> f64 {
        0.5 * (self.bend[0] + self.bend[2]) + self.bend[1]
    }

    /// Bounds on the difference of the first derivatives from those at the centre, for half sides.
    pub(crate) fn differ(&self) -> [f64; 2] {
        [self.bend[0] + self.bend[1], self.bend[1] + self.bend[2]]
    }

    pub(crate) fn derivative_bounds(&self) -> DerivativeBounds {
        DerivativeBounds::new(&self.sides, self.differ(), self.bend)
    }

    /// The lowest and highest corner of a box that contains the surface in the cell.
    pub(crate) fn bounds(&self) -> [Point; 2] {
        let spread = Vector::from_element(self.spread());
        let reach = self.sides[0].abs() + self.sides[1].abs() + spread;
        [self.centre - reach, self.centre + reach]
    }

    /// The point of the parallelogram nearest to `p`, as a parameter point, and its distance.
    pub(crate) fn nearest(&self, p: Point) -> (Uv, f64) {
        let r = p - self.centre;
        let [a, b] = self.sides;
        let (aa, ab, bb) = (a.norm_squared(), a.dot(&b), b.norm_squared());
        let (ra, rb) = (r.dot(&a), r.dot(&b));
        let determinant = aa * bb - ab * ab;
        let (x, y) = ((ra * bb - rb * ab) / determinant, (rb * aa - ra * ab) / determinant);
        let away = |x: f64, y: f64| (r - a * x - b * y).norm_squared();
        let clamp = |t: f64| if t.is_nan() { 0.0 } else { t.clamp(-1.0, 1.0) };
        let mut best = (x, y, 0.0);
        if x.abs() <= 1.0 && y.abs() <= 1.0 {
            best.2 = away(x, y);
        } else {
            best.2 = f64::INFINITY;
            for side in [-1.0, 1.0] {
                let (y, x) = (clamp((rb - side * ab) / bb), clamp((ra - side * ab) / aa));
                for (x, y) in [(side, y), (x, side)] {
                    let d = away(x, y);
                    if d < best.2 {
                        best = (x, y, d);
                    }
                }
            }
        }
        let half = 0.5 * (self.high - self.low);
        let middle = nalgebra::center(&self.low, &self.high);
        (Uv::new(middle.x + half.x * best.0, middle.y + half.y * best.1), best.2.sqrt())
    }

    /// Whether the gradient of ½‖S − p‖² is proved not to vanish in the cell, so that the cell
    /// contains no foot point of `p`.
    pub(crate) fn has_no_foot(&self, p: Point, derivative_bounds: &DerivativeBounds) -> bool {
        let r = self.centre - p;
        let [a, b] = self.sides.map(|side| side.norm().max(f64::MIN_POSITIVE));
        let gradient = (r.dot(&self.sides[0]) / a).hypot(r.dot(&self.sides[1]) / b);
        let corner = a.hypot(b);
        let away = r.norm() + derivative_bounds.most * corner;
        gradient
            > corner
                * (derivative_bounds.most * derivative_bounds.most + away * derivative_bounds.bend)
    }

    /// A lower bound on the distance of `p` from the cell, by the Taylor series at the point `foot`
    /// of the cell.
    pub(crate) fn least_distance(
        &self,
        p: Point,
        foot: &Foot,
        derivative_bounds: &DerivativeBounds,
    ) -> f64 {
        let r = foot.jet.s - p;
        let half = 0.5 * (self.high - self.low);
        let (mut remaining_gradient, mut square) = (0.0, 0.0);
        for (k, derivative) in [foot.jet.su, foot.jet.sv].iter().enumerate() {
            let gradient = r.dot(derivative);
            let (down, up) = (self.low[k] - foot.at[k], self.high[k] - foot.at[k]);
            remaining_gradient += (gradient * down).min(gradient * up).min(0.0);
            let farthest = up.max(-down);
            let scale = self.sides[k].norm() / half[k].max(f64::MIN_POSITIVE);
            square += (farthest * scale).powi(2);
        }
        let hollow = (foot.distance * derivative_bounds.bend
            - derivative_bounds.least * derivative_bounds.least)
            .max(0.0);
        (foot.distance.powi(2) + 2.0 * remaining_gradient - hollow * square).max(0.0).sqrt()
    }
}

/// A bound on the length of a vector-valued polynomial, from its values at the nodes.
fn longest(values: &[Vector; 16], factor: f64) -> f64 {
    let mean = values.iter().sum::<Vector>() / values.len() as f64;
    let off = values.iter().map(|v| (v - mean).norm_squared()).fold(0.0, f64::max).sqrt();
    mean.norm() + factor * off
}
