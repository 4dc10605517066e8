//! Smoothing compared with the truth of virtual scans with many kinds of noise.

use std::collections::HashMap;

use crate::common::virtual_scan::{Star, Truth, VirtualScan, relief, rolled_sheet, sheet};
use formats::Soup;
use scan2step::geometry::{Point, VertexId};
use scan2step::mesh::{self, Choice, Components, Disk, Outer, Repairs};
use scan2step::stages::smooth::{self, Options, Report, Support};

fn disk(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Disk {
    let mut soup = Soup { points: points.to_vec(), ..Soup::default() };
    triangles.iter().for_each(|t| soup.polygons.push(*t));
    let scan = Components::new(mesh::from_soup(&soup, 1.0).expect("a sound mesh"));
    let largest = scan.take(Choice::Largest).expect("there is one");
    largest.into_disk(Outer::Auto, &mut Repairs::new()).expect("a disk")
}

/// A smoothed scan, and the true positions of its vertices.
struct Case {
    name: &'static str,
    noise: f64,
    scan: VirtualScan,
    raw: Disk,
    smooth: Disk,
    report: Report,
    truth: Vec<Point>,
}

fn case(name: &'static str, truth: Truth, size: [usize; 2], noise: f64, seed: u64) -> Case {
    let holes = vec![Star { centre: [0.4, 0.6], radius: 0.12, arms: 4.0 }];
    let scan = VirtualScan::new(truth, size, noise, holes.clone(), seed);
    let clean = VirtualScan::new(truth, size, 0.0, holes, seed);
    let raw = disk(&scan.points, &scan.triangles);
    let (smooth, report) = smooth::smooth(&raw, &Options::default()).unwrap();
    let number = scan.points.iter().map(|p| p.map(f64::to_bits)).zip(&clean.points);
    let true_place: HashMap<[u64; 3], &[f64; 3]> = number.collect();
    let place = |p: &Point| Point::from(*true_place[&[p.x, p.y, p.z].map(f64::to_bits)]);
    let truth = raw.mesh.points.iter().map(place).collect();
    Case { name, noise, truth, scan, raw, smooth, report }
}

/// Shapes, sizes, noises and seeds. The spacing is about 1 mm.
fn cases() -> impl Iterator<Item = Case> {
    let shapes: [(&str, Truth, [usize; 2]); 3] = [
        ("sheet", sheet, [90, 90]),
        ("relief", relief, [100, 80]),
        ("roll", rolled_sheet, [120, 80]),
    ];
    let noises = [0.02, 0.15, 0.5];
    let all = shapes.into_iter().flat_map(move |s| noises.map(|noise| (s, noise)));
    all.enumerate().map(|(seed, ((name, truth, size), noise))| {
        case(name, truth, size, noise, seed as u64 + 11)
    })
}

fn rms(scan: &VirtualScan, points: &[Point]) -> f64 {
    scan.rms(points.iter().map(|p| p.coords.into()))
}

impl Case {
    /// The number of triangles whose normals are opposite to the true ones.
    fn flipped(&self, disk: &Disk) -> usize {
        let turned = |t: &&[VertexId; 3]| {
            let [a, b, c] = t.map(|v| self.truth[v.index()]);
            disk.mesh.area_vector(**t).dot(&(b - a).cross(&(c - a))) <= 0.0
        };
        disk.mesh.triangles.iter().filter(turned).count()
    }

    /// The root mean square distance of the outer boundary from the true one.
    fn outer_rms(&self, disk: &Disk) -> f64 {
        let side = |k: usize| (0..=4000).map(move |i| (k, f64::from(i) / 4000.0));
        let edge: Vec<Point> = (0..4)
            .flat_map(side)
            .map(|(k, t)| [(t, 0.0), (t, 1.0), (0.0, t), (1.0, t)][k])
            .map(|(u, v)| Point::from((self.scan.truth)(u, v)))
            .collect();
        let off = |p: Point| edge.iter().map(|q| (q - p).norm_squared()).fold(f64::MAX, f64::min);
        let squares: f64 = disk.outer.iter().map(|&v| off(disk.mesh.point(v))).sum();
        (squares / disk.outer.len() as f64).sqrt()
    }
}

#[test]
fn the_surface_is_found_under_the_noise() {
    for case in cases() {
        let (raw, smooth) =
            (rms(&case.scan, &case.raw.mesh.points), rms(&case.scan, &case.smooth.mesh.points));
        let outer = (case.outer_rms(&case.raw), case.outer_rms(&case.smooth));
        println!(
            "{} {}: rms {raw:.4} → {smooth:.4}, outer boundary {:.4} → {:.4} mm, h {:.2}",
            case.name, case.noise, outer.0, outer.1, case.report.h
        );
        // With a spacing of 1 mm, a shape with less noise has fewer points.
        assert!(smooth < 0.3 * raw, "{}, {}: {raw} → {smooth}", case.name, case.noise);
        assert!(outer.1 < 0.5 * outer.0, "{}, {}: {outer:?}", case.name, case.noise);
        let found = case.report.noise;
        assert!((found / case.noise - 1.0).abs() < 0.15, "{}: noise {found}", case.name);
        assert_eq!(case.report.outliers, 0, "{}", case.name);
    }
}

#[test]
fn no_triangle_stays_folded() {
    let mut before = 0;
    for case in cases() {
        before += case.flipped(&case.raw);
        assert_eq!(case.flipped(&case.smooth), 0, "{} {}", case.name, case.noise);
    }
    assert!(before > 1000, "the noise folds {before} triangles only");
}

#[test]
fn a_clean_scan_is_left_alone() {
    for truth in [sheet as Truth, relief, rolled_sheet] {
        let case = case("clean", truth, [100, 90], 0.0, 5);
        println!("noise {}, moved {} mm", case.report.noise, case.report.moved_rms);
        assert!(case.report.noise < 0.001, "{:?}", case.report);
        assert!(case.report.moved_rms < 0.001, "{:?}", case.report);
        assert_eq!(case.report.outliers, 0);
    }
}

#[test]
fn rows_far_apart_let_no_surface_swing_between_them() {
    // Scans as of line scanners. Points are eleven times as dense along a line.
    for (size, seed) in [([400, 36], 3), ([36, 400], 4)] {
        let scan = VirtualScan::new(sheet, size, 0.1, Vec::new(), seed);
        let raw = disk(&scan.points, &scan.triangles);
        let (smooth, _) = smooth::smooth(&raw, &Options::default()).unwrap();
        let off = scan.distances(smooth.mesh.points.iter().map(|p| p.coords.into()));
        let farthest = off.into_iter().fold(0.0, f64::max);
        let left = rms(&scan, &smooth.mesh.points);
        println!("{size:?}: rms {left:.4}, farthest {farthest:.4} mm");
        assert!(left < 0.03 && farthest < 0.2, "{size:?}: rms {left}, farthest {farthest}");
    }
}

#[test]
fn outliers_are_left_out() {
    let mut scan = VirtualScan::new(relief, [100, 80], 0.05, Vec::new(), 9);
    let clean = VirtualScan::new(relief, [100, 80], 0.0, Vec::new(), 9);
    let thrown = |i: usize| i % 97 == 50;
    for (i, p) in scan.points.iter_mut().enumerate().filter(|(i, _)| thrown(*i)) {
        p[2] += if i % 2 == 0 { 0.9 } else { -1.2 };
    }
    let raw = disk(&scan.points, &scan.triangles);
    let (smooth, report) = smooth::smooth(&raw, &Options::default()).unwrap();
    let count = (0..scan.points.len()).filter(|&i| thrown(i)).count();
    let found = report.outliers;
    assert!(found.abs_diff(count) <= count / 20, "{found} found of {count}");
    let after = rms(&clean, &smooth.mesh.points);
    assert!(after < 0.02, "{after}");
    assert!((report.noise / 0.05 - 1.0).abs() < 0.15, "{}", report.noise);
}

/// A sheet that is rolled up twice with a gap of 1.5 mm.
fn scroll(u: f64, v: f64) -> [f64; 3] {
    let angle = 4.0 * std::f64::consts::PI * u;
    let radius = 12.0 + 1.5 * angle / std::f64::consts::TAU;
    [radius * angle.cos(), radius * angle.sin(), 40.0 * v]
}

#[test]
fn the_layer_above_is_not_seen() {
    let scan = VirtualScan::new(scroll, [320, 80], 0.08, Vec::new(), 4);
    let raw = disk(&scan.points, &scan.triangles);
    let (smooth, report) = smooth::smooth(&raw, &Options::default()).unwrap();
    let after = rms(&scan, &smooth.mesh.points);
    println!("scroll: rms {after:.4} mm with h {:.2} mm, gap 1.5 mm", report.h);
    assert!(report.h > 1.5, "the support does not reach over the gap: {}", report.h);
    assert!(after < 0.024, "{after}");
}

#[test]
fn a_support_that_is_named_is_taken() {
    let scan = VirtualScan::new(sheet, [60, 60], 0.1, Vec::new(), 2);
    let raw = disk(&scan.points, &scan.triangles);
    let options = Options { support: Support::Fixed(5.5), ..Options::default() };
    let (smooth, report) = smooth::smooth(&raw, &options).unwrap();
    assert_eq!(report.h, 5.5);
    assert!(rms(&scan, &smooth.mesh.points) < 0.05);
    let off = Options { support: Support::Off, ..Options::default() };
    let (same, report) = smooth::smooth(&raw, &off).unwrap();
    assert_eq!((same.mesh.points, report.h), (raw.mesh.points, 0.0));
    assert!((report.noise / 0.1 - 1.0).abs() < 0.15);
}
