//! Small files that declare large contents.

use std::fs;

use crate::Judge;
use crate::support::case;

pub fn judge(judge: &mut Judge) {
    ply(judge);
    stl(judge);
    glb(judge);
    gltf(judge);
    gltf_buffers(judge);
    obj(judge);
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

fn ply(judge: &mut Judge) {
    let elements = [
        ("points", format!("element vertex 4000000000\n{XYZ}")),
        ("faces", "element face 4000000000\nproperty list uchar int vertex_indices\n".into()),
        ("strip", "element tristrips 1\nproperty list int int vertex_indices\n".into()),
        ("corners", "element face 1\nproperty list uint uint vertex_indices\n".into()),
        ("bytes", "element face 1\nproperty list uint uchar vertex_indices\n".into()),
        ("unknown", "element odd 4000000000\nproperty double a\n".into()),
        ("nothing", "element odd 18446744073709551615\nelement b 18446744073709551615\n".into()),
        ("unknown list", "element odd 9\nproperty list uint double a\n".into()),
    ];
    let encodings: [(&str, &[u8]); 3] = [
        ("ascii", b"4000000000 1 2 3 4 5 6\n"),
        ("binary_little_endian", b"\xff\xff\xff\x7f\0\0\0\0\0\0\0\0"),
        ("binary_big_endian", b"\x7f\xff\xff\xff\0\0\0\0\0\0\0\0"),
    ];
    for (title, element) in &elements {
        for (encoding, body) in encodings {
            let head = format!("ply\nformat {encoding} 1.0\n{element}end_header\n");
            let file = [head.as_bytes(), body].concat();
            judge.judge_made("lie.ply", &format!("{encoding} PLY, {title}"), file);
        }
    }
}

fn stl(judge: &mut Judge) {
    for count in [4_000_000_000, u32::MAX] {
        let file = [&[b' '; 80][..], &count.to_le_bytes(), &[0; 150]].concat();
        judge.judge_made("lie.stl", "STL", file);
    }
}

fn glb(judge: &mut Judge) {
    let json = br#"{"asset":{"version":"2.0"} }"#;
    let n = json.len() as u32;
    let honest = 28 + n + 4;
    for lengths in [[u32::MAX, n, 4], [honest, u32::MAX, 4], [honest, n, u32::MAX], [20, n, 4]] {
        let [all, text, bin] = lengths.map(u32::to_le_bytes);
        let file = [b"glTF\x02\0\0\0", &all[..], &text, b"JSON", json, &bin, b"BIN\0", &[0; 4]];
        judge.judge_made("lie.glb", &format!("GLB {lengths:?}"), file.concat());
    }
}

const GLTF: &str = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0},
    "indices": 1}]}], "buffers": [{"byteLength": 64, "uri": "data:,URI"}], "bufferViews":
    [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 16}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5121, "count": 16, "type": "SCALAR"}]}"#;

fn gltf(judge: &mut Judge) {
    let sparse = r#""count": 4, "sparse": {"count": COUNT, "indices": {"bufferView": 1,
        "componentType": 5121}, "values": {"bufferView": 0}}"#;
    let zeros = r#""componentType": 5126, "count": COUNT, "sparse": {"count": 1, "indices":
        {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}"#;
    let swaps = [
        (r#""count": 4"#, r#""count": COUNT"#),
        (r#""count": 16"#, r#""count": COUNT"#),
        (r#""byteLength": 64"#, r#""byteLength": COUNT"#),
        (r#""byteLength": 48"#, r#""byteLength": COUNT"#),
        (r#""byteOffset": 48"#, r#""byteOffset": COUNT"#),
        (r#""buffer": 0"#, r#""buffer": 0, "byteStride": COUNT"#),
        (r#""mesh": 0"#, r#""mesh": COUNT"#),
        (r#""nodes": [0]"#, r#""nodes": [COUNT]"#),
        (r#""count": 4"#, sparse),
        (r#""bufferView": 0, "componentType": 5126, "count": 4"#, zeros),
    ];
    let text = GLTF.replace("URI", &"%00".repeat(64));
    for (from, to) in swaps {
        for count in ["4000000000", "18446744073709551615", "1000000", "200000"] {
            assert!(text.contains(from));
            let file = text.replacen(from, &to.replace("COUNT", count), 1);
            judge.judge_made("lie.gltf", &format!("glTF, {count} for {from}"), &file);
            // The same mesh with many more instances.
            for nodes in [2, 3000] {
                let title = format!("glTF {nodes} times, {count} for {from}");
                judge.judge_made("lie.gltf", &title, placed(&file, nodes));
            }
        }
    }
    for nested in ["[", r#"{"extras":"#, r#"{"nodes":["#] {
        let file = format!(r#"{{"asset": {}"#, nested.repeat(100_000));
        judge.judge_made("deep.gltf", &format!("glTF, deep {nested}"), file);
    }
}

/// Many buffers in one file.
fn gltf_buffers(judge: &mut Judge) {
    const SIZE: usize = 4 << 20;
    let list = |item: fn(usize) -> String| (0..200).map(item).collect::<Vec<_>>().join(",");
    let primitives = list(|i| format!(r#"{{"attributes": {{"POSITION": {i}}}, "mode": 4}}"#));
    let buffers = list(|i| format!(r#"{{"byteLength": {}, "uri": "./zeros.bin"}}"#, SIZE - i));
    let views = list(|i| format!(r#"{{"buffer": {i}, "byteLength": 36}}"#));
    let accessor = r#""componentType": 5126, "count": 3, "type": "VEC3""#;
    let accessors: Vec<String> =
        (0..200).map(|i| format!(r#"{{"bufferView": {i}, {accessor}}}"#)).collect();
    let file = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}], "meshes":
        [{{"primitives": [{primitives}]}}], "buffers": [{buffers}], "bufferViews": [{views}],
        "accessors": [{}]}}"#,
        accessors.join(",")
    );
    let case = case("lie.gltf", file);
    fs::write(case.path.with_file_name("zeros.bin"), vec![0; SIZE]).expect("a buffer");
    judge.judge("glTF, 200 buffers in one file", &case.path);
}

/// `file` in which this number of `nodes` uses its mesh.
fn placed(file: &str, nodes: usize) -> String {
    let places = vec![r#"{"mesh": 0}"#; nodes].join(",");
    let list: Vec<String> = (0..nodes).map(|i| i.to_string()).collect();
    let file = file.replace(r#""nodes": [{"mesh": 0}]"#, &format!(r#""nodes": [{places}]"#));
    file.replace(r#""nodes": [0]"#, &format!(r#""nodes": [{}]"#, list.join(",")))
}

fn obj(judge: &mut Judge) {
    for number in ["4000000000", "4294967295", "-4000000000", "9223372036854775807"] {
        let file = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 {number}\nf {number} 1 2\n");
        judge.judge_made("lie.obj", &format!("OBJ, vertex {number}"), file);
        let file = format!("f {number}/{number}/{number} 2 3\nv 0 0 0\n");
        judge.judge_made("lie.obj", &format!("OBJ, vertex {number} before all"), file);
    }
}
