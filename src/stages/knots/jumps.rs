//! The effect of each knot line on a cubic spline surface.
//!
//! The third derivative of a cubic spline is constant between two knots and jumps at them. The jump
//! times the cubed length of a span, in mm, measures how far the surface would move without the
//! knot line. Measured at the lines around a span, it estimates what a knot in the middle of the
//! span could achieve.

use rayon::prelude::*;

use crate::geometry::{Uv, Vector};
use crate::spline::{Jet, Surface};

/// The jumps of the third derivatives of a surface across its knot lines.
pub(crate) struct Jumps {
    /// Breakpoints in u and v.
    pub breaks: [Vec<f64>; 2],
    /// `at[axis][line][span]` is the jump across an inner knot line of `axis` in a span of the
    /// other axis, in mm per cubed parameter unit.
    at: [Vec<Vec<f64>>; 2],
}

impl Jumps {
    /// Computes the jumps in the middles of the spans.
    pub(super) fn new(surface: &Surface) -> Self {
        let breaks = [surface.u.breaks(), surface.v.breaks()];
        let along_u = |u: f64, v: f64| Uv::new(u, v);
        let along_v = |v: f64, u: f64| Uv::new(u, v);
        let at = [
            jumps(surface, &breaks[0], &breaks[1], along_u, |jet| jet.suu),
            jumps(surface, &breaks[1], &breaks[0], along_v, |jet| jet.svv),
        ];
        Jumps { breaks, at }
    }

    /// The largest effect on the surface of inner line `line` of an axis, in mm. Lines are counted
    /// from 0.
    pub(crate) fn of_line(&self, axis: usize, line: usize) -> f64 {
        let b = &self.breaks[axis][line..line + 3];
        let length = ((b[1] - b[0]) * (b[2] - b[1])).powf(1.5);
        length * self.at[axis][line].iter().copied().fold(0.0, f64::max)
    }

    /// The effect in cell `place` that a line in the middle of span `place[axis]` could have. It is
    /// infinite if the axis has no inner line yet.
    pub(crate) fn of_cell(&self, axis: usize, place: [usize; 2]) -> f64 {
        let (span, other) = (place[axis], place[1 - axis]);
        let length = self.breaks[axis][span + 1] - self.breaks[axis][span];
        let lines = span.saturating_sub(1)..(span + 1).min(self.at[axis].len());
        let jump = lines.map(|line| self.at[axis][line][other]).reduce(f64::max);
        jump.map_or(f64::INFINITY, |jump| jump * length.powi(3))
    }
}

fn jumps(
    surface: &Surface,
    along: &[f64],
    other: &[f64],
    place: impl Fn(f64, f64) -> Uv + Sync,
    second: impl Fn(&Jet) -> Vector + Sync,
) -> Vec<Vec<f64>> {
    let middles: Vec<f64> = other.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    // Second derivatives are continuous, and linear between two knots.
    let row = |&t: &f64| -> Vec<Vector> {
        middles.iter().map(|&s| second(&surface.jet(place(t, s)))).collect()
    };
    let seconds: Vec<Vec<Vector>> = along.par_iter().map(row).collect();
    let third =
        |i: usize, n: usize| (seconds[i + 1][n] - seconds[i][n]) / (along[i + 1] - along[i]);
    let jump =
        |i: usize| (0..middles.len()).map(|n| (third(i, n) - third(i - 1, n)).norm()).collect();
    (1..along.len() - 1).map(jump).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spline::KnotVector;

    #[test]
    fn a_cubic_with_one_break_jumps_there_only() {
        // x = u; z = (u − ½)³ beyond ½ and 0 before it. The third derivative jumps by 6.
        let u = KnotVector::clamped(3, &[0.0, 0.25, 0.5, 1.0], 1);
        let v = KnotVector::uniform(3, 5);
        let polar = |a: [f64; 3]| -> f64 {
            // The blossom of the piece that contains the middle one of the three knots.
            if a[1] < 0.5 || a[0] < 0.5 { 0.0 } else { a.iter().map(|t| t - 0.5).product() }
        };
        let mut net = Vec::new();
        for i in 0..u.functions() {
            for j in 0..v.functions() {
                let k = u.knots();
                let z = polar([k[i + 1], k[i + 2], k[i + 3]]);
                net.push(Vector::new(u.greville(i), v.greville(j), z));
            }
        }
        let jumps = Jumps::new(&Surface::new(u, v, net));
        assert!(jumps.of_line(0, 0) < 1e-9 && jumps.of_line(1, 0) < 1e-9);
        assert!((jumps.of_line(0, 1) - 6.0 * (0.25f64 * 0.5).powf(1.5)).abs() < 1e-9);
        assert!(jumps.of_cell(0, [0, 1]) < 1e-9 && jumps.of_cell(0, [2, 1]) > 0.5);
    }
}
