//! Clouds of points in the program and in the library: they become faces as meshes do.
#![cfg(feature = "cli")]

use crate::common::face_seen;
use crate::common::random::Random;
use crate::common::{arg, check, checked, converted, fixture, inspected, json};
use scan2step::formats::{self, Points, read_points};
use scan2step::{Body, Options, TargetShape, cloud_components};
use std::f64::consts::TAU;

/// The points of the relief.
fn cloud() -> Points {
    read_points(&fixture("relief.xyz")).expect("points")
}

fn face(cloud: Points, options: &Options) -> Body {
    face_seen(cloud, options, &mut |_| Ok(())).expect("a face")
}

#[test]
fn a_cloud_becomes_a_face_that_is_as_good_as_that_of_its_mesh() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let (step, report, stages) = (at("relief.step"), at("relief.json"), at("stages"));
    let scan = fixture("relief.xyz");
    converted(&[arg(&scan), arg(&step), "--report", arg(&report), "--stages", arg(&stages)]);
    let found = json(&report);
    assert_eq!(found["input"]["points"], 4000);
    assert_eq!(found["input"]["mesher"], "stars");
    assert_eq!(found["fill"]["holes"].as_array().map(Vec::len), Some(2));
    assert_eq!(found["tolerance_met"], true);
    // The fixture's noise.
    let noise = found["noise_mm"].as_f64().expect("noise");
    assert!((0.054..0.066).contains(&noise), "{noise}");
    let points = read_points(&stages.join("0-points.ply")).expect("points");
    assert_eq!(points.len(), 4000);

    let of_mesh = at("mesh.step");
    converted(&[arg(&fixture("relief.ply")), arg(&of_mesh)]);
    // A few points lie at the tips of the holes, which trim loops cut off. The rims of the two meshes
    // differ there, and a few far points weigh much in the root mean square.
    let [of_cloud, of_mesh] = [&step, &of_mesh].map(|cad| checked(cad, &scan));
    for (figure, most) in [("rms_mm", 1.2), ("p95_mm", 1.05), ("p99_mm", 1.05)] {
        let [cloud, mesh] = [&of_cloud, &of_mesh]
            .map(|found| found["scan_to_face"][figure].as_f64().expect("a length"));
        assert!(cloud < most * mesh, "{figure}: {cloud} of the cloud, {mesh} of the mesh");
    }
}

#[test]
fn inspect_says_what_a_cloud_is() {
    let found = inspected(&fixture("relief.xyz"));
    assert_eq!((&found["points"], &found["mesher"]), (&4000.into(), &"stars".into()));
    assert_eq!(found["cloud"]["scans"][0]["points"], 4000);
    let spacing = found["cloud"]["spacing_mm"].as_f64().expect("a spacing");
    assert!((1.2..1.7).contains(&spacing), "{spacing}");
    assert_eq!((&found["disk"], &found["boundary_loops"]), (&true.into(), &3.into()));
}

#[test]
fn a_cloud_far_away_comes_back_where_it_was() {
    let far = [4e8, 5.8e9, 1e5];
    let here = face(cloud(), &Options::default());
    let moved = Points { origin: far, ..cloud() };
    let local = face(moved.clone(), &Options::default());
    assert_eq!(local.origin, far);
    assert_eq!(local.brep.surfaces, here.brep.surfaces, "near zero it is the same face");
    assert!(local.brep.description.contains("5800000000"), "{}", local.brep.description);
    let keep = Options::builder().keeps_origin(true).build().expect("options");
    let kept = face(moved, &keep);
    for (kept, here) in kept.brep.vertices.iter().zip(&here.brep.vertices) {
        for axis in 0..3 {
            assert!((kept[axis] - far[axis] - here[axis]).abs() < 1e-6);
        }
    }
    kept.brep.check().expect("a valid model");
}

/// The fixture with each coordinate moved by whole millimetres, as text.
fn moved_text(by: [i64; 3]) -> String {
    let of_line = |position: &[f64; 3]| {
        let micrometres = |axis: usize| (position[axis] * 1e3).round() as i64 + 1000 * by[axis];
        let text = |number: i64| {
            let sign = if number < 0 { "-" } else { "" };
            format!("{sign}{}.{:03}", number.abs() / 1000, number.abs() % 1000)
        };
        [0, 1, 2].map(|axis| text(micrometres(axis))).join(" ") + "\n"
    };
    cloud().positions.iter().map(of_line).collect()
}

/// Numbers of the size of a map projection have an error of half a nanometre in metres. It must not
/// reach the face, because stages that end when they are good enough would end elsewhere.
#[test]
fn a_file_of_a_cloud_that_was_moved_makes_the_same_face() {
    let by = [400_000_000, 5_800_000_000, 100_000];
    let [near, far] = [[0; 3], by].map(|by| {
        let text = std::io::Cursor::new(moved_text(by));
        let cloud = formats::read_points_from("relief.xyz".as_ref(), text).expect("points");
        face(cloud, &Options::default())
    });
    assert_eq!((near.origin, far.origin), ([0.0; 3], by.map(|x| x as f64)));
    assert_eq!(near.brep.surfaces, far.brep.surfaces);
    assert_eq!(near.brep.vertices, far.brep.vertices);
}

#[test]
fn smoothing_sees_all_of_the_noise_of_a_cloud() {
    let found = face(cloud(), &Options::default());
    let share = found.smooth.noise / found.noise;
    assert!((0.9..=1.0).contains(&share), "{share}");
    let body = torus(0.1);
    let options = Options::default();
    let (scan, _) = cloud_components(body, &options, &mut |_| Ok(())).expect("a mesh");
    let solid = crate::common::body_of(&scan, TargetShape::Solid, &options, &mut |_| Ok(()));
    let found = solid.expect("a solid");
    let share = found.smooth.noise / found.noise;
    // Some vertices stand for two points or three.
    assert!((0.75..=1.0).contains(&share), "{share}");
}

/// Random points of a torus, with some noise in mm.
fn torus(noise: f64) -> Points {
    let mut random = Random(7);
    let mut positions = Vec::new();
    while positions.len() < 6000 {
        let [u, v] = [0; 2].map(|_| TAU * random.share());
        if random.share() < (30.0 + 10.0 * v.cos()) / 40.0 {
            // The sum of twelve uniform numbers has a variance of one.
            let tube = 10.0 + noise * ((0..12).map(|_| random.share()).sum::<f64>() - 6.0);
            let reach = 30.0 + tube * v.cos();
            positions.push([reach * u.cos(), reach * u.sin(), tube * v.sin()]);
        }
    }
    Points { positions, ..Points::default() }
}

#[test]
fn check_finds_a_face_at_the_place_of_its_cloud() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name);
    let (scan, kept, local) = (at("far.xyz"), at("kept.step"), at("local.step"));
    let near = cloud();
    let line = |[x, y, z]: &[f64; 3]| format!("{} {} {z}\n", x + 4e8, y + 5.8e9);
    std::fs::write(&scan, near.positions.iter().map(line).collect::<String>()).expect("written");
    converted(&[arg(&scan), arg(&local)]);
    converted(&[arg(&scan), arg(&kept), "--origin", "keep"]);
    for (cad, origin) in [(&local, "local"), (&kept, "keep")] {
        let output = check(&[arg(cad), arg(&scan), "--origin", origin, "--tolerance", "2"]);
        assert!(output.status.success(), "{origin}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[test]
fn fewer_points_are_taken_if_that_is_asked_for() {
    let options = Options::builder().max_points(2000).build().expect("options");
    let thinned = face(cloud(), &options);
    let count = thinned.deviation.distances.len();
    assert!((1500..=2000).contains(&count), "{count}");
    assert!(Options::builder().max_points(10).build().is_err());
    let missing = Options::builder().scan_number(1).build().expect("options");
    let error = face_seen(cloud(), &missing, &mut |_| Ok(())).expect_err("one scan");
    assert!(error.to_string().contains("no scan 1"), "{error}");
}
