//! Filling: for any holes the result is a disk, the fills lie inside their rims, and they are near
//! the true surface.

use std::collections::{HashMap, HashSet};

use crate::common::random::Random;
use crate::common::virtual_scan::{Star, VirtualScan, paper_scan, rolled_sheet, sheet};
use formats::Soup;
use scan2step::geometry::{Vector, VertexId};
use scan2step::mesh::{self, Choice, Components, Disk, FaceOrigin, Outer, Patch, Repairs};
use scan2step::stages::fill::{self, Strategy};
use scan2step::stages::smooth::{self, Support};

fn disk(soup: &Soup) -> Disk {
    let scan = Components::new(mesh::from_soup(soup, 1.0).unwrap());
    scan.take(Choice::Largest).unwrap().into_disk(Outer::Auto, &mut Repairs::new()).unwrap()
}

/// A bumpy square of 40 × 40 cells. Its points are moved by up to `noise` cells, and a dozen random
/// walks are cut out of it.
fn moth_eaten(random: &mut Random, noise: f64) -> Soup {
    let n = 40;
    let mut cut = HashSet::new();
    for _ in 0..12 {
        let mut at = [3 + random.below(n - 6), 3 + random.below(n - 6)];
        for _ in 0..random.below(80) {
            cut.insert(at);
            let (axis, step) = (random.below(2), random.below(2));
            at[axis] = (at[axis] + 2 * step).saturating_sub(1).clamp(2, n - 3);
        }
    }
    grid(n, &cut, |i, j| {
        let mut shaken = |x: usize| x as f64 + noise * (random.share() - 0.5);
        let (x, y) = (shaken(i), shaken(j));
        [x, y, 3.0 * (0.2 * x).sin() * (0.15 * y).cos() + noise * random.share()]
    })
}

/// A square of n × n cells without those that are cut out.
fn grid(n: usize, cut: &HashSet<[usize; 2]>, mut at: impl FnMut(usize, usize) -> [f64; 3]) -> Soup {
    let mut soup = Soup::default();
    soup.points.extend((0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))).map(|(i, j)| at(i, j)));
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let (k, m) = ((i * (n + 1) + j) as u32, n as u32 + 1);
        if !cut.contains(&[i, j]) {
            soup.polygons.push([k, k + m, k + m + 1]);
            soup.polygons.push([k, k + m + 1, k + 1]);
        }
    }
    soup
}

/// Checks that the boundary of each hole's fill consists of the rim of the hole and those of its
/// islands, and that every inner side has two triangles.
fn check(patch: &Patch, report: &fill::Report) {
    assert!(patch.is_disk());
    for (number, hole) in report.holes.iter().enumerate() {
        let of_hole = FaceOrigin::Hole(number as u32);
        let numbered = patch.mesh.triangles.iter().zip(&patch.origin);
        let own: Vec<_> = numbered.filter(|(_, o)| **o == of_hole).map(|(t, _)| *t).collect();
        assert_eq!(own.len(), hole.added_triangles);
        let sides: HashSet<_> =
            own.iter().flat_map(|t| (0..3).map(move |k| (t[k], t[(k + 1) % 3]))).collect();
        assert_eq!(sides.len(), 3 * own.len(), "no side twice");
        let open = sides.iter().filter(|s| !sides.contains(&(s.1, s.0)));
        let open: HashMap<_, _> = open.copied().collect();
        let rim = &patch.rims[number];
        for (k, &v) in rim.iter().enumerate() {
            assert_eq!(open.get(&rim[(k + 1) % rim.len()]), Some(&v), "the fill meets its rim");
        }
        let islands = patch.islands.iter().filter(|i| i.hole == number);
        let islands = islands.map(|i| i.rim.len()).sum::<usize>();
        assert_eq!(open.len(), rim.len() + islands);
    }
}

#[test]
fn random_holes_are_filled_to_a_disk() {
    let mut random = Random(1);
    let mut holes = 0;
    for round in 0..40 {
        let soup = moth_eaten(&mut random, [0.0, 0.3, 0.8, 1.5][round % 4]);
        let disk = disk(&soup);
        let points = disk.mesh.points.clone();
        let (patch, report) = fill::fill(disk, &points, &fill::Options::default()).unwrap();
        check(&patch, &report);
        holes += report.holes.len();
    }
    assert!(holes > 200, "{holes}");
}

/// Steep waves with six round holes that are not visible as a whole from one side.
fn waves(random: &mut Random) -> Soup {
    let n = 48;
    let mut cut = HashSet::new();
    for _ in 0..6 {
        let (x, y) = (8 + random.below(n - 16), 8 + random.below(n - 16));
        let radius = 2.0 + 4.0 * random.share();
        for (i, j) in (2..n - 2).flat_map(|i| (2..n - 2).map(move |j| (i, j))) {
            let (dx, dy) = (i as f64 - x as f64, j as f64 - y as f64);
            if dx.hypot(dy) < radius {
                cut.insert([i, j]);
            }
        }
    }
    let height = |x: f64, y: f64| 4.0 * (0.4 * x).sin() * (0.4 * y).sin();
    grid(n, &cut, |i, j| {
        let (x, y) = (i as f64, j as f64);
        [x, y, height(x, y)]
    })
}

/// The number of sides at which the fills of a patch fold, according to the normals of the
/// triangles.
fn folds(patch: &Patch) -> usize {
    let mesh = &patch.mesh;
    let normal = |t: &[VertexId; 3]| {
        let [a, b, c] = t.map(|v| mesh.point(v));
        (b - a).cross(&(c - a)).normalize()
    };
    let sides = |t: &[VertexId; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    let numbered = || mesh.triangles.iter().zip(&patch.origin);
    let all: HashMap<_, _> =
        numbered().flat_map(|(t, _)| sides(t).map(|side| (side, normal(t)))).collect();
    let filled = numbered().filter(|(_, o)| matches!(o, FaceOrigin::Hole(_)));
    let folded = |(v, w): &(_, _), own: &Vector| {
        all.get(&(*w, *v)).is_some_and(|beside| beside.dot(own) < -0.3)
    };
    filled.map(|(t, _)| sides(t).iter().filter(|side| folded(side, &normal(t))).count()).sum()
}

#[test]
fn holes_in_steep_waves_are_filled_without_a_fold() {
    let mut random = Random(1);
    let mut strategies = HashSet::new();
    for _ in 0..12 {
        let disk = disk(&waves(&mut random));
        let points = disk.mesh.points.clone();
        let (patch, report) = fill::fill(disk, &points, &fill::Options::default()).unwrap();
        check(&patch, &report);
        assert_eq!(folds(&patch), 0);
        for hole in &report.holes {
            assert_eq!(hole.faults.count(), 0, "{hole:?}");
            strategies.insert(format!("{:?}", hole.strategy));
        }
    }
    // Not all holes can be closed in the same way.
    assert!(strategies.len() > 2, "{strategies:?}");
}

/// Two bowls, one upside down above the other, whose bottoms would cross. They are a strip that is
/// bent at one side. Both bottoms are missing.
fn waist() -> Soup {
    let (n, m, half) = (30, 80, 30.0);
    let place = |i: usize, j: usize| {
        let (x, y) = (i as f64 - 0.5 * n as f64, j as f64);
        // The strip goes up over the first bowl, around the bend, and back over the second bowl.
        let (side, along) = if y <= half { (1.0, y) } else { (-1.0, (m as f64 - y).min(half)) };
        let depth = (x / 15.0).powi(2) + ((along - 15.0) / 15.0).powi(2);
        let turn = (y - half).clamp(0.0, m as f64 - 2.0 * half) / (m as f64 - 2.0 * half);
        let height = -0.6 + 4.0 * depth;
        match turn {
            t if t <= 0.0 || t >= 1.0 => [x, along, side * height],
            t => {
                let angle = std::f64::consts::PI * t;
                [x, half + height * angle.sin(), height * angle.cos()]
            }
        }
    };
    let missing = |i: usize, j: usize| {
        let centre = |y: f64| (i as f64 + 0.5 - 15.0).hypot(j as f64 + 0.5 - y) < 9.0;
        centre(15.0) || centre(m as f64 - 15.0)
    };
    let mut soup = Soup::default();
    soup.points.extend((0..=n).flat_map(|i| (0..=m).map(move |j| place(i, j))));
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let (k, row) = ((i * (m + 1) + j) as u32, m as u32 + 1);
        if !missing(i, j) {
            soup.polygons.push([k, k + row, k + row + 1]);
            soup.polygons.push([k, k + row + 1, k + 1]);
        }
    }
    soup
}

#[test]
fn fills_on_both_sides_of_a_thin_wall_do_not_cut_each_other() {
    let disk = disk(&waist());
    let points = disk.mesh.points.clone();
    let (patch, report) = fill::fill(disk, &points, &fill::Options::default()).unwrap();
    check(&patch, &report);
    assert_eq!(report.holes.len(), 2);
    assert_eq!((folds(&patch), report.holes.iter().map(|h| h.faults.count()).sum()), (0, 0));
    // Each fill alone would continue beyond the other one to where its bowl is deepest. The second
    // fill gives way.
    let heights = |hole: u32| {
        let numbered = patch.mesh.triangles.iter().zip(&patch.origin);
        let own = numbered.filter(move |(_, o)| **o == FaceOrigin::Hole(hole));
        own.flat_map(|(t, _)| t.map(|v| patch.mesh.point(v).z))
    };
    assert!(heights(0).fold(f64::MAX, f64::min) < -0.5);
    assert!(heights(1).fold(f64::MIN, f64::max) < -0.5);
}

/// Fills a virtual scan, smoothed before or not, and returns the rms distance of the new vertices
/// from the true surface.
fn rms_of_fill(scan: &VirtualScan, support: Support) -> (f64, fill::Report) {
    let mut soup = Soup { points: scan.points.clone(), ..Soup::default() };
    scan.triangles.iter().for_each(|t| soup.polygons.push(*t));
    let measured = disk(&soup);
    let options = smooth::Options { support, ..Default::default() };
    let (smoothed, smooth) = smooth::smooth(&measured, &options).unwrap();
    let options =
        fill::Options { support: smooth.h, noise: smooth.noise, ..fill::Options::default() };
    let (patch, report) = fill::fill(smoothed, &measured.mesh.points, &options).unwrap();
    check(&patch, &report);
    (scan.rms(patch.mesh.points[patch.measured..].iter().map(|p| p.coords.into())), report)
}

#[test]
fn a_clean_hole_is_filled_as_if_it_were_measured() {
    let hole = Star { centre: [0.35, 0.62], radius: 0.1, arms: 5.0 };
    let scan = VirtualScan::new(sheet, [90, 90], 0.0, vec![hole], 1);
    let (rms, report) = rms_of_fill(&scan, Support::Off);
    assert!(rms < 0.002, "{rms}");
    assert_eq!(report.holes[0].strategy, Strategy::Front);
}

#[test]
fn a_noisy_hole_is_filled_within_a_third_of_the_noise() {
    let scan = paper_scan();
    let (rms, _) = rms_of_fill(&scan, Support::Auto);
    assert!(rms < 0.05, "{rms} mm at a noise of 0.15 mm");
}

#[test]
fn a_hole_around_a_barrel_follows_the_barrel() {
    let hole = Star { centre: [0.5, 0.5], radius: 0.25, arms: 3.0 };
    let scan = VirtualScan::new(rolled_sheet, [120, 80], 0.0, vec![hole], 1);
    let (rms, _) = rms_of_fill(&scan, Support::Off);
    // A membrane would cut the corner by more than 10 mm.
    assert!(rms < 1.0, "{rms}");
}
