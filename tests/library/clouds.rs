//! The stage `cloud` against the truth of virtual clouds.
//!
//! The clouds have about 7,000 points. `CLOUD_SIZE` asks for others: it is the number of rows and
//! columns of a scan (90 by default). `CLOUD_SEED` draws the clouds anew.

use crate::common::virtual_cloud::{Flaws, SoupCheck, VirtualCloud, cloud};
use crate::common::virtual_scan::{Random, Truth, relief, rolled_sheet, sheet};
use formats::Points;
use scan2step::error::CloudFault;
use scan2step::stages::cloud::{LEFT_OUT, Options, Triangulation, triangulate};
use scan2step::{Error, formats, nalgebra, threads};

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().map_or(default, |text| text.parse().expect("a number"))
}

fn size() -> usize {
    number("CLOUD_SIZE", 90) as usize
}

fn triangles(cloud: &Points) -> Result<Triangulation, Error> {
    triangulate(cloud, &Options::default(), &mut |_| Ok(()))
}

const SURFACES: [(&str, Truth); 3] =
    [("sheet", sheet), ("barrel", rolled_sheet), ("relief", relief)];

/// Checks every surface with some flaws and a noise, which is a share of the spacing. `rms` bounds
/// the error of the vertices as a share of the noise.
fn are_right(noise: f64, flaws: Flaws, rms: f64) {
    for (name, truth) in SURFACES {
        let seed = number("CLOUD_SEED", 1);
        // The smallest hole is nine spacings wide. It closes where the noise is as large as these.
        let holes = if noise < 1.0 { 3 } else { 2 };
        let made = VirtualCloud::new(truth, [size(); 2], noise, holes, flaws, seed);
        let found = triangles(&made.cloud).expect("the cloud is that of a surface");
        let check = SoupCheck::new(&found.soup);
        let what = format!("{name}, noise {noise}, {flaws:?}: {:?} {check:?}", found.report);
        assert!(check.is_manifold(), "{what}");
        assert_eq!((check.components, check.loops.len()), (1, 1 + holes), "{what}");
        let share = check.area / made.scan.true_area();
        // Noise makes vertices rough, and lies beyond the boundary.
        assert!((0.985..1.06 + 0.06 * noise).contains(&share), "{share}: {what}");
        let error =
            made.scan.rms(found.soup.points.iter().copied().step_by(1 + check.loops[0] / 9));
        assert!(error < rms * made.noise, "{}: {what}", error / made.noise);
        let told = found.report.noise / made.noise;
        assert!((0.9..1.1).contains(&told), "{told}: {what}");
        let spacing = made.spacing / (flaws.layers.max(1) as f64).sqrt();
        let told = found.report.spacing / spacing;
        assert!((0.95..1.4).contains(&told), "{told}: {what}");
    }
}

#[test]
fn a_single_scan_has_its_true_loops() {
    for noise in [0.05, 0.13, 0.3] {
        are_right(noise, Flaws::default(), 0.6);
    }
}

#[test]
fn noise_as_large_as_the_spacing_is_averaged_away() {
    are_right(0.5, Flaws::default(), 0.6);
    are_right(1.0, Flaws::default(), 0.6);
}

#[test]
fn three_registered_layers_are_one_sheet() {
    are_right(0.13, Flaws { layers: 3, ..Flaws::default() }, 0.62);
    are_right(0.4, Flaws { layers: 3, ..Flaws::default() }, 0.6);
}

#[test]
fn outliers_are_left_out() {
    are_right(0.13, Flaws { outliers: 0.01, ..Flaws::default() }, 0.75);
}

#[test]
fn a_density_that_falls_to_a_fifth_makes_no_loop() {
    are_right(0.13, Flaws { uneven: true, ..Flaws::default() }, 0.6);
}

#[test]
fn outliers_have_no_vertex_and_points_have_a_near_one() {
    let flaws = Flaws { outliers: 0.01, ..Flaws::default() };
    let made = VirtualCloud::new(sheet, [60; 2], 0.1, 2, flaws, 3);
    let found = triangles(&made.cloud).expect("a surface");
    assert_eq!(found.vertex_of.len(), made.cloud.len());
    let mut left_out = 0;
    for (p, &vertex) in made.cloud.positions.iter().zip(&found.vertex_of) {
        if vertex == LEFT_OUT {
            left_out += 1;
            continue;
        }
        let q = found.soup.points[vertex as usize];
        let squared: f64 = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum();
        assert!(squared.sqrt() < 1.5 * made.spacing, "{p:?} {q:?}");
    }
    assert!(left_out >= found.report.outliers, "{left_out}: {:?}", found.report);
    assert!(left_out < made.cloud.len() / 50, "{left_out}: {:?}", found.report);
}

/// Smoothing tells noise from shape because noise is independent at every vertex. That of projected
/// vertices is not, so it gets places with the noise of the points.
#[test]
fn vertices_are_told_where_they_were_measured() {
    let of_noise = |noise: f64| {
        let made = VirtualCloud::new(relief, [200; 2], noise, 3, Flaws::default(), 4);
        let found = triangles(&made.cloud).expect("a surface");
        (made, found)
    };
    let (made, found) = of_noise(0.4);
    assert_eq!(found.measured.len(), found.soup.points.len());
    let share = made.scan.rms(found.measured.iter().copied().step_by(7)) / made.noise;
    // Some vertices stand for two points or three.
    assert!((0.75..1.0).contains(&share), "{share}");
    // Which points were kept depends on their heights, but the mean height must not.
    let heights = found.measured.iter().zip(&found.soup.points).map(|(p, q)| p[2] - q[2]);
    let mean = heights.sum::<f64>() / found.measured.len() as f64 / made.noise;
    assert!(mean.abs() < 0.02, "{mean}");
    let (_, rough) = of_noise(1.0);
    assert!(rough.measured.is_empty(), "smoothing would not find its way");
}

#[test]
fn any_order_and_any_number_of_threads_give_the_same_bytes() {
    let flaws = Flaws { layers: 2, outliers: 0.01, uneven: true };
    let made = VirtualCloud::new(relief, [40; 2], 0.2, 2, flaws, 5);
    let expected = triangles(&made.cloud).expect("a surface");
    let mut random = Random::new(11);
    for count in [1, 2, 3] {
        let mut positions = made.cloud.positions.clone();
        for i in (1..positions.len()).rev() {
            positions.swap(i, (random.uniform() * (i + 1) as f64) as usize);
        }
        let shuffled = cloud(positions);
        let found = threads::run(Some(count), || triangles(&shuffled)).expect("threads");
        assert!(found.expect("a surface").soup == expected.soup, "{count} threads");
    }
}

#[test]
fn a_wanted_spacing_is_kept() {
    let made = VirtualCloud::new(sheet, [80; 2], 0.1, 0, Flaws::default(), 2);
    let options = Options { spacing: Some(4.0), ..Options::default() };
    let found = triangulate(&made.cloud, &options, &mut |_| Ok(())).expect("a surface");
    let check = SoupCheck::new(&found.soup);
    assert!(check.is_manifold() && check.loops.len() == 1, "{check:?}");
    // Vertices 4 mm apart on 100 × 100 mm: at most 2 / (√3 · 16) a mm², and half of that at least.
    let most = 2.0 / (3f64.sqrt() * 16.0) * check.area;
    let vertices = found.soup.points.len() as f64;
    assert!(vertices < 1.1 * most && vertices > 0.5 * most, "{vertices} of {most}");
}

/// Triangles of the means at so many places.
fn averaged(cloud: &Points, places: usize) -> Result<Triangulation, Error> {
    let options = Options { most_places: Some(places), ..Options::default() };
    triangulate(cloud, &options, &mut |_| Ok(()))
}

/// Points whose noise is larger than their spacing are a ball and not a sheet among their neighbours.
#[test]
fn means_of_crowded_points_are_a_surface_with_its_rims() {
    for (name, truth) in SURFACES {
        let flaws = Flaws { outliers: 0.01, ..Flaws::default() };
        let made = VirtualCloud::new(truth, [300; 2], 1.5, 3, flaws, number("CLOUD_SEED", 1));
        let found = averaged(&made.cloud, 10_000).expect("the cloud is that of a surface");
        let check = SoupCheck::new(&found.soup);
        let what = format!("{name}: {:?} {check:?}", found.report);
        assert!(check.is_manifold(), "{what}");
        assert_eq!((check.components, check.loops.len()), (1, 4), "{what}");
        assert!((5000..12_000).contains(&found.soup.points.len()), "{what}");
        // Noise lies beyond the boundary.
        let share = check.area / made.scan.true_area();
        assert!((0.99..1.06).contains(&share), "{share}: {what}");
        let error = made.scan.rms(found.soup.points.iter().copied()) / made.noise;
        assert!(error < 0.35, "{error}: {what}");
        let told = found.report.noise / made.noise;
        assert!((0.9..1.1).contains(&told), "{told}: {what}");
        let told = found.report.spacing / made.spacing;
        assert!((0.95..1.1).contains(&told), "{told}: {what}");
        assert!(found.report.averaged.is_some_and(|width| width > 2.5 * made.spacing), "{what}");
        let left_out = found.vertex_of.iter().filter(|&&vertex| vertex == LEFT_OUT).count();
        assert!(left_out >= found.report.outliers && left_out < 2500, "{left_out}: {what}");
        let mut reversed = made.cloud.clone();
        reversed.positions.reverse();
        let again = threads::run(Some(1), || averaged(&reversed, 10_000)).expect("a thread");
        assert!(again.expect("a surface").soup == found.soup, "{name} depends on the order");
    }
}

#[test]
fn points_of_two_sides_are_not_averaged() {
    let mut random = Random::new(8);
    let mut plate = |noise: f64| {
        let point = |k: usize| {
            let side = (k % 2) as f64;
            [50.0 * random.uniform(), 50.0 * random.uniform(), 1.5 * side + noise * random.normal()]
        };
        cloud((0..40_000).map(point).collect())
    };
    let refused = |found: Result<Triangulation, Error>| {
        matches!(found, Err(Error::Cloud(CloudFault::Crowded { places: 4000, .. })))
    };
    assert!(refused(averaged(&plate(0.02), 4000)), "layers are told by their heights");
    let mut with_normals = plate(0.4);
    assert!(averaged(&with_normals, 4000).is_ok(), "nothing tells the sides");
    let normal = |k: usize| [0.0, 0.0, if k.is_multiple_of(2) { -1.0 } else { 1.0 }];
    with_normals.normals = Some((0..40_000).map(normal).collect());
    assert!(refused(averaged(&with_normals, 4000)), "normals tell them");
}

#[test]
fn triangles_face_the_scanner_or_the_normals() {
    let made = VirtualCloud::new(sheet, [40; 2], 0.1, 1, Flaws::default(), 4);
    let upward = |cloud: &Points| {
        let soup = triangles(cloud).expect("a surface").soup;
        let first = soup.polygons.iter().next().expect("a triangle");
        let [a, b, c] = [0, 1, 2].map(|k| nalgebra::Point3::from(soup.points[first[k] as usize]));
        (b - a).cross(&(c - a)).z > 0.0
    };
    for side in [1.0, -1.0] {
        let mut scanned = made.cloud.clone();
        scanned.scans[0].viewpoint = Some([50.0, 50.0, 1000.0 * side]);
        assert_eq!(upward(&scanned), side > 0.0);
        let mut with_normals = made.cloud.clone();
        with_normals.normals = Some(vec![[0.0, 0.0, side as f32]; made.cloud.len()]);
        assert_eq!(upward(&with_normals), side > 0.0);
    }
}

#[test]
fn what_is_no_surface_is_refused() {
    let fault = |positions: Vec<[f64; 3]>| match triangles(&cloud(positions)) {
        Err(Error::Cloud(fault)) => fault,
        other => panic!("{:?}", other.map(|t| t.report)),
    };
    assert_eq!(fault(vec![[1.0, 2.0, 3.0]; 500]), CloudFault::OnePlace);
    let few = (0..99).map(|i| [f64::from(i), f64::from(i * i), 0.0]).collect();
    assert_eq!(fault(few), CloudFault::Few(99));
    let line = (0..500).map(|i| [f64::from(i), 2.0 * f64::from(i), 0.0]).collect();
    assert_eq!(fault(line), CloudFault::Line);
    let nan = cloud(vec![[0.0, f64::NAN, 0.0]; 200]);
    assert!(matches!(triangles(&nan), Err(Error::Input(_))));
}

/// A random body, sheet or cloud without any surface, with noise and outliers.
fn random_cloud(random: &mut Random) -> Points {
    let count = 150 + (random.uniform() * 1500.0) as usize;
    let kind = (random.uniform() * 4.0) as usize;
    let noise = random.uniform() / (count as f64).sqrt();
    let mut positions = Vec::new();
    for _ in 0..count {
        let v = nalgebra::Vector3::from_fn(|_, _| random.normal());
        let p = match kind {
            0 => v.normalize(),
            1 => nalgebra::Vector3::new(random.uniform(), random.uniform(), 0.0),
            2 => nalgebra::Vector3::new(v.x, v.y, (v.x * v.y).sin()),
            _ => v,
        };
        let far = if random.uniform() < 0.01 { 1.0 } else { noise };
        positions.push((p + far * nalgebra::Vector3::from_fn(|_, _| random.normal())).into());
    }
    cloud(positions)
}

#[test]
fn random_clouds_become_manifold_meshes_or_errors() {
    let mut random = Random::new(number("CLOUD_SEED", 9));
    let mut meshes = 0;
    for case in 0..60 {
        let cloud = random_cloud(&mut random);
        let Ok(found) = triangles(&cloud) else { continue };
        let check = SoupCheck::new(&found.soup);
        assert!(check.is_manifold(), "case {case}: {check:?}");
        meshes += 1;
    }
    assert!(meshes > 30, "only {meshes} became meshes");
}
