//! Scenes of OBJ, STL and glTF: names, groups, colours, places and instances.

use std::fs;

use formats::{Scene, read_scene};

use crate::support::{case, scene, soup, tree};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// The groups of the only mesh, with their ranges of polygons.
fn groups(scene: &Scene) -> Vec<(Option<&str>, std::ops::Range<usize>)> {
    let groups = &scene.meshes()[0].groups;
    groups.iter().map(|(run, value)| (groups.values()[value].as_deref(), run)).collect()
}

/// The colours of the only mesh, with their ranges of polygons.
fn colours(scene: &Scene) -> Vec<(Option<[u8; 3]>, std::ops::Range<usize>)> {
    let colours = &scene.meshes()[0].colours;
    colours.iter().map(|(run, value)| (colours.values()[value], run)).collect()
}

#[test]
fn a_file_with_one_mesh_has_one_node() {
    let obj = SQUARE.to_owned() + "o plate\nf 1 2 3\nf 1 3 4\n";
    assert_eq!(tree(&scene("a.obj", &obj)), ["0 -: plate None 2"]);
    let stl = "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
               vertex 0 1 0\nendloop\nendfacet\nendsolid plate\n";
    assert_eq!(tree(&scene("a.stl", stl)), ["0 -: plate None 1"]);
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    assert_eq!(tree(&scene("a.off", off)), ["0 -: - None 1"]);
}

#[test]
fn objects_and_groups_of_obj_keep_their_names() {
    let faces = "f 1 2 3\no left\nf 1 3 4\ng a\nf 1 2 4\no left\nf 2 3 4\no empty\n";
    let of_objects = scene("a.obj", SQUARE.to_owned() + faces);
    let named = |name| Some(name);
    let expected = [(None, 0..1), (named("left"), 1..3), (named("left"), 3..4)];
    assert_eq!(groups(&of_objects), expected);
    // A group goes on where its name comes again.
    let faces = "o only\ng a\nf 1 2 3\ng Gr\u{f6}\u{df}e 2\nf 1 3 4\ng a\nf 1 2 4\n";
    let of_groups = scene("a.obj", SQUARE.to_owned() + faces);
    let expected = [(named("a"), 0..1), (named("Gr\u{f6}\u{df}e 2"), 1..2), (named("a"), 2..3)];
    assert_eq!(groups(&of_groups), expected);
    assert_eq!(of_groups.meshes()[0].groups.values().len(), 2);
}

#[test]
fn too_many_groups_are_none() {
    let faces: String = (0..10_001).map(|i| format!("g g{i}\nf 1 2 3\n")).collect();
    let scene = scene("a.obj", SQUARE.to_owned() + &faces);
    assert!(scene.meshes()[0].groups.is_empty());
    assert!(scene.notes[0].to_string().contains("10,001 named groups"), "{}", scene.notes[0]);
}

#[test]
fn solids_of_stl_keep_their_names() {
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let text = format!("solid a b\n{facet}{facet}endsolid\nSOLID\n{facet}endsolid\n");
    assert_eq!(groups(&scene("a.stl", text)), [(Some("a b"), 0..2), (None, 2..3)]);
}

#[test]
fn colours_of_obj_are_in_a_file_beside_it() {
    let text = format!(
        "mtllib two words.mtl\n{SQUARE}f 1 2 3\nusemtl red\nf 1 3 4\nusemtl grey\nf 1 2 4\n\
         usemtl image\nf 2 3 4\nusemtl unknown\nf 2 3 1\nusemtl red\nf 1 2 3\n"
    );
    let library = "newmtl red\r\nKd 1 0 0\n newmtl grey\nKd .5\nnewmtl image\nKd 1 1 1\n\
                   map_Kd a.png\nnewmtl unused\nKd 0 0 1\n";
    let of = |name: &str, library: &str| {
        let case = case("a.obj", text.replace("two words.mtl", name));
        fs::write(case.path.with_file_name("two words.mtl"), library).expect("a library");
        read_scene(&case.path).unwrap_or_else(|e| panic!("{e}"))
    };
    let (red, grey) = (Some([255, 0, 0]), Some([128; 3]));
    let expected = [(None, 0..1), (red, 1..2), (grey, 2..3), (None, 3..5), (red, 5..6)];
    assert_eq!(colours(&of("two words.mtl", library)), expected);
    assert_eq!(colours(&of("C:\\models\\two words.mtl", library)), expected);
    for name in ["absent.mtl", "..", "/etc/passwd"] {
        let scene = of(name, library);
        let note = scene.notes[0].to_string();
        assert!(note.contains("no colours") && scene.meshes()[0].colours.is_empty(), "{note}");
    }
    // One colour is that of the mesh.
    let one = case("a.obj", format!("mtllib a.mtl\nusemtl red\n{SQUARE}f 1 2 3\n"));
    fs::write(one.path.with_file_name("a.mtl"), "newmtl red\nKd 0 1 0\n").expect("a library");
    let scene = read_scene(&one.path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.meshes()[0].colour, Some([0, 255, 0]));
    assert_eq!(scene.into_soup().map(|soup| soup.colour).ok(), Some(Some([0, 255, 0])));
}

const TRIANGLE: &str = r#""buffers": [{"byteLength": 72, "uri": "data:,BYTES"}], "bufferViews": [{"buffer": 0,
    "byteLength": 72}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3,
    "type": "VEC3"}, {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3,
    "type": "VEC3"}]"#;

/// A glTF file whose accessor 0 is a triangle and accessor 1 three points 10 apart.
fn gltf(rest: &str) -> String {
    let points: [f32; 18] =
        [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 0., 10., 0., 0., 20., 0., 0.];
    let bytes: String =
        points.iter().flat_map(|x| x.to_le_bytes()).map(|b| format!("%{b:02x}")).collect();
    format!(r#"{{"asset": {{"version": "2.0"}}, {}, {rest}}}"#, TRIANGLE.replace("BYTES", &bytes))
}

const MESH: &str = r#""primitives": [{"attributes": {"POSITION": 0}}]"#;

#[test]
fn meshes_of_gltf_are_held_once() {
    let rest = format!(
        r#""nodes": [{{"name": "all", "children": [1, 2, 3, 5]}}, {{"name": "one", "mesh": 0}},
        {{"name": "two", "mesh": 1, "translation": [5, 0, 0]}}, {{"mesh": 0, "scale": [2, 2, 2],
        "children": [4]}}, {{"name": "camera"}}, {{"name": "lamps", "children": [6]}}, {{}}],
        "meshes": [{{"name": "screw", {MESH}}}, {{"name": "screw", {MESH}}}]"#
    );
    let scene = scene("a.gltf", gltf(&rest));
    assert_eq!(scene.meshes().len(), 1);
    let expected = [
        "0 all: group -",
        "1 one: screw None 1",
        "1 two: screw None 1",
        "1 -: group -",
        "2 -: screw None 1 stretched",
    ];
    assert_eq!(tree(&scene), expected);
    let form = scene
        .form_mesh(scene.forms().len().checked_sub(1).map(formats::scene::FormId).expect("a form"));
    assert_eq!(form.soup.points[1], [2., 0., 0.]);
    assert!(scene.is_y_up);
}

#[test]
fn instances_of_gltf_are_places() {
    let rest = format!(
        r#""extensionsRequired": ["EXT_mesh_gpu_instancing"], "nodes": [{{"mesh": 0, "name": "row",
        "translation": [0, 0, 1], "extensions": {{"EXT_mesh_gpu_instancing": {{"attributes":
        {{"TRANSLATION": 1}}}}}}}}], "meshes": [{{{MESH}}}]"#
    );
    let scene = scene("a.gltf", gltf(&rest));
    assert_eq!(tree(&scene)[0], "0 row: group -");
    let places = scene.places();
    let xs: Vec<[f64; 3]> = places[1..].iter().map(|place| place.translation).collect();
    assert_eq!(xs, [[0., 0., 1.], [10., 0., 1.], [20., 0., 1.]]);
    let soup = scene.into_soup().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((soup.points.len(), soup.points[7]), (9, [21., 0., 1.]));
    let missing = rest.replace(r#""TRANSLATION": 1"#, r#""TRANSLATION": 9"#);
    crate::support::refusal("a.gltf", gltf(&missing), "accessor");
}

#[test]
fn base_colours_of_gltf_are_linear() {
    let of = |material: &str| {
        let mesh = MESH.replace("}]", r#", "material": 0}]"#);
        let rest = format!(
            r#""nodes": [{{"mesh": 0}}], "meshes": [{{{mesh}}}], "materials": [{{{material}}}]"#
        );
        scene("a.gltf", gltf(&rest)).meshes()[0].colour
    };
    let factor = r#""baseColorFactor": [0.5, 0, 1, 1]"#;
    let material = format!(r#""pbrMetallicRoughness": {{{factor}}}"#);
    assert_eq!(of(&material), Some([188, 0, 255]));
    assert_eq!(of(&material.replace("1]}", r#"1], "baseColorTexture": {"index": 0}}"#)), None);
    assert_eq!(of(r#""name": "plain""#), None);
    // Colours are not worth an error.
    assert_eq!(of(r#""pbrMetallicRoughness": 5"#), None);
}

#[test]
fn mirrored_and_scaled_uses_are_forms_of_their_own() {
    let place = |rest: &str| format!(r#"{{"mesh": 0, {rest}}}"#);
    let nodes = [
        place(r#""scale": [-1, 1, 1]"#),
        // The same but for a rotation.
        place(r#""scale": [1, -1, 1]"#),
        place(r#""scale": [3, 3, 3]"#),
        place(r#""scale": [3, 3, 3], "rotation": [0.70710678, 0, 0, 0.70710678]"#),
        place(r#""rotation": [0, 0.70710678, 0, 0.70710678]"#),
        place(r#""translation": [1, 2, 3]"#),
    ];
    let rest = format!(r#""nodes": [{}], "meshes": [{{{MESH}}}]"#, nodes.join(","));
    let scene = scene("a.gltf", gltf(&rest));
    assert_eq!((scene.forms().len(), scene.place_count()), (3, 6));
    // Forms in their places are the file's triangles.
    let flat = soup("a.gltf", gltf(&rest));
    for (at, (node, place)) in scene.nodes().iter().zip(scene.places()).enumerate() {
        let formats::scene::NodeContent::Form(form) = node.content else { panic!("a group") };
        let mesh = scene.form_mesh(form);
        for (k, point) in mesh.soup.points.iter().enumerate() {
            let [a, b] = [place.apply(*point), flat.points[3 * at + k]];
            assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-6), "{at}: {a:?}, not {b:?}");
        }
        let turned = mesh.soup.polygons.iter().next().expect("a triangle");
        let flat = flat.polygons.iter().nth(at).expect("a triangle");
        assert_eq!(turned.iter().map(|i| i + 3 * at as u32).collect::<Vec<_>>(), flat);
    }
}
