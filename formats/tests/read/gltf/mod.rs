//! glTF and GLB: supported features and errors.

mod accessors;
mod data;
mod glb;
mod nothing;
mod placed;
mod refused;
mod scene;
mod uris;

use std::fs;

use formats::{Location, Soup, read_scan};

use crate::support::{Case, case, refused};

const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

/// The positions of the square as floats, then 0 1 2 0 2 3 as shorts.
fn square_bytes() -> Vec<u8> {
    let mut bytes = Vec::new();
    SQUARE.as_flattened().iter().for_each(|v| bytes.extend((*v as f32).to_le_bytes()));
    [0u16, 1, 2, 0, 2, 3].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes
}

const BASE: &str = r#"{
  "asset": {"version": "2.0"},
  "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
  "buffers": [{"byteLength": 60, "uri": "a%20b/square.bin"}],
  "bufferViews": [{"buffer": 0, "byteLength": 48},
    {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
    {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]
}"#;

/// `BASE` with replaced text. Every replacement must find its text.
#[track_caller]
fn json(swaps: &[(&str, &str)]) -> String {
    let mut text = BASE.to_owned();
    for (from, to) in swaps {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    text
}

/// A triangle without indices. Its three points are in the buffer at `uri`.
fn one_triangle(uri: &str) -> String {
    json(&[
        ("a%20b/square.bin", uri),
        (r#""byteLength": 60"#, r#""byteLength": 36"#),
        (r#""byteLength": 48"#, r#""byteLength": 36"#),
        (r#""count": 4"#, r#""count": 3"#),
        (r#", "indices": 1"#, ""),
    ])
}

/// A glTF file with its buffer beside it.
fn with_buffer(json: &str, bytes: &[u8]) -> Case {
    let case = case("square.gltf", json);
    let folder = case.path.with_file_name("a b");
    fs::create_dir(&folder).expect("a folder");
    fs::write(folder.join("square.bin"), bytes).expect("a buffer");
    case
}

#[track_caller]
fn good(swaps: &[(&str, &str)], bytes: &[u8]) -> Soup {
    let result = read_scan(&with_buffer(&json(swaps), bytes).path);
    result.unwrap_or_else(|e| panic!("{e}"))
}

#[track_caller]
fn bad(swaps: &[(&str, &str)], word: &str) -> Option<Location> {
    refused(read_scan(&with_buffer(&json(swaps), &square_bytes()).path), word).place
}

fn glb(json: &str, chunk: &[u8]) -> Vec<u8> {
    let json = format!("{json:<width$}", width = json.len().next_multiple_of(4));
    let length = 28 + json.len() + chunk.len();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((length as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json.as_bytes());
    file.extend((chunk.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(chunk);
    file
}

fn square_glb(swaps: &[(&str, &str)]) -> Vec<u8> {
    let no_uri = (r#", "uri": "a%20b/square.bin""#, "");
    glb(&json(&[&[no_uri], swaps].concat()), &square_bytes())
}

/// A data URI. It is percent-encoded because this needs no encoder.
fn data_uri(bytes: &[u8]) -> String {
    let text: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    format!("data:application/octet-stream,{text}")
}
