//! Valid files with the shortest elements that take much memory.

use crate::Judge;

/// The size of the files. It is large enough to measure the memory for each byte.
const SIZE: usize = 8 << 20;

fn fill(head: &str, piece: &str, tail: &str) -> String {
    format!("{head}{}{tail}", piece.repeat(SIZE / piece.len()))
}

pub fn judge(judge: &mut Judge) {
    let corners = SIZE / 2;
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
               property float z\n";
    let list = "property list uint uchar vertex_indices\nend_header\n0 0 0\n";
    let face = format!("{ply}element face 1\n{list}{corners} ");
    let strip = format!("{ply}element tristrips 1\n{list}{corners} ");
    let small = format!("{ply}element face {}\n{list}", SIZE / 8);
    let points = ply.replace("vertex 1", &format!("vertex {}", SIZE / 6)) + "end_header\n";
    let texts = [
        ("points.obj", fill("", "v 1 1 1\n", "f 1 1 1\n")),
        ("faces.obj", fill("v 1 1 1\n", "f 1 1 1\n", "")),
        ("face.obj", fill("v 1 1 1\nf", " 1", "\n")),
        ("face.ply", fill(&face, "0 ", "\n")),
        ("strip.ply", fill(&strip, "0 ", "\n")),
        ("faces.ply", fill(&small, "3 0 0 0\n", "")),
        ("points.ply", fill(&points, "0 0 0\n", "")),
        (
            "facets.stl",
            fill("solid\nfacet outer loop\n", "vertex 0 0 0\n", "endloop endfacet\nendsolid"),
        ),
    ];
    for (name, text) in texts {
        judge.judge_made(name, &format!("dense {name}"), text);
    }
    binary_ply(judge);
    binary_stl(judge);
    gltf(judge);
}

fn binary_ply(judge: &mut Judge) {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\n\
                property uchar y\nproperty uchar z\n";
    for (element, kind, width) in [("face", "uchar", 1), ("tristrips", "ushort", 2)] {
        let list = format!("property list uint {kind} vertex_indices\nend_header\n");
        let head = format!("{head}element {element} 1\n{list}");
        let count = (SIZE as u32 / width).to_le_bytes();
        let file = [head.as_bytes(), &[0; 3], &count, &vec![0; SIZE]].concat();
        judge.judge_made("list.ply", &format!("dense binary {element}.ply"), file);
    }
    let head = head.replace("vertex 1", &format!("vertex {}", SIZE / 3)) + "end_header\n";
    let file = [head.as_bytes(), &vec![0; SIZE]].concat();
    judge.judge_made("points.ply", "dense binary points.ply", file);
}

fn binary_stl(judge: &mut Judge) {
    let count = SIZE / 50;
    let file = [&[0; 80][..], &(count as u32).to_le_bytes(), &vec![0; 50 * count]].concat();
    judge.judge_made("records.stl", "dense records.stl", file);
}

fn gltf(judge: &mut Judge) {
    let begin = r#"{"asset":{"version":"2.0"},"#;
    for (key, item) in [
        ("nodes", "{}"),
        ("scenes", r#"{"nodes":[]}"#),
        ("meshes", r#"{"primitives":[]}"#),
        ("buffers", r#"{"byteLength":0}"#),
        ("materials", "{}"),
        ("textures", r#"{"source":0}"#),
        ("images", "{}"),
        ("samplers", "{}"),
        ("skins", r#"{"joints":[]}"#),
        ("animations", r#"{"channels":[],"samplers":[]}"#),
        ("cameras", r#"{"type":""}"#),
        ("bufferViews", r#"{"buffer":0,"byteLength":0}"#),
        ("extensionsUsed", r#""""#),
        ("accessors", r#"{"componentType":0,"count":0,"type":""}"#),
    ] {
        let piece = format!("{item},");
        let text = fill(&format!(r#"{begin}"{key}":["#), &piece, &format!("{item}]}}"));
        judge.judge_made("list.gltf", &format!("dense {key} of glTF"), text);
    }
    // The largest number that is allowed.
    let nodes = format!(r#"{begin}"nodes":[{}{{}}]}}"#, "{},".repeat(131_000));
    judge.judge_made("nodes.gltf", "131,000 nodes of glTF", nodes);
    let primitive = r#"{"attributes":{}},"#;
    let head = format!(r#"{begin}"meshes":[{{"primitives":["#);
    let text = fill(&head, primitive, r#"{"attributes":{}}]}]}"#);
    judge.judge_made("list.gltf", "dense primitives of glTF", text);
}
