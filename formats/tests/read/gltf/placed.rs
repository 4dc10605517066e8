//! Meshes and nodes in unusual arrangements, and unusual JSON.

use formats::Location;

use super::{BASE, SQUARE, bad, good, square_bytes};
use crate::support::{polygons, refusal};

const SCENES: &str = r#""scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}]"#;

#[track_caller]
fn placed(nodes: &str) -> Vec<[f64; 3]> {
    good(&[(SCENES, nodes)], &square_bytes()).points
}

#[test]
fn several_meshes_in_the_order_of_the_nodes() {
    let swaps = [
        (
            SCENES,
            r#""scenes": [{"nodes": [2, 0]}], "nodes": [{"mesh": 0}, {"mesh": 1}, {"mesh": 1}]"#,
        ),
        (r#""meshes": ["#, r#""meshes": [{"primitives": []}, "#),
    ];
    let soup = good(&swaps, &square_bytes());
    assert_eq!(soup.points, SQUARE);
    let swaps = [
        (SCENES, r#""scenes": [{"nodes": [1, 0]}], "nodes": [{"mesh": 0}, {"mesh": 1}]"#),
        (
            r#""meshes": ["#,
            r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}, "#,
        ),
    ];
    let faces = [[0, 1, 2], [0, 2, 3], [5, 6, 4], [6, 7, 4]];
    assert_eq!(polygons(&good(&swaps, &square_bytes())), faces);
}

#[test]
fn transforms_go_down_the_tree() {
    let nodes = r#""scenes": [{"nodes": [2]}], "nodes": [{"mesh": 0, "scale": [2, 2, 2]},
        {"children": [0], "matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 5,0,0,1]},
        {"children": [1], "translation": [0, 0, 7], "scale": [1, 3, 1]}]"#;
    assert_eq!(placed(nodes), [[5., 0., 7.], [5., 6., 7.], [3., 6., 7.], [3., 0., 7.]]);
}

#[test]
fn mirrors_turn_faces_over() {
    let of = |nodes: &str| polygons(&good(&[(SCENES, nodes)], &square_bytes()));
    let (front, back) = ([[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]);
    for (scale, faces) in [("-1, -1, -1", back), ("1, -1, 1", back), ("-1, -1, 1", front)] {
        let nodes = format!(r#""nodes": [{{"mesh": 0, "scale": [{scale}]}}]"#);
        assert_eq!(of(&nodes), faces, "{scale}");
    }
    let twice =
        r#""nodes": [{"mesh": 0, "scale": [1, -1, 1]}, {"children": [0], "scale": [-1, 1, 1]}]"#;
    assert_eq!(of(twice), front);
}

#[test]
fn matrices_need_no_inverse() {
    let ones = r#""nodes": [{"mesh": 0, "matrix": [1,1,1,1, 1,1,1,1, 1,1,1,1, 1,1,1,1]}]"#;
    assert_eq!(placed(ones), [[1.; 3], [2.; 3], [3.; 3], [2.; 3]]);
    assert_eq!(placed(r#""nodes": [{"mesh": 0, "scale": [0, 0, 0]}]"#), [[0.; 3]; 4]);
}

#[test]
fn transforms_without_a_number_are_refused() {
    for node in [r#""translation": [1e999, 0, 0]"#, r#""scale": [1, 1, -1e999]"#] {
        let nodes = format!(r#""nodes": [{{"mesh": 0, {node}}}]"#);
        bad(&[(SCENES, &nodes)], "number out of range at line 3");
    }
    let nodes = r#""nodes": [{"mesh": 0, "scale": [1e30, 1, 1]},
        {"children": [0], "scale": [1e38, 1, 1]}]"#;
    // This is far away but still a number. Later stages decide about it.
    assert!(placed(nodes).iter().flatten().all(|v| v.is_finite()));
}

#[test]
fn files_without_scenes_place_all_nodes() {
    for nodes in [
        r#""nodes": [{"mesh": 0}]"#,
        r#""scenes": [], "nodes": [{"mesh": 0}]"#,
        r#""scenes": [{"nodes": [1]}, {"nodes": []}], "nodes": [{}, {"mesh": 0}]"#,
        r#""nodes": [{"children": [1]}, {"children": [2]}, {"mesh": 0}]"#,
    ] {
        assert_eq!(placed(nodes), SQUARE, "{nodes}");
    }
}

#[test]
fn scenes_without_meshes_are_refused() {
    for nodes in [
        r#""extras": {}"#,
        r#""nodes": []"#,
        r#""nodes": [{}]"#,
        r#""scene": 0, "scenes": [{"nodes": []}], "nodes": [{"mesh": 0}]"#,
        r#""nodes": [{"matrix": [1,1,1,1, 1,1,1,1, 1,1,1,1, 1,1,1,1]}]"#,
    ] {
        bad(&[(SCENES, nodes)], "no triangles in its default scene");
    }
}

/// A scene need not have nodes. Blender writes empty scenes like this.
#[test]
fn scenes_without_a_list_of_nodes_are_sound() {
    let empty =
        r#""scene": 1, "scenes": [{"name": "none"}, {"nodes": [0]}], "nodes": [{"mesh": 0}]"#;
    assert_eq!(placed(empty), SQUARE);
    let only = r#""scene": 0, "scenes": [{}], "nodes": [{"mesh": 0}]"#;
    bad(&[(SCENES, only)], "no triangles in its default scene");
}

/// The target of an animation by an extension need not be a node.
#[test]
fn animations_without_a_node_are_left_alone() {
    let nodes = r#""nodes": [{"mesh": 0}], "animations": [{"samplers": [{"input": 1, "output": 1}],
        "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions":
        {"KHR_animation_pointer": {"pointer": "/materials/0/alphaCutoff"}}}}]}]"#;
    assert_eq!(placed(nodes), SQUARE);
}

#[test]
fn textures_of_extensions_alone_are_left_alone() {
    let nodes = r#""extensionsRequired": ["KHR_texture_basisu", "EXT_texture_webp"],
        "nodes": [{"mesh": 0}], "images": [{"uri": "absent.ktx2", "mimeType": "image/ktx2"}],
        "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}, {}]"#;
    assert_eq!(placed(nodes), SQUARE);
}

#[test]
fn nodes_below_two_others_are_refused() {
    let nodes = r#""scenes": [{"nodes": [0, 1]}],
        "nodes": [{"children": [2]}, {"children": [2]}, {"mesh": 0}]"#;
    let place = bad(&[(SCENES, nodes)], "in the scene twice");
    assert_eq!(place, Some(Location::Element("node", 2)));
    let nodes = r#""scenes": [{"nodes": [0, 0]}], "nodes": [{"mesh": 0}]"#;
    assert_eq!(bad(&[(SCENES, nodes)], "twice"), Some(Location::Element("node", 0)));
}

/// Without a scene, no node of a cycle is a root. It must not be lost.
#[test]
fn loops_without_a_scene_are_refused() {
    for nodes in [
        r#""nodes": [{"children": [1]}, {"children": [2]}, {"mesh": 0, "children": [0]}]"#,
        r#""nodes": [{"mesh": 0}, {"mesh": 0, "children": [1]}]"#,
    ] {
        bad(&[(SCENES, nodes)], "is its own descendant");
    }
}

#[test]
fn skins_morphs_and_other_attributes_are_left_alone() {
    let swaps = [
        (
            SCENES,
            r#""nodes": [{"mesh": 0, "skin": 0, "weights": [1], "camera": 0,
            "translation": [1, 0, 0]}],
            "skins": [{"joints": [0], "inverseBindMatrices": 7}], "cameras": [],
            "animations": [{"channels": [], "samplers": []}], "materials": [{}]"#,
        ),
        (
            r#"{"attributes": {"POSITION": 0}"#,
            r#"{"targets": [{"POSITION": 9}], "material": 4, "attributes": {"POSITION": 0,
            "NORMAL": 9, "TEXCOORD_0": 9, "COLOR_0": 1, "JOINTS_0": 9, "WEIGHTS_0": 9, "_MINE": 9}"#,
        ),
    ];
    let soup = good(&swaps, &square_bytes());
    assert_eq!(soup.points, SQUARE.map(|[x, y, z]| [x + 1., y, z]));
    assert_eq!(polygons(&soup), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn json_of_the_wrong_types_is_refused_by_line() {
    for (from, to, line) in [
        (r#""scene": 0"#, r#""scene": "hello""#, 3),
        (r#""scene": 0"#, r#""scene": -1"#, 3),
        (r#"[{"attributes": {"POSITION": 0}, "indices": 1}]"#, r#"{"not an array": {}}"#, 4),
        (r#""byteLength": 48"#, r#""byteLength": 1e300"#, 6),
        (r#""byteLength": 48"#, r#""byteLength": -1"#, 6),
        (r#""byteLength": 48"#, r#""byteLength": 48.5"#, 6),
        (r#""byteLength": 48"#, r#""byteLength": 18446744073709551616"#, 6),
        (r#", "count": 4"#, "", 8),
        (r#""type": "VEC3""#, r#""type": "VEC3","#, 8),
    ] {
        bad(&[(from, to)], "not a valid glTF 2.0 file: ");
        bad(&[(from, to)], &format!("at line {line} "));
    }
    for text in ["{}", "{\"name\": \"scan2step\"}", "{", "{\"asset\": {}}", "{ v 0 0 0"] {
        refusal("other.gltf", text, "not a valid glTF 2.0 file");
    }
    for cut in 1..BASE.len() - 1 {
        refusal("cut.gltf", &BASE[..cut], "not a valid glTF 2.0 file");
    }
}

/// Its lists were objects, and its version need not be declared.
#[test]
fn version_1_is_refused_by_name() {
    let old = r#"{"accessors": {"a": {"bufferView": "b", "componentType": 5126, "count": 3,
        "type": "VEC3"}}, "asset": {"version": "1.0"}, "scene": "s",
        "scenes": {"s": {"nodes": ["n"]}}, "nodes": {"n": {"meshes": ["m"]}}}"#;
    let error = refusal("old.gltf", old, "version 1.0");
    assert!(error.help.contains("glTF 2.0"));
}

#[test]
fn later_versions_are_read_if_they_are_of_2() {
    let version = r#""version": "2.0""#;
    for text in
        [r#""version": "2.1""#, r#""version": "2.0", "minVersion": "2.0", "generator": "x""#]
    {
        assert_eq!(good(&[(version, text)], &square_bytes()).points, SQUARE);
    }
    for text in ["3.0", "1.1", "", "20", "two"] {
        bad(&[(version, &format!(r#""version": "{text}""#))], "of glTF version");
    }
}

/// A rotation that is rounded or not normalized must not shear.
#[test]
fn rotations_are_made_unit_length() {
    for length in ["0.9", "1", "1e-20", "7e15"] {
        let nodes = format!(r#""nodes": [{{"mesh": 0, "rotation": [0, 0, {length}, {length}]}}]"#);
        let points = placed(&nodes);
        let turned = SQUARE.map(|[x, y, z]| [-y, x, z]);
        let off = points.as_flattened().iter().zip(turned.as_flattened()).map(|(a, b)| a - b);
        assert!(off.map(f64::abs).fold(0.0, f64::max) < 1e-12, "{length}: {points:?}");
    }
    // An axis without length defines no rotation.
    assert_eq!(placed(r#""nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]"#), SQUARE);
    // The number is too large for single precision. serde_json reports this. Without its feature
    // float_roundtrip, which other crates enable for it, the reader reports it.
    bad(&[(SCENES, r#""nodes": [{"mesh": 0, "rotation": [0, 0, 1e39, 0]}]"#)], "");
}

/// Faults of such elements, which the crate would refuse, are ignored. The numbers of lines stay
/// the same.
#[test]
fn what_no_mesh_needs_is_passed_over() {
    for part in ["animations", "cameras", "images", "materials", "samplers", "skins", "textures"] {
        let nodes = format!(
            "\"{part}\": [\n{{}}, {{\"a]\": [\"}}\"]}},\n 7], \"nodes\": [{{\"mesh\": 0}}]"
        );
        assert_eq!(placed(&nodes), SQUARE, "{part}");
        let wrong = (r#""count": 4"#, r#""count": "4""#);
        bad(&[(SCENES, &nodes), wrong], "at line 10 column");
    }
}
