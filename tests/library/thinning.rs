//! A scan that is far denser than its noise lets tell is thinned before it is smoothed, and
//! everything is still measured at all its points.

use crate::common::virtual_scan::{Star, VirtualScan, relief};
use crate::common::{OneFace, face_seen};
use formats::Soup;
use scan2step::{Body, Builder, Error, Options, Stage};

/// The noise in mm of a sheet of 100 × 80 mm.
const NOISE: f64 = 0.15;

fn soup(scan: &VirtualScan) -> Soup {
    let mut soup = Soup { points: scan.points.clone(), ..Soup::default() };
    scan.triangles.iter().for_each(|t| soup.polygons.push(*t));
    soup
}

/// A conversion, and the number of vertices of its map.
fn converted(scan: &VirtualScan, options: Builder) -> (Body, usize) {
    let mut mapped = 0;
    let options = options.build().expect("sound options");
    let conversion = face_seen(&soup(scan), &options, &mut |stage| {
        if let Stage::Parameterize(map, _) = stage {
            mapped = map.uv.len();
        }
        Ok(())
    });
    (conversion.expect("a face"), mapped)
}

#[test]
fn a_dense_scan_is_mapped_with_a_part_of_its_vertices_and_measured_at_all() {
    let holes = vec![Star { centre: [0.4, 0.6], radius: 0.12, arms: 4.0 }];
    let scan = VirtualScan::new(relief, [500, 600], NOISE, holes, 1);
    let vertices = scan.points.len();
    let (face, mapped) = converted(&scan, Options::builder());
    assert!((100_000..vertices / 2).contains(&mapped), "{mapped} of {vertices}");
    let measured = face.deviation.distances.len();
    let smoothed = face.fit_deviation.distances.len();
    assert!(measured > vertices - 100, "{measured} of {vertices}");
    assert!((100_000..=mapped).contains(&smoothed), "{smoothed} of {mapped}");
    assert!((face.deviation.rms / NOISE - 1.0).abs() < 0.05, "{}", face.deviation.rms);
    assert_eq!((face.one().loops.len(), face.missed.points), (1, 0));
}

/// Noise of 1.6 spacings hides details between neighbours.
#[test]
fn a_mesh_far_denser_than_its_noise_lets_tell_is_averaged() {
    let holes = vec![Star { centre: [0.4, 0.6], radius: 0.12, arms: 4.0 }];
    let scan = VirtualScan::new(relief, [1400, 1600], 0.1, holes, 1);
    let vertices = scan.points.len();
    let (face, mapped) = converted(&scan, Options::builder());
    let thin = face.face().expect("a face").thin;
    assert!(thin.averaged.is_some_and(|width| (0.15..0.25).contains(&width)), "{thin:?}");
    assert!((100_000..vertices / 8).contains(&mapped), "{mapped} of {vertices}");
    assert_eq!(face.deviation.distances.len(), thin.vertices + thin.removed);
    assert!(face.deviation.distances.len() > vertices - 500);
    assert!((face.deviation.rms / 0.1 - 1.0).abs() < 0.02, "{}", face.deviation.rms);
    assert!((face.noise / 0.1 - 1.0).abs() < 0.05, "{}", face.noise);
    assert_eq!((face.one().loops.len(), face.missed.points), (1, 0));
}

/// A mesh of 60,000 vertices may need 600 MB, and means of them at 14,000 places 250 MB.
#[test]
fn points_that_means_do_not_show_are_told() {
    // Every 200th point is an outlier, as far off as ten times the noise.
    let mut scan = VirtualScan::new(relief, [220, 270], 0.3, vec![], 1);
    scan.points.iter_mut().step_by(200).for_each(|p| p[2] += 3.0);
    let (face, _) = converted(&scan, Options::builder().max_memory(250_000_000));
    let told = scan.points.len() / 200;
    let lost = face.lost_by_means().expect("as many as chance does not leave");
    assert!((told * 9 / 10..=told + 10).contains(&lost), "{lost} of {told}");
    assert!(
        face.hints[0].contains("outliers, or details that means have lost"),
        "{:?}",
        face.hints
    );
}

#[test]
fn memory_bounds_the_number_of_means() {
    const ALLOWED: u64 = 250_000_000;
    let sheet = |noise: f64| VirtualScan::new(relief, [220, 270], noise, vec![], 1);
    let bounded = || Options::builder().max_memory(ALLOWED);
    let scan = sheet(0.3);
    let (face, mapped) = converted(&scan, bounded());
    let thin = face.face().expect("a face").thin;
    assert!((10_000..30_000).contains(&mapped), "{mapped}");
    assert!(thin.averaged.is_some_and(|width| (0.6..0.75).contains(&width)), "{thin:?}");
    let measured = face.deviation.distances.len();
    assert_eq!(measured, thin.vertices + thin.removed);
    assert!(measured > scan.points.len() - 500, "{measured}");
    assert!((face.deviation.rms / 0.3 - 1.0).abs() < 0.05, "{}", face.deviation.rms);
    assert_eq!(face.lost_by_means(), None);
    // A named tolerance holds at every vertex, and without noise nothing hides what means lose.
    for (scan, options) in [(&scan, bounded().tolerance(0.5)), (&sheet(0.0), bounded())] {
        let options = options.build().expect("sound options");
        let refused = face_seen(&soup(scan), &options, &mut |_| Ok(()));
        let Err(Error::MaxMemory { needed, allowed, .. }) = refused else { panic!("{refused:?}") };
        assert!(needed > allowed && allowed == ALLOWED, "{needed}");
    }
}
