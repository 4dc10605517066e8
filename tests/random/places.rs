//! The same scan at another place or with another size becomes the same face.

use crate::common::{OneFace, face_of};
use scan2step::{Body, Options};

use crate::common::virtual_scan::Star;
use crate::scan::{Damage, Place, Scan, sound};
use crate::sheet::{Mesh, Shape};

fn face(place: Place, tolerance: Option<f64>) -> Body {
    let holes = vec![Star { centre: [0.4, 0.55], radius: 0.15, arms: 3.0 }];
    let damage = Damage { holes, noise: 0.03, ..sound() };
    // On coarser grids, noise and shape cannot be told apart.
    let mesh = Mesh::Grid([36, 30], 0.3);
    let scan = Scan { mesh, shape: Shape::Waves, damage, place, seed: 5 };
    let options = Options::builder().tolerance(tolerance.map(|t| t * place.scale));
    let options = options.build().expect("options");
    face_of(&scan.soup(), &options).expect("it becomes a face")
}

/// Nets and figures are almost the same relative to the size. They are not exactly the same,
/// because rounding may decide on the support of the smoothing and on the corners of a rim. The
/// 95th percentile of the deviation is compared. Without a tolerance, the distance of a fit from
/// smoothed points matters relative to the noise, and equally good nets differ in it.
fn same(place: Place, tolerance: Option<f64>, room: f64) {
    let here = face(Place { scale: 100.0, away: 0.0, turned: 0.0 }, tolerance);
    let there = face(place, tolerance);
    let alike = |a: f64, b: f64, of: f64| {
        let b = b * 100.0 / place.scale;
        assert!((a - b).abs() <= room * of, "{place:?}: {b} instead of {a}");
    };
    // The rounding of numbers is not that of the scan elsewhere.
    let noise = |c: &Body| if c.smooth.is_noisy { c.smooth.noise } else { 0.0 };
    let figures = |c: &Body| [noise(c), c.tolerance, c.deviation.p95];
    figures(&here).into_iter().zip(figures(&there)).for_each(|(a, b)| alike(a, b, a));
    let rms = [&here, &there].map(|c| c.fit_deviation.rms);
    let against = if tolerance.is_none() { noise(&here) } else { 0.0 };
    alike(rms[0], rms[1], rms[0].max(against));
    for (a, b) in here.one().surface.shape().into_iter().zip(there.one().surface.shape()) {
        assert!(a.abs_diff(b) <= 2, "{place:?}: {b} control points instead of {a}");
    }
}

#[test]
fn size_is_no_matter() {
    for scale in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        for tolerance in [None, Some(2e-3)] {
            same(Place { scale, away: 0.0, turned: 0.0 }, tolerance, 0.1);
        }
    }
}

#[test]
fn the_place_is_no_matter() {
    for away in [1.0, 1e3, 1e6] {
        for tolerance in [None, Some(2e-3)] {
            same(Place { scale: 100.0, away, turned: 0.0 }, tolerance, 0.1);
        }
    }
}

#[test]
fn the_direction_is_no_matter() {
    for turned in [0.3, 1.0, 2.5] {
        for tolerance in [None, Some(2e-3)] {
            same(Place { scale: 100.0, away: 0.0, turned }, tolerance, 0.25);
        }
    }
}
