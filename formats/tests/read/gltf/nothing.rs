//! Files without triangles: what is missing or wrong.

use formats::Location;

use super::{SQUARE, bad, good, square_bytes};

const PLACES: &str = r#""scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],"#;

#[test]
fn what_is_missing_is_told() {
    let meshes = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],"#;
    let count = r#""count": 6"#;
    for (from, to, word) in [
        (meshes, "", "mesh that does not exist"),
        (r#"[{"mesh": 0}]"#, "[{}]", "none of the scene's nodes has a mesh"),
        (r#""nodes": [0]"#, r#""nodes": []"#, "none of the scene's nodes has a mesh"),
        (PLACES, "", "it has no nodes"),
        (r#""indices": 1"#, r#""indices": 1, "mode": 0"#, "only points or lines"),
        (r#""indices": 1"#, r#""mode": 3"#, "only points or lines"),
        (count, r#""count": 2"#, "no whole triangle"),
        (r#"{"POSITION": 0}"#, "{}", "no whole triangle"),
    ] {
        bad(&[(from, to)], word);
    }
    bad(&[(meshes, ""), (PLACES, "")], "it has no meshes");
    bad(&[(meshes, ""), (r#"[{"mesh": 0}]"#, "[{}]")], "it has no meshes");
}

/// Faults are reported even in meshes that no node uses.
#[test]
fn the_first_fault_is_told() {
    let element = |kind, i| Some(Location::Element(kind, i));
    for (from, to, word, place) in [
        (r#""count": 4"#, r#""count": 3"#, "vertex 3, but only 3", element("accessor", 1)),
        (r#""POSITION": 0"#, r#""POSITION": 7"#, "does not exist", element("accessor", 7)),
        (r#""indices": 1"#, r#""indices": 7"#, "does not exist", element("accessor", 7)),
        ("5123", "5126", "not unsigned integers", element("accessor", 1)),
        (
            r#"{"POSITION": 0}"#,
            r#"{"POSITION": 0, "_A": 1}"#,
            "differ in count",
            element("mesh", 0),
        ),
        (r#"{"POSITION": 0}"#, r#"{}, "mode": 9"#, "unknown kind", element("mesh", 0)),
        (r#"0}, "indices": 1"#, r#"0}, "mode": 0, "indices": 0"#, "shape", element("accessor", 0)),
        (
            r#""bufferView": 1"#,
            r#""bufferView": 2"#,
            "buffer view 2, which",
            element("accessor", 1),
        ),
        (r#""buffer": 0"#, r#""buffer": 1"#, "buffer 1, which does not", element("bufferView", 0)),
        ("a%20b/square.bin", "absent.bin", "absent.bin", element("buffer", 0)),
    ] {
        assert_eq!(bad(&[(PLACES, ""), (from, to)], word), place, "{to}");
    }
    // Meshes that no node uses may have faults if they are not needed.
    let more = r#""meshes": [{"primitives": [{"attributes": {"POSITION": 9}}]}, "#;
    let swaps = [(r#""meshes": ["#, more), (r#"{"mesh": 0}"#, r#"{"mesh": 1}"#)];
    assert_eq!(good(&swaps, &square_bytes()).points, SQUARE);
}

/// The search for faults reads no more than a scene may contain.
#[test]
fn faults_are_not_sought_without_bound() {
    let one = r#"{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}]},"#;
    let many = format!(r#""meshes": [{}"#, one.repeat(40_000));
    let (views, count) = (r#""byteLength": 240000"#, r#""count": 20000"#);
    let swaps = [
        (PLACES, ""),
        (r#""meshes": ["#, many.as_str()),
        (r#""byteLength": 60"#, views),
        (r#""byteLength": 48"#, views),
        (r#""count": 4"#, count),
    ];
    let begun = std::time::Instant::now();
    let case = super::with_buffer(&super::json(&swaps), &vec![0; 240_000]);
    crate::support::refused(formats::read_scan(&case.path), "it has no nodes");
    assert!(begun.elapsed().as_secs() < 10);
}

#[test]
fn loops_outside_of_the_scene_are_refused() {
    let nodes =
        r#""nodes": [{"mesh": 0}, {"children": [3]}, {"children": [1]}, {"children": [2]}]"#;
    let place = bad(&[(r#""nodes": [{"mesh": 0}]"#, nodes)], "is its own descendant");
    assert_eq!(place, Some(Location::Element("node", 1)));
    let nodes = r#""nodes": [{"mesh": 0}, {"children": [4]}]"#;
    let place = bad(&[(r#""nodes": [{"mesh": 0}]"#, nodes)], "does not exist");
    assert_eq!(place, Some(Location::Element("node", 4)));
    let nodes = r#""nodes": [{"mesh": 0}, {"children": [3]}, {"children": [3]}, {}]"#;
    let place = bad(&[(r#""nodes": [{"mesh": 0}]"#, nodes)], "below node 1 and below node 2");
    assert_eq!(place, Some(Location::Element("node", 3)));
}

#[test]
fn a_root_may_be_below_a_node_of_no_scene() {
    let nodes = r#""nodes": [{"mesh": 0}, {"children": [0], "translation": [1, 1, 1]}]"#;
    assert_eq!(good(&[(r#""nodes": [{"mesh": 0}]"#, nodes)], &square_bytes()).points, SQUARE);
}
