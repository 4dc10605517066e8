//! A bicubic surface in power form, with one polynomial for each knot cell. Foot points of many
//! samples are searched on this form, because it is faster to evaluate.

use nalgebra::Vector4;
use rayon::prelude::*;

use super::spans::{Cubic, KnotSpans, Span};
use super::surface::{Jet, ParametricSurface, Surface};
use crate::geometry::{Point, Uv, Vector};

/// Three coordinates and a zero. Processors add four numbers at once faster than three.
type PaddedVector = Vector4<f64>;

/// The polynomials. Evaluating one takes a third of the time of a B-spline, whose basis functions
/// have to be computed first.
struct Polynomials {
    spans: [KnotSpans; 2],
    breaks: [Vec<f64>; 2],
    /// Cell (p, q) is at `p * down + q`, where `down` is the number of spans in v. Entry [l][k] is
    /// the coefficient of tˡ sᵏ.
    cells: Vec<[[PaddedVector; 4]; 4]>,
}

/// A form of the surface for many evaluations: polynomials if it is cubic in both directions, as
/// the fits make it, and the surface itself otherwise.
pub(crate) fn fast_evaluator(surface: &Surface) -> Box<dyn ParametricSurface> {
    match [&surface.u, &surface.v].iter().all(|knots| knots.degree() == 3) {
        true => Box::new(Polynomials::new(surface)),
        false => Box::new(surface.clone()),
    }
}

impl Polynomials {
    fn new(surface: &Surface) -> Self {
        let spans = [&surface.u, &surface.v].map(KnotSpans::new);
        let down = spans[1].all.len();
        let of = |c: usize| cell(surface, [c / down, c % down], &spans);
        let cells = (0..spans[0].all.len() * down).into_par_iter().with_min_len(64).map(of);
        Polynomials { cells: cells.collect(), breaks: surface.breaks(), spans }
    }
}

fn cell(surface: &Surface, [p, q]: [usize; 2], spans: &[KnotSpans; 2]) -> [[PaddedVector; 4]; 4] {
    let [u, v] = [&spans[0].all[p], &spans[1].all[q]];
    let row = |i: usize| combined(&v.basis, |j| surface.control(p + i, q + j).push(0.0));
    let rows: [[PaddedVector; 4]; 4] = std::array::from_fn(row);
    std::array::from_fn(|l| combined(&u.basis, |i| rows[i][l]))
}

/// The coefficients of the polynomial Σ p_i B_i.
fn combined(basis: &[Cubic; 4], points: impl Fn(usize) -> PaddedVector) -> [PaddedVector; 4] {
    let mut sums = [PaddedVector::zeros(); 4];
    for (i, cubic) in basis.iter().enumerate() {
        let p = points(i);
        sums.iter_mut().zip(cubic).for_each(|(sum, c)| *sum += p * *c);
    }
    sums
}

/// Evaluates a cubic and its first two derivatives.
#[inline(always)]
fn cubic_jet(&[a, b, c, d]: &[PaddedVector; 4], x: f64) -> [PaddedVector; 3] {
    let dx = d * x;
    [((c + dx) * x + b) * x + a, (c * 2.0 + dx * 3.0) * x + b, c * 2.0 + dx * 6.0]
}

impl ParametricSurface for Polynomials {
    fn jet(&self, at: Uv) -> Jet {
        let [p, q] = [self.spans[0].find(at.x), self.spans[1].find(at.y)];
        let [u, v]: [&Span; 2] = [&self.spans[0].all[p], &self.spans[1].all[q]];
        let cell = &self.cells[p * self.spans[1].all.len() + q];
        let x = u.local(at.x);
        // `map` on these arrays compiles to calls that copy them and take longer than the sums.
        let [mut along, mut slopes, mut bends] = [[PaddedVector::zeros(); 4]; 3];
        for l in 0..4 {
            [along[l], slopes[l], bends[l]] = cubic_jet(&cell[l], x);
        }
        let t = v.local(at.y);
        let [s, sv, svv] = cubic_jet(&along, t);
        let [su, suv, _] = cubic_jet(&slopes, t);
        let [suu, ..] = cubic_jet(&bends, t);
        let (a, b) = (1.0 / u.half(), 1.0 / v.half());
        let vector = |lane: PaddedVector, scale: f64| -> Vector { lane.xyz() * scale };
        Jet {
            s: Point::from(s.xyz()),
            su: vector(su, a),
            sv: vector(sv, b),
            suu: vector(suu, a * a),
            suv: vector(suv, a * b),
            svv: vector(svv, b * b),
        }
    }

    fn ranges(&self) -> [(f64, f64); 2] {
        self.breaks.each_ref().map(|breaks| (breaks[0], breaks[breaks.len() - 1]))
    }

    fn breaks(&self) -> [Vec<f64>; 2] {
        self.breaks.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::KnotVector;

    #[test]
    fn polynomials_are_the_surface() {
        let u = KnotVector::clamped(3, &[0.0, 0.01, 0.4, 0.45, 1.0], 1);
        let v = KnotVector::uniform(3, 6);
        let height = |n: usize| ((n * 7) % 11) as f64;
        let at = |n: usize| Vector::new((n / 6) as f64, (n % 6) as f64, height(n));
        let surface = Surface::new(u.clone(), v, (0..6 * u.functions()).map(at).collect());
        let polynomials = Polynomials::new(&surface);
        for (x, y) in [(0.0, 0.0), (0.005, 0.3), (0.01, 0.5), (0.42, 0.61), (0.9, 0.99), (1.0, 1.0)]
        {
            let (a, b) = (surface.jet(Uv::new(x, y)), polynomials.jet(Uv::new(x, y)));
            assert!((a.s - b.s).norm() < 1e-12);
            for (a, b) in
                [(a.su, b.su), (a.sv, b.sv), (a.suu, b.suu), (a.suv, b.suv), (a.svv, b.svv)]
            {
                assert!((a - b).norm() <= 1e-11 * a.norm().max(1.0), "{x} {y}: {a} {b}");
            }
        }
    }
}
