//! What reports say of parts: how cylinders lie to each other, which edges are sharp, and what was moved.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use crate::common::{arg, converted, fixture, inspect, json, number};
use serde_json::{Value, json};

/// A ring along z with these radii and height, as ASCII STL with numbers of 32 bits. The axis of its bore is
/// beside that of its outside by an offset.
fn ring([outer, inner]: [f64; 2], height: f64, offset: f64) -> String {
    const SIDES: u32 = 48;
    let at = |k: u32, radius: f64, x: f64, z: f64| {
        let (sin, cos) = (TAU * f64::from(k % SIDES) / f64::from(SIDES)).sin_cos();
        [x + radius * cos, radius * sin, z]
    };
    let [out, within] = [(outer, 0.0), (inner, offset)].map(|(radius, x)| {
        move |k: u32, top: bool| at(k, radius, x, if top { height } else { 0.0 })
    });
    let mut text = String::from("solid ring\n");
    for k in 0..SIDES {
        let [a, b, c, d] = [out(k, false), out(k + 1, false), out(k + 1, true), out(k, true)];
        let [e, f, g, h] =
            [within(k, false), within(k + 1, false), within(k + 1, true), within(k, true)];
        for [p, q, r, s] in [[a, b, c, d], [f, e, h, g], [d, c, g, h], [b, a, e, f]] {
            for triangle in [[p, q, r], [p, r, s]] {
                text += "facet normal 0 0 0\nouter loop\n";
                for [x, y, z] in triangle.map(|corner| corner.map(|x| x as f32)) {
                    writeln!(text, "vertex {x} {y} {z}").expect("text");
                }
                text += "endloop\nendfacet\n";
            }
        }
    }
    text + "endsolid ring\n"
}

/// Converts a scan with a report and a page, and returns the messages, the report and the page.
fn told(scan: &Path, folder: &Path) -> (String, Value, String) {
    let [step, report, page] = ["a.step", "a.json", "a.html"].map(|name| folder.join(name));
    let files = [arg(scan), arg(&step), "--report", arg(&report), "--report", arg(&page)];
    let said = converted(&files);
    (said, json(&report), std::fs::read_to_string(page).expect("a page"))
}

#[test]
fn a_bracket_has_groups_of_cylinders() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (said, report, page) = told(&fixture("bracket.stl"), folder.path());
    // The cylinders are a round edge and a bore along x, a fillet along y and two bores along z.
    let expected = json!([
        { "kind": "equal radius", "cylinders": [3, 4], "to": [] },
        { "kind": "coaxial", "cylinders": [0, 1], "to": [] },
        { "kind": "parallel", "cylinders": [3, 4], "to": [] },
        { "kind": "perpendicular", "cylinders": [0, 1], "to": [2, 3, 4] },
        { "kind": "perpendicular", "cylinders": [3, 4], "to": [2] },
    ]);
    assert_eq!(report["exact"]["relations"], expected);
    assert!(
        said.contains("2 bores of radius 2.750 mm along z, at (40.000, 10.000, 1.625)"),
        "{said}"
    );
    let line = "relations: equal radii 2 × 2.750 mm; 2 coaxial; 2 parallel; 5 perpendicular";
    assert!(said.contains(line), "{said}");
    assert!(said.contains("10 to a round value"), "{said}");
    // Each face in the colours of its kind, and what was moved with its values before and after.
    assert!(page.contains("id=\"show-face\" checked") && page.contains("7 planes"));
    let moved = number(&report, "/exact/snaps/0/before/radius_mm");
    assert!((moved - 10.5).abs() < 1e-5 && moved != 10.5, "{moved}");
    assert!(
        page.contains(
            "<td>radius</td><td class=\"values\">19.9999998908</td><td class=\"values\">20</td>"
        ),
        "no snap on the page"
    );
}

#[test]
fn sharp_edges_are_told_from_smooth_ones() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (_, report, page) = told(&fixture("bracket.stl"), folder.path());
    let (_, scene) = page.split_once("id=\"scene\">").expect("a scene");
    let (scene, _) = scene.split_once("</script>").expect("its end");
    let scene: Value = serde_json::from_str(scene).expect("JSON");
    let count = |key: &str| scene["parts"][0][key].as_array().expect("a list").len();
    // The fillet ends smoothly at two planes, and so does the round edge. A torus lies between the large bore and a
    // plane. Its edge at the bore is two arcs, as the seams of both end there.
    assert_eq!(count("smooth"), 7);
    // Six faces go all around and have a seam edge, which is no edge of the part: three bores, two cones, a torus.
    let edges = report["shape"]["edges"].as_u64().expect("a count") as usize;
    assert_eq!(edges - count("smooth") - count("edges"), 6);
    assert_eq!(count("spots"), 5, "a place for each cylinder");
}

#[test]
fn a_ring_is_coaxial_only_if_its_axes_are_one_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scan = folder.path().join("ring.stl");
    for (offset, kind) in [(0.0, "coaxial"), (0.001, "parallel")] {
        std::fs::write(&scan, ring([10.0, 6.0], 7.0, offset)).expect("a file");
        let (said, report, _) = told(&scan, folder.path());
        let relation = json!([{ "kind": kind, "cylinders": [0, 1], "to": [] }]);
        assert_eq!(report["exact"]["relations"], relation, "{offset}: {said}");
        assert!(said.contains(&format!("relations: 2 {kind}")), "{said}");
    }
}

#[test]
fn inspect_tells_the_radii() {
    let scan = fixture("bracket.stl");
    let text = inspect(&[arg(&scan)]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(text.contains("cylinders   radius 20.00, 9.000, 8.000, 2 × 2.750 mm"), "{text}");
    let found = inspect(&[arg(&scan), "--json"]);
    let found: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    assert_eq!(found["exact"]["radii_mm"], json!([20.0, 9.0, 8.0, 2.75, 2.75]));
    assert_eq!(found["exact"]["surfaces"]["torus"], 1);
    let found = inspect(&[arg(&fixture("relief.ply")), "--json"]);
    let found: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    assert_eq!(found["exact"], Value::Null);
}
