//! Properties of distances and fits, near degenerate shapes as well.

use std::f64::consts::TAU;

use nalgebra::Rotation3;

use super::*;
use crate::geometry::random::scattered;
use crate::geometry::{Point, Uv, Vector};

/// A number in [0, 1).
fn share(n: &mut u64) -> f64 {
    *n += 1;
    (scattered(*n) >> 11) as f64 / (1u64 << 53) as f64
}

fn between(n: &mut u64, low: f64, high: f64) -> f64 {
    low + (high - low) * share(n)
}

/// A turn and a shift of any size up to `far`.
fn pose(n: &mut u64, far: f64) -> (Rotation3<f64>, Vector) {
    let axis = Vector::new(share(n) - 0.5, share(n) - 0.5, share(n) - 0.5);
    let shift = Vector::new(share(n) - 0.5, share(n) - 0.5, share(n) - 0.5) * 2.0 * far;
    (Rotation3::new(axis * 6.0), shift)
}

fn posed(surface: Primitive, (turn, shift): (Rotation3<f64>, Vector)) -> Primitive {
    let place = |p: Point| turn * p + shift;
    match surface {
        Primitive::Plane { origin, normal } => {
            Primitive::Plane { origin: place(origin), normal: turn * normal }
        }
        Primitive::Cylinder { origin, axis, radius } => {
            Primitive::Cylinder { origin: place(origin), axis: turn * axis, radius }
        }
        Primitive::Cone { origin, axis, radius, angle } => {
            Primitive::Cone { origin: place(origin), axis: turn * axis, radius, angle }
        }
        Primitive::Sphere { centre, radius } => Primitive::Sphere { centre: place(centre), radius },
        Primitive::Torus { centre, axis, major, minor } => {
            Primitive::Torus { centre: place(centre), axis: turn * axis, major, minor }
        }
    }
}

/// One surface of every kind of ordinary shape, about the origin.
fn ordinary(n: &mut u64) -> [Primitive; 5] {
    let (origin, axis) = (Point::origin(), Vector::z());
    let radius = between(n, 0.5, 20.0);
    [
        Primitive::Plane { origin, normal: axis },
        Primitive::Cylinder { origin, axis, radius },
        Primitive::Cone { origin, axis, radius, angle: between(n, 0.05, 1.4) },
        Primitive::Sphere { centre: origin, radius },
        Primitive::Torus {
            centre: origin,
            axis,
            major: radius * between(n, 1.2, 9.0),
            minor: radius,
        },
    ]
}

/// Points with parameters in a range, and the surface's normals there.
fn patch(surface: &Primitive, u: [f64; 2], v: [f64; 2], n: &mut u64) -> Vec<(Point, Vector)> {
    (0..60)
        .map(|_| {
            let uv = Uv::new(between(n, u[0], u[1]), between(n, v[0], v[1]));
            let p = surface.point_at(uv);
            (p, surface.normal(p))
        })
        .collect()
}

fn faces(points: &[(Point, Vector)]) -> Vec<OrientedPoint> {
    points.iter().map(|&(centre, normal)| OrientedPoint { centre, normal, area: 1.0 }).collect()
}

/// The range of v of a patch that is neither tiny nor closed.
fn heights(surface: &Primitive) -> [f64; 2] {
    match *surface {
        Primitive::Plane { .. } => [-5.0, 5.0],
        Primitive::Cylinder { radius, .. } => [-radius, radius],
        Primitive::Cone { radius, angle, .. } => {
            [-0.6 * radius / angle.tan(), radius / angle.tan()]
        }
        Primitive::Sphere { .. } => [-0.6, 1.2],
        Primitive::Torus { .. } => [0.3, 2.6],
    }
}

#[test]
fn points_of_a_surface_have_distance_zero() {
    let mut n = 1;
    for _ in 0..200 {
        for surface in ordinary(&mut n) {
            let pose = pose(&mut n, 1000.0);
            let surface = posed(surface, pose);
            let v = heights(&surface);
            for _ in 0..5 {
                let uv = Uv::new(between(&mut n, 0.1, 6.0), between(&mut n, v[0], v[1]));
                let p = surface.point_at(uv);
                assert!(surface.distance(p).0.abs() < 1e-10, "{surface:?}");
            }
        }
    }
}

#[test]
fn the_gradient_is_that_of_the_distance_and_the_closest_point_is_on_the_surface() {
    let mut n = 2;
    for _ in 0..200 {
        for surface in ordinary(&mut n) {
            let pose = pose(&mut n, 10.0);
            let surface = posed(surface, pose);
            let on =
                surface.point_at(Uv::new(between(&mut n, 0.0, TAU), heights(&surface)[1] * 0.5));
            let p = on + 0.2 * surface.normal(on) + 0.1 * Vector::new(share(&mut n), 0.0, 0.0);
            let (d, g) = surface.distance(p);
            assert!((g.norm() - 1.0).abs() < 1e-12);
            assert!(surface.distance(surface.closest(p)).0.abs() < 1e-10);
            for (k, step) in [Vector::x(), Vector::y(), Vector::z()].into_iter().enumerate() {
                let slope = (surface.distance(p + 1e-6 * step).0 - d) / 1e-6;
                assert!((slope - g[k]).abs() < 1e-4, "{surface:?}");
            }
        }
    }
}

#[test]
fn the_motions_derivatives_are_those_of_the_moved_surface() {
    let mut n = 3;
    for _ in 0..50 {
        for surface in ordinary(&mut n) {
            let pose = pose(&mut n, 10.0);
            let surface = posed(surface, pose);
            let points = patch(&surface, [0.3, 1.4], heights(&surface), &mut n);
            let pivot = points[0].0 + 0.1 * points[0].1;
            for fixed in [false, true] {
                let motions = Motions::new(surface, pivot, fixed);
                for &(p, normal) in &points[..10] {
                    let p = p + 0.05 * normal;
                    let (d, row) = motions.row(p);
                    for k in 0..surface.kind().parameters() {
                        let mut step = MotionRow::zeros();
                        step[k] = 1e-7;
                        let moved = motions.moved(&step).unwrap();
                        let slope = (moved.distance(p).0 - d) / 1e-7;
                        assert!(
                            (slope - row[k]).abs() < 1e-4 * (1.0 + row[k].abs()),
                            "{surface:?} {k}"
                        );
                    }
                }
            }
        }
    }
}

/// Fits from the starts of a kind; the best worst distance in units of the error.
fn best(kind: PrimitiveKind, points: &[(Point, Vector)], error: f64) -> Option<PrimitiveFit> {
    let places: Vec<Point> = points.iter().map(|p| p.0).collect();
    let samples: Vec<FitSample> = places.iter().map(|&at| FitSample { at, error }).collect();
    let fits = starts(kind, &places, &faces(points), &[])
        .into_iter()
        .filter_map(|start| fit(start, &samples, &FitOptions::default()));
    fits.min_by(|a, b| a.worst.total_cmp(&b.worst))
}

#[test]
fn exact_points_are_fitted_exactly_in_every_pose_and_size() {
    let mut n = 4;
    for _ in 0..60 {
        for surface in ordinary(&mut n) {
            let scale = 10f64.powf(between(&mut n, -3.0, 3.0));
            let pose = pose(&mut n, 50.0);
            let surface = posed(surface, pose).scaled(scale);
            let v = heights(&surface);
            let points = patch(&surface, [0.2, 2.4], v, &mut n);
            let found = best(surface.kind(), &points, 1e-9 * scale).unwrap();
            assert!(found.worst < 1.0, "{surface:?} {found:?}");
            if let (Some(a), Some(b)) = (surface.radius(), found.surface.radius()) {
                assert!((a - b).abs() < 1e-6 * a, "{a} {b}");
            }
        }
    }
}

#[test]
fn short_arcs_of_large_radii_converge() {
    let mut n = 5;
    let (origin, axis) = (Point::origin(), Vector::z());
    for radius in [50.0, 500.0, 5000.0] {
        let arc = 10.0 / radius;
        let surfaces = [
            (Primitive::Cylinder { origin, axis, radius }, [-5.0, 5.0]),
            (Primitive::Sphere { centre: origin, radius }, [-arc / 2.0, arc / 2.0]),
        ];
        for (surface, v) in surfaces {
            let pose = pose(&mut n, 1000.0);
            let surface = posed(surface, pose);
            let points = patch(&surface, [0.0, arc], v, &mut n);
            let found = best(surface.kind(), &points, 1e-8).unwrap();
            assert!(found.worst < 1.0, "{surface:?}: {} {:?}", found.worst, found.surface);
        }
    }
}

#[test]
fn shallow_and_steep_cones_converge() {
    let mut n = 6;
    for angle in [1e-3, 0.01, 0.1, 1.0, 1.5, 1.56] {
        let cone =
            Primitive::Cone { origin: Point::origin(), axis: Vector::z(), radius: 10.0, angle };
        let height = (5.0 / angle.tan()).min(10.0);
        for turn in [0.5, 2.0, 6.0] {
            let pose = pose(&mut n, 100.0);
            let surface = posed(cone, pose);
            let points = patch(&surface, [0.0, turn], [-height, height], &mut n);
            let found = best(PrimitiveKind::Cone, &points, 1e-9).unwrap();
            assert!(found.worst < 1.0, "{angle} {turn}: {}", found.worst);
            let Primitive::Cone { angle: other, .. } = found.surface else { panic!("no cone") };
            assert!((other - angle).abs() < 1e-5, "{other} {angle}");
        }
    }
}

#[test]
fn a_torus_may_cross_itself_but_not_turn_inside_out() {
    let torus =
        Primitive::Torus { centre: Point::origin(), axis: Vector::z(), major: 2.0, minor: 1.9 };
    let motions = Motions::new(torus, Point::new(3.0, 0.0, 1.0), true);
    let mut step = MotionRow::zeros();
    step[5] = -2.5;
    assert_eq!(motions.moved(&step), None);
    // The points of a spindle: half a circle about an axis that cuts it.
    let mut n = 7;
    let spindle: Vec<Point> = (0..60)
        .map(|_| {
            let (u, v) = (between(&mut n, 0.0, 2.0), between(&mut n, -1.0, 1.0));
            let rho = 1.0 + 2.0 * f64::cos(v);
            Point::new(rho * u.cos(), rho * u.sin(), 2.0 * v.sin())
        })
        .collect();
    let samples: Vec<FitSample> = spindle.iter().map(|&at| FitSample { at, error: 1e-6 }).collect();
    let found = fit(torus, &samples, &FitOptions::default()).unwrap();
    let Primitive::Torus { major, minor, .. } = found.surface else { panic!("no torus") };
    assert!((major - 1.0).abs() < 1e-6 && (minor - 2.0).abs() < 1e-6, "{major} {minor}");
}

#[test]
fn frozen_motions_are_not_made() {
    let mut n = 8;
    let cylinder = Primitive::Cylinder { origin: Point::origin(), axis: Vector::z(), radius: 5.0 };
    let points = patch(&cylinder, [0.0, 6.0], [-5.0, 5.0], &mut n);
    let samples: Vec<FitSample> =
        points.iter().map(|p| FitSample { at: p.0, error: 1e-6 }).collect();
    let start = Primitive::Cylinder { origin: Point::origin(), axis: Vector::z(), radius: 4.0 };
    let mut options = FitOptions { fixed_centre: true, ..FitOptions::default() };
    [0, 1, 2, 3].iter().for_each(|&k| options.frozen[k] = true);
    let found = fit(start, &samples, &options).unwrap().surface;
    let Primitive::Cylinder { origin, axis, radius } = found else { panic!("no cylinder") };
    assert_eq!((origin.x, origin.y, axis), (0.0, 0.0, Vector::z()));
    assert!((radius - 5.0).abs() < 1e-12);
}

#[test]
fn the_covariance_tells_how_far_fits_of_noisy_points_scatter() {
    let mut n = 9;
    let sphere = Primitive::Sphere { centre: Point::new(1.0, 2.0, 3.0), radius: 10.0 };
    let exact = patch(&sphere, [0.0, 1.0], [-0.4, 0.4], &mut n);
    let (mut sum, mut predicted) = (0.0, 0.0);
    for _ in 0..200 {
        let samples: Vec<FitSample> = exact
            .iter()
            .map(|&(p, normal)| {
                let noise: f64 = (0..12).map(|_| share(&mut n)).sum::<f64>() - 6.0;
                FitSample { at: p + 1e-3 * noise * normal, error: 1e-3 }
            })
            .collect();
        let found = fit(sphere, &samples, &FitOptions::default()).unwrap();
        sum += (found.surface.radius().unwrap() - 10.0).powi(2);
        predicted += found.covariance[(3, 3)];
    }
    let ratio = (sum / predicted).sqrt();
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
}
