//! What is left out of a scan: outside of a box, below a plane, and the turntable.

use std::fmt::Write;

use crate::common::{arg, convert, converted, fixture, inspect, json};
use serde_json::{Value, json};

/// The ring of the fixtures on a tilted table, as one mesh, and as a cloud.
fn ring_on_table(folder: &std::path::Path) -> [std::path::PathBuf; 2] {
    let ring = std::fs::read_to_string(fixture("ring.obj")).expect("the fixture");
    let mut text = ring.clone();
    let count = ring.lines().filter(|line| line.starts_with("v ")).count();
    let side = 60;
    let height = |x: f64| 0.05 * x - 30.0;
    let mut rows = String::new();
    for k in 0..side * side {
        let (x, y) = ((k % side) as f64 * 4.0 - 118.0, (k / side) as f64 * 4.0 - 118.0);
        let noise = 0.02 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        writeln!(text, "v {x} {y} {}", height(x) + noise).expect("text grows");
        writeln!(rows, "{x} {y} {}", height(x) + noise).expect("text grows");
    }
    for k in (0..side * (side - 1)).filter(|k| k % side < side - 1) {
        let a = count + k + 1;
        writeln!(text, "f {a} {} {} {}", a + 1, a + side + 1, a + side).expect("text grows");
    }
    let points = ring.lines().filter_map(|line| line.strip_prefix("v "));
    points.for_each(|point| writeln!(rows, "{point}").expect("text grows"));
    let [mesh, cloud] = ["scan.obj", "scan.xyz"].map(|name| folder.join(name));
    std::fs::write(&mesh, text).expect("the scan is written");
    std::fs::write(&cloud, rows).expect("the scan is written");
    [mesh, cloud]
}

fn inspected(arguments: &[&str]) -> Value {
    let output = inspect(&[arguments, &["--json"]].concat());
    let wrong = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{wrong}"))
}

#[test]
fn the_turntable_goes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [mesh, cloud] = ring_on_table(folder.path());
    let ring = inspected(&[arg(&fixture("ring.obj"))]);
    let before = inspected(&[arg(&mesh)]);
    assert_eq!(before["components"], 2);
    let found = inspected(&[arg(&mesh), "--remove-plane"]);
    for key in ["components", "triangles", "genus", "shape"] {
        assert_eq!(found[key], ring[key], "{key}");
    }
    let of_cloud = inspected(&[arg(&cloud), "--remove-plane"]);
    assert_eq!((&of_cloud["genus"], &of_cloud["components"]), (&json!(1), &json!(1)), "{of_cloud}");

    let path = |name: &str| folder.path().join(name);
    let (step, report) = (path("a.step"), path("a.json"));
    converted(&[arg(&mesh), arg(&step), "--remove-plane", "--report", arg(&report)]);
    let told = json(&report);
    assert_eq!(
        (&told["shape"]["kind"], &told["options"]["remove_plane"]),
        (&json!("solid"), &json!(true))
    );
    let alone = convert(&[arg(&fixture("ring.obj")), arg(&step), "--remove-plane"]);
    let said = String::from_utf8_lossy(&alone.stderr);
    assert_eq!(alone.status.code(), Some(1));
    assert!(said.contains("no plane has the rest of the scan on one side"), "{said}");
}

#[test]
fn a_box_and_a_plane_leave_parts_out() {
    let scan = fixture("relief.ply");
    let bounds = |arguments: &[&str], axis: usize| {
        let found = inspected(&[&[arg(&scan)], arguments].concat());
        [0, 1].map(|end| found["bounds_mm"][end][axis].as_f64().expect("a number"))
    };
    let [low, high] = bounds(&["--box=-20,-100,-100;30,100,100"], 0);
    assert!((-20.0..-17.0).contains(&low) && (27.0..=30.0).contains(&high), "{low} to {high}");
    // In inches.
    let [low, high] = bounds(&["--box", "30,100,100;-20,-100,-100", "--units", "in"], 0);
    assert!((-508.0..-431.0).contains(&low) && (685.0..=762.0).contains(&high), "{low} to {high}");
    let [low, _] = bounds(&["--above", "0,2,0,10"], 1);
    assert!((5.0..8.0).contains(&low), "{low}");
    let nothing = inspect(&[arg(&scan), "--above", "0,0,1,1000"]);
    let said = String::from_utf8_lossy(&nothing.stderr);
    assert!(said.contains("nothing of the scan is left") && said.contains("--above"), "{said}");
    for wrong in [["--box", "1,2,3"], ["--above", "0,0,0,1"], ["--above", "1,2,3"]] {
        assert_eq!(inspect(&[&[arg(&scan)], &wrong[..]].concat()).status.code(), Some(2));
    }
}
