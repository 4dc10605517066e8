//! The fit: what it reproduces, how it bridges gaps, and how it adapts.

use crate::common::virtual_scan::{Star, Truth, VirtualScan, relief, rolled_sheet, sheet};
use crate::common::{OneFace, face_of, face_seen};
use formats::Soup;
use scan2step::geometry::{Point, Uv, Vector};
use scan2step::spline::{KnotVector, Samples, Surface, foot_point, foot_point_moving, last_step};
use scan2step::stages::fit::{Method, fit, mean_error};
use scan2step::stages::smooth::Support;
use scan2step::{Body, Builder, Options, Stage};

const METHODS: [Method; 3] = [Method::Blend, Method::Refined, Method::Global];

/// Deterministic numbers in [0, 1).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn knots(&mut self) -> KnotVector {
        let count = 1 + (10.0 * self.next()) as usize;
        let mut breaks = vec![0.0];
        for _ in 0..count {
            breaks.push(breaks[breaks.len() - 1] + 0.2 + self.next());
        }
        let end = breaks[count];
        KnotVector::clamped(3, &breaks.iter().map(|b| b / end).collect::<Vec<_>>(), 1)
    }
}

fn samples(n: usize, random: &mut Random, point: impl Fn(Uv) -> Point) -> Samples {
    let uv: Vec<Uv> = (0..n).map(|_| Uv::new(random.next(), random.next())).collect();
    Samples {
        points: uv.iter().map(|&at| point(at)).collect(),
        weights: vec![1.0; n],
        uv,
        open: false,
    }
}

fn without(s: &Samples, gone: impl Fn(Uv) -> bool) -> Samples {
    let left = |i: &usize| !gone(s.uv[*i]);
    let (points, uv) = (0..s.len()).filter(left).map(|i| (s.points[i], s.uv[i])).unzip();
    let mut kept = Samples { points, uv, weights: Vec::new(), open: s.open };
    kept.weights = vec![1.0; kept.uv.len()];
    kept
}

fn furthest(surface: &Surface, truth: impl Fn(Uv) -> Point, places: impl Fn(Uv) -> bool) -> f64 {
    let at = (0..101 * 101).map(|i| Uv::new((i / 101) as f64 / 100.0, (i % 101) as f64 / 100.0));
    let off = |at: Uv| (surface.point(at) - truth(at)).norm();
    at.filter(|&at| places(at)).map(off).fold(0.0, f64::max)
}

fn wavy(at: Uv) -> Point {
    Point::new(100.0 * at.x, 80.0 * at.y, 6.0 * (9.0 * at.x).sin() * (7.0 * at.y).cos())
}

#[test]
fn bicubic_data_are_reproduced_over_any_knots() {
    for seed in 0..12 {
        let mut random = Random(seed);
        let c: Vec<Vector> = (0..16)
            .map(|_| Vector::new(random.next(), random.next(), random.next()) * 50.0)
            .collect();
        let exact = |at: Uv| {
            let term = |k: usize| c[k] * at.x.powi(k as i32 / 4) * at.y.powi(k as i32 % 4);
            Point::from((0..16).map(term).sum::<Vector>() + Vector::new(5e5, 5e6, 0.0))
        };
        let s = samples(20_000, &mut random, exact);
        let knots = [random.knots(), random.knots()];
        for method in METHODS {
            let (surface, _) = fit(&s, knots.clone(), method).expect("a fit");
            let off = furthest(&surface, exact, |_| true);
            // Polynomials that are extrapolated over the neighbours are badly conditioned.
            let limit = if method == Method::Blend { 1e-4 } else { 2e-6 };
            assert!(off < limit, "seed {seed}, {method:?}: {off}");
        }
    }
}

#[test]
fn refined_reaches_the_optimum_whatever_the_knots_and_gaps() {
    for seed in 0..16 {
        let mut random = Random(100 + seed);
        let s = samples(3000, &mut random, wavy);
        let noise: Vec<Vector> = (0..3000).map(|_| Vector::z() * (random.next() - 0.5)).collect();
        let mut s = s;
        s.points.iter_mut().zip(&noise).for_each(|(p, n)| *p += n);
        // Every other scan has a hole and is dense in one corner.
        let s =
            if seed % 2 == 0 { s } else { without(&s, |at| (at - Uv::new(0.6, 0.4)).norm() < 0.2) };
        let knots = [random.knots(), random.knots()];
        let error = |method| {
            let (surface, _) = fit(&s, knots.clone(), method).expect("a fit");
            let squares =
                s.uv.iter().zip(&s.points).map(|(&at, p)| (surface.point(at) - p).norm_squared());
            squares.sum::<f64>().sqrt()
        };
        let (refined, global) = (error(Method::Refined), error(Method::Global));
        assert!(refined < 1.001 * global, "seed {seed}: {refined} {global}");
    }
}

#[test]
fn the_papers_blend_is_three_times_the_optimum() {
    for seed in [4, 5, 6] {
        let scan = VirtualScan::new(sheet, [50, 50], 0.0, Vec::new(), seed);
        let s = Samples {
            open: false,
            points: scan.points.iter().map(|&p| p.into()).collect(),
            uv: scan.uv.iter().map(|&[u, v]| Uv::new(u, v)).collect(),
            weights: vec![1.0; scan.points.len()],
        };
        let [blend, refined, global] = METHODS.map(|method| {
            let knots = [KnotVector::uniform(3, 13), KnotVector::uniform(3, 13)];
            mean_error(&fit(&s, knots, method).expect("a fit").0, &s)
        });
        println!("blend {:.3}, refined {:.5} times global", blend / global, refined / global);
        assert!(blend / global < 3.1 && refined / global < 1.002);
    }
}

#[test]
fn holes_in_a_plane_stay_plane_and_those_in_waves_do_not_swing() {
    let plane =
        |at: Uv| Point::new(100.0 * at.x, 90.0 * at.y + 10.0 * at.x, 7.0 * at.x - 3.0 * at.y);
    let gap = |at: Uv| (at - Uv::new(0.5, 0.45)).norm() < 0.22 || at.x > 0.93;
    let knots = || [KnotVector::uniform(3, 30), KnotVector::uniform(3, 24)];
    for method in METHODS {
        let s = without(&samples(30_000, &mut Random(7), plane), gap);
        let (surface, _) = fit(&s, knots(), method).expect("a fit");
        let off = furthest(&surface, plane, |_| true);
        assert!(off < 1e-3, "{method:?}: {off} off the plane");
        let s = without(&samples(30_000, &mut Random(8), wavy), gap);
        let (surface, _) = fit(&s, knots(), method).expect("a fit");
        // The wave in the gap is unknown except for its rim.
        let off = furthest(&surface, wavy, |_| true);
        assert!(off < 12.0, "{method:?}: {off} off a wave of 6 mm");
        let beside = furthest(&surface, wavy, |at| !gap(at) && at.x < 0.9);
        assert!(beside < 0.05, "{method:?}: {beside} where there are samples");
    }
}

#[test]
fn noise_does_not_overshoot_at_the_edges() {
    let mut random = Random(21);
    let mut s = samples(20_000, &mut random, wavy);
    for p in &mut s.points {
        p.z += 0.2 * (random.next() + random.next() + random.next() - 1.5);
    }
    for method in METHODS {
        let knots = [KnotVector::uniform(3, 24), KnotVector::uniform(3, 24)];
        let (surface, _) = fit(&s, knots, method).expect("a fit");
        let off = furthest(&surface, wavy, |_| true);
        assert!(off < 0.3, "{method:?}: {off} with a noise of 0.1");
    }
}

#[test]
fn too_few_samples_make_a_surface_all_the_same() {
    let line = |at: Uv| Uv::new(at.x, 0.3);
    let place = Uv::new(0.4, 0.6);
    let sets: [(&str, Vec<Uv>); 5] = [
        ("one", vec![place]),
        ("many at one place", vec![place; 500]),
        ("on a line", samples(400, &mut Random(1), wavy).uv.into_iter().map(line).collect()),
        ("three", vec![place, Uv::new(0.1, 0.1), Uv::new(0.9, 0.2)]),
        ("in a corner", samples(400, &mut Random(2), wavy).uv.iter().map(|at| at * 0.05).collect()),
    ];
    for (name, uv) in sets {
        let points: Vec<Point> = uv.iter().map(|&at| wavy(at)).collect();
        let s = Samples { weights: vec![1.0; uv.len()], points, uv, open: false };
        for method in METHODS {
            let knots = [KnotVector::uniform(3, 17), KnotVector::uniform(3, 9)];
            let (surface, _) = fit(&s, knots, method).expect("a fit");
            assert!(surface.net.iter().all(|p| p.norm() < 1e4), "{name}, {method:?}");
            let off = mean_error(&surface, &s);
            let limit = if method == Method::Blend { 5.0 } else { 0.5 };
            assert!(off < limit, "{name}, {method:?}: {off}");
        }
    }
}

#[test]
fn the_same_net_on_any_number_of_threads() {
    let s =
        without(&samples(50_000, &mut Random(3), wavy), |at| (at - Uv::new(0.3, 0.3)).norm() < 0.1);
    for method in METHODS {
        let on = |threads: usize| {
            let pool =
                rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let knots = [KnotVector::uniform(3, 40), KnotVector::uniform(3, 61)];
            pool.install(|| fit(&s, knots, method).expect("a fit").0.net)
        };
        assert_eq!(on(1), on(2), "{method:?}");
        assert_eq!(on(1), on(5), "{method:?}");
    }
}

struct Run {
    scan: VirtualScan,
    conversion: Body,
    /// The measured vertices after smoothing, and those of the outer boundary.
    vertices: Vec<(Point, Uv)>,
    outer: Vec<(Point, Uv)>,
}

fn soup(scan: &VirtualScan) -> Soup {
    let mut soup = Soup { points: scan.points.clone(), ..Soup::default() };
    scan.triangles.iter().for_each(|t| soup.polygons.push(*t));
    soup
}

fn run(truth: Truth, size: [usize; 2], noise: f64, options: Builder) -> Run {
    let holes = vec![Star { centre: [0.4, 0.6], radius: 0.1, arms: 4.0 }];
    let scan = VirtualScan::new(truth, size, noise, holes, 17);
    let soup = soup(&scan);
    let (mut vertices, mut outer) = (Vec::new(), Vec::new());
    let mut watch = |stage: Stage| {
        if let Stage::Parameterize(map, _) = stage {
            let vertex = |v: usize| (map.patch.mesh.points[v], map.uv[v]);
            vertices = (0..map.patch.measured).map(vertex).collect();
            outer = map.patch.outer.iter().map(|v| vertex(v.index())).collect();
        }
        Ok(())
    };
    let options = options.build().expect("sound options");
    let conversion = face_seen(&soup, &options, &mut watch).expect("a conversion");
    Run { scan, conversion, vertices, outer }
}

fn named(tolerance: f64) -> Builder {
    Options::builder().tolerance(tolerance)
}

#[test]
fn a_named_tolerance_holds_for_points_sides_and_corners() {
    let cases: [(Truth, [usize; 2], f64, f64); 3] = [
        (sheet, [90, 90], 0.15, 0.1),
        (relief, [120, 100], 0.02, 0.02),
        (rolled_sheet, [140, 100], 0.05, 0.04),
    ];
    for (truth, size, noise, tolerance) in cases {
        let Run { conversion: c, vertices, outer, .. } = run(truth, size, noise, named(tolerance));
        let feet = vertices.iter().map(|&(p, uv)| foot_point(&c.one().surface, p, uv).1);
        let off = feet.fold(0.0, f64::max);
        assert!(off <= tolerance, "{off} from the surface");
        for &(p, uv) in &outer {
            let side = (0..2).find(|&axis| uv[axis] == 0.0 || uv[axis] == 1.0).expect("on a side");
            let (_, off) = foot_point_moving(
                &c.one().surface,
                p,
                uv,
                [side != 0, side != 1],
                last_step(&c.one().surface),
            );
            assert!(off <= tolerance, "{off} from the side of the patch");
        }
        for (p, uv) in outer.iter().filter(|(_, uv)| uv.iter().all(|t| *t == 0.0 || *t == 1.0)) {
            assert!((c.one().surface.point(*uv) - p).norm() < 1e-9, "a corner is not met");
        }
    }
}

#[test]
fn the_net_is_smaller_than_a_uniform_one_of_the_same_error() {
    let tolerance = 0.05;
    let Run { conversion: c, .. } = run(relief, [150, 120], 0.02, named(tolerance));
    let [m, n] = c.one().surface.shape();
    let uniform = |k: usize| run(relief, [150, 120], 0.02, named(tolerance).net([k, k])).conversion;
    let enough =
        (8..80).step_by(4).find(|&k| uniform(k).tolerance_met(0.0)).expect("one is enough");
    println!("{m} × {n} against {enough} × {enough}");
    assert!(c.tolerance_met(0.0) && 2 * m * n < enough * enough, "{m} × {n}, {enough}²");
}

#[test]
fn the_bound_on_the_net_holds_and_a_miss_is_told() {
    let Run { conversion: c, .. } = run(relief, [100, 80], 0.02, named(0.02).max_net(150));
    let [m, n] = c.one().surface.shape();
    assert!(m * n <= 150, "{m} × {n}");
    assert!(!c.tolerance_met(0.0) && c.fit_deviation.max > 0.02);
}

#[test]
fn without_a_tolerance_the_face_is_nearer_the_truth_than_the_noise() {
    let cases: [(Truth, [usize; 2], f64, f64); 4] = [
        (sheet, [90, 90], 0.15, 0.03),
        (relief, [150, 120], 0.06, 0.02),
        (rolled_sheet, [200, 200], 0.05, 0.010),
        (sheet, [120, 120], 0.5, 0.1),
    ];
    for (truth, size, noise, limit) in cases {
        let Run { scan, conversion: c, .. } = run(truth, size, noise, Options::builder());
        let at = |i: usize| Uv::new((i / 80) as f64 / 79.0, (i % 80) as f64 / 79.0);
        let measured = |at: &Uv| {
            let p = c.one().surface.point(*at);
            scan.points.iter().any(|q| (p - Point::from(*q)).norm() < 2.0)
        };
        let places = (0..6400).map(at).filter(measured);
        let off = scan.rms(places.map(|at| c.one().surface.point(at).coords.into()));
        println!("noise {noise}: {:?}, {off:.4} off the truth", c.one().surface.shape());
        assert!(off < limit, "noise {noise}: {off}");
    }
}

#[test]
fn outliers_pull_nothing_where_smoothing_is_off() {
    for (truth, size, noise, limit) in
        [(sheet as Truth, [90, 90], 0.1, 0.03), (relief, [150, 120], 0.06, 0.025)]
    {
        let mut scan = VirtualScan::new(truth, size, noise, Vec::new(), 17);
        // One vertex of a hundred is moved by up to 3 mm along the scanner's rays.
        let mut random = Random(9);
        for p in &mut scan.points {
            p[2] += if random.next() < 0.01 { 6.0 * (random.next() - 0.5) } else { 0.0 };
        }
        let soup = soup(&scan);
        let options = Options::builder().smooth(Support::Off).build().expect("sound options");
        let c = face_of(&soup, &options).expect("a conversion");
        let at = |i: usize| Uv::new((i / 80) as f64 / 79.0, (i % 80) as f64 / 79.0);
        let off = scan.rms((0..6400).map(|i| c.one().surface.point(at(i)).coords.into()));
        println!("{:?}, {off:.4} off the truth", c.one().surface.shape());
        assert!(off < limit, "{off} with a noise of {noise}");
    }
}

#[test]
fn a_foot_is_where_the_normal_meets() {
    let s = samples(20_000, &mut Random(5), wavy);
    let knots = [KnotVector::uniform(3, 14), KnotVector::uniform(3, 14)];
    let (surface, _) = fit(&s, knots, Method::Refined).expect("a fit");
    for i in 0..200 {
        let at = Uv::new(0.02 + 0.0048 * f64::from(i), 0.98 - 0.0047 * f64::from(i));
        let jet = surface.jet(at);
        let p = jet.s + 0.3 * jet.su.cross(&jet.sv).normalize();
        let (foot, off) =
            foot_point(&surface, p, at + scan2step::geometry::UvVector::new(0.01, -0.01));
        assert!((foot - at).norm() < 1e-9 && (off - 0.3).abs() < 1e-12, "{foot} {at} {off}");
    }
}

#[test]
fn a_tolerance_below_the_noise_is_told_and_not_followed() {
    let noise = 0.05;
    let scan = VirtualScan::new(sheet, [70, 70], noise, Vec::new(), 5);
    let soup = soup(&scan);
    let converted = |tolerance: f64| {
        let options = Options::builder().smooth(Support::Off).tolerance(tolerance);
        face_seen(&soup, &options.build().expect("sound options"), &mut |_| Ok(())).expect("a face")
    };
    let below = converted(2.0 * noise);
    let told = below.one().adapted.hindrance.expect("noise in the way");
    // The part of the shape that the net still misses counts, too.
    assert!((0.95..1.2).contains(&(told / noise)), "{told}");
    let shape = below.one().surface.shape();
    assert!(!below.tolerance_met(0.0) && shape.iter().product::<usize>() < 4900 / 2, "{shape:?}");
    let above = converted(6.0 * noise);
    assert!(
        above.one().adapted.hindrance.is_none() && above.tolerance_met(0.0),
        "{:?}",
        above.missed
    );
}
