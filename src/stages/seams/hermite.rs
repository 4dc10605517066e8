//! Cubic interpolation of points at given parameters, as a clamped B-spline with double knots.

use formats::spline::SplineCurve;

/// So many points of the other end continue a closed curve. The influence of a point falls by a factor of 3.7 for each.
const AROUND: usize = 24;

/// The curve through points at rising parameters. Its second derivative is continuous. If the points are closed, the
/// first and the last are the same, and so are the tangents.
pub(super) fn through<const D: usize>(
    t: &[f64],
    points: &[[f64; D]],
    is_closed: bool,
) -> Result<SplineCurve<D>, String> {
    let n = t.len();
    if n < 2 || points.len() != n {
        return Err("a curve through less than two points".into());
    }
    let slopes = if is_closed && n > 3 { closed_slopes(t, points) } else { slopes(t, points) };
    with_slopes(t, points, &slopes)
}

/// The curve through points at rising parameters with given derivatives there.
pub(super) fn with_slopes<const D: usize>(
    t: &[f64],
    points: &[[f64; D]],
    slopes: &[[f64; D]],
) -> Result<SplineCurve<D>, String> {
    let n = t.len();
    let mut poles = vec![points[0]];
    let mut knots = vec![t[0]; 4];
    for i in 0..n - 1 {
        let h = (t[i + 1] - t[i]) / 3.0;
        poles.push(std::array::from_fn(|k| points[i][k] + h * slopes[i][k]));
        poles.push(std::array::from_fn(|k| points[i + 1][k] - h * slopes[i + 1][k]));
        if i + 2 < n {
            knots.extend([t[i + 1]; 2]);
        }
    }
    poles.push(points[n - 1]);
    knots.extend([t[n - 1]; 4]);
    SplineCurve::new(3, knots, poles, None)
}

fn closed_slopes<const D: usize>(t: &[f64], points: &[[f64; D]]) -> Vec<[f64; D]> {
    let n = t.len() - 1;
    let period = t[n] - t[0];
    let pad = AROUND as isize;
    let indices = -pad..=(n as isize + pad);
    let (mut long_t, mut long_points) = (Vec::new(), Vec::new());
    for i in indices {
        let (lap, k) = (i.div_euclid(n as isize), i.rem_euclid(n as isize) as usize);
        long_t.push(t[k] + lap as f64 * period);
        long_points.push(points[k]);
    }
    let all = slopes(&long_t, &long_points);
    let mut own = all[AROUND..=AROUND + n].to_vec();
    own[n] = own[0];
    own
}

/// The slopes of the interpolating cubic spline. Those at the ends are of the polynomial through the five points there.
pub(super) fn slopes<const D: usize>(t: &[f64], points: &[[f64; D]]) -> Vec<[f64; D]> {
    let n = t.len();
    let mut slopes = vec![[0.0; D]; n];
    let near = n.min(5);
    slopes[0] = end_slope(&t[..near], &points[..near], 0);
    slopes[n - 1] = end_slope(&t[n - near..], &points[n - near..], near - 1);
    // The Thomas algorithm for the continuity of the second derivative.
    let mut share = vec![0.0; n];
    for i in 1..n - 1 {
        let (h, g) = (t[i] - t[i - 1], t[i + 1] - t[i]);
        let (a, b, c) = (1.0 / h, 2.0 / h + 2.0 / g, 1.0 / g);
        let pivot = b - a * share[i - 1];
        share[i] = c / pivot;
        for k in 0..D {
            let right = 3.0 * (points[i][k] - points[i - 1][k]) / (h * h)
                + 3.0 * (points[i + 1][k] - points[i][k]) / (g * g);
            slopes[i][k] = (right - a * slopes[i - 1][k]) / pivot;
        }
    }
    for i in (1..n - 1).rev() {
        let next = slopes[i + 1];
        slopes[i].iter_mut().zip(next).for_each(|(slope, after)| *slope -= share[i] * after);
    }
    slopes
}

/// The derivative at one point of the polynomial through some, by Lagrange's formula.
fn end_slope<const D: usize>(t: &[f64], points: &[[f64; D]], at: usize) -> [f64; D] {
    let n = t.len();
    let weight = |j: usize| -> f64 {
        let others = || (0..n).filter(move |&m| m != j);
        if j == at {
            return others().map(|m| 1.0 / (t[j] - t[m])).sum();
        }
        let top: f64 = others().filter(|&m| m != at).map(|m| t[at] - t[m]).product();
        let bottom: f64 = others().map(|m| t[j] - t[m]).product();
        top / bottom
    };
    std::array::from_fn(|k| (0..n).map(|j| weight(j) * points[j][k]).sum())
}
