//! Nearest points of trimmed faces compared with brute force.

use crate::common::random::Random;
use nalgebra::Vector2;
use rayon::prelude::*;
use scan2step::deviation::TrimmedFace;
use scan2step::geometry::{Point, Uv, Vector};
use scan2step::spline::{Curve, EdgeTree, KnotVector, Surface, foot_point};

/// The largest difference of distances as a share of the diagonal.
const SAME: f64 = 1e-6;

/// The number of samples along a side of the domain for brute force.
const SIDE: usize = 300;

/// Knots with simple inner ones whose spans differ up to tenfold.
fn knots(random: &mut Random, spans: usize) -> KnotVector {
    let mut breaks = vec![0.0];
    for _ in 0..spans {
        breaks.push(breaks[breaks.len() - 1] + 0.1 + random.share());
    }
    let end = breaks[spans];
    breaks.iter_mut().for_each(|t| *t /= end);
    KnotVector::clamped(3, &breaks, 1)
}

/// A shape of a sheet of about 100 mm.
type Shape = fn(f64, f64) -> [f64; 3];

const SHAPES: [(&str, Shape); 4] = [
    ("wavy", |u, v| [100.0 * u, 80.0 * v, 8.0 * (9.0 * u).sin() * (7.0 * v).cos()]),
    ("rolled", |u, v| {
        let (angle, radius) = (11.0 * u, 15.0 + 6.0 * u);
        [radius * angle.cos(), radius * angle.sin(), 80.0 * v]
    }),
    ("folded", |u, v| {
        let (s, c) = (std::f64::consts::TAU * 1.5 * u).sin_cos();
        [20.0 * s * (1.0 + 0.3 * v), 12.0 * u - 3.0 * c, 80.0 * v + 5.0 * s]
    }),
    ("ball", |u, v| {
        let ((a, b), (c, d)) = ((2.0 * u).sin_cos(), (2.0 * v - 1.0).sin_cos());
        [50.0 * a * d, 50.0 * b * d, 50.0 * c]
    }),
];

fn surface(shape: Shape, random: &mut Random) -> Surface {
    let (u, v) = (knots(random, 14), knots(random, 9));
    let mut net = Vec::new();
    for i in 0..u.functions() {
        for j in 0..v.functions() {
            let noise = Vector::new(random.share(), random.share(), random.share());
            net.push(Vector::from(shape(u.greville(i), v.greville(j))) + 0.3 * noise);
        }
    }
    Surface::new(u, v, net)
}

/// A closed wavy loop of one cubic arc around a place.
fn round(middle: Uv, radius: f64, waves: f64) -> Vec<Curve<2>> {
    let n = 24;
    let knots = KnotVector::new(3, (0..n + 7).map(f64::from).collect());
    let control = (0..n + 3).map(|i| {
        let angle = std::f64::consts::TAU * f64::from(i % n) / f64::from(n);
        let r = radius * (1.0 + 0.2 * (waves * angle).sin());
        Vector2::new(middle.x + r * angle.cos(), middle.y + r * angle.sin())
    });
    vec![Curve::new(knots, control.collect())]
}

/// Loops, and whether the face extends to the boundary of the surface.
fn trims() -> Vec<(Vec<Vec<Curve<2>>>, bool)> {
    let at = |x: f64, y: f64, r: f64, w: f64| round(Uv::new(x, y), r, w);
    vec![
        (vec![], true),
        (vec![at(0.4, 0.5, 0.2, 3.0)], true),
        (vec![at(0.5, 0.5, 0.35, 5.0)], false),
        (vec![at(0.5, 0.5, 0.4, 2.0), at(0.45, 0.5, 0.25, 4.0), at(0.45, 0.5, 0.1, 3.0)], false),
    ]
}

/// Samples of the surface, each with whether it is on the face.
fn samples(face: &TrimmedFace<Surface>) -> Vec<(Uv, Point, bool)> {
    let at = |n: usize| [n / SIDE, n % SIDE].map(|i| i as f64 / (SIDE - 1) as f64);
    let all = (0..SIDE * SIDE).into_par_iter().map(|n| {
        let [u, v] = at(n);
        let at = Uv::new(u, v);
        (at, face.surface().point(at), face.contains(at))
    });
    all.collect()
}

/// The distance by brute force: foot points are searched from every sample whose cell may contain
/// the nearest one, and the trim curves are searched by samples and golden sections.
fn brute(
    face: &TrimmedFace<Surface>,
    samples: &[(Uv, Point, bool)],
    curves: &[&Curve<2>],
    p: Point,
) -> f64 {
    let step = 1.5 * face.surface().speed() / (SIDE - 1) as f64;
    let near = samples.iter().filter(|s| s.2).map(|s| (s.1 - p).norm());
    let best = near.fold(f64::INFINITY, f64::min);
    let mut best = curves.iter().map(|curve| along(face.surface(), curve, p)).fold(best, f64::min);
    let from: Vec<&(Uv, Point, bool)> =
        samples.iter().filter(|s| (s.1 - p).norm() < best + step.min(4.0)).collect();
    for (at, ..) in from.into_iter().step_by(3) {
        let (foot, distance) = foot_point(face.surface(), p, *at);
        if face.contains(foot) {
            best = best.min(distance);
        }
    }
    best
}

/// The distance from a trim curve.
fn along(surface: &Surface, curve: &Curve<2>, p: Point) -> f64 {
    let (low, high) = curve.knots.range();
    let away = |t: f64| (surface.point(Uv::from(curve.point(t.clamp(low, high)))) - p).norm();
    least(&away, (low, high), 600)
}

/// The minimum of a function between two parameters: samples, and a ternary search around each
/// sample that is less than its neighbours.
fn least(of: &dyn Fn(f64) -> f64, (low, high): (f64, f64), count: u32) -> f64 {
    let step = (high - low) / f64::from(count);
    let all: Vec<f64> = (0..=count).map(|i| of(low + step * f64::from(i))).collect();
    let mut best = f64::INFINITY;
    for i in 0..all.len() {
        let (before, after) = (all[i.saturating_sub(1)], all[(i + 1).min(all.len() - 1)]);
        if all[i] <= before && all[i] <= after {
            let middle = low + step * i as f64;
            let (mut a, mut b) = ((middle - step).max(low), (middle + step).min(high));
            for _ in 0..60 {
                let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                if of(c) < of(d) { b = d } else { a = c }
            }
            best = best.min(of(a));
        }
    }
    best
}

/// Points near the surface and far from it, and starts of the search, most of which are bad.
fn points(surface: &Surface, random: &mut Random, count: usize) -> Vec<(Point, Uv)> {
    let place = |random: &mut Random| Uv::new(random.share(), random.share());
    let one = |_| {
        let at = place(random);
        let far = [0.05, 1.0, 10.0, 60.0][random.below(4)];
        let off = Vector::new(random.share() - 0.5, random.share() - 0.5, random.share() - 0.5);
        let start = if random.below(3) == 0 { at } else { place(random) };
        (surface.point(at) + far * off, start)
    };
    (0..count).map(one).collect()
}

#[test]
fn the_nearest_point_is_that_of_brute_force() {
    let mut random = Random(7);
    for (name, shape) in SHAPES {
        for (loops, natural) in trims() {
            let surface = surface(shape, &mut random);
            let face = TrimmedFace::new(&surface, loops.iter().map(Vec::as_slice), natural);
            let samples = samples(&face);
            let curves: Vec<&Curve<2>> = loops.iter().flatten().collect();
            let points = points(&surface, &mut random, 150);
            points.par_iter().for_each(|&(p, start)| {
                let expected = brute(&face, &samples, &curves, p);
                for start in [Some(start), None] {
                    let (at, found) = face.nearest(p, start);
                    assert!(
                        (found - expected).abs() < SAME * 100.0,
                        "{name}, {} loops, {natural}, {p}: {found} and not {expected}",
                        loops.len()
                    );
                    assert!((found - (surface.point(at) - p).norm()).abs() < SAME * 100.0);
                }
            });
        }
    }
}

/// Two sheets of one face at a distance of 4 mm, as in a car's door. The starts of points of one
/// sheet are on the other. Newton's method would end on the wrong sheet.
#[test]
fn a_bad_start_on_another_sheet_does_not_matter() {
    let (u, v) = (KnotVector::uniform(3, 40), KnotVector::uniform(3, 12));
    let hem = |u: f64, v: f64| {
        let x = 100.0 * (u - 0.5);
        Vector::new((x * x + 1.0).sqrt(), 80.0 * v, 2.0 * (x / 2.0).tanh())
    };
    let greville = |n: usize| hem(u.greville(n / 12), v.greville(n % 12));
    let surface = Surface::new(u.clone(), v.clone(), (0..40 * 12).map(greville).collect());
    let face = TrimmedFace::new(&surface, std::iter::empty(), true);
    let mut trapped = 0;
    for i in 0..200 {
        let at = Uv::new(0.55 + 0.002 * f64::from(i), 0.1 + 0.004 * f64::from(i));
        let p = surface.point(at);
        let start = Uv::new(1.0 - at.x, at.y);
        trapped += u32::from(foot_point(&surface, p, start).1 > 1.0);
        assert!(face.distance(p, start) < 1e-5, "{at}");
    }
    assert!(trapped > 100, "the starts are not bad: {trapped}");
}

#[test]
fn any_number_of_threads_finds_the_same_bits() {
    let mut random = Random(11);
    let surface = surface(SHAPES[2].1, &mut random);
    let loops = [round(Uv::new(0.4, 0.5), 0.2, 3.0)];
    let (points, starts): (Vec<Point>, Vec<Uv>) =
        points(&surface, &mut random, 3000).into_iter().unzip();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let face = TrimmedFace::new(&surface, loops.iter().map(Vec::as_slice), true);
            face.deviation(&points, &starts).distances
        })
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn edges_are_as_far_as_brute_force_says() {
    let mut random = Random(5);
    let edge = |random: &mut Random| {
        let knots = knots(random, 20);
        let control = (0..knots.functions()).map(|i| {
            let noise = Vector::new(random.share(), random.share(), random.share());
            Vector::new(5.0 * i as f64, 0.0, 0.0) + 20.0 * noise
        });
        Curve::new(knots.clone(), control.collect())
    };
    let edges = [edge(&mut random), edge(&mut random)];
    let tree = EdgeTree::new(&edges);
    for _ in 0..300 {
        let p = Point::new(100.0 * random.share(), 40.0 * random.share(), 40.0 * random.share());
        let away = |edge: &Curve<3>, t: f64| (Point::from(edge.point(t)) - p).norm();
        let expected = edges.iter().map(|edge| least(&|t| away(edge, t), (0.0, 1.0), 4000));
        let expected = expected.fold(f64::INFINITY, f64::min);
        let found = tree.distance(p);
        assert!((found - expected).abs() < SAME * 100.0, "{found} {expected}");
    }
    assert_eq!(EdgeTree::new(&[]).distance(Point::origin()), f64::INFINITY);
}
