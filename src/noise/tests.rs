//! The noise of made scans.

use nalgebra::Rotation3;

use super::rounding::Rounding;
use super::{NoiseField, Terraces};
use crate::geometry::random::scattered;
use crate::geometry::{Point, Vector, VertexId};
use crate::mesh::{Mesh, VertexRings};

/// Normal errors of standard deviation 1 (Box and Muller).
fn normal(seed: u64) -> impl Iterator<Item = f64> {
    let uniform = move |k: u64| (scattered(seed << 40 | k) as f64 + 0.5) / 2f64.powi(64);
    (0..).map(move |k: u64| {
        (-2.0 * uniform(2 * k).ln()).sqrt() * (std::f64::consts::TAU * uniform(2 * k + 1)).cos()
    })
}

/// A grid with its triangles.
fn grid(m: usize, n: usize, at: impl Fn(usize, usize) -> Point) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=m {
        mesh.points.extend((0..=n).map(|j| at(i, j)));
    }
    let v = |i: usize, j: usize| VertexId::from(i * (n + 1) + j);
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// The surface of a box.
fn cuboid(sides: [f64; 3], edge: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let mut number = std::collections::BTreeMap::new();
    let count = sides.map(|s| (s / edge).round() as usize);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, count[axis]] {
            let part = grid(count[u], count[v], |_, _| Point::origin());
            let place = |w: VertexId| {
                let mut p = [0; 3];
                p[axis] = side;
                (p[u], p[v]) = (w.index() / (count[v] + 1), w.index() % (count[v] + 1));
                p
            };
            for t in part.triangles {
                let mut t = t.map(|w| {
                    let p = place(w);
                    *number.entry(p).or_insert_with(|| {
                        mesh.points.push(Point::from(p.map(|k| edge * k as f64)));
                        VertexId::from(mesh.points.len() - 1)
                    })
                });
                if side == 0 {
                    t.swap(1, 2);
                }
                mesh.triangles.push(t);
            }
        }
    }
    mesh
}

/// Two flanges at a right angle.
fn bent_sheet() -> Mesh {
    grid(40, 30, |i, j| Point::new(i.min(20) as f64, j as f64, i.saturating_sub(20) as f64))
}

/// The mesh with noise of this standard deviation in each coordinate, averaged over neighbours
/// `rounds` times and scaled back.
fn noisy(mut mesh: Mesh, sigma: f64, rounds: usize, seed: u64) -> Mesh {
    let rings = VertexRings::new(&mesh);
    let mut errors = normal(seed);
    let mut error = || [(); 3].map(|()| errors.next().unwrap());
    let mut noise: Vec<Vector> = mesh.points.iter().map(|_| Vector::from(error())).collect();
    for _ in 0..rounds {
        let mean = |v: usize| {
            let around = rings.neighbours(&mesh, VertexId::from(v)).map(|w| noise[w.index()]);
            let (sum, count) = around.fold((noise[v], 1.0), |(sum, n), e| (sum + e, n + 1.0));
            sum / count
        };
        noise = (0..noise.len()).map(mean).collect();
    }
    let square = noise.iter().map(|e| e.norm_squared()).sum::<f64>() / (3 * noise.len()) as f64;
    let scale = sigma / square.sqrt();
    mesh.points.iter_mut().zip(noise).for_each(|(p, e)| *p += scale * e);
    mesh
}

fn field(mesh: &Mesh) -> NoiseField {
    NoiseField::new(mesh, &VertexRings::new(mesh))
}

#[test]
fn edges_do_not_count_as_noise() {
    for sigma in [0.02, 0.05, 0.1] {
        for (rounds, correlation) in [(0, [0.0, 0.0]), (1, [0.56, 0.21])] {
            let meshes = [cuboid([40.0, 30.0, 20.0], 1.0), bent_sheet()];
            for (k, mesh) in meshes.into_iter().enumerate() {
                let noise = field(&noisy(mesh, sigma, rounds, k as u64));
                println!("{k} {sigma} {rounds}: {} {:?}", noise.deviation, noise.correlation);
                assert!(noise.is_visible);
                assert!((noise.deviation / sigma - 1.0).abs() < 0.15, "{}", noise.deviation);
                for (found, truth) in noise.correlation.into_iter().zip(correlation) {
                    assert!((found - truth).abs() < 0.15, "{found} {truth}");
                }
            }
        }
    }
}

/// A ball with triangles between circles of latitude.
fn ball(radius: f64) -> Mesh {
    let mut mesh = grid(40, 80, |i, j| {
        let (polar, turn) = ((i as f64 + 0.5) / 41.0, j as f64 / 81.0);
        let (s, c) = (std::f64::consts::PI * polar).sin_cos();
        let (x, y) = (std::f64::consts::TAU * turn).sin_cos();
        radius * Point::new(s * y, s * x, c)
    });
    // The last column meets the first one.
    for i in 0..40 {
        let [a, b, c, d] =
            [(i, 80), (i + 1, 80), (i + 1, 0), (i, 0)].map(|(i, j)| VertexId::from(81 * i + j));
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

#[test]
fn clean_meshes_have_the_noise_of_their_rounding() {
    let turn = Rotation3::new(Vector::new(0.3, 0.5, -0.2));
    for mut mesh in [cuboid([20.0, 20.0, 20.0], 20.0), cuboid([40.0, 30.0, 20.0], 2.0), ball(10.0)]
    {
        mesh.points.iter_mut().for_each(|p| *p = (turn * *p).map(|x| f64::from(x as f32)));
        let noise = field(&mesh);
        assert!(!noise.is_visible);
        // Half of the distance between single numbers near 32.
        assert!(noise.deviation < 2.0 * 1e-6, "{}", noise.deviation);
        assert!(noise.outliers(&mesh, &VertexRings::new(&mesh)).iter().all(|is| !is));
    }
}

#[test]
fn round_numbers_of_a_design_are_no_rounding() {
    let noise = field(&cuboid([4.0, 3.0, 2.0], 0.1));
    assert!(!noise.is_visible && noise.deviation < 1e-12, "{}", noise.deviation);
}

#[test]
fn decimals_are_told_from_chance() {
    let rounded = |digits: f64| {
        let points = noisy(ball(10.0), 0.1, 0, 3).points;
        let round = |x: f64| (x * digits).round() / digits;
        // As the pipeline scales them.
        Rounding::of(&points.iter().map(|p| p.map(|x| 0.25 * round(x))).collect::<Vec<_>>())
    };
    assert_eq!(rounded(1e2), Rounding::Decimal(0.25e-2));
    assert_eq!(rounded(1e6), Rounding::Decimal(0.25e-6));
    let exact = Rounding::of(&noisy(ball(10.0), 0.1, 0, 3).points);
    assert_eq!(exact, Rounding::Floating(f64::EPSILON));
    let single: Vec<Point> =
        ball(10.0).points.iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
    assert_eq!(Rounding::of(&single), Rounding::Floating(f64::from(f32::EPSILON)));
}

#[test]
fn a_part_with_more_noise_has_its_own() {
    let flat = |i: usize, j: usize| Point::new(i as f64, j as f64, 0.0);
    let mut mesh = grid(80, 80, flat);
    let mut errors = normal(5);
    for p in &mut mesh.points {
        p.z += errors.next().unwrap() * if p.x < 40.0 { 0.02 } else { 0.06 };
    }
    let noise = field(&mesh);
    let at = |x: usize| noise.at(VertexId::from(81 * x + 40));
    assert!((at(15) / 0.02 - 1.0).abs() < 0.15, "{}", at(15));
    assert!((at(65) / 0.06 - 1.0).abs() < 0.15, "{}", at(65));
}

#[test]
fn outliers_are_found_and_edges_are_not() {
    let mut mesh = noisy(cuboid([40.0, 30.0, 20.0], 1.0), 0.02, 0, 9);
    let thrown: Vec<usize> = (100..5000).step_by(331).collect();
    let centre = Point::new(20.0, 15.0, 10.0);
    for &v in &thrown {
        let out = (mesh.points[v] - centre).normalize();
        mesh.points[v] += 0.5 * out;
    }
    let noise = field(&mesh);
    let outliers = noise.outliers(&mesh, &VertexRings::new(&mesh));
    let found: Vec<usize> = (0..outliers.len()).filter(|&v| outliers[v]).collect();
    assert!(found.iter().all(|v| thrown.contains(v)), "{found:?}");
    // Beside an edge, nothing tells a point that is off from the edge.
    let from_edge = |v: usize| {
        let mut depth = [(20.0, 0), (15.0, 1), (10.0, 2)]
            .map(|(half, k): (f64, usize)| half - (mesh.points[v][k] - centre[k]).abs());
        depth.sort_by(f64::total_cmp);
        depth[1]
    };
    let missed = thrown.iter().filter(|v| !found.contains(v));
    missed.for_each(|&v| assert!(from_edge(v) < 3.5, "{v} is missed"));
    assert!(found.len() > thrown.len() / 2);
}

/// A hilly sheet with heights in steps.
fn stepped(step: f64) -> Mesh {
    grid(60, 60, |i, j| {
        let (x, y) = (i as f64, j as f64);
        let z = 6.0 * (0.08 * x).sin() * (0.06 * y).cos() + 0.1 * y;
        Point::new(x, y, step * (z / step).round())
    })
}

#[test]
fn heights_in_steps_are_found() {
    for step in [2.0, 1.0, 0.25] {
        let found = Terraces::of(&stepped(step)).expect("steps");
        assert!((found.step - step).abs() < 1e-9, "{found:?}");
    }
    // Steps of a thousandth of what the heights differ by are the rounding of a file.
    assert_eq!(Terraces::of(&stepped(1e-4)), None);
}

/// Depths of whole disparities: the same sheet, `far` away.
fn of_disparities(far: f64, k: f64) -> Mesh {
    let mut mesh = stepped(1e-9);
    for p in &mut mesh.points {
        p.z = f64::from((k / (k / (far + p.z)).round()) as f32);
    }
    mesh
}

#[test]
fn depths_of_whole_disparities_have_the_noise_of_their_steps() {
    for (far, k) in [(40.0, 1600.0), (400.0, 480_000.0)] {
        let mesh = of_disparities(far, k);
        let noise = NoiseField::new(&mesh, &VertexRings::new(&mesh));
        assert!(noise.is_visible && noise.terraces.is_some(), "{noise:?}");
        for v in [0, 1830, 3599].map(VertexId::from) {
            let z = mesh.point(v).z;
            let expected = z * z / k / 12f64.sqrt();
            assert!((noise.at(v) / expected - 1.0).abs() < 1e-3, "{} {expected}", noise.at(v));
        }
    }
}

#[test]
fn smooth_heights_on_a_lattice_are_no_steps() {
    // Of x y on a grid, all heights are multiples of one step.
    let saddle = grid(20, 20, |i, j| {
        let (x, y) = (i as f64 - 10.0, j as f64 - 10.0);
        Point::new(x, y, 0.02 * x * y)
    });
    assert_eq!(Terraces::of(&saddle), None);
}
