//! Foot points: the parameters at which a surface is nearest to a point in space.

use nalgebra::{Matrix2, Vector2};

use super::{ACCURACY, Jet, ParametricSurface, Surface};
use crate::geometry::{Point, Uv};

/// The parameter point of a local minimum of the distance from `p` to the surface, and this
/// distance in mm. The descent starts at `start` and stays inside the domain.
///
/// Newton's method is applied to ½‖S(u,v) − p‖². Where the Hessian is not positive definite it is
/// replaced by the Gauss–Newton matrix. A step that does not reduce the distance is halved. A
/// parameter at the end of its range is fixed while the descent direction leads out of the range.
/// The result is never farther than the point at `start`. Newton's last step is below 1e-7 of the
/// domain, so the remaining error is far below 1e-10.
pub fn foot_point<S: ParametricSurface + ?Sized>(surface: &S, p: Point, start: Uv) -> (Uv, f64) {
    foot_point_moving(surface, p, start, [true; 2], ACCURACY)
}

/// The largest number of steps. From most starts a few suffice.
const STEPS: usize = 30;

/// The step length of a coarse descent, as a share of a mean knot span. The error that Newton's
/// method leaves is about the square of its last step.
const COARSE_STEP: f64 = 0.02;

/// The step length below which a coarse descent to a foot point ends.
pub fn last_step(surface: &Surface) -> f64 {
    let [m, n] = surface.shape();
    COARSE_STEP / m.max(n) as f64
}

/// Like [`foot_point`], but only the parameters with `moves` set may change; with one of them the
/// search stays on an iso-curve. The descent ends when a step is below `last_step`.
pub fn foot_point_moving<S: ParametricSurface + ?Sized>(
    surface: &S,
    p: Point,
    start: Uv,
    moves: [bool; 2],
    last_step: f64,
) -> (Uv, f64) {
    let foot = descend(surface, p, start, moves, last_step);
    (foot.at, foot.distance)
}

/// The result of a descent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Foot {
    /// The parameter point.
    pub at: Uv,
    /// Point and derivatives of the surface there.
    pub jet: Jet,
    /// The distance in mm.
    pub distance: f64,
}

impl Foot {
    /// The result of [`foot_point`], with the derivatives at the foot point.
    pub(crate) fn find<S: ParametricSurface + ?Sized>(surface: &S, p: Point, start: Uv) -> Self {
        descend(surface, p, start, [true; 2], ACCURACY)
    }
}

/// The descent of [`foot_point_moving`].
pub(super) fn descend<S: ParametricSurface + ?Sized>(
    surface: &S,
    p: Point,
    start: Uv,
    moves: [bool; 2],
    last_step: f64,
) -> Foot {
    let mut at = surface.clamp(start);
    let mut jet = surface.jet(at);
    let mut distance = (jet.s - p).norm_squared();
    for _ in 0..STEPS {
        let r = jet.s - p;
        let gradient = Vector2::new(r.dot(&jet.su), r.dot(&jet.sv));
        let metric = Matrix2::new(
            jet.su.norm_squared(),
            jet.su.dot(&jet.sv),
            jet.su.dot(&jet.sv),
            jet.sv.norm_squared(),
        );
        let bend = Matrix2::new(r.dot(&jet.suu), r.dot(&jet.suv), r.dot(&jet.suv), r.dot(&jet.svv));
        let inside = free_axes(surface, at, gradient);
        let free = [moves[0] && inside[0], moves[1] && inside[1]];
        let Some(step) = descent(metric + bend, metric, gradient, free) else { break };
        let mut share = 1.0;
        let nearer = loop {
            let next = surface.clamp(at + share * step);
            let there = surface.jet(next);
            let d = (there.s - p).norm_squared();
            if d < distance {
                break Some((next, there, d));
            }
            share *= 0.5;
            // A step below the last step length fails only because of rounding.
            if share < 1e-3 || (share * step).amax() < last_step {
                break None;
            }
        };
        let Some((next, there, d)) = nearer else { break };
        let moved = (next - at).amax();
        (at, jet, distance) = (next, there, d);
        if moved < last_step {
            break;
        }
    }
    Foot { at, jet, distance: distance.sqrt() }
}

/// Which parameters may change. A parameter at the end of its range may not if the descent leads
/// out of the range.
fn free_axes<S: ParametricSurface + ?Sized>(
    surface: &S,
    at: Uv,
    gradient: Vector2<f64>,
) -> [bool; 2] {
    let held =
        |x: f64, g: f64, (low, high): (f64, f64)| (x <= low && g > 0.0) || (x >= high && g < 0.0);
    let [u, v] = surface.ranges();
    [!held(at.x, gradient.x, u), !held(at.y, gradient.y, v)]
}

fn descent(
    hessian: Matrix2<f64>,
    metric: Matrix2<f64>,
    g: Vector2<f64>,
    free: [bool; 2],
) -> Option<Vector2<f64>> {
    let along = |k: usize| {
        let curvature = if hessian[(k, k)] > 0.0 { hessian[(k, k)] } else { metric[(k, k)] };
        (curvature > 0.0).then(|| -g[k] / curvature)
    };
    match free {
        [true, true] => {
            let factor = hessian.cholesky().or_else(|| metric.cholesky());
            factor.map(|f| -f.solve(&g))
        }
        [true, false] => along(0).map(|d| Vector2::new(d, 0.0)),
        [false, true] => along(1).map(|d| Vector2::new(0.0, d)),
        [false, false] => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::spline::{KnotVector, Surface};

    fn bump() -> Surface {
        let k = KnotVector::uniform(3, 8);
        let height = |i: usize, j: usize| ((i * 3 + j * 5) % 7) as f64;
        let net = (0..64).map(|n| {
            let (i, j) = (n / 8, n % 8);
            Vector::new(100.0 * k.greville(i), 100.0 * k.greville(j), height(i, j))
        });
        Surface::new(k.clone(), k.clone(), net.collect())
    }

    #[test]
    fn a_point_off_the_surface_falls_back_along_the_normal() {
        let s = bump();
        for (u, v) in [(0.5, 0.5), (0.13, 0.92), (0.0, 0.3), (1.0, 1.0)] {
            let jet = s.jet(Uv::new(u, v));
            let n = jet.su.cross(&jet.sv).normalize();
            let (at, d) = foot_point(&s, jet.s + 0.4 * n, Uv::new(u + 0.03, v - 0.02));
            assert!((at - Uv::new(u, v)).norm() < 1e-7 && (d - 0.4).abs() < 1e-9);
        }
    }

    #[test]
    fn a_point_beyond_the_edge_has_its_foot_on_the_edge() {
        let (at, _) = foot_point(&bump(), Point::new(-20.0, 50.0, 3.0), Uv::new(0.3, 0.3));
        assert_eq!(at.x, 0.0);
        assert!((at.y - 0.5).abs() < 0.1);
    }
}
