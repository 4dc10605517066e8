//! Curves on one surface through given points: cubic pieces whose middles lie on the surface.
//!
//! A piece leaves its ends along the surface. One length is free, the distance of its inner control points from its ends, and puts its middle onto the
//! surface. So its distance from the surface falls with the fifth power of its length, and with the sixth where it bends evenly: a circle
//! needs a piece for every 9°. A curve that interpolates falls with the fourth power only. The parameter is nearly the length of the curve.

use formats::brep::BrepCurve;
use formats::spline::SplineCurve;

use super::chart::{array, vector};
use super::curves::{MOST_POINTS, MOST_ROUNDS, SPLINE};
use super::hermite::{slopes, with_slopes};
use crate::geometry::{Point, Vector, segment_distance};
use crate::primitives::Primitive;

/// The share of the length for the numerical derivative. Its error is as small as the step, which Newton's method makes good.
const STEP: f64 = 1e-4;

/// The steps of Newton's method for the length of a piece.
const STEPS: usize = 8;

/// The length is at most so many times that of a straight piece, and at least its inverse. Others make loops.
const MOST_STRETCHED: f64 = 2.0;

/// A cubic curve rises over its chord by at most this share of what its inner control points do.
const RISES: f64 = 0.75;

/// Where pieces are compared with the surface: besides the middle and the ends, where they are on it.
const COMPARED: [f64; 4] = [0.15, 0.3, 0.7, 0.85];

/// A point of the curve with its unit tangent.
#[derive(Debug, Clone, Copy)]
struct Station {
    at: Point,
    along: Vector,
}

/// A piece between two stations.
struct LedPiece {
    ends: [Station; 2],
    /// The distance of the inner control points from the ends.
    length: f64,
}

impl LedPiece {
    /// The piece with its middle on a surface.
    fn on(surface: &Primitive, ends: [Station; 2]) -> Self {
        let third = (ends[1].at - ends[0].at).norm() / 3.0;
        let off = |length: f64| surface.distance(LedPiece { ends, length }.point(0.5)).0;
        let (mut length, mut now) = (third, off(third));
        for _ in 0..STEPS {
            let step = STEP * third;
            let slope = (off(length + step) - now) / step;
            let within = |x: f64| x.clamp(third / MOST_STRETCHED, third * MOST_STRETCHED);
            let next = within(length - now / slope);
            let then = off(next);
            // A length that does not matter stays.
            let is_better = then.abs() < now.abs();
            if !is_better {
                break;
            }
            (length, now) = (next, then);
        }
        LedPiece { ends, length }
    }

    fn poles(&self) -> [Point; 4] {
        let [from, to] = self.ends;
        let a = self.length;
        [from.at, from.at + a * from.along, to.at - a * to.along, to.at]
    }

    fn point(&self, t: f64) -> Point {
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        Point::from(self.poles().iter().zip(weights).map(|(p, w)| w * p.coords).sum::<Vector>())
    }

    fn tangent(&self, t: f64) -> Vector {
        let s = 1.0 - t;
        let [p, q, r, u] = self.poles();
        s * s * (q - p) + 2.0 * s * t * (r - q) + t * t * (u - r)
    }
}

/// The parameters of points, which are lengths along their chords, the places and the derivatives there.
type LedSlopes = (Vec<f64>, Vec<[f64; 3]>, Vec<Vector>);

fn led_by(points: &[Point], tangents: [Option<Vector>; 2], most_sagitta: Option<f64>) -> LedSlopes {
    let mut t = vec![0.0];
    for pair in points.windows(2) {
        t.push(t[t.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let places: Vec<[f64; 3]> = points.iter().map(|&p| array(p)).collect();
    let mut slopes = led_slopes(&t, &places, most_sagitta);
    let last = slopes.len() - 1;
    for (at, tangent) in [0, last].into_iter().zip(tangents) {
        slopes[at] = tangent.unwrap_or(slopes[at]);
    }
    (t, places, slopes)
}

/// The slopes of the curve through points at given parameters.
fn led_slopes(t: &[f64], places: &[[f64; 3]], most_sagitta: Option<f64>) -> Vec<Vector> {
    let mut slopes: Vec<Vector> = slopes(t, places).into_iter().map(Vector::from).collect();
    let Some(most) = most_sagitta else { return slopes };
    let points: Vec<Point> = places.iter().map(|&p| Point::from(p)).collect();
    let rises = |k: usize| {
        let third = (t[k + 1] - t[k]) / 3.0;
        let poles = [points[k] + third * slopes[k], points[k + 1] - third * slopes[k + 1]];
        poles.iter().any(|&p| RISES * segment_distance(p, points[k], points[k + 1]) > most)
    };
    if (0..t.len() - 1).any(rises) {
        limit_sagittas(&points, &mut slopes, most);
    }
    slopes
}

/// The curve through points at given parameters.
pub(super) fn led_at(
    t: &[f64],
    points: &[Point],
    most_sagitta: Option<f64>,
) -> Result<SplineCurve<3>, String> {
    let places: Vec<[f64; 3]> = points.iter().map(|&p| array(p)).collect();
    let slopes: Vec<[f64; 3]> =
        led_slopes(t, &places, most_sagitta).into_iter().map(vector).collect();
    with_slopes(t, &places, &slopes)
}

/// Makes unit vectors of slopes at points, and turns them towards the chords that they leave too steeply: an arc rises over its chord by a quarter of
/// its length times the angle at its ends. A curve with a continuous second derivative bulges over the long ones among chords of very uneven lengths,
/// where the mesher found the model flat.
fn limit_sagittas(points: &[Point], slopes: &mut [Vector], most: f64) {
    for (k, slope) in slopes.iter_mut().enumerate() {
        let before = k.checked_sub(1).map(|j| points[k] - points[j]);
        let after = points.get(k + 1).map(|next| next - points[k]);
        let mut chords: Vec<Vector> = before.into_iter().chain(after).collect();
        // The longest one has the last word.
        chords.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        let bisector: Vector = chords.iter().map(|chord| chord.normalize()).sum();
        *slope = if chords.len() == 2 { bisector } else { *slope };
        for chord in chords {
            let along = chord.normalize();
            let most_angle = 4.0 * most / chord.norm();
            let aside = *slope - slope.dot(&along) * along;
            if slope.angle(&along) > most_angle
                && let Some(aside) = aside.try_normalize(f64::MIN_POSITIVE)
            {
                *slope = most_angle.cos() * along + most_angle.sin() * aside;
            }
        }
        *slope = slope.try_normalize(f64::MIN_POSITIVE).unwrap_or(*slope);
    }
}

/// The cubic curve through points, with the given directions at its ends.
pub(super) fn led_curve(
    points: &[Point],
    tangents: [Option<Vector>; 2],
    most_sagitta: Option<f64>,
) -> Result<SplineCurve<3>, String> {
    let (t, places, slopes) = led_by(points, tangents, most_sagitta);
    let slopes: Vec<[f64; 3]> = slopes.into_iter().map(vector).collect();
    with_slopes(&t, &places, &slopes)
}

/// The curve on a surface through points of it, and how far it is from the surface.
pub(super) fn followed(
    surface: &Primitive,
    points: &[Point],
    tangents: [Option<Vector>; 2],
    most_sagitta: Option<f64>,
) -> Result<(BrepCurve, f64), String> {
    let station = |at: Point, along: Vector| {
        let normal = surface.normal(at);
        let along = (along - along.dot(&normal) * normal).try_normalize(f64::MIN_POSITIVE);
        along.map(|along| Station { at, along }).ok_or("a border across its face")
    };
    let (_, _, slopes) = led_by(points, tangents, most_sagitta);
    let stations = points.iter().zip(slopes).map(|(&at, along)| station(at, along));
    let mut stations = stations.collect::<Result<Vec<Station>, &str>>()?;
    let off = |piece: &LedPiece, t: f64| surface.distance(piece.point(t)).0.abs();
    let mut rounds = 0;
    loop {
        rounds += 1;
        let pieces: Vec<LedPiece> =
            stations.windows(2).map(|ends| LedPiece::on(surface, [ends[0], ends[1]])).collect();
        let mut worst: f64 = 0.0;
        let mut finer = vec![stations[0]];
        for piece in &pieces {
            let own = COMPARED.map(|t| off(piece, t)).into_iter().fold(0.0, f64::max);
            worst = worst.max(own);
            // More pieces do not mend what an end is off.
            let ends = [0.0, 1.0].map(|t| off(piece, t)).into_iter().fold(SPLINE, f64::max);
            if own > ends {
                finer.push(station(surface.closest(piece.point(0.5)), piece.tangent(0.5))?);
            }
            finer.push(piece.ends[1]);
        }
        let is_done = finer.len() == stations.len() || finer.len() > MOST_POINTS;
        if is_done || rounds == MOST_ROUNDS {
            return Ok((BrepCurve::Spline(joined(&pieces)?), worst));
        }
        stations = finer;
    }
}

/// The pieces as one curve, whose derivative has the length 1 where they meet.
fn joined(pieces: &[LedPiece]) -> Result<SplineCurve<3>, String> {
    let mut poles = Vec::with_capacity(2 * pieces.len() + 2);
    let mut knots = vec![0.0; 4];
    let mut end = 0.0;
    for (k, piece) in pieces.iter().enumerate() {
        let [first, second, third, last] = piece.poles().map(array);
        if k == 0 {
            poles.push(first);
        } else {
            knots.extend([end; 2]);
        }
        end += 3.0 * piece.length;
        poles.extend([second, third]);
        if k + 1 == pieces.len() {
            poles.push(last);
        }
    }
    knots.extend([end; 4]);
    SplineCurve::new(3, knots, poles, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TORUS: Primitive = Primitive::Torus {
        centre: Point::new(0.0, 0.0, 0.0),
        axis: Vector::new(0.0, 0.0, 1.0),
        major: 50.0,
        minor: 8.0,
    };

    fn on_torus(u: f64, v: f64) -> Point {
        let r = 50.0 + 8.0 * v.cos();
        Point::new(r * u.cos(), r * u.sin(), 8.0 * v.sin())
    }

    #[test]
    fn a_curve_through_very_uneven_points_stays_near_long_chords() {
        // A wave whose flat parts have one long chord each.
        let points = [[-0.3, 0.4], [-0.1, 0.1], [0.0, 0.0], [5.0, -1.0], [5.1, -1.1], [5.2, -1.4]];
        let points = points.map(|[x, y]| Point::new(x, y, 0.0));
        let worst = |most: Option<f64>| {
            let curve = led_curve(&points, [None; 2], most).expect("a curve");
            let (start, end) = curve.knots().range();
            let at =
                |k: i32| Point::from(curve.point(start + (end - start) * f64::from(k) / 999.0));
            let off = |p: Point| {
                let chords = points.windows(2).map(|ends| segment_distance(p, ends[0], ends[1]));
                chords.fold(f64::INFINITY, f64::min)
            };
            (0..1000).map(|k| off(at(k))).fold(0.0, f64::max)
        };
        assert!(worst(None) > 0.2, "{}", worst(None));
        assert!(worst(Some(0.1)) <= 0.1, "{}", worst(Some(0.1)));
    }

    #[test]
    fn a_curve_through_points_of_a_surface_lies_on_it() {
        let points: Vec<Point> = (0..12)
            .map(|k| {
                let s = f64::from(k) / 11.0;
                on_torus(1.5 * s, 0.8 * (4.0 * s).sin())
            })
            .collect();
        let (curve, worst) = followed(&TORUS, &points, [None; 2], None).expect("a curve");
        assert!(worst <= SPLINE, "{worst}");
        let (start, end) = curve.range();
        for k in 0..=1000 {
            let p = Point::from(curve.point(start + (end - start) * f64::from(k) / 1000.0));
            assert!(TORUS.distance(p).0.abs() < 3e-8);
        }
        assert_eq!(curve.ends().map(Point::from), [points[0], points[11]]);
        for p in points {
            let near = |k: i32| {
                let t = start + (end - start) * f64::from(k) / 3000.0;
                (Point::from(curve.point(t)) - p).norm()
            };
            assert!((0..=3000).map(near).fold(f64::INFINITY, f64::min) < 0.05);
        }
    }
}
