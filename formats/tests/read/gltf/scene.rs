//! Scenes, nodes and primitives.

use formats::Location;

use super::{SQUARE, bad, good, square_bytes};
use crate::support::polygons;

#[test]
fn strips_fans_and_unindexed_points() {
    fn mode(mode: &str) -> [(&str, &str); 1] {
        [(r#""indices": 1"#, mode)]
    }
    let bytes = square_bytes();
    let strip = good(&mode(r#""mode": 5"#), &bytes);
    assert_eq!(polygons(&strip), [[0, 1, 2], [1, 3, 2]]);
    let fan = good(&mode(r#""mode": 6"#), &bytes);
    assert_eq!(polygons(&fan), [[1, 2, 0], [2, 3, 0]]);
    let plain = good(&mode(r#""mode": 4"#), &bytes);
    assert_eq!(polygons(&plain), [[0, 1, 2]]);
    let listed = good(&mode(r#""indices": 1, "mode": 5"#), &bytes);
    assert_eq!(polygons(&listed).len(), 4);
    for loose in 0..4 {
        bad(&mode(&format!(r#""mode": {loose}"#)), "no triangles");
    }
    bad(&mode(r#""mode": 7"#), "unknown kind of primitive");
}

#[test]
fn nodes_move_turn_scale_and_mirror() {
    let place = |node: &str| {
        let node = format!(r#""nodes": [{{"mesh": 0, {node}}}]"#);
        good(&[(r#""nodes": [{"mesh": 0}]"#, &node)], &square_bytes())
    };
    let moved = place(r#""translation": [1, 2, 3], "scale": [2, 1, 1]"#);
    assert_eq!(moved.points[2], [3., 3., 3.]);
    assert_eq!(polygons(&moved), [[0, 1, 2], [0, 2, 3]]);
    let turned = place(r#""rotation": [0, 0, 0.70710678, 0.70710678]"#);
    assert!((turned.points[1][0]).abs() < 1e-6 && (turned.points[1][1] - 1.0).abs() < 1e-6);
    let mirrored = place(r#""scale": [-1, 1, 1]"#);
    assert_eq!(mirrored.points[1], [-1., 0., 0.]);
    assert_eq!(polygons(&mirrored), [[0, 2, 1], [0, 3, 2]]);
    let matrix = place(r#""matrix": [0,1,0,0, 1,0,0,0, 0,0,1,0, 5,6,7,1]"#);
    assert_eq!(matrix.points[1], [5., 7., 7.]);
    assert_eq!(polygons(&matrix), [[0, 2, 1], [0, 3, 2]]);
}

#[test]
fn nodes_inherit_and_meshes_repeat() {
    let nodes = r#""nodes": [{"mesh": 0, "scale": [2, 2, 2], "children": [1, 2]},
        {"mesh": 0, "translation": [1, 0, 0]}, {"mesh": 0, "scale": [-1, 1, 1]}]"#;
    let soup = good(&[(r#""nodes": [{"mesh": 0}]"#, nodes)], &square_bytes());
    assert_eq!(soup.points.len(), 12);
    assert_eq!(soup.points[5], [4., 0., 0.]);
    assert_eq!(soup.points[9], [-2., 0., 0.]);
    let faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [8, 10, 9], [8, 11, 10]];
    assert_eq!(polygons(&soup), faces);
}

#[test]
fn several_primitives() {
    let two = r#""primitives": [{"attributes": {"POSITION": 0}, "indices": 1},
        {"attributes": {"POSITION": 0}, "mode": 0}, {"attributes": {}},"#;
    let soup = good(&[(r#""primitives": ["#, two)], &square_bytes());
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]);
}

#[test]
fn only_the_default_scene_is_read() {
    let scenes = [
        (r#""scene": 0, "scenes": [{"nodes": [0]}]"#, 4),
        (r#""scene": 1, "scenes": [{"nodes": []}, {"nodes": [0, 1]}]"#, 8),
        (r#""scenes": [{"nodes": [1]}, {"nodes": [0]}]"#, 4),
        (r#""extras": {}"#, 8),
    ];
    for (scene, points) in scenes {
        let swaps = [
            (r#""scene": 0, "scenes": [{"nodes": [0]}]"#, scene),
            (r#"[{"mesh": 0}]"#, r#"[{"mesh": 0}, {"children": [2]}, {"mesh": 0}]"#),
        ];
        assert_eq!(good(&swaps, &square_bytes()).points.len(), points, "{scene}");
    }
}

#[test]
fn deep_and_cyclic_trees_end() {
    let count = 50_000;
    let chain: String = (1..count).map(|i| format!(r#"{{"children": [{i}]}},"#)).collect();
    let nodes = format!(r#""nodes": [{chain}{{"mesh": 0}}]"#);
    let soup = good(&[(r#""nodes": [{"mesh": 0}]"#, &nodes)], &square_bytes());
    assert_eq!(soup.points, SQUARE);
    let one = r#""nodes": [{"mesh": 0}]"#;
    for nodes in [
        r#""nodes": [{"mesh": 0, "children": [0]}]"#,
        r#""nodes": [{"children": [1]}, {"children": [0], "mesh": 0}]"#,
    ] {
        let place = bad(&[(one, nodes)], "is its own descendant");
        assert!(matches!(place, Some(Location::Element("node", _))));
    }
    let nodes = r#""nodes": [{"children": [1, 1]}, {"mesh": 0}]"#;
    let place = bad(&[(one, nodes)], "twice, below node 0 and below node 0");
    assert_eq!(place, Some(Location::Element("node", 1)));
}
